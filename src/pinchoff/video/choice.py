"""The choice of a method by the clip itself.

Every method is tried on frames spread over the clip, in the variants that a picture leaves open:
which channel, dark or bright, how far the surroundings reach. Each is scored by what a right
answer must have; the best is used, and all scores are kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pinchoff.video.background import Background, Sample, median_background
from pinchoff.video.droplets import Droplet, Segmenter
from pinchoff.video.levels import calibrate
from pinchoff.video.methods.enclosed import EnclosedSegmenter
from pinchoff.video.methods.function import FunctionSegmenter, SegmentFunction, function_name
from pinchoff.video.methods.packed import RimSegmenter
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.methods.spots import SpotSegmenter
from pinchoff.video.obstacles import is_obstacle, known_obstacles, obstacles_of
from pinchoff.video.quality import Picture, Quality, persistence, quality
from pinchoff.video.reading import Frame
from pinchoff.video.settings import SMALLEST_RIM_PX, VideoSettings
from pinchoff.video.signal import Signal, best_channel, noise_of, strong_tint

T = TypeVar("T")

_FIRST = 2  # frames on which variants are tried
_FINALISTS, _NEARLY = 2, 0.9  # variants of each method that are tried on more, if near the best
_TRIED = 4  # frames on which they are
_PAIRS = 3  # frames in whose next one droplets are looked for again
_HOPELESS = 0.3  # of the best score so far: then it does not matter what persists
_BUSY = 0.5  # of what is usual in the busiest tenth of the frames
_GRID, _CLEARLY = 4, 6.0  # pixels and deviations of the noise, for that
_LEARNED = 8  # frames from which one learns what stands still
_WINDOWS = (32, 16, 8, 4)  # parts of the shorter side over which the local mean is taken
_BRIGHT_WINDOWS = (16, 8)  # the same for rims that are bright, which are rare
_SMALLEST_WINDOW = 9  # pixels
_WIDE = (4, 2)  # the same, for spots
_PARTS_OF_VIEW = 3.0  # largest droplets that fit beside each other into a packed scene
_AS_GOOD = 0.92  # of the best score: then the method that comes first is taken
_RINGS, _RINGS_AT_PILLARS = 0.9, 0.5  # the same for rings, and for rings where there are pillars
_MANY_MORE = 1.15  # droplets of another method whose score is higher: then it is taken
_SMALL = 0.25  # of the usual diameter: what is smaller is none of the droplets
_NEAR_LEAST = 0.6  # of the usual diameter: where the least looked for is more, less is


Variant = tuple[Callable[[Sequence[Frame]], Segmenter], dict[str, Any]]
"""What learns a segmenter from frames, and what tells it from other variants, by name."""

Variants = list[Variant]


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
    built : (callable, dict)
        How the segmenter is learned from frames, and `variant`.
    """

    method: str
    segmenter: Segmenter
    variant: dict[str, Any]
    quality: Quality
    found: list[list[Droplet]]
    built: Variant


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


def _rings(sample: Sample, settings: VideoSettings) -> Iterator[Variants]:
    calibrated = calibrate(sample.frames, settings)
    segmenter = RingSegmenter(calibrated.background, calibrated.levels)
    yield [(partial(_same, segmenter), calibrated.thresholds())]


def _enclosed(sample: Sample, settings: VideoSettings) -> Iterator[Variants]:
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
            yield [(build, {"channel": channel, "bright_rims": inverted, "window_px": window})]


def _spots(sample: Sample, settings: VideoSettings) -> Iterator[Variants]:
    shorter = min(sample.frames[0].luma.shape)
    tint = strong_tint(sample.frames)
    for channel in [best_channel(sample.frames), *([tint] if tint else [])]:
        for inverted in (False, True):
            sort: Variants = []
            for window in _odd(shorter / part for part in _WIDE):
                build = partial(
                    SpotSegmenter.learned,
                    signal=Signal(channel, inverted),
                    window=window,
                    minimum_area=settings.minimum_area_px,
                )
                sort.append((build, {"channel": channel, "bright": inverted, "window_px": window}))
            yield sort


def _packed(sample: Sample, settings: VideoSettings) -> Iterator[Variants]:
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
        yield [(build, {"channel": channel, "bright_rims": inverted})]


def _same(segmenter: Segmenter, frames: Sequence[Frame]) -> Segmenter:
    return segmenter


METHODS: dict[str, Callable[[Sample, VideoSettings], Iterator[Variants]]] = {
    "rings": _rings,
    "enclosed": _enclosed,
    "spots": _spots,
    "packed": _packed,
}
"""Names of the methods, and what yields their variants for a clip, sort by sort. Of two methods
that are as good the first is taken."""


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
    contest = _Contest(sample, settings, background)
    if segment is not None:
        own = FunctionSegmenter(segment, settings.minimum_area_px)
        variant: Variant = (partial(_same, own), {"function": function_name(segment)})
        (trial,) = contest.tried({OWN: [[variant]]})
        return Choice(background, trial, [trial], contest.frames)
    names = [settings.method] if settings.method is not None else list(METHODS)
    trials = contest.tried({name: list(METHODS[name](sample, settings)) for name in names})
    chosen = _best(trials, contest.at_pillars)
    segmenter = chosen.segmenter
    if isinstance(segmenter, RingSegmenter):
        background = segmenter.background
    elif settings.minimum_diameter_um is None:
        small = chosen
        chosen = _without_small(small)
        trials = [chosen if each is small else each for each in trials]
    return Choice(background, chosen, trials, contest.frames)


def _best(trials: Sequence[Trial], pillars: bool) -> Trial:
    """Return the first of the trials that is as good as the best."""
    best = max(trial.quality.score for trial in trials)
    for trial in trials:
        share = _AS_GOOD
        if trial.method == "rings":
            # They measure finest, and only they tell a droplet from the pillar that it touches,
            # which is not in what they see.
            share = _RINGS_AT_PILLARS if pillars else _RINGS
        if trial.quality.score >= share * best > 0.0:
            return max((trial, *trials), key=lambda each: _finds_more(each, trial))
    return max(trials, key=lambda each: each.quality.score)


def _finds_more(trial: Trial, other: Trial) -> float:
    """Return how many more droplets a trial finds than another that is not better; or 1."""
    seen, least = trial.quality, other.quality
    many = seen.droplets >= _MANY_MORE * least.droplets and other.method != "rings"
    return seen.droplets / least.droplets if many and seen.score >= least.score else 1.0


def _without_small(trial: Trial) -> Trial:
    """Let a method leave out what is much smaller than its droplets usually are, and no more."""
    areas = np.sort([each.area for found in trial.found for each in found if not each.cut])
    segmenter = trial.segmenter
    if not len(areas) or not isinstance(segmenter, EnclosedSegmenter | SpotSegmenter):
        return trial
    # The median weighted by area: half of the covered area is in larger droplets.
    usual = float(areas[np.searchsorted(np.cumsum(areas), 0.5 * areas.sum())])
    least = max(min(segmenter.minimum_area, _NEAR_LEAST**2 * usual), _SMALL**2 * usual)
    segmenter.minimum_area = least
    kept = [[each for each in here if each.area >= least] for here in trial.found]
    return trial._replace(variant={**trial.variant, "minimum_area_px": least}, found=kept)


class _Contest:
    """The methods tried on the same frames.

    First every variant on few frames, then the best one of each method that is not hopeless on
    more, and on pairs of frames that follow one another.

    Attributes
    ----------
    frames : list of Frame
        On which they are tried.
    """

    def __init__(self, sample: Sample, settings: VideoSettings, background: Background) -> None:
        self.frames = _busy(sample.frames, sample.frames, background, _TRIED)
        self._first = _spread(self.frames, _FIRST)
        self._learned = _spread(sample.frames, _LEARNED)
        self._pairs = _busy(sample.pairs, [one for one, _ in sample.pairs], background, _PAIRS)
        self._obstacles = obstacles_of(background, settings)
        tint = strong_tint(self.frames)
        channels = dict.fromkeys([best_channel(self.frames), *([tint] if tint else [])])
        self._pictures = {
            frame.number: [_picture(frame, channel, rims=channel != tint) for channel in channels]
            for frame in self.frames
        }

    @property
    def at_pillars(self) -> bool:
        """Whether there are pillars."""
        return bool(len(self._obstacles))

    def tried(self, methods: dict[str, Sequence[Variants]]) -> list[Trial]:
        """Return the best trial of each method."""
        first = [self._first_look(name, variants) for name, variants in methods.items()]
        best = max(max(trial.quality.score for trial in trials) for trials in first)
        return [self._closer_look(trials, _HOPELESS * best) for trials in first]

    def _first_look(self, name: str, sorts: Sequence[Variants]) -> list[Trial]:
        """Return trials on few frames, the best first: of each sort one, of the best sort all."""

        def tried(variant: Variant) -> Trial:
            return self._trial(name, variant, self._first[:1], self._first)

        firsts = [tried(sort[0]) for sort in sorts]
        best = max(range(len(sorts)), key=lambda k: firsts[k].quality.score)
        trials = firsts + [tried(variant) for variant in sorts[best][1:]]
        return sorted(trials, key=lambda each: -each.quality.score)

    def _closer_look(self, trials: Sequence[Trial], hopeless: float) -> Trial:
        """Return the best of a method's trials, on more frames where that may change anything."""
        best = trials[0]
        if best.quality.score <= hopeless or len(self._learned) == 1:
            return best
        near = [each for each in trials if each.quality.score >= _NEARLY * best.quality.score]
        closer = [
            self._persisting(self._trial(each.method, each.built, self._learned, self.frames))
            for each in near[:_FINALISTS]
        ]
        return max(closer, key=lambda each: each.quality.score)

    def _trial(
        self, name: str, variant: Variant, learned: Sequence[Frame], frames: Sequence[Frame]
    ) -> Trial:
        build, description = variant
        segmenter = build(learned)
        found = [self._droplets(segmenter, frame) for frame in frames]
        seen = quality([self._pictures[frame.number] for frame in frames], found)
        return Trial(name, segmenter, description, seen, found, variant)

    def _droplets(self, segmenter: Segmenter, frame: Frame) -> list[Droplet]:
        found = segmenter.droplets(frame)
        return [each for each in found if not is_obstacle(each, self._obstacles)]

    def _persisting(self, trial: Trial) -> Trial:
        """Return a trial whose score knows whether droplets are the same in the next frame."""
        pairs = [
            (self._droplets(trial.segmenter, one), self._droplets(trial.segmenter, other))
            for one, other in self._pairs
        ]
        height, width = self.frames[0].luma.shape
        share = persistence(pairs, (width, height))
        if math.isnan(share):
            return trial
        seen = trial.quality
        return trial._replace(quality=seen._replace(score=seen.score * share, persistent=share))


def _picture(frame: Frame, channel: str, *, rims: bool) -> Picture:
    image = Signal(channel).of(frame)
    return Picture(image, noise_of(image), rims)


def _spread(frames: Sequence[T], most: int) -> list[T]:
    places = np.linspace(0, len(frames) - 1, min(most, len(frames)))
    return [frames[round(place)] for place in places.tolist()]


def _busy(
    things: Sequence[T], frames: Sequence[Frame], background: Background, most: int
) -> list[T]:
    """Return what belongs to frames in which much differs from the background, spread over them."""
    if len(frames) <= 1:
        return list(things)
    share = np.array([_activity(frame, background) for frame in frames])
    least = _BUSY * float(np.quantile(share, 0.9))
    return _spread(
        [thing for thing, here in zip(things, share, strict=True) if here >= least], most
    )


def _activity(frame: Frame, background: Background) -> float:
    """Return the share of a frame that is clearly not as in the background."""
    some = (slice(None, None, _GRID), slice(None, None, _GRID))
    empty = background.lamp(frame.luma) * background.luma[some]
    return float((np.abs(frame.luma[some] - empty) > _CLEARLY * background.noise).mean())


def _odd(lengths: Iterator[float]) -> list[int]:
    """Return whole odd numbers of pixels, the small ones left out."""
    whole = [int(length) | 1 for length in lengths]
    kept = [length for length in dict.fromkeys(whole) if length >= _SMALLEST_WINDOW]
    return kept or [_SMALLEST_WINDOW]
