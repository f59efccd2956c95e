"""Pairs of images of collisions, before and after, as a microscope's film shows them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pinchoff.figures import style
from pinchoff.figures.scene import Scale, Window, draw_chamber, draw_droplets, draw_scale_bar
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.results import Collision

TRAVEL_UM = 400.0
"""Way of the fluid between the two images of a pair, as in the paper, µm."""

_SEEN_UM = (1150.0, 720.0)  # width and height of an image
_BEHIND = 0.42  # share of the width that lies upstream of the obstacle


def collision_pairs(
    collisions: Sequence[Collision], axes: Sequence[Axes] | None = None
) -> list[Axes]:
    """Draw two images of each collision, v Δt = 400 µm apart, about the middle of it.

    Parameters
    ----------
    collisions : sequence of n Collision
        From physical quantities, with outlines.
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
    with style.journal_style():
        if axes is None:
            height = 1.75 * len(collisions)
            figure = Figure(figsize=(0.8 * style.TWO_COLUMNS, height), layout="constrained")
            axes = list(figure.subplots(len(collisions), 2, squeeze=False).flat)
        for k, collision in enumerate(collisions):
            _draw_pair(axes[2 * k : 2 * k + 2], collision)
        return list(axes)


def _draw_pair(pair: Sequence[Axes], collision: Collision) -> None:
    outlines, scale = collision.outlines, collision.parameters.scale
    if outlines is None or scale is None:
        rule = "ones with outlines, from physical quantities"
        raise InputError.of("collisions", rule, collision, "simulate with outlines=True")
    unit = scale.diameter_um
    half = 0.5 * TRAVEL_UM / unit  # t0 = D0/v: a length in D0 is the time in t0
    middle = _middle(collision, outlines)
    width, height = _SEEN_UM[0] / unit, _SEEN_UM[1] / unit
    window = Window(-_BEHIND * width, (1 - _BEHIND) * width, -0.5 * height, 0.5 * height)
    for panel, time in zip(pair, (middle - half, middle + half), strict=True):
        frame = int(np.argmin(np.abs(outlines.times - time)))
        draw_chamber(panel, outlines, window)
        draw_droplets(panel, outlines[frame])
        label = Scale.of(outlines).time_label(outlines.times[frame])
        panel.text(0.02, 0.04, label, transform=panel.transAxes, fontsize=7, zorder=6)
    outcome = "breaks" if collision.broke else "does not break"
    pair[0].set_title(
        f"$v$ = {scale.speed_mm_s:g} mm/s, $S$ = {collision.symmetry:.2f}: {outcome}", loc="left"
    )
    draw_scale_bar(pair[1], window, Scale.of(outlines))


def _middle(collision: Collision, outlines: Outlines) -> float:
    """Return the time of the break-up, or that at which the droplet passes the obstacle."""
    if collision.broke:
        return collision.breakup_time
    places = [outlines.outline(k).vertices[:, 0].mean() for k in range(len(outlines.frame))]
    beyond = np.flatnonzero(np.array(places) > outlines.obstacles[0, 0])
    frame = outlines.frame[beyond[0]] if len(beyond) else len(outlines) - 1
    return float(outlines.times[frame])
