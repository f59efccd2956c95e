"""A strip of snapshots: one collision from the approach to what is left of the droplet."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pinchoff.figures import style
from pinchoff.figures.scene import (
    Scale,
    Window,
    draw_chamber,
    draw_droplets,
    draw_scale_bar,
)
from pinchoff.model.outlines import Outline, Outlines
from pinchoff.support.errors import InputError
from pinchoff.support.files import written_aside

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.gsd import Floats

_PANELS_A_ROW = 3
_APPROACH_GAP = 0.35  # between droplet and obstacle in the first snapshot [D0]
_DEPARTURE = 1.2  # of the foremost centroid from the last obstacle in the last snapshot [D0]
_MARGIN = 0.15  # round everything that is shown [D0]


class Moment(NamedTuple):
    """A frame worth showing, and what happens in it."""

    frame: int
    name: str


class _Contact(NamedTuple):
    """First contact: its frame, which outline (of all) touches, and which obstacle."""

    frame: int
    outline: int
    obstacle: int


def snapshot_strip(
    outlines: Outlines,
    times: npt.ArrayLike | None = None,
    axes: Sequence[Axes] | None = None,
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

    Returns
    -------
    list of Axes
        One per snapshot; their figure is ``axes[0].figure``.

    Raises
    ------
    InputError
        If there are no outlines, or not as many axes as snapshots.
    """
    if len(outlines.frame) == 0:
        raise InputError.of("outlines", "of one droplet or more", outlines, "simulate first")
    moments = collision_moments(outlines) if times is None else _nearest_frames(outlines, times)
    window = _window(outlines, moments)
    with style.journal_style():
        panels = _new_axes(len(moments), window) if axes is None else list(axes)
        if len(panels) != len(moments):
            raise InputError.of(
                "axes", f"{len(moments)}, one per snapshot", len(panels), "give one for each time"
            )
        scale = Scale.of(outlines)
        for panel, moment in zip(panels, moments, strict=True):
            _draw_snapshot(panel, outlines, moment, window, scale)
        draw_scale_bar(panels[0], window, scale)
    return panels


def write_snapshots(path: str | os.PathLike[str], outlines: Outlines) -> None:
    """Write the default strip as a picture; the suffix chooses its format.

    Parameters
    ----------
    path : path
        The file, as ``.png`` or ``.pdf``; it appears when it is complete.
    outlines : Outlines
        The collision.

    Raises
    ------
    InputError
        If there are no outlines.
    """
    figure = snapshot_strip(outlines)[0].figure
    assert isinstance(figure, Figure)
    with written_aside(Path(path)) as unfinished:
        figure.savefig(unfinished)


def collision_moments(outlines: Outlines) -> list[Moment]:
    """Choose the frames that tell a collision, from the outlines alone.

    Returns
    -------
    list of Moment
        Approach, contact, deformation, neck, break-up and after; without a break-up the greatest
        deformation stands for the neck; without a contact, six frames of the passage. Moments that
        fall on one frame are listed once.
    """
    table = outlines.measure()
    contact = _first_contact(outlines)
    if contact is None:
        return _pass_moments(table, outlines)
    breakup = _breakup_frame(outlines)
    after = _departure_frame(table, outlines, breakup or contact.frame)
    told = [
        Moment(_approach_frame(outlines, contact.frame), "approach"),
        Moment(contact.frame, "contact"),
        *(
            _slip_moments(table, contact.frame, after)
            if breakup is None
            else _breakup_moments(contact.frame, breakup)
        ),
        Moment(after, "after"),
    ]
    first_named = {moment.frame: moment for moment in reversed(told)}
    return [first_named[frame] for frame in sorted(first_named)]


def _breakup_moments(contact: int, breakup: int) -> list[Moment]:
    return [
        Moment((contact + breakup) // 2, "deformation"),
        Moment(breakup - 1, "neck"),
        Moment(breakup, "break-up"),
    ]


def _slip_moments(table: pd.DataFrame, contact: int, after: int) -> list[Moment]:
    shown = table[table["frame"].between(contact, after)]
    most = int(shown["frame"].to_numpy()[shown["shape_parameter"].argmax()])
    return [
        Moment((contact + most) // 2, "deformation"),
        Moment(most, "most deformed"),
        Moment((most + after) // 2, "passing"),
    ]


def _pass_moments(table: pd.DataFrame, outlines: Outlines) -> list[Moment]:
    """Return moments at equal intervals while a droplet passes the obstacles, or all along."""
    near = table["frame"]
    if len(outlines.obstacles):
        low, high = outlines.obstacles[:, 0].min(), outlines.obstacles[:, 0].max()
        near = near[table["x"].between(low - _DEPARTURE, high + _DEPARTURE)]
    first, last = (near.min(), near.max()) if len(near) else (0, len(outlines) - 1)
    frames = np.unique(np.linspace(first, last, 2 * _PANELS_A_ROW).round().astype(int))
    return [Moment(int(frame), "") for frame in frames]


def _nearest_frames(outlines: Outlines, times: npt.ArrayLike) -> list[Moment]:
    wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if wanted.ndim != 1 or wanted.size == 0 or not np.all(np.isfinite(wanted)):
        raise InputError.of("times", "finite numbers", times, "give one or more times in t0")
    return [Moment(int(np.argmin(np.abs(outlines.times - time))), "") for time in wanted]


def _distances(outlines: Outlines) -> Floats:
    """Return the distance of each vertex from the surface of each obstacle: (V, M) [D0]."""
    separation = outlines.vertices[:, None, :] - outlines.obstacles[None, :, :2]
    return np.hypot(separation[..., 0], separation[..., 1]) - outlines.obstacles[:, 2]


def _first_contact(outlines: Outlines) -> _Contact | None:
    """Find the first vertex within half an edge of an obstacle: there it feels the wall."""
    sizes = np.diff(outlines.offsets)
    perimeters = outlines.measure()["perimeter"].to_numpy()
    reach = np.repeat(0.5 * perimeters / sizes, sizes)
    vertices, obstacles = np.nonzero(_distances(outlines) < reach[:, None])
    if len(vertices) == 0:
        return None
    outline = int(np.searchsorted(outlines.offsets, vertices[0], side="right")) - 1
    return _Contact(int(outlines.frame[outline]), outline, int(obstacles[0]))


def _approach_frame(outlines: Outlines, contact: int) -> int:
    """Return the last frame before the contact in which every droplet keeps its distance."""
    near = np.flatnonzero(_distances(outlines).min(axis=1) < _APPROACH_GAP)
    outline = np.searchsorted(outlines.offsets, near[0], side="right") - 1
    return max(min(int(outlines.frame[outline]), contact) - 1, 0)


def _breakup_frame(outlines: Outlines) -> int | None:
    """Return the first frame with a daughter."""
    born = outlines.frame[outlines.generation > outlines.generation[0]]
    return int(born[0]) if len(born) else None


def _departure_frame(table: pd.DataFrame, outlines: Outlines, first: int) -> int:
    """Return the first frame after `first` in which a droplet is well past the obstacles."""
    beyond = outlines.obstacles[:, 0].max() + _DEPARTURE
    gone = table.loc[(table["frame"] > first) & (table["x"] > beyond), "frame"]
    return int(gone.iloc[0]) if len(gone) else len(outlines) - 1


def _window(outlines: Outlines, moments: Sequence[Moment]) -> Window:
    """Return the window that holds all that is shown, even about the obstacles' mean height."""
    corners = [
        outlines.obstacles[:, :2] - outlines.obstacles[:, 2:],
        outlines.obstacles[:, :2] + outlines.obstacles[:, 2:],
        *(droplet.vertices for moment in moments for droplet in outlines[moment.frame]),
    ]
    points = np.concatenate(corners)
    left, bottom = points.min(axis=0) - _MARGIN
    right, top = points.max(axis=0) + _MARGIN
    return Window(float(left), float(right), float(bottom), float(top))


def _new_axes(count: int, window: Window) -> list[Axes]:
    """Make a figure as wide as a page with rows of equal panels, and room for titles above."""
    columns = min(count, _PANELS_A_ROW)
    rows = math.ceil(count / columns)
    edge, gap, title = 0.03, 0.08, 0.2  # inches: round the figure, between panels, above each
    width = (style.TWO_COLUMNS - 2 * edge - (columns - 1) * gap) / columns
    height = width * window.height / window.width
    total = rows * (height + title) + 2 * edge
    figure = Figure(figsize=(style.TWO_COLUMNS, total))
    panels = []
    for k in range(count):
        row, column = divmod(k, columns)
        left = edge + column * (width + gap)
        bottom = edge + (rows - 1 - row) * (height + title)
        box = (left / style.TWO_COLUMNS, bottom / total, width / style.TWO_COLUMNS, height / total)
        panels.append(figure.add_axes(box))
    return panels


def _draw_snapshot(
    axes: Axes, outlines: Outlines, moment: Moment, window: Window, scale: Scale
) -> None:
    draw_chamber(axes, outlines, window)
    droplets = outlines[moment.frame]
    draw_droplets(axes, droplets)
    axes.set_title(scale.time_label(outlines.times[moment.frame]), loc="left")
    axes.set_title(moment.name, loc="right")
    if moment.name == "contact":
        _draw_centreline(axes, outlines)
    if moment.name == "neck":
        _draw_neck(axes, outlines, droplets)


def _draw_centreline(axes: Axes, outlines: Outlines) -> None:
    """Draw the line that divides the droplet at contact into the two areas of its symmetry."""
    contact = _first_contact(outlines)
    if contact is None:
        return
    droplet = outlines.outline(contact.outline)
    centre = outlines.obstacles[contact.obstacle, :2]
    velocity = droplet.velocities.mean(axis=0)  # of the mass, which sits on the vertices
    axes.axline(
        tuple(centre),
        tuple(centre + velocity),
        color=style.CENTRELINE,
        lw=1,
        ls=(0, (4, 2)),
        zorder=2.5,
    )


def _draw_neck(axes: Axes, outlines: Outlines, droplets: Sequence[Outline]) -> None:
    """Draw the thinnest chord among the droplets."""
    necks = [outlines.neck(droplet) for droplet in droplets]
    thinnest = min(range(len(necks)), key=lambda k: necks[k][0])
    thickness, i, j = necks[thinnest]
    if math.isfinite(thickness):
        ends = droplets[thinnest].vertices[[i, j]]
        axes.plot(*ends.T, color=style.NECK, lw=2, solid_capstyle="round", zorder=3.5)
