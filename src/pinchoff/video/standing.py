"""What stands still in a clip while droplets move: walls, dust, a clock; or that nothing does."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.droplets import Droplet, Segmenter
from pinchoff.video.reading import Frame

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_STILL_PX, _STILL_AREA = 1.5, 0.08  # how much what stands still may seem to move and to change
_STILL_EDGE = 1.0  # and besides, of its area, square roots of that: what noise does to its border
_STILL_SHARE = 0.6  # of the frames in which it is seen
_LINGERING = 3.0  # times that: it moves, but about its place
_SPREAD_PX = 0.6  # about its mean place: what moves to and fro by more is no dirt
_LONG_TRACK = 10  # whole droplets from which it is known that a track does not move
_TRAVELLED = 2.0  # radii that one has to go to be moving for sure
_PAIRS = 5  # of frames in which it is looked whether the picture moves
_SHIFT_PX = 0.5  # least that it does
_EXPLAINED = 0.8  # of what differs between two frames, what is left once one is moved back
_MOST_DIFFERENT = 60.0  # grey levels: a droplet that comes and goes counts for no more
_NOTHING = 0.5  # grey levels: frames that differ by less are the same
_AROUND, _AROUND_PX = 0.5, 6.0  # radii, and pixels at least, beyond an outline: light about it
_FARTHEST = 0.25  # of the shorter side, the picture may go
_FREE_SHARE = 0.05  # least part of the frame without droplets in which it can be seen
_TO_AND_FRO = 0.5  # of the way that the picture goes, what it is farther in the end, at most
_TOGETHER = 0.5  # of what differs, what is left where all goes to and fro together


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


class PictureMoved(NamedTuple):
    """The picture itself moved, by so many pixels, between two frames given by number."""

    pixels: float
    first: int
    last: int


def picture_moved(
    pairs: Sequence[tuple[Frame, Frame]], segmenter: Segmenter
) -> PictureMoved | None:
    """Return by how much the picture itself moves from a frame to another, None if it does not.

    It moves if what is no droplet does, dirt and walls and shades; or if everything goes to and
    fro together, as no droplets do. What stands cannot be told from what moves then.
    """
    places = np.linspace(0, len(pairs) - 1, min(_PAIRS, len(pairs)))
    some = [pairs[round(place)] for place in places.tolist()]
    shifts = [_shift(*pair) for pair in some]
    left = [_left_over(one, other, shift) for (one, other), shift in zip(some, shifts, strict=True)]
    moved = [k for k, share in enumerate(left) if share < _EXPLAINED]
    if 2 * len(moved) <= len(some):
        return None
    ways = np.array(shifts)[moved]
    lengths = np.hypot(*ways.T)
    farthest = moved[int(lengths.argmax())]
    found = PictureMoved(float(lengths.max()), some[farthest][0].number, some[farthest][1].number)
    to_and_fro = np.hypot(*ways.sum(axis=0)) <= _TO_AND_FRO * lengths.sum()
    if len(moved) > 2 and to_and_fro and float(np.median(left)) < _TOGETHER:
        return found
    without = [_left_over(*some[k], shifts[k], segmenter) < _EXPLAINED for k in moved]
    return found if 2 * sum(without) > len(some) else None


def _images(pair: tuple[Frame, Frame]) -> list[NDArray[np.float32]]:
    """Return two frames' grey levels, a little smoothed, about zero, in the light of the first."""
    images = [cv2.GaussianBlur(each.luma.astype(np.float32), (0, 0), 1.0) for each in pair]
    light = [max(float(image.mean()), 1e-3) for image in images]
    return [image * (light[0] / own) - light[0] for image, own in zip(images, light, strict=True)]


def _shift(one: Frame, other: Frame) -> tuple[float, float]:
    """Return how far most of what is in a frame is to the right and down in another, pixels."""
    height, width = one.luma.shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    first, last = _images((one, other))
    (x, y), _ = cv2.phaseCorrelate(first, last, window)
    return float(x), float(y)


def _left_over(
    one: Frame, other: Frame, shift: tuple[float, float], segmenter: Segmenter | None = None
) -> float:
    """Return how much of what differs between frames, where no droplet is, a shift leaves."""
    height, width = one.luma.shape
    if not _SHIFT_PX <= math.hypot(*shift) <= _FARTHEST * min(height, width):
        return 1.0
    images = _images((one, other))
    back = np.array([[1.0, 0.0, -shift[0]], [0.0, 1.0, -shift[1]]])
    moved = cv2.warpAffine(images[1], back, (width, height), borderMode=cv2.BORDER_REPLICATE)
    margin = math.ceil(max(map(abs, shift)))
    free = np.zeros((height, width), dtype=np.uint8)
    free[margin : height - margin, margin : width - margin] = 255
    if segmenter is not None:
        for droplet in segmenter.droplets(one):
            _take_out(free, droplet, shift)
        for droplet in segmenter.droplets(other):
            _take_out(free, droplet, (-shift[0], -shift[1]))
    if cv2.countNonZero(free) < _FREE_SHARE * free.size:
        return 1.0
    before, after = (
        cv2.mean(np.minimum(np.abs(images[0] - image), _MOST_DIFFERENT), free)[0]
        for image in (images[1], moved)
    )
    return (after + _NOTHING) / (before + _NOTHING)


def _take_out(free: NDArray[np.uint8], droplet: Droplet, shift: tuple[float, float]) -> None:
    """Take a droplet, and the light about it, out of a mask, where it is and where it goes."""
    width = 2 * round(max(_AROUND_PX, _AROUND * math.sqrt(droplet.area / math.pi)))
    for move in ((0.0, 0.0), shift):
        walk = np.rint(droplet.outline + move).astype(np.int32)
        cv2.fillPoly(free, [walk], 0)
        cv2.polylines(free, [walk], True, 0, width)
