"""The methods in the variants that a picture leaves open, and what is known of a clip before.

Which channel, dark or bright, how far the surroundings reach: each variant learns a segmenter
from frames of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.background import Background
from pinchoff.video.droplets import Segmenter
from pinchoff.video.levels import calibrate
from pinchoff.video.methods.enclosed import EnclosedSegmenter
from pinchoff.video.methods.packed import RimSegmenter
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.methods.spots import SpotSegmenter
from pinchoff.video.obstacles import known_obstacles
from pinchoff.video.reading import Frame
from pinchoff.video.regions import outside_view
from pinchoff.video.settings import SMALLEST_RIM_PX, VideoSettings
from pinchoff.video.signal import Signal

T = TypeVar("T")

_VIEWED = 24  # frames from which one learns where the view ends
_WINDOWS = (32, 16, 8, 4)  # parts of the shorter side over which the local mean is taken
_BRIGHT_WINDOWS = (16, 8)  # the same for rims that are bright, which are rare
_SMALLEST_WINDOW = 9  # pixels
_WIDE = (4, 2)  # the same, for spots
_PARTS_OF_VIEW = 3.0  # largest droplets that fit beside each other into a packed scene

Variant = tuple[Callable[[Sequence[Frame]], Segmenter], dict[str, Any]]
"""What learns a segmenter from frames, and what tells it from other variants, by name."""

Variants = list[Variant]


class KnownClip(NamedTuple):
    """What is known of a clip before a method is tried.

    Attributes
    ----------
    frames : sequence of Frame
    settings : VideoSettings
    background : Background
    channel : str
        With the most contrast.
    tint : str or None
        That differs from place to place, if one does.
    """

    frames: Sequence[Frame]
    settings: VideoSettings
    background: Background
    channel: str
    tint: str | None

    @property
    def channels(self) -> list[str]:
        """Those in which droplets may show."""
        return list(dict.fromkeys([self.channel, *([self.tint] if self.tint else [])]))

    def view(self, signal: Signal) -> NDArray[np.uint8] | None:
        """Return what is outside of the view: dark in all frames; in a negative, bright too."""
        frames = spread(self.frames, _VIEWED)
        seen_in = dict.fromkeys([Signal(), signal._replace(channel=Signal().channel)])
        views = [outside_view([each.of(frame) for frame in frames]) for each in seen_in]
        outside = [view for view in views if view is not None]
        return np.maximum.reduce(outside) if outside else None

    @property
    def shorter(self) -> int:
        """Shorter side of the picture, pixels."""
        return int(min(self.frames[0].luma.shape))


def _rings(clip: KnownClip) -> Iterator[Variants]:
    calibrated = calibrate(clip.frames, clip.settings, clip.background)
    segmenter = RingSegmenter(calibrated.background, calibrated.levels)
    yield [(partial(known_before, segmenter), calibrated.thresholds())]


def _enclosed(clip: KnownClip) -> Iterator[Variants]:
    for inverted, parts in ((False, _WINDOWS), (True, _BRIGHT_WINDOWS)):
        signal = Signal(clip.channel, inverted)
        view = clip.view(signal)
        for window in _odd(clip.shorter / part for part in parts):
            build = _learning(EnclosedSegmenter, clip, signal, window, view)
            yield [(build, {"channel": clip.channel, "bright_rims": inverted, "window_px": window})]


def _spots(clip: KnownClip) -> Iterator[Variants]:
    views = {inverted: clip.view(Signal(inverted=inverted)) for inverted in (False, True)}
    for channel in clip.channels:
        for inverted, view in views.items():
            sort: Variants = []
            signal = Signal(channel, inverted)
            for window in _odd(clip.shorter / part for part in _WIDE):
                build = _learning(SpotSegmenter, clip, signal, window, view)
                sort.append((build, {"channel": channel, "bright": inverted, "window_px": window}))
            yield sort


def _learning(
    kind: type[EnclosedSegmenter | SpotSegmenter],
    clip: KnownClip,
    signal: Signal,
    window: int,
    view: NDArray[np.uint8] | None,
) -> Callable[[Sequence[Frame]], Segmenter]:
    """Return what learns such a segmenter from frames of a clip."""
    least = clip.settings.minimum_area_px
    return partial(kind.learned, signal=signal, window=window, view=view, minimum_area=least)


def _packed(clip: KnownClip) -> Iterator[Variants]:
    settings = clip.settings
    px = settings.pixel_um
    smallest = max(SMALLEST_RIM_PX, 2.0 * math.sqrt(settings.minimum_area_px / math.pi))
    height, width = clip.frames[0].luma.shape
    largest = max(smallest, min(height, width) / _PARTS_OF_VIEW)
    if settings.maximum_diameter_um is not None:
        largest = settings.maximum_diameter_um / px
    channel = clip.channel
    known = known_obstacles(settings, (width, height))
    obstacles = np.empty((0, 3)) if known is None else known
    for inverted in (False, True):
        segmenter = RimSegmenter(
            smallest,
            largest,
            settings.rim_contrast,
            settings.rim_score,
            obstacles,
            Signal(channel, inverted),
        )
        build: Callable[[Sequence[Frame]], Segmenter] = partial(known_before, segmenter)
        yield [(build, {"channel": channel, "bright_rims": inverted})]


def known_before(segmenter: Segmenter, _: Sequence[Frame]) -> Segmenter:
    """Return a segmenter that learns nothing from frames."""
    return segmenter


METHODS: dict[str, Callable[[KnownClip], Iterator[Variants]]] = {
    "rings": _rings,
    "enclosed": _enclosed,
    "spots": _spots,
    "packed": _packed,
}
"""Names of the methods, and what yields their variants for a clip, sort by sort. Of two methods
that are as good the first is taken."""


def spread(frames: Sequence[T], most: int) -> list[T]:
    """Return at most so many of some frames, from the first to the last."""
    places = np.linspace(0, len(frames) - 1, min(most, len(frames)))
    return [frames[round(place)] for place in places.tolist()]


def _odd(lengths: Iterator[float]) -> list[int]:
    """Return whole odd numbers of pixels, the small ones left out."""
    whole = [int(length) | 1 for length in lengths]
    kept = [length for length in dict.fromkeys(whole) if length >= _SMALLEST_WINDOW]
    return kept or [_SMALLEST_WINDOW]
