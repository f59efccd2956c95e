"""What methods share that look for regions at one level of darkness after the other."""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Sequence
from typing import ClassVar, Generic, NamedTuple, Protocol, Self, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.reading import Frame
from pinchoff.video.regions import SAME, Border, Region
from pinchoff.video.signal import Image, Signal, noise_of
from pinchoff.video.standing import Placed, alike, rows_of

Floats = NDArray[np.float64]
Numbers = NDArray[np.int16]

_LOOKED_AT = 3  # frames whose noise is measured, about
_SAME_PLACE = 0.25  # square roots of the area between a droplet's regions at two levels
_BEYOND = 1.5  # pixels beyond an outline, where a neighbour is if it touches


class Surroundings(NamedTuple):
    """What is about the droplets of a clip.

    Attributes
    ----------
    noise : float
        Standard deviation, grey levels.
    levels : tuple of float
        Of darkness, grey levels below what is about them.
    view : ndarray of uint8, shape (height, width), or None
        Not zero beyond the dark edge of the view.
    standing : ndarray, shape (n, 3)
        Centre x, y and area of regions that never move.
    """

    noise: float
    levels: tuple[float, ...] = ()
    view: NDArray[np.uint8] | None = None
    standing: Floats = np.empty((0, 3))

    def stands(self, region: Placed) -> bool:
        """Return whether a region is one of those that never move."""
        (row,) = rows_of([region])
        return bool(alike(self.standing, row).any())


class LevelRegion(Region, Protocol):
    """A region at one level, with rays across its border."""

    @property
    def border(self) -> Border: ...
    @property
    def level(self) -> float: ...


class Shown(NamedTuple):
    """A droplet that was seen: the area of its region, and the levels at which it shows."""

    area: float
    levels: frozenset[float]


_R = TypeVar("_R", bound=LevelRegion)


class LevelSegmenter(Generic[_R]):
    """Find droplets as regions at several levels; each method has regions of its own.

    Parameters
    ----------
    signal : Signal
        The picture in which droplets or their rims are dark.
    window : int
        Side of the square over which the local mean is taken, pixels; odd.
    minimum_area : float
        Of a droplet, pixels.
    about : Surroundings
    """

    REGION_SHARE: ClassVar[float] = 1.0
    """Least area of a region, of its droplet's."""

    def __init__(
        self, signal: Signal, window: int, minimum_area: float, about: Surroundings
    ) -> None:
        self.signal, self.window, self.about = signal, window, about
        self.minimum_area, self._largest_cut = minimum_area, math.inf
        self._shown: Sequence[Shown] = ()
        self._seen: dict[int, list[_R]] = {}  # in the frames from which it was learned

    def forget(self) -> None:
        """Let go of what was seen in the frames from which it was learned."""
        self._seen = {}

    def between(self, area: float, largest_cut: float) -> Self:
        """Return a segmenter for droplets from an area on: it may need fewer levels.

        Parameters
        ----------
        area, largest_cut : float
            Least area, and largest area of what the frame cuts, pixels: what is larger lies
            beyond a wall.
        """
        least = self.REGION_SHARE * area
        levels = needed_levels([each for each in self._shown if each.area >= least])
        other = copy.copy(self)
        other.about = self.about._replace(levels=levels) if levels else self.about
        other.minimum_area, other._largest_cut = area, largest_cut
        other.forget()
        return other

    def _regions(self, dark: Image) -> list[_R]:
        """Return the regions of a picture at all levels."""
        raise NotImplementedError

    def _regions_in(self, frame: Frame, dark: Image) -> list[_R]:
        """Return those of a frame that may be droplets."""
        seen = self._seen.get(frame.number)
        if seen is None:
            seen = self._regions(dark)
        else:
            seen = [each for each in seen if each.level in self.about.levels]
        return [each for each in seen if self._may_be_droplet(each)]

    def _may_be_droplet(self, region: _R) -> bool:
        beyond = region.area > self._largest_cut and region.border.at_edge.any()
        return not beyond and not self.about.stands(region)


def usual_noise(frames: Sequence[Frame], signal: Signal) -> float:
    """Return the noise of a clip in a signal, grey levels, from some of its frames."""
    some = frames[:: max(1, len(frames) // _LOOKED_AT)]
    return float(np.median([noise_of(signal.of(frame)) for frame in some]))


def shown_at(droplets: Sequence[LevelRegion], regions: Sequence[LevelRegion]) -> list[Shown]:
    """Return at which levels the droplets of a frame show.

    Parameters
    ----------
    droplets, regions : sequence of LevelRegion
        One a droplet, and all of the frame, at all levels.
    """
    rows, levels = rows_of(regions), np.array([each.level for each in regions])
    shown = []
    for droplet in droplets:
        away = np.hypot(rows[:, 0] - droplet.x, rows[:, 1] - droplet.y)
        same = away <= _SAME_PLACE * math.sqrt(droplet.area)
        same &= (rows[:, 2] >= SAME * droplet.area) & (SAME * rows[:, 2] <= droplet.area)
        shown.append(Shown(droplet.area, frozenset(levels[same].tolist())))
    return shown


def needed_levels(shown: Sequence[Shown]) -> tuple[float, ...]:
    """Return the fewest levels that show every droplet twice (once if one level alone shows it)."""
    wanted = [each.levels for each in shown]
    chosen: set[float] = set()
    missing = [min(2, len(levels)) for levels in wanted]
    while any(missing):
        gain: Counter[float] = Counter()
        for levels_of, count in zip(wanted, missing, strict=True):
            if count:
                gain.update(levels_of - chosen)
        level = max(gain, key=lambda each: (gain[each], each))
        chosen.add(level)
        missing = [
            count - (count > 0 and level in levels_of)
            for levels_of, count in zip(wanted, missing, strict=True)
        ]
    return tuple(sorted(chosen))


def owners(regions: Sequence[Region], shape: tuple[int, ...]) -> Numbers:
    """Return the number of the region that each pixel is in, -1 for none."""
    owner = np.full(shape, -1, dtype=np.int16)
    for number, region in enumerate(regions):
        cv2.drawContours(owner, [region.walk], -1, number, cv2.FILLED)
    return owner


def beyond(away: Floats, border: Border, owner: Numbers, number: int) -> Numbers:
    """Return which other region is beyond the outline on each ray, -1 where none is."""
    height, width = owner.shape
    places = np.rint(border.points + (away + _BEYOND)[:, None] * border.normals)
    x, y = np.clip(places, 0, (width - 1, height - 1)).astype(np.intp).T
    other = owner[y, x]
    return np.where(other == number, np.int16(-1), other)
