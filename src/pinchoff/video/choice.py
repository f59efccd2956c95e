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
from pinchoff.video.quality import Picture, Quality, persistence, quality
from pinchoff.video.reading import Frame
from pinchoff.video.regions import outside_view, rows_of, standing_rows, without_standing
from pinchoff.video.settings import SMALLEST_DROPLET_PX, SMALLEST_RIM_PX, VideoSettings
from pinchoff.video.signal import Signal, best_channel, noise_of, strong_tint

T = TypeVar("T")

_FINALISTS, _NEARLY = 2, 0.9  # variants of each method that are tried on more, if near the best
_TRIED = 4  # frames on which they are; every variant is tried on one
_VIEWED = 24  # frames from which one learns where the view ends
_PAIRS = 3  # frames in whose next one droplets are looked for again
_HOPEFUL = 1.25  # of the score on one frame: more it may hardly have on all
_BUSY = 0.5  # of what is usual in the busiest tenth of the frames
_GRID, _CLEARLY = 4, 6.0  # pixels and deviations of the noise, for that
_WINDOWS = (32, 16, 8, 4)  # parts of the shorter side over which the local mean is taken
_BRIGHT_WINDOWS = (16, 8)  # the same for rims that are bright, which are rare
_SMALLEST_WINDOW = 9  # pixels
_WIDE = (4, 2)  # the same, for spots
_PARTS_OF_VIEW = 3.0  # largest droplets that fit beside each other into a packed scene
_AS_GOOD = 0.92  # of the best score: then the method that comes first is taken
_RINGS, _RINGS_AT_PILLARS = 0.9, 0.5  # the same for rings, and for rings where there are pillars
_TWICE, _AS_MANY = 2.0, 0.85  # times the droplets of the best: then this share of its score will do
_MANY_MORE = 1.15  # droplets of another method whose score is higher: then it is taken
_SMALL = 0.25  # of the usual diameter: what is smaller is none of the droplets
_SMALLER = 0.5  # of the smallest droplet that is looked for: tried where none is found
_HARDLY_LARGER = 1.5  # times that one, in diameter: then smaller ones are looked for too
_MUCH_BETTER = 1.5  # times the score: then smaller ones are taken
_MOVING = 3  # frames from which it is known what moves
_LARGEST_CUT = 2.0  # times the largest whole droplet: what the frame cuts of one is no larger
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


class _Known(NamedTuple):
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
        frames = _spread(self.frames, _VIEWED)
        seen_in = dict.fromkeys([Signal(), signal._replace(channel=Signal().channel)])
        views = [outside_view([each.of(frame) for frame in frames]) for each in seen_in]
        outside = [view for view in views if view is not None]
        return np.maximum.reduce(outside) if outside else None

    @property
    def shorter(self) -> int:
        """Shorter side of the picture, pixels."""
        return int(min(self.frames[0].luma.shape))


def _rings(clip: _Known) -> Iterator[Variants]:
    calibrated = calibrate(clip.frames, clip.settings, clip.background)
    segmenter = RingSegmenter(calibrated.background, calibrated.levels)
    yield [(partial(_same, segmenter), calibrated.thresholds())]


def _enclosed(clip: _Known) -> Iterator[Variants]:
    for inverted, parts in ((False, _WINDOWS), (True, _BRIGHT_WINDOWS)):
        signal = Signal(clip.channel, inverted)
        view = clip.view(signal)
        for window in _odd(clip.shorter / part for part in parts):
            build = partial(
                EnclosedSegmenter.learned,
                signal=signal,
                window=window,
                view=view,
                minimum_area=clip.settings.minimum_area_px,
            )
            yield [(build, {"channel": clip.channel, "bright_rims": inverted, "window_px": window})]


def _spots(clip: _Known) -> Iterator[Variants]:
    views = {inverted: clip.view(Signal(inverted=inverted)) for inverted in (False, True)}
    for channel in clip.channels:
        for inverted, view in views.items():
            sort: Variants = []
            signal = Signal(channel, inverted)
            for window in _odd(clip.shorter / part for part in _WIDE):
                build = partial(
                    SpotSegmenter.learned,
                    signal=signal,
                    window=window,
                    view=view,
                    minimum_area=clip.settings.minimum_area_px,
                )
                sort.append((build, {"channel": channel, "bright": inverted, "window_px": window}))
            yield sort


def _packed(clip: _Known) -> Iterator[Variants]:
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
        build: Callable[[Sequence[Frame]], Segmenter] = partial(_same, segmenter)
        yield [(build, {"channel": channel, "bright_rims": inverted})]


def _same(segmenter: Segmenter, frames: Sequence[Frame]) -> Segmenter:
    return segmenter


METHODS: dict[str, Callable[[_Known], Iterator[Variants]]] = {
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
    channel, tint = best_channel(sample.frames), strong_tint(sample.frames)
    clip = _Known(sample.frames, settings, background, channel, tint)
    if segment is not None:
        contest = _Contest(clip, sample.pairs)
        own = FunctionSegmenter(segment, settings.minimum_area_px)
        variant: Variant = (partial(_same, own), {"function": function_name(segment)})
        (trial,) = contest.tried({OWN: [[variant]]})
        return Choice(background, trial, [trial], contest.frames)
    choice = _among_methods(clip, sample.pairs)
    if settings.minimum_diameter_um is None and _may_be_smaller(choice.trial):
        least_um = _SMALLER * SMALLEST_DROPLET_PX * settings.pixel_um
        smaller = settings.replace(minimum_diameter_um=least_um)
        other = _among_methods(clip._replace(settings=smaller), sample.pairs)
        better = other.trial.quality.score > _MUCH_BETTER * max(choice.trial.quality.score, 0.0)
        if better and _move(other.trial, sample.frames):
            choice = other
    last = _without_small(choice.trial, given=settings.minimum_diameter_um is not None)
    trials = [last if each is choice.trial else each for each in choice.trials]
    return choice._replace(trial=last, trials=trials)


def _among_methods(clip: _Known, pairs: Sequence[tuple[Frame, Frame]]) -> Choice:
    """Return the best of the methods that may be used."""
    contest = _Contest(clip, pairs)
    wanted = clip.settings.method
    names = [wanted] if wanted is not None else list(METHODS)
    trials = contest.tried({name: list(METHODS[name](clip)) for name in names})
    chosen = _best(trials, contest.at_pillars)
    background = clip.background
    if isinstance(chosen.segmenter, RingSegmenter):
        background = chosen.segmenter.background
    return Choice(background, chosen, trials, contest.frames)


def _may_be_smaller(trial: Trial) -> bool:
    """Return whether nothing was found, or droplets hardly larger than the least looked for."""
    usual = _usual_area(trial)
    largest = 0.25 * math.pi * (_HARDLY_LARGER * SMALLEST_DROPLET_PX) ** 2
    return trial.quality.score <= 0.0 or usual is None or usual < largest


def _move(trial: Trial, frames: Sequence[Frame]) -> bool:
    """Return whether what a method finds moves, where that can be known: dust does not."""
    seen = [rows_of(trial.segmenter.droplets(frame)) for frame in _spread(frames, _TRIED)]
    return len(seen) < _MOVING or len(standing_rows(seen, always=True)) < sum(map(len, seen)) / 2


def _usual_area(trial: Trial) -> float | None:
    """Return the median area, weighted by area: half of what is covered is in larger droplets."""
    areas = np.sort([each.area for found in trial.found for each in found if not each.cut])
    if not len(areas):
        return None
    return float(areas[np.searchsorted(np.cumsum(areas), 0.5 * areas.sum())])


def _best(trials: Sequence[Trial], pillars: bool) -> Trial:
    """Return the first of the trials that is as good as the best."""
    winner = max(trials, key=lambda each: each.quality.score).quality
    best = winner.score
    for trial in trials:
        share = _AS_GOOD
        if trial.quality.droplets >= _TWICE * winner.droplets:
            share = _AS_MANY
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


def _without_small(trial: Trial, *, given: bool) -> Trial:
    """Let a method leave out what is much smaller than its droplets usually are, unless `given`."""
    segmenter, usual = trial.segmenter, _usual_area(trial)
    if usual is None or not isinstance(segmenter, EnclosedSegmenter | SpotSegmenter):
        return trial
    whole = [droplet.area for found in trial.found for droplet in found if not droplet.cut]
    largest = _LARGEST_CUT * max(whole)
    if given:
        return trial._replace(segmenter=segmenter.between(segmenter.minimum_area, largest))
    least = max(min(segmenter.minimum_area, _NEAR_LEAST**2 * usual), _SMALL**2 * usual)
    kept = [[each for each in here if each.area >= least] for here in trial.found]
    variant = {**trial.variant, "minimum_area_px": least}
    return trial._replace(segmenter=segmenter.between(least, largest), variant=variant, found=kept)


class _Contest:
    """The methods tried on the same frames.

    First every variant on one frame; then the best one of each method, if that may change the
    choice, on more, and on pairs of frames that follow one another.

    Attributes
    ----------
    frames : list of Frame
        On which they are tried.
    """

    def __init__(self, clip: _Known, pairs: Sequence[tuple[Frame, Frame]]) -> None:
        self.frames = _busy(clip.frames, clip.frames, clip.background, _TRIED)
        self._pairs = _busy(pairs, [one for one, _ in pairs], clip.background, _PAIRS)
        several = {
            frame.number: frame for frame in [*self.frames, *(one for one, _ in self._pairs)]
        }
        self._learned = [several[number] for number in sorted(several)]
        self._obstacles = obstacles_of(clip.background, clip.settings)
        self._pictures = {
            frame.number: [
                _picture(frame, channel, rims=channel != clip.tint) for channel in clip.channels
            ]
            for frame in self.frames
        }

    @property
    def at_pillars(self) -> bool:
        """Whether there are pillars."""
        return bool(len(self._obstacles))

    def tried(self, methods: dict[str, Sequence[Variants]]) -> list[Trial]:
        """Return the best trial of each method."""
        first = {name: self._first_look(name, variants) for name, variants in methods.items()}
        trials = {name: found[0] for name, found in first.items()}
        if len(self._learned) == 1:
            return list(trials.values())
        looked_at: dict[str, Trial] = {}
        # The rings first: that they are good enough is soon known.
        order = sorted(trials, key=lambda each: (each != "rings", -trials[each].quality.score))
        for name in order:
            if self._may_change(looked_at, trials[name], list(methods)):
                looked_at[name] = self._closer_look(first[name])
        return [looked_at.get(name, trial) for name, trial in trials.items()]

    def _may_change(self, looked_at: dict[str, Trial], trial: Trial, order: Sequence[str]) -> bool:
        """Return whether a trial would be chosen if it did better on more frames than on one."""
        if not looked_at:
            return True
        score = _HOPEFUL * trial.quality.score
        hoped = trial._replace(quality=trial.quality._replace(score=score))
        among = {**looked_at, trial.method: hoped}
        return _best([among[name] for name in order if name in among], self.at_pillars) is hoped

    def _first_look(self, name: str, sorts: Sequence[Variants]) -> list[Trial]:
        """Return trials on one frame, the best first: of each sort one, of the best sort all."""
        frame = self.frames[len(self.frames) // 2 : len(self.frames) // 2 + 1]

        def tried(variant: Variant) -> Trial:
            return _forgetting(self._trial(name, variant, frame, frame))

        firsts = [tried(sort[0]) for sort in sorts]
        best = max(range(len(sorts)), key=lambda k: firsts[k].quality.score)
        trials = firsts + [tried(variant) for variant in sorts[best][1:]]
        return sorted(trials, key=lambda each: -each.quality.score)

    def _closer_look(self, trials: Sequence[Trial]) -> Trial:
        """Return the best of a method's trials, on more frames."""
        best, *others = trials
        near = [each for each in others if each.quality.score >= _NEARLY * best.quality.score]
        closer = [
            _forgetting(
                self._persisting(self._trial(each.method, each.built, self._learned, self.frames))
            )
            for each in [best, *near][:_FINALISTS]
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
        if isinstance(trial.segmenter, RimSegmenter):
            # The others know what stands still from what they learned from.
            seen_in = [*trial.found, *(here for pair in pairs for here in pair)]
            standing = standing_rows([rows_of(here) for here in seen_in])
            segmenter = trial.segmenter.without(standing)
            found = [without_standing(here, standing) for here in trial.found]
            seen = quality([self._pictures[frame.number] for frame in self.frames], found)
            trial = trial._replace(segmenter=segmenter, found=found, quality=seen)
            pairs = [
                (without_standing(one, standing), without_standing(other, standing))
                for one, other in pairs
            ]
        height, width = self.frames[0].luma.shape
        share = persistence(pairs, (width, height))
        if math.isnan(share):
            return trial
        seen = trial.quality
        return trial._replace(quality=seen._replace(score=seen.score * share, persistent=share))


def _forgetting(trial: Trial) -> Trial:
    """Let a method go of what it saw in the frames from which it learned: that takes memory."""
    if isinstance(trial.segmenter, EnclosedSegmenter | SpotSegmenter):
        trial.segmenter.forget()
    return trial


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
