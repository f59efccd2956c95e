"""Plane shapes from which the device is put together, µm."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, MultiPolygon, Point, Polygon
from shapely.geometry.base import BaseGeometry

GRID_UM = 0.001
"""All vertices lie on this grid, the database unit of the masks."""


def quarter_segments(radius_um: float, tolerance_um: float) -> int:
    """Return into how many chords a quarter of a circle is divided.

    A chord over the angle 2π/n stands off its circle by R (1 - cos(π/n)).
    """
    if tolerance_um >= radius_um:
        return 1
    whole = math.pi / math.acos(1.0 - tolerance_um / radius_um)
    return max(1, math.ceil(whole / 4.0))


def disc(x_um: float, y_um: float, radius_um: float, tolerance_um: float) -> Polygon:
    """Return a circle as a polygon, with its vertices on the circle."""
    segments = quarter_segments(radius_um, tolerance_um)
    shape: Polygon = Point(x_um, y_um).buffer(radius_um, quad_segs=segments)
    return shape


def channel(
    points_um: Sequence[tuple[float, float]], width_um: float, tolerance_um: float
) -> BaseGeometry:
    """Return a channel along a line of points, its bends rounded, its ends square."""
    segments = quarter_segments(width_um / 2, tolerance_um)
    line = LineString(points_um)
    return line.buffer(width_um / 2, quad_segs=segments, cap_style="flat", join_style="round")


def mirrored(shape: BaseGeometry) -> BaseGeometry:
    """Return a shape together with its mirror image in y = 0."""
    return shapely.union(shape, shapely.transform(shape, lambda xy: xy * [1.0, -1.0]))


def polygons(shape: BaseGeometry) -> list[Polygon]:
    """Return the polygons of a shape, leaving out lines and points."""
    flat: list[Polygon] = []
    for part in shapely.get_parts(shape):
        if isinstance(part, Polygon) and not part.is_empty:
            flat.append(part)
        elif hasattr(part, "geoms"):
            flat += polygons(part)
    return flat


def on_grid(shape: BaseGeometry) -> MultiPolygon:
    """Return a shape with its vertices on the grid, as polygons."""
    return MultiPolygon(polygons(shapely.set_precision(shape, GRID_UM)))


def staggered(
    x_um: Iterable[float], pitch_um: float, count: int, stagger: float
) -> NDArray[np.float64]:
    """Return points on columns at given x, each `count` wide, symmetric about y = 0.

    Every second column is shifted sideways by ``stagger`` pitches; what is shifted out on one side
    comes in on the other.

    Returns
    -------
    ndarray, shape (n, 2)
        µm; y from -count/2 to count/2 pitches.
    """
    width = count * pitch_um
    even = (np.arange(count) - (count - 1) / 2) * pitch_um
    points = []
    for column, x in enumerate(x_um):
        shift = stagger * pitch_um if column % 2 else 0.0
        y = np.mod(even + shift + width / 2, width) - width / 2
        points += [(x, place) for place in np.sort(y)]
    return np.array(points).reshape(-1, 2)


def inside(points_um: NDArray[np.float64], shape: BaseGeometry) -> NDArray[np.float64]:
    """Return the points, shape (n, 2), that lie inside a shape."""
    shapely.prepare(shape)
    within = shapely.intersects_xy(shape, points_um[:, 0], points_um[:, 1])
    return np.asarray(points_um[within])
