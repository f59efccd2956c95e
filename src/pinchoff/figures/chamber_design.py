"""The device as a drawing: its regions coloured and numbered, and where it breaks a rule."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle, Patch, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.layout import REGIONS
from pinchoff.chamber.rules import broken_rules
from pinchoff.chamber.shapes import polygons
from pinchoff.figures import style
from pinchoff.support import palette

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.rules import Violation

#: Colour and name of each region, near those of the appendix's figure.
REGION_LOOK = {
    "inlets": ("#f0e442", "inlets with debris traps"),
    "junction": ("#b5e08c", "flow-focusing junction"),
    "oil_inputs": ("#2ca25f", "extra oil inlets"),
    "expansion": ("#9fd3f0", "expansion"),
    "supports": ("#3b62ad", "structural pillars"),
    "imaging": ("#b48ad0", "imaging area"),
    "exit": ("#f0a04b", "converging exit"),
}
_VIOLATION = "#d62728"
_RIM = 0.3
_RING_SHARE = 0.012  # of the chip's length: radius of the ring round a violation
_APART = 2.5  # rings: numbers of one rule are not written nearer to each other


def chamber_design(
    chamber: Chamber, violations: Sequence[Violation] = (), axes: Axes | None = None
) -> Axes:
    """Draw the device from above, flow to the right, lengths in mm.

    Parameters
    ----------
    chamber : Chamber
    violations : sequence of Violation, optional
        Places to mark, numbered in their order.
    axes : Axes, optional
        Where to draw; by default a new figure across two columns.

    Returns
    -------
    Axes
    """
    layout = chamber.layout
    with style.journal_style():
        if axes is None:
            axes = _wide_panel(layout.outline.bounds, len(broken_rules(violations)))
        # Artists, not patches, whose limits matplotlib would compute point by point.
        for name, shape in layout.regions.items():
            color = REGION_LOOK[name][0]
            axes.add_artist(shape_patch(shape, facecolor=color, edgecolor="0.25", lw=_RIM))
        for shape in layout.marks.values():
            axes.add_artist(shape_patch(shape, facecolor="0.45", lw=0))
        if violations:
            _draw_violations(axes, violations, layout.outline.bounds)
        else:
            _draw_numbers(axes, chamber)
        left, low, right, high = (side / 1e3 for side in layout.outline.bounds)
        axes.add_patch(Rectangle((left, low), right - left, high - low, fill=False, lw=0.6))
        axes.set(xlim=(left, right), ylim=(low, high), aspect="equal")
        axes.set(xlabel="along the flow, $x$ (mm)", ylabel="across, $y$ (mm)")
        _draw_legend(axes)
        return axes


def shape_patch(shape: BaseGeometry, **look: Any) -> PathPatch:
    """Return a shape given in µm, with its holes, as a patch in mm."""
    parts = [
        Outline(np.asarray(ring.coords)[:, :2] / 1e3, closed=True)
        for polygon in polygons(shape)
        for ring in (polygon.exterior, *polygon.interiors)
    ]
    return PathPatch(Outline.make_compound_path(*parts), **look)


def _wide_panel(bounds: tuple[float, float, float, float], lines: int) -> Axes:
    left, low, right, high = bounds
    height = (style.TWO_COLUMNS - 0.5) * (high - low) / (right - left) + 0.95
    height += 0.11 * lines  # of the list above it
    figure = style.new_figure(style.TWO_COLUMNS, height)
    return figure.subplots()


def _draw_numbers(axes: Axes, chamber: Chamber) -> None:
    """Write each region's number where it has most room, once, at y >= 0."""
    for number, shape in enumerate(chamber.layout.regions.values(), start=1):
        upper = [part for part in polygons(shape) if part.centroid.y > -1.0]
        room = shapely.maximum_inscribed_circle(max(upper, key=lambda part: part.area), 10.0)
        x, y = room.coords[0]
        axes.annotate(
            str(number),
            (x / 1e3, y / 1e3),
            ha="center",
            va="center",
            fontsize=7,
            bbox={"boxstyle": "circle,pad=0.18", "fc": "white", "ec": palette.INK, "lw": 0.5},
            zorder=5,
        )


def _draw_violations(
    axes: Axes, violations: Sequence[Violation], bounds: tuple[float, float, float, float]
) -> None:
    """Mark each place in red, with a ring that shows where to look and its rule's number."""
    ring = _RING_SHARE * (bounds[2] - bounds[0]) / 1e3
    look = {"facecolor": (*to_rgb(_VIOLATION), 0.5), "edgecolor": _VIOLATION, "lw": 0.5}
    rules = broken_rules(violations)
    for number, places in enumerate(rules.values(), start=1):
        numbered: list[tuple[float, float]] = []
        for violation in places:
            axes.add_artist(shape_patch(violation.shape, **look, zorder=4))
            place = violation.x_um / 1e3, violation.y_um / 1e3
            axes.add_patch(Circle(place, ring, fill=False, edgecolor=_VIOLATION, lw=0.9, zorder=5))
            if all(math.dist(place, other) > _APART * ring for other in numbered):
                numbered.append(place)
                _draw_number(axes, number, place, ring)
    listed = [f"{number}  {line}" for number, line in enumerate(rules, start=1)]
    axes.set_title("\n".join(listed), loc="left", fontsize=6, color=_VIOLATION)


def _draw_number(axes: Axes, number: int, place: tuple[float, float], above: float) -> None:
    axes.annotate(
        str(number),
        (place[0], place[1] + above),
        xytext=(0, 1),
        textcoords="offset points",
        color=_VIOLATION,
        fontsize=6,
        ha="center",
        va="bottom",
        bbox={"boxstyle": "round,pad=0.1", "fc": "white", "lw": 0},
        zorder=6,
    )


def _draw_legend(axes: Axes) -> None:
    patches = [
        Patch(facecolor=color, edgecolor="0.25", lw=_RIM, label=f"{number}  {name}")
        for number, (color, name) in enumerate((REGION_LOOK[region] for region in REGIONS), start=1)
    ]
    axes.legend(
        handles=patches,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.16),
        ncols=4,
        columnspacing=1.2,
        handlelength=1.2,
    )
