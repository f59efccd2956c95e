"""A strip of snapshots: one collision from the approach to after the break-up."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from pinchoff.figures import style
from pinchoff.figures.scene import (
    Scale,
    Window,
    draw_centreline,
    draw_chamber,
    draw_droplets,
    draw_scale_bar,
    draw_streamlines,
)
from pinchoff.model.outlines import Outline, Outlines
from pinchoff.studies.moments import Moment, collision_moments, first_contact
from pinchoff.support import palette
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.flow import Flow

_PANELS_A_ROW = 3
_MARGIN = 0.15  # between what is shown and the edge of the picture [D0]
_TITLE = 0.2  # inch: height of a title above a panel


def snapshot_strip(
    outlines: Outlines,
    times: npt.ArrayLike | None = None,
    axes: Sequence[Axes] | None = None,
    *,
    flow: Flow | None = None,
) -> list[Axes]:
    """Draw snapshots of a collision side by side, all of the same window at the same scale.

    The frame of first contact shows the centreline of the symmetry (dashed: through the obstacle's
    centre, along the droplet's velocity [paper, eq. symdef]), the last one before a break-up
    the neck.

    Parameters
    ----------
    outlines : Outlines
        The collision. Where its parameters hold a physical scale, times are in ms and the bar in
        µm, else in t0 and D0.
    times : (n,) array_like, optional
        Times of the snapshots [t0]; the nearest frames are shown. By default six moments from the
        approach to after the break-up, or to the departure.
    axes : sequence of n Axes, optional
        Where to draw; by default a new figure across two columns.
    flow : Flow, optional
        The flow of the run, such as ``po.flow.stokes(parameters.obstacle_radius)``; its streamlines
        are drawn, as they are without a droplet.

    Returns
    -------
    list of Axes
        One per snapshot; their figure is ``axes[0].figure``.

    Raises
    ------
    InputError
        There are no outlines, a time lies outside of the run, there are not as many axes as
        snapshots, or a flow is given for outlines in µm.

    Examples
    --------
    >>> import pinchoff as po
    >>> panels = snapshot_strip(po.simulate(po.Parameters(), outlines=0.05).outlines)
    >>> [panel.get_title("right") for panel in panels]
    ['approach', 'contact', 'deformation', 'neck', 'break-up', 'after']
    """
    if len(outlines.frame) == 0:
        raise InputError.of("outlines", "of one droplet or more", outlines, "simulate first")
    if flow is not None and outlines.units == "um":
        raise InputError.of("flow", "left out for outlines in µm", flow, "a flow counts in D0")
    moments = collision_moments(outlines) if times is None else _nearest_frames(outlines, times)
    window = Window.around(outlines, (moment.frame for moment in moments), _MARGIN)
    with style.journal_style():
        panels = _new_axes(len(moments), window) if axes is None else list(axes)
        if len(panels) != len(moments):
            raise InputError.of(
                "axes", f"{len(moments)}, one per snapshot", len(panels), "give one for each time"
            )
        scale = Scale.of(outlines)
        for panel, moment in zip(panels, moments, strict=True):
            _draw_snapshot(panel, outlines, moment, window, scale)
            if flow is not None:
                draw_streamlines(panel, flow, outlines, window)
        draw_scale_bar(panels[0], window, scale)
    return panels


def write_snapshots(
    path: str | os.PathLike[str], outlines: Outlines, flow: Flow | None = None
) -> None:
    """Write the default strip as a picture; the suffix chooses its format.

    Parameters
    ----------
    path : path
        The file, as ``.png`` or ``.pdf``; it appears when it is complete.
    outlines : Outlines
        The collision.
    flow : Flow, optional
        Its streamlines are drawn.

    Raises
    ------
    InputError
        There are no outlines.
    """
    with style.off_screen():
        panels = snapshot_strip(outlines, flow=flow)
    style.save(path, panels[0])


def _nearest_frames(outlines: Outlines, times: npt.ArrayLike) -> list[Moment]:
    wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if wanted.ndim != 1 or wanted.size == 0 or not np.all(np.isfinite(wanted)):
        raise InputError.of("times", "finite numbers", times, "give one or more times in t0")
    first, last = float(outlines.times[0]), float(outlines.times[-1])
    outside = wanted[(wanted < first - 1e-9) | (wanted > last + 1e-9)]
    if len(outside):
        rule = f"within the run, from {first:.4g} to {last:.4g}"
        raise InputError.of("times", rule, f"{outside[0]:g}", "give times of the run")
    return [Moment(int(np.argmin(np.abs(outlines.times - time))), "") for time in wanted]


def _new_axes(count: int, window: Window) -> list[Axes]:
    """Make a figure as wide as a page, with rows of panels and room for titles above each."""
    columns = min(count, _PANELS_A_ROW)
    rows = math.ceil(count / columns)
    height = style.TWO_COLUMNS / columns * window.height / window.width + _TITLE
    figure = style.new_figure(style.TWO_COLUMNS, rows * height, layout="compressed")
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    for spare in panels[count:]:
        spare.remove()
    return panels[:count]


def _draw_snapshot(
    axes: Axes, outlines: Outlines, moment: Moment, window: Window, scale: Scale
) -> None:
    draw_chamber(axes, outlines, window)
    droplets = outlines[moment.frame]
    draw_droplets(axes, droplets)
    axes.set_title(scale.time_label(outlines.times[moment.frame]), loc="left")
    axes.set_title(moment.name, loc="right")
    contact = first_contact(outlines) if moment.name == "contact" else None
    if contact is not None:
        centre = outlines.obstacles[contact.obstacle, :2]
        draw_centreline(axes, centre, outlines.outline(contact.outline), palette.CENTRELINE)
    if moment.name == "neck":
        _draw_neck(axes, outlines, droplets)


def _draw_neck(axes: Axes, outlines: Outlines, droplets: Sequence[Outline]) -> None:
    """Draw the thinnest chord among the droplets."""
    necks = [(*outlines.neck(droplet), droplet) for droplet in droplets]
    thickness, i, j, droplet = min(necks, key=lambda neck: neck[0])
    if math.isfinite(thickness):
        axes.plot(
            *droplet.vertices[[i, j]].T,
            color=palette.NECK,
            lw=2,
            solid_capstyle="round",
            zorder=3.5,
        )
