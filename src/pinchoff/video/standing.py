"""What stands still in a clip while droplets move: walls, dust, a clock."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.droplets import Droplet

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_STILL_PX, _STILL_AREA = 1.5, 0.08  # how much what stands still may seem to move and to change
_STILL_EDGE = 1.0  # and besides, of its area, square roots of that: what noise does to its border
_STILL_SHARE = 0.6  # of the frames in which it is seen
_LINGERING = 3.0  # times that: it moves, but about its place
_SPREAD_PX = 0.6  # about its mean place: what moves to and fro by more is no dirt
_LONG_TRACK = 10  # whole droplets from which it is known that a track does not move
_TRAVELLED = 2.0  # radii that one has to go to be moving for sure


class Placed(Protocol):
    """What has a place and a size, as droplets and regions have; pixels."""

    @property
    def x(self) -> float:
        """Of its centre."""

    @property
    def y(self) -> float:
        """Of its centre."""

    @property
    def area(self) -> float:
        """Enclosed by it."""


def standing_rows(seen: Sequence[Floats], *, always: bool = False) -> Floats:
    """Return the regions that stand still while others move.

    Parameters
    ----------
    seen : sequence of ndarray, shape (n, 3)
        Centre x, y and area of the regions in each frame.
    always : bool, optional
        Whether to return them also where nothing else moves.

    Returns
    -------
    ndarray, shape (m, 3)
        None where nothing moves, or much to and fro about its place and little farther: then what
        is there are the droplets.
    """
    nothing = np.empty((0, 3))
    if len(seen) < 3:
        return nothing
    every = np.concatenate(seen)
    frames = np.repeat(np.arange(len(seen)), [len(rows) for rows in seen])
    stays = np.array([_stays(every, frames, row, len(seen)) for row in every], dtype=bool)
    stays = stays.reshape(-1, 2)
    still, lingers = stays[:, 0], stays[:, 1]
    to_and_fro = np.count_nonzero(lingers & ~still)
    travel = np.count_nonzero(~lingers)
    trembling = to_and_fro > travel and to_and_fro > 0.5 * np.count_nonzero(still)
    if not always and (still.all() or trembling):
        return nothing
    kept: Floats = every[still]
    return kept


def _stays(every: Floats, frames: NDArray[np.int64], row: Floats, count: int) -> tuple[bool, bool]:
    """Return whether a region stands still, and whether it is near its place, in most frames.

    Parameters
    ----------
    every : ndarray, shape (n, 3)
        Centre x, y and area of the regions in all frames.
    frames : ndarray, shape (n,)
        In which frame each is.
    row : ndarray, shape (3,)
        The region.
    count : int
        Of frames.
    """
    near = _agree(every, row, _LINGERING * _STILL_PX, _LINGERING * _STILL_AREA)
    if len(np.unique(frames[near])) < _STILL_SHARE * count:
        return False, False
    same = near & alike(every, row)
    if len(np.unique(frames[same])) < _STILL_SHARE * count:
        return False, True
    places = np.array([every[same & (frames == k), :2].mean(axis=0) for k in set(frames[same])])
    return bool(np.hypot(*places.std(axis=0)) < _SPREAD_PX), True


def rows_of(regions: Iterable[Placed]) -> Floats:
    """Return centre x, y and area of regions, shape (n, 3), pixels."""
    return np.array([[each.x, each.y, each.area] for each in regions]).reshape(-1, 3)


def without_standing(droplets: Sequence[Droplet], standing: Floats) -> list[Droplet]:
    """Return the droplets that are not near those that stand still, rows of centre and area."""
    if not len(standing):
        return list(droplets)
    distance, share = _LINGERING * _STILL_PX, _LINGERING * _STILL_AREA
    return [
        each
        for each, row in zip(droplets, rows_of(droplets), strict=True)
        if not _agree(standing, row, distance, share).any()
    ]


def alike(rows: Floats, row: Floats) -> Bools:
    """Return which rows of centre and area agree with one."""
    return _agree(rows, row, _STILL_PX, _STILL_AREA)


def _agree(rows: Floats, row: Floats, distance: float, share: float) -> Bools:
    away = np.hypot(rows[:, 0] - row[0], rows[:, 1] - row[1])
    change = np.abs(rows[:, 2] - row[2])
    allowed = share * row[2] + _STILL_EDGE * math.sqrt(row[2])
    agree: Bools = (away <= distance) & (change <= allowed)
    return agree


class Travels:
    """How far the droplets of each track go from where they are first seen whole."""

    def __init__(self) -> None:
        self._first: dict[int, Droplet] = {}
        self._farthest: dict[int, float] = {}
        self._seen: Counter[int] = Counter()

    def append(self, droplets: Sequence[Droplet], tracks: Sequence[int]) -> None:
        """Take one frame."""
        for droplet, track in zip(droplets, tracks, strict=True):
            if not droplet.cut:
                first = self._first.setdefault(track, droplet)
                away = math.hypot(droplet.x - first.x, droplet.y - first.y)
                self._farthest[track] = max(away, self._farthest.get(track, 0.0))
                self._seen[track] += 1

    def standing(self) -> int:
        """Return how many tracks never move, 0 where most of the others do not go far either."""
        long = [track for track, count in self._seen.items() if count >= _LONG_TRACK]
        still = {track for track in long if self._farthest[track] <= _LINGERING * _STILL_PX}
        others = [track for track in long if track not in still]
        far = [
            track
            for track in others
            if self._farthest[track] >= _TRAVELLED * math.sqrt(self._first[track].area / math.pi)
        ]
        return len(still) if 2 * len(far) > len(others) else 0
