"""The moments that tell a collision, chosen from its outlines alone: contact, neck, break-up."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinchoff import _core

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.gsd import Floats
    from pinchoff.model.outlines import Outlines

_PASSING = 6  # frames that show a passage without a contact
_APPROACH_GAP = 0.35  # between droplet and obstacle in the frame of the approach, D0
_DEPARTURE = 1.2  # of the foremost droplet beyond the last obstacle, in the last frame, D0


class Moment(NamedTuple):
    """A frame worth showing, and what happens in it."""

    frame: int
    name: str


class Contact(NamedTuple):
    """First contact of a droplet with an obstacle."""

    frame: int
    outline: int  # which of all outlines touches
    obstacle: int


def collision_moments(outlines: Outlines) -> list[Moment]:
    """Choose the frames that tell a collision, from the outlines alone.

    They are approach, contact, deformation, neck, break-up and after; without a break-up the
    greatest deformation stands for the neck; without a contact, six frames of the passage. Moments
    that fall on one frame are listed once.
    """
    table = outlines.measure()
    contact = first_contact(outlines)
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
    touching = table[table["frame"].between(contact, after)]
    most = int(touching["frame"].to_numpy()[touching["shape_parameter"].argmax()])
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
        beyond = _DEPARTURE * _diameter(outlines)
        near = near[table["x"].between(low - beyond, high + beyond)]
    first, last = (near.min(), near.max()) if len(near) else (0, len(outlines) - 1)
    frames = np.unique(np.linspace(first, last, _PASSING).round().astype(int))
    return [Moment(int(frame), "") for frame in frames]


def _diameter(outlines: Outlines) -> float:
    """Return D0 in the outlines' own unit; of filmed ones that of the first."""
    if outlines.units == "D0" or not len(outlines.frame):
        return 1.0
    return math.sqrt(4.0 / math.pi * float(_core.area(outlines.outline(0).vertices)))


def _distances(outlines: Outlines) -> Floats:
    """Return the distance of each vertex from the surface of each obstacle, shape (V, M)."""
    separation = outlines.vertices[:, None, :] - outlines.obstacles[None, :, :2]
    return np.hypot(separation[..., 0], separation[..., 1]) - outlines.obstacles[:, 2]


def first_contact(outlines: Outlines) -> Contact | None:
    """Find the first vertex within half an edge of an obstacle: there it feels the wall."""
    sizes = np.diff(outlines.offsets)
    perimeters = outlines.measure()["perimeter"].to_numpy()
    reach = np.repeat(0.5 * perimeters / sizes, sizes)
    vertices, obstacles = np.nonzero(_distances(outlines) < reach[:, None])
    if len(vertices) == 0:
        return None
    outline = int(np.searchsorted(outlines.offsets, vertices[0], side="right")) - 1
    return Contact(int(outlines.frame[outline]), outline, int(obstacles[0]))


def _approach_frame(outlines: Outlines, contact: int) -> int:
    """Return the last frame before the contact in which every droplet keeps its distance."""
    gap = _APPROACH_GAP * _diameter(outlines)
    near = np.flatnonzero(_distances(outlines).min(axis=1) < gap)
    outlines_near = np.searchsorted(outlines.offsets, near[:1], side="right") - 1
    first = min([contact, *map(int, outlines.frame[outlines_near])])
    return max(first - 1, 0)


def _breakup_frame(outlines: Outlines) -> int | None:
    """Return the first frame with a daughter."""
    born = outlines.frame[outlines.generation > outlines.generation[0]]
    return int(born[0]) if len(born) else None


def _departure_frame(table: pd.DataFrame, outlines: Outlines, first: int) -> int:
    """Return the first frame after `first` in which a droplet is well past the obstacles."""
    beyond = outlines.obstacles[:, 0].max() + _DEPARTURE * _diameter(outlines)
    gone = table.loc[(table["frame"] > first) & (table["x"] > beyond), "frame"]
    return int(gone.iloc[0]) if len(gone) else len(outlines) - 1
