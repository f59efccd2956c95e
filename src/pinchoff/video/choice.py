"""The choice of a method by the clip itself.

Every method is tried on frames spread over the clip, in the variants that a picture leaves open:
which channel, dark or bright, how far the surroundings reach. Each is scored by what a right
answer must have; the best is used, and all scores are kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.background import Background, Sample, median_background
from pinchoff.video.droplets import Droplet, Segmenter
from pinchoff.video.levels import calibrate
from pinchoff.video.methods.enclosed import EnclosedSegmenter
from pinchoff.video.methods.function import FunctionSegmenter, SegmentFunction, function_name
from pinchoff.video.methods.packed import RimSegmenter
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.methods.spots import SpotSegmenter
from pinchoff.video.obstacles import is_obstacle, known_obstacles, obstacles_of
from pinchoff.video.quality import Quality, persistence, quality
from pinchoff.video.reading import Frame
from pinchoff.video.settings import SMALLEST_RIM_PX, VideoSettings
from pinchoff.video.signal import Signal, best_channel, noise_of, strong_tint

Floats = NDArray[np.float64]

_FIRST = 2  # frames on which every variant is tried
_FINALISTS = 2  # variants of each method that are tried on more
_TRIED = 4  # frames on which they are
_PAIRS = 3  # frames in whose next one droplets are looked for again
_SLOW = {"packed": 1}  # frames on which a method that takes long is tried
_HOPELESS = 0.3  # of the best score so far: then it does not matter what persists
_LEARNED = 8  # frames from which one learns what stands still
_WINDOWS = (32, 16, 8, 4)  # parts of the shorter side over which the local mean is taken
_BRIGHT_WINDOWS = (16, 8)  # the same for rims that are bright, which are rare
_SMALLEST_WINDOW = 9  # pixels
_WIDE = (4, 2)  # the same, for spots
_PARTS_OF_VIEW = 3.0  # largest droplets that fit beside each other into a packed scene
_AS_GOOD = 0.97  # of the best score: then the method that comes first is taken
_RINGS, _RINGS_AT_PILLARS = 0.9, 0.5  # the same for rings, and for rings where there are pillars
_SMALL = 0.25  # of the usual diameter: what is smaller is none of the droplets


class Trial(NamedTuple):
    """What came of one method on a sample.

    Attributes
    ----------
    method : str
        One of `METHODS`.
    segmenter : Segmenter
    variant : dict
        What was chosen within the method, by name.
    quality : Quality
    found : list of list of Droplet
        In each of the frames on which it was tried.
    """

    method: str
    segmenter: Segmenter
    variant: dict[str, Any]
    quality: Quality
    found: list[list[Droplet]]


class Choice(NamedTuple):
    """The method that a clip is measured with, and what the others came to.

    Attributes
    ----------
    background : Background
    trial : Trial
        The method that is used.
    trials : list of Trial
        The best variant of each method that was tried, in the order of `METHODS`.
    frames : list of Frame
        On which they were tried.
    """

    background: Background
    trial: Trial
    trials: list[Trial]
    frames: list[Frame]

    @property
    def method(self) -> str:
        """Name of the method that is used."""
        return self.trial.method

    @property
    def segmenter(self) -> Segmenter:
        """What finds the droplets."""
        return self.trial.segmenter

    def scores(self) -> dict[str, float]:
        """Return the score of each method that was tried; the best one's is 1."""
        best = max(each.quality.score for each in self.trials)
        return {
            each.method: round(max(0.0, each.quality.score) / best, 4) if best > 0.0 else 0.0
            for each in self.trials
        }

    def thresholds(self) -> dict[str, Any]:
        """Return what followed from the image, by name and unit."""
        return {**self.trial.variant, "noise_grey_levels": self.background.noise}


OWN = "own"
"""Name of a user's own segmentation."""

_Variant = tuple[Callable[[Sequence[Frame]], Segmenter], dict[str, Any]]


def _rings(sample: Sample, settings: VideoSettings) -> Iterator[_Variant]:
    calibrated = calibrate(sample.frames, settings)
    segmenter = RingSegmenter(calibrated.background, calibrated.levels)
    yield partial(_same, segmenter), calibrated.thresholds()


def _enclosed(sample: Sample, settings: VideoSettings) -> Iterator[_Variant]:
    channel = best_channel(sample.frames)
    shorter = min(sample.frames[0].luma.shape)
    for inverted, parts in ((False, _WINDOWS), (True, _BRIGHT_WINDOWS)):
        for window in _odd(shorter / part for part in parts):
            build = partial(
                EnclosedSegmenter.learned,
                signal=Signal(channel, inverted),
                window=window,
                minimum_area=settings.minimum_area_px,
            )
            yield build, {"channel": channel, "bright_rims": inverted, "window_px": window}


def _spots(sample: Sample, settings: VideoSettings) -> Iterator[_Variant]:
    shorter = min(sample.frames[0].luma.shape)
    tint = strong_tint(sample.frames)
    for channel in [best_channel(sample.frames), *([tint] if tint else [])]:
        for inverted in (False, True):
            for window in _odd(shorter / part for part in _WIDE):
                build = partial(
                    SpotSegmenter.learned,
                    signal=Signal(channel, inverted),
                    window=window,
                    minimum_area=settings.minimum_area_px,
                )
                yield build, {"channel": channel, "bright": inverted, "window_px": window}


def _packed(sample: Sample, settings: VideoSettings) -> Iterator[_Variant]:
    px = settings.pixel_um
    smallest = max(SMALLEST_RIM_PX, 2.0 * math.sqrt(settings.minimum_area_px / math.pi))
    height, width = sample.frames[0].luma.shape
    largest = max(smallest, min(height, width) / _PARTS_OF_VIEW)
    if settings.maximum_diameter_um is not None:
        largest = settings.maximum_diameter_um / px
    channel = best_channel(sample.frames)
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
        build: Callable[[Sequence[Frame]], Segmenter] = partial(_same, segmenter)
        yield build, {"channel": channel, "bright_rims": inverted}


def _same(segmenter: Segmenter, frames: Sequence[Frame]) -> Segmenter:
    return segmenter


METHODS: dict[str, Callable[[Sample, VideoSettings], Iterator[_Variant]]] = {
    "rings": _rings,
    "enclosed": _enclosed,
    "spots": _spots,
    "packed": _packed,
}
"""Names of the methods, and what yields their variants for a clip. Of two that are as good the
first is taken."""


def choose(
    sample: Sample, settings: VideoSettings, segment: SegmentFunction | None = None
) -> Choice:
    """Try the methods on a sample of a clip and return the best.

    Parameters
    ----------
    sample : Sample
    settings : VideoSettings
        Where they name a method, it alone is tried.
    segment : callable, optional
        A user's own, which is used in place of all methods.
    """
    background = median_background(sample.frames)
    obstacles = obstacles_of(background, settings)
    contest = _Contest(sample, settings, obstacles)
    if segment is not None:
        own = FunctionSegmenter(segment, settings.minimum_area_px)
        variant: _Variant = (partial(_same, own), {"function": function_name(segment)})
        trial = contest.tried(OWN, [variant])
        return Choice(background, trial, [trial], contest.frames)
    names = [settings.method] if settings.method is not None else list(METHODS)
    trials = [contest.tried(name, list(METHODS[name](sample, settings))) for name in names]
    chosen = _best(trials, contest.best, bool(len(obstacles)))
    segmenter = chosen.segmenter
    if isinstance(segmenter, RingSegmenter):
        background = segmenter.background
    elif settings.minimum_diameter_um is None:
        small = chosen
        chosen = _without_small(small)
        trials = [chosen if each is small else each for each in trials]
    return Choice(background, chosen, trials, contest.frames)


def _best(trials: Sequence[Trial], best: float, pillars: bool) -> Trial:
    """Return the first of the trials that is as good as the best."""
    for trial in trials:
        share = _AS_GOOD
        if trial.method == "rings":
            # They measure finest, and only they tell a droplet from the pillar that it touches,
            # which is not in what they see.
            share = _RINGS_AT_PILLARS if pillars else _RINGS
        if trial.quality.score >= share * best > 0.0:
            return trial
    return max(trials, key=lambda each: each.quality.score)


def _without_small(trial: Trial) -> Trial:
    """Let a method leave out what is much smaller than its droplets usually are."""
    areas = np.sort([each.area for found in trial.found for each in found if not each.cut])
    segmenter = trial.segmenter
    if not len(areas) or not isinstance(segmenter, EnclosedSegmenter | SpotSegmenter):
        return trial
    # The median weighted by area: half of the covered area is in larger droplets.
    usual = float(areas[np.searchsorted(np.cumsum(areas), 0.5 * areas.sum())])
    least = max(segmenter.minimum_area, _SMALL**2 * usual)
    segmenter.minimum_area = least
    kept = [[each for each in here if each.area >= least] for here in trial.found]
    return trial._replace(variant={**trial.variant, "minimum_area_px": least}, found=kept)


class _Contest:
    """The methods tried on the same frames, one after the other.

    Attributes
    ----------
    frames : list of Frame
        On which they are tried.
    best : float
        The best score so far.
    """

    def __init__(self, sample: Sample, settings: VideoSettings, obstacles: Floats) -> None:
        self.frames = _spread(sample.frames, _TRIED)
        self.best = 0.0
        self._learned = _spread(sample.frames, _LEARNED)
        places = np.linspace(0, len(sample.pairs) - 1, min(_PAIRS, len(sample.pairs)))
        self._pairs = [sample.pairs[round(place)] for place in places.tolist()]
        self._obstacles = obstacles
        signal = Signal(best_channel(self.frames))
        self._images = [signal.of(frame) for frame in self.frames]
        self._noise = float(np.median([noise_of(image) for image in self._images]))

    def tried(self, name: str, variants: Sequence[_Variant]) -> Trial:
        """Return the best variant of a method: of all on few frames, then of the best on more."""
        few = [0, len(self.frames) - 1][: _SLOW.get(name, _FIRST)][: len(self.frames)]
        if len(variants) > 1:
            learned = [self.frames[k] for k in few]
            first = [self._trial(name, variant, learned, few) for variant in variants]
            order = sorted(range(len(first)), key=lambda k: -first[k].quality.score)
            variants = [variants[k] for k in order[: _SLOW.get(name, _FINALISTS)]]
        every = list(range(len(self.frames)))
        trials = [self._trial(name, variant, self._learned, every) for variant in variants]
        trials = [self._persisting(trial) for trial in trials]
        trial = max(trials, key=lambda each: each.quality.score)
        self.best = max(self.best, trial.quality.score)
        return trial

    def _trial(
        self, name: str, variant: _Variant, learned: Sequence[Frame], places: Sequence[int]
    ) -> Trial:
        build, description = variant
        segmenter = build(learned)
        found = [self._droplets(segmenter, self.frames[place]) for place in places]
        seen = quality([self._images[place] for place in places], found, self._noise)
        return Trial(name, segmenter, description, seen, found)

    def _droplets(self, segmenter: Segmenter, frame: Frame) -> list[Droplet]:
        found = segmenter.droplets(frame)
        return [each for each in found if not is_obstacle(each, self._obstacles)]

    def _persisting(self, trial: Trial) -> Trial:
        """Return a trial whose score knows whether droplets are there again in the next frame."""
        seen = trial.quality
        if not self._pairs or seen.score <= _HOPELESS * self.best:
            return trial
        pairs = [
            (self._droplets(trial.segmenter, one), self._droplets(trial.segmenter, other))
            for one, other in self._pairs
        ]
        height, width = self.frames[0].luma.shape
        share = persistence(pairs, (width, height))
        if math.isnan(share):
            return trial
        return trial._replace(quality=seen._replace(score=seen.score * share, persistent=share))


def _spread(frames: Sequence[Frame], most: int) -> list[Frame]:
    places = np.linspace(0, len(frames) - 1, min(most, len(frames)))
    return [frames[round(place)] for place in places.tolist()]


def _odd(lengths: Iterator[float]) -> list[int]:
    """Return whole odd numbers of pixels, the small ones left out."""
    whole = [int(length) | 1 for length in lengths]
    kept = [length for length in dict.fromkeys(whole) if length >= _SMALLEST_WINDOW]
    return kept or [_SMALLEST_WINDOW]
