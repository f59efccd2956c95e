"""Where obstacles stand and droplets start: circles of one's own, checked before anything runs."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff import _core
from pinchoff.model.parameters import Parameters
from pinchoff.support.errors import InputError

Floats: TypeAlias = NDArray[np.float64]

CLEARANCE = 0.05
"""Least gap at the start, D0. Fine outlines need no more; a coarse one needs a vertex spacing,
because its corners stand out of the circle and the wall reaches half an edge."""

LEAST_RADIUS = 1e-3
"""Least radius of an obstacle, D0: a smaller one passes between two vertices."""

LEAST_DIAMETER = 0.02
"""Least diameter of a droplet, D0."""

MOST_VERTICES = 4096
"""Most vertices of a droplet; it has ``vertex_count`` for each D0 of its diameter."""


def obstacle_circles(parameters: Parameters, obstacles: ArrayLike | None) -> Floats:
    """Return centre x, y and radius of each obstacle, shape (M, 3), D0.

    By default there is one of radius 1/size_ratio at the origin.

    Raises
    ------
    InputError
        The shape is another, a number is not finite or a radius is too small.
    """
    if obstacles is None:
        return np.array([_core.default_arrangement(parameters.model_row())[0]])
    circles = _circles("obstacles", obstacles, "[x, y, radius]")
    _require_size("obstacles", circles, LEAST_RADIUS, math.inf)
    return circles


def droplet_circles(
    parameters: Parameters, droplets: ArrayLike | None, obstacles: Floats
) -> Floats:
    """Return start x, y and diameter of each droplet, shape (K, 3), D0.

    By default there is one of diameter 1 at (-start_distance, offset). The obstacles are those that
    `obstacle_circles` returned.

    Raises
    ------
    InputError
        The shape is another, there is none, a number is not finite, a diameter is too small or
        has too many vertices, or a droplet is too near to an obstacle or another droplet.
    """
    if droplets is None:
        starts = np.array([_core.default_arrangement(parameters.model_row())[1]])
    else:
        starts = _circles("droplets", droplets, "[x, y, diameter]")
        largest = MOST_VERTICES / parameters.vertex_count
        _require_size("droplets", starts, LEAST_DIAMETER, largest)
    if not len(starts):
        raise InputError.of("droplets", "at least one", "none", "give [x, y, diameter]")
    _require_clear(starts, obstacles, start_clearance(parameters))
    return starts


def start_clearance(parameters: Parameters) -> float:
    """Return the least gap that a droplet needs at the start, D0.

    Examples
    --------
    >>> start_clearance(Parameters(vertex_count=64))
    0.05
    """
    return max(CLEARANCE, math.pi / parameters.vertex_count)


def _circles(name: str, values: ArrayLike, row: str) -> Floats:
    advice = f"give {row} for each, in D0"
    try:
        circles = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError.of(name, "an array of numbers", values, advice) from None
    if circles.size == 0:
        return np.empty((0, 3))
    if circles.ndim != 2 or circles.shape[1] != 3:
        raise InputError.of(name, "of shape (n, 3)", f"shape {circles.shape}", advice)
    finite = np.isfinite(circles).all(axis=1)
    if not finite.all():
        first = int(np.argmin(finite))
        raise InputError.of(f"{name}[{first}]", "finite", circles[first].tolist(), advice)
    return circles


def _require_size(name: str, circles: Floats, least: float, most: float) -> None:
    """Refuse a circle with an impossible radius."""
    size = "radius" if name == "obstacles" else "diameter"
    rule = f"of {size} at least {least:g} D0"
    if math.isfinite(most):
        rule += f" and at most {most:g} D0, which is {MOST_VERTICES} vertices"
    for i, circle in enumerate(circles.tolist()):
        if not least <= circle[2] <= most:
            advice = "enlarge it" if circle[2] < least else "make it smaller, or lower vertex_count"
            raise InputError.of(f"{name}[{i}]", rule, circle, advice)


def _require_clear(starts: Floats, obstacles: Floats, clearance: float) -> None:
    from scipy.spatial import cKDTree  # slow to import

    discs = np.concatenate((obstacles, starts * [1.0, 1.0, 0.5]))
    tree = cKDTree(discs[:, :2])
    for i, disc in enumerate(discs[len(obstacles) :], start=len(obstacles)):
        reach = disc[2] + discs[:, 2].max() + clearance
        for j in sorted(tree.query_ball_point(disc[:2], reach)):
            other = discs[j]
            if j < i and math.hypot(*(disc[:2] - other[:2])) - disc[2] - other[2] < clearance:
                raise InputError.of(
                    f"droplets[{i - len(obstacles)}]",
                    f"at least {clearance:.3g} D0 clear of every obstacle and of the other "
                    "droplets at the start",
                    starts[i - len(obstacles)].tolist(),
                    f"move it away from ({other[0]:g}, {other[1]:g})",
                )
