"""The chamber as a microscope shows it: fluid, obstacles, droplets, a scale bar, the time.

Snapshots and movie draw with these functions, so they look alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle
from numpy.typing import NDArray

from pinchoff.model.outlines import Outline, Outlines
from pinchoff.support import palette

if TYPE_CHECKING:
    from pinchoff.model.flow import Flow

_SCALE_BAR_SHARE = 0.2  # of the window's width, about
_POINTS_AN_EDGE = 8  # of a smooth outline
_STREAMLINE_GRID = 81  # places along each side where the flow is asked for

Floats = NDArray[np.float64]


class Window(NamedTuple):
    """The part of the plane that is shown [D0]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """Width [D0]."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """Height [D0]."""
        return self.top - self.bottom

    @classmethod
    def around(cls, outlines: Outlines, frames: Iterable[int], margin: float = 0.0) -> Window:
        """Return the smallest one with the obstacles and the droplets of some frames in it."""
        centres, radii = outlines.obstacles[:, :2], outlines.obstacles[:, 2:]
        droplets = [droplet.vertices for frame in frames for droplet in outlines[frame]]
        points = np.concatenate([centres - radii, centres + radii, *droplets])
        left, bottom = (points.min(axis=0) - margin).tolist()
        right, top = (points.max(axis=0) + margin).tolist()
        return cls(left, right, bottom, top)


class Scale(NamedTuple):
    """The units in which a run's lengths and times are written, and their sizes."""

    length: float
    length_unit: str
    time: float
    time_unit: str

    @classmethod
    def of(cls, outlines: Outlines) -> Scale:
        """Return µm and ms where the parameters hold a physical scale, else D0 and t0."""
        if outlines.units == "um":
            return cls(1.0, "µm", 1e3, "ms")
        physical = outlines.parameters.get("scale")
        if physical is None:
            return cls(1.0, "$D_0$", 1.0, "$t_0$")
        diameter_um = float(physical["diameter_um"])
        # t0 = D0 / v_f∞, and 1 µm / (1 mm/s) = 1 ms.
        return cls(diameter_um, "µm", diameter_um / float(physical["speed_mm_s"]), "ms")

    def time_label(self, time: float) -> str:
        """Return the label of a time given in t0."""
        value = time * self.time
        # Two decimals of t0, and as many digits of a physical time as those stand for.
        decimals = max(0, 2 - math.floor(math.log10(self.time)))
        return f"$t$ = {value:.{decimals}f} {self.time_unit}"


def draw_chamber(axes: Axes, outlines: Outlines, window: Window) -> None:
    """Draw the fluid and the obstacles, and fit the axes to the window without any ticks."""
    axes.set_facecolor(palette.FLUID)
    axes.set(xlim=(window.left, window.right), ylim=(window.bottom, window.top), aspect="equal")
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    for x, y, radius in outlines.obstacles:
        axes.add_patch(
            Circle((x, y), radius, facecolor=palette.OBSTACLE, edgecolor="none", zorder=3)
        )


def draw_streamlines(axes: Axes, flow: Flow, outlines: Outlines, window: Window) -> None:
    """Draw streamlines of the undisturbed flow, thin and grey, behind the droplets."""
    x = np.linspace(window.left, window.right, _STREAMLINE_GRID)
    y = np.linspace(window.bottom, window.top, _STREAMLINE_GRID)
    places = np.stack(np.meshgrid(x, y), axis=-1)
    velocity: Floats = np.array(flow.velocity(places), dtype=np.float64)
    for centre_x, centre_y, radius in outlines.obstacles:
        inside = np.hypot(places[..., 0] - centre_x, places[..., 1] - centre_y) < radius
        velocity[inside] = np.nan
    lines = axes.streamplot(
        x,
        y,
        velocity[..., 0],
        velocity[..., 1],
        density=(0.7, 0.7 * window.height / window.width),
        color=palette.GREY,
        linewidth=0.5,
        arrowsize=0.5,
        zorder=1.5,
    )
    lines.lines.set_capstyle("round")


def draw_droplets(axes: Axes, droplets: Iterable[Outline], rim: float = 1.0) -> PolyCollection:
    """Draw droplets, pink with a dark rim of the given width [points], as smooth curves."""
    polygons = PolyCollection(
        [smooth_outline(droplet.vertices) for droplet in droplets],
        facecolors=palette.DROPLET,
        edgecolors=palette.DROPLET_RIM,
        linewidths=rim,
        joinstyle="round",
        zorder=2,
    )
    axes.add_collection(polygons, autolim=False)
    return polygons


def smooth_outline(vertices: Floats) -> Floats:
    """Return points on a smooth closed curve through every vertex of an outline.

    A periodic cubic spline over the length of the polygon. For the eye alone: whatever is measured
    is measured on the vertices.

    Parameters
    ----------
    vertices : ndarray, shape (n, 2)
        [D0]

    Returns
    -------
    ndarray, shape (8 n, 2)
        Every eighth one is a vertex.

    Examples
    --------
    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> smooth_outline(square).shape
    (32, 2)
    """
    from scipy.interpolate import CubicSpline  # slow to import

    closed = np.concatenate([vertices, vertices[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    curve = CubicSpline(along, closed, bc_type="periodic")
    share = np.arange(_POINTS_AN_EDGE) / _POINTS_AN_EDGE
    places = along[:-1, None] + share * np.diff(along)[:, None]
    return np.asarray(curve(places.ravel()))


def draw_centreline(axes: Axes, centre: Floats, droplet: Outline, color: str) -> None:
    """Draw the line that divides a droplet at contact into the two areas of its symmetry."""
    # along the velocity of the centre of mass: all mass sits on the vertices
    other = centre + droplet.velocities.mean(axis=0)
    axes.axline(tuple(centre), tuple(other), color=color, lw=1, ls=(0, (4, 2)), zorder=3.5)


def draw_scale_bar(axes: Axes, window: Window, scale: Scale) -> None:
    """Draw a bar of a round length, with the length, in the lower right corner."""
    length = round_length(_SCALE_BAR_SHARE * window.width * scale.length)
    right = window.right - 0.04 * window.width
    left = right - length / scale.length
    height = window.bottom + 0.07 * window.height
    axes.plot(
        [left, right], [height, height], color=palette.INK, lw=2, solid_capstyle="butt", zorder=4
    )
    axes.annotate(
        f"{length:g} {scale.length_unit}",
        ((left + right) / 2, height),
        xytext=(0, 2.5),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize="small",
    )


def round_length(value: float) -> float:
    """Return the number of the form 1, 2 or 5 times a power of ten that is nearest in ratio."""
    power = 10.0 ** math.floor(math.log10(value))
    return min((k * power for k in (1, 2, 5, 10)), key=lambda length: abs(math.log(length / value)))
