"""Droplets as plugs: length, width, speed, and how often they are formed.

A droplet that is first seen whole inside the frame was pinched off there, from a thread; one that
comes in over the frame's edge was formed before. The time between two that were formed in the same
way is the period of formation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import cv2
import numpy as np

from pinchoff.video.clips import Measured
from pinchoff.video.droplets import Droplet

FORMED, ENTERED, PRESENT = "pinch-off", "entry", "first frame"
"""How a droplet came to be: pinched off in view, come in over the edge, there from the start."""

_FEWEST_FRAMES = 3  # in which a plug is whole
_FEWEST_FORMED = 2  # plugs from which a rate follows


class Plug(NamedTuple):
    """One droplet over all frames in which it is whole.

    Attributes
    ----------
    track : int
    born : str
        `FORMED`, `ENTERED` or `PRESENT`.
    frame : int
        The first in which it is seen.
    time_s, period_s : float
        When that is, and the time since the one before that was born in the same way; NaN for
        the first.
    frames : int
        In which it is whole.
    length, width : float
        Sides of the smallest rectangle about it, pixels; medians.
    area : float
        Pixels; median.
    speed : float
        Of its centre along its path, pixels a second.
    """

    track: int
    born: str
    frame: int
    time_s: float
    period_s: float
    frames: int
    length: float
    width: float
    area: float
    speed: float


@dataclass
class _Followed:
    """What is kept of one track."""

    born: str
    frame: int
    time_s: float
    rows: list[tuple[float, ...]] = field(default_factory=list)


class PlugFinder:
    """Gather plugs frame by frame."""

    def __init__(self) -> None:
        self._tracks: dict[int, _Followed] = {}
        self._first: int | None = None

    def append(self, seen: Measured) -> None:
        """Take one frame."""
        if self._first is None:
            self._first = seen.frame.number
        for droplet, track in zip(seen.droplets, seen.tracks, strict=True):
            if track not in self._tracks:
                self._tracks[track] = self._begun(droplet, seen)
            if not droplet.cut:
                self._tracks[track].rows.append((seen.frame.time_s, *_measures(droplet)))

    def _begun(self, droplet: Droplet, seen: Measured) -> _Followed:
        born = ENTERED if droplet.cut else FORMED
        if seen.frame.number == self._first:
            born = PRESENT
        return _Followed(born, seen.frame.number, seen.frame.time_s)

    def plugs(self) -> list[Plug]:
        """Return the plugs in the order in which they were born."""
        found = []
        last: dict[str, float] = {}
        for track, droplet in sorted(self._tracks.items(), key=lambda item: item[1].frame):
            if len(droplet.rows) < _FEWEST_FRAMES:
                continue
            rows = np.array(droplet.rows)
            length, width, area = np.median(rows[:, 3:], axis=0).tolist()
            period = droplet.time_s - last.get(droplet.born, math.nan)
            last[droplet.born] = droplet.time_s
            found.append(
                Plug(
                    track,
                    droplet.born,
                    droplet.frame,
                    droplet.time_s,
                    math.nan if droplet.born == PRESENT else period,
                    len(rows),
                    length,
                    width,
                    area,
                    _speed(rows[:, 0], rows[:, 1:3]),
                )
            )
        return found


def formation_rate(plugs: list[Plug]) -> float | None:
    """Return how many plugs are formed a second: the inverse of the median period; or None.

    Of those that are pinched off in view; where there are none, of those that come in.
    """
    for born in (FORMED, ENTERED):
        periods = [plug.period_s for plug in plugs if plug.born == born]
        known = [period for period in periods if math.isfinite(period) and period > 0.0]
        if len(known) >= _FEWEST_FORMED:
            return 1.0 / float(np.median(known))
    return None


def _measures(droplet: Droplet) -> tuple[float, ...]:
    _, sides, _ = cv2.minAreaRect(droplet.outline.astype(np.float32))
    return droplet.x, droplet.y, max(sides), min(sides), droplet.area


def _speed(times: np.ndarray, places: np.ndarray) -> float:
    """Return the speed of a straight line through places, by least squares."""
    since = times - times.mean()
    spread = float((since**2).sum())
    if spread <= 0.0:
        return math.nan
    return float(np.hypot(*(since @ (places - places.mean(axis=0)) / spread)))
