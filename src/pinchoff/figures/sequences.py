"""Pairs of images of collisions, before and after, as a microscope's film shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pinchoff.figures import style
from pinchoff.figures.scene import Scale, Window, draw_chamber, draw_droplets, draw_scale_bar
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.results import Collision
    from pinchoff.support.quantities import PhysicalScale

TRAVEL_UM = 400.0
"""Way of the fluid between the two images of a pair, as in the paper, µm."""

_MARGIN_UM = 60.0  # round all that is shown
_FOOT_UM = 110.0  # below that, where the scale bar stands


def collision_pairs(
    collisions: Sequence[Collision], axes: Sequence[Axes] | None = None
) -> list[Axes]:
    """Draw two images of each collision, v Δt = 400 µm apart, around its middle.

    Parameters
    ----------
    collisions : sequence of n Collision
        They must be made from physical quantities and have outlines.
    axes : sequence of 2n Axes, optional
        Where to draw, two a row; by default a new figure.

    Returns
    -------
    list of Axes

    Raises
    ------
    InputError
        A collision has no outlines or no physical scale.
    """
    shown = [_frames(collision) for collision in collisions]
    window = _window(collisions, shown)
    with style.journal_style():
        width = 0.8 * style.TWO_COLUMNS
        height = (0.5 * width * window.height / window.width + 0.25) * len(collisions)
        panels = style.panels(axes, width, height, nrows=len(collisions), ncols=2)
        for k, collision in enumerate(collisions):
            _draw_pair(panels[2 * k : 2 * k + 2], collision, shown[k], window)
        return panels


def _frames(collision: Collision) -> tuple[int, int]:
    """Return the frames of the two images."""
    outlines, scale = _filmed(collision)
    half = 0.5 * TRAVEL_UM / scale.diameter_um  # t0 = D0/v: a length in D0 is the time in t0
    middle = _middle(collision, outlines)
    before, after = (
        int(np.argmin(np.abs(outlines.times - time))) for time in (middle - half, middle + half)
    )
    return before, after


def _filmed(collision: Collision) -> tuple[Outlines, PhysicalScale]:
    outlines, scale = collision.outlines, collision.parameters.scale
    if outlines is None or scale is None:
        rule = "ones with outlines, from physical quantities"
        raise InputError.of("collisions", rule, collision, "simulate with outlines=True")
    return outlines, scale


def _window(collisions: Sequence[Collision], shown: Sequence[tuple[int, int]]) -> Window:
    """Return what all images show, in µm about the obstacle: whole droplets, at one scale."""
    filmed = [_filmed(collision) for collision in collisions]
    windows = [
        np.array(Window.around(outlines, frames)) * scale.diameter_um
        for (outlines, scale), frames in zip(filmed, shown, strict=True)
    ]
    left, right, bottom, top = zip(*windows, strict=True)
    return Window(
        min(left) - _MARGIN_UM,
        max(right) + _MARGIN_UM,
        min(bottom) - _FOOT_UM,
        max(top) + _MARGIN_UM,
    )


def _draw_pair(
    pair: Sequence[Axes], collision: Collision, frames: tuple[int, int], window: Window
) -> None:
    outlines, scale = _filmed(collision)
    view = Window(*(length / scale.diameter_um for length in window))
    for panel, frame in zip(pair, frames, strict=True):
        draw_chamber(panel, outlines, view)
        draw_droplets(panel, outlines[frame])
        label = Scale.of(outlines).time_label(outlines.times[frame])
        panel.text(0.02, 0.03, label, transform=panel.transAxes, fontsize=7)
    outcome = "breaks" if collision.broke else "does not break"
    pair[0].set_title(
        f"$v$ = {scale.speed_mm_s:g} mm/s, $S$ = {collision.symmetry:.2f}: {outcome}", loc="left"
    )
    draw_scale_bar(pair[1], view, Scale.of(outlines))


def _middle(collision: Collision, outlines: Outlines) -> float:
    """Return the time of the break-up, or that at which the droplet passes the obstacle."""
    if collision.broke:
        return collision.breakup_time
    places = [outlines.outline(k).vertices[:, 0].mean() for k in range(len(outlines.frame))]
    beyond = np.flatnonzero(np.array(places) > outlines.obstacles[0, 0])
    frame = outlines.frame[beyond[0]] if len(beyond) else len(outlines) - 1
    return float(outlines.times[frame])
