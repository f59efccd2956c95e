"""Why β is near -3/4: on the separating line all droplets have smaller parts of one height."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from pinchoff.collisions.circle_segments import (
    SMALL_SEGMENT_EXPONENT,
    height_of_symmetry,
    local_exponent,
    segment_area,
)
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, LineLike, as_line
from pinchoff.figures import style
from pinchoff.support import palette
from pinchoff.support.numerals import numeral

_OBSTACLE = 0.45  # radius, of the smaller droplet's diameter
_APART = 2.0  # of the two obstacles, in that diameter


def constant_height(
    line: LineLike = PAPER_EXPERIMENT_LINE,
    small_symmetry: float = 0.8,
    axes: Sequence[Axes] | None = None,
) -> list[Axes]:
    """Draw the paper's construction for two sizes, and the exponent that one height gives.

    Left: two droplets on the separating line, one with twice the diameter of the other and the
    rest equal; the smaller parts have nearly one height. Right: d ln S/d ln A of circles that
    share the height h, exactly, against h/D; -3/4 in the limit of small h.

    Parameters
    ----------
    line : Line, fitted law or str, optional
        Its exponent counts.
    small_symmetry : float, optional
        S of the smaller droplet.
    axes : sequence of 2 Axes, optional
        Where to draw; by default a new figure across two columns.

    Returns
    -------
    list of 2 Axes

    Examples
    --------
    >>> construction, exponent = constant_height("paper-rounded")
    >>> exponent.get_xlabel()
    '$h/D$'
    """
    beta = as_line(line).beta
    with style.journal_style():
        panels = style.panels(axes, style.TWO_COLUMNS, 2.6, ncols=2, width_ratios=(1.15, 1))
        _draw_construction(panels[0], beta, small_symmetry)
        _draw_exponent(panels[1], beta)
        return panels


def _draw_construction(axes: Axes, beta: float, small_symmetry: float) -> None:
    heights, areas = [], []
    for diameter, place in ((2.0, -_APART), (1.0, 0.0)):
        axes.add_patch(Circle((place, 0), _OBSTACLE, color=palette.OBSTACLE, zorder=4))
        symmetry = small_symmetry * (diameter**2) ** beta
        height = diameter * height_of_symmetry(symmetry)
        heights.append(height)
        areas.append(float(segment_area(height, diameter)))
        _draw_droplet(axes, diameter, height, place)
    axes.axhline(0.0, color=palette.CENTRELINE, ls=(0, (4, 2)), lw=0.9, zorder=5)
    axes.set_aspect("equal")
    axes.set_xlim(-_APART - 2.35, 0.6)
    axes.set_ylim(-0.62, 1.75)
    axes.set_axis_off()
    text = f"heights $h$ = {heights[1]:.3f} and {heights[0]:.3f} of the small diameter"
    axes.set_title(f"{text}\nyellow areas 1 : {areas[0] / areas[1]:.2f}", loc="left", fontsize=7)


def _draw_droplet(axes: Axes, diameter: float, height: float, place: float) -> None:
    """Draw a circle that touches the obstacle at x = place, with its smaller part in yellow."""
    y = 0.5 * diameter - height
    x = place - np.sqrt((_OBSTACLE + 0.5 * diameter) ** 2 - y**2)
    radius = 0.5 * diameter
    circle = Circle((x, y), radius, fc=palette.DROPLET, ec="none", alpha=0.55, zorder=1)
    below = Rectangle((-9, -9), 18, 9, fc=palette.YELLOW, ec="none", alpha=0.8, zorder=2)
    rim = Circle((x, y), radius, fc="none", ec=palette.DROPLET_RIM, lw=1, zorder=3)
    for patch in (circle, below, rim):
        axes.add_patch(patch)
    below.set_clip_path(circle)
    arrow = {"arrowstyle": "<->", "lw": 0.7, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x, -height), (x, 0), arrowprops=arrow, zorder=6)
    axes.text(x + 0.05, -0.5 * height, "$h$", ha="left", va="center", zorder=6)


def _draw_exponent(axes: Axes, beta: float) -> None:
    relative = np.linspace(1e-3, 0.5, 300)
    axes.plot(relative, local_exponent(relative), color="k", label="one height $h$, exact")
    limit = SMALL_SEGMENT_EXPONENT
    axes.axhline(limit, color=palette.BLUE, ls=":", label=f"limit of small $h$: {numeral(limit)}")
    axes.axhline(
        beta, color=palette.VERMILION, ls="--", label=f"separating line: {numeral(beta, '.3f')}"
    )
    axes.set_xlim(0, 0.5)
    axes.set_ylim(bottom=min(beta, limit) - 0.012)
    axes.set_xlabel("$h/D$")
    axes.set_ylabel(r"$\mathrm{d}\ln S/\mathrm{d}\ln A$")
    axes.legend()
