"""The methods tried on frames of a clip, and which of them is best.

Each is scored by what a right answer must have: see `quality`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from pinchoff.video.background import Background
from pinchoff.video.droplets import Droplet, Segmenter
from pinchoff.video.methods.packed import RimSegmenter
from pinchoff.video.methods.surroundings import LevelSegmenter
from pinchoff.video.obstacles import is_obstacle, obstacles_of
from pinchoff.video.quality import Picture, Quality, persistence, quality
from pinchoff.video.reading import Frame
from pinchoff.video.signal import Signal, noise_of
from pinchoff.video.standing import rows_of, standing_rows, without_standing
from pinchoff.video.variants import KnownClip, Variant, Variants, spread

T = TypeVar("T")

_FINALISTS, _NEARLY = 2, 0.9  # variants of each method that are tried on more, if near the best
_TRIED = 4  # frames on which they are; every variant is tried on one
_PAIRS = 3  # frames in whose next one droplets are looked for again
_HOPEFUL = 1.25  # of the score on one frame: more it may hardly have on all
_BUSY = 0.5  # of what is usual in the busiest tenth of the frames
_GRID, _CLEARLY = 4, 6.0  # pixels and deviations of the noise, for that
_AS_GOOD = 0.92  # of the best score: then the method that comes first is taken
_RINGS, _RINGS_AT_PILLARS = 0.9, 0.5  # the same for rings, and for rings where there are pillars
_TWICE, _AS_MANY = 2.0, 0.85  # times the droplets of the best: then this share of its score will do
_MANY_MORE = 1.15  # droplets of another method whose score is not lower: then it is taken
_MORE, _BETTER = 1.02, 1.02  # droplets, and score, of another method: then it is taken too


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


def best_of(trials: Sequence[Trial], pillars: bool) -> Trial:
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
    more = _MORE if seen.score >= _BETTER * least.score else _MANY_MORE
    many = seen.droplets >= more * least.droplets and other.method != "rings"
    return seen.droplets / least.droplets if many and seen.score >= least.score else 1.0


class Contest:
    """The methods tried on the same frames.

    First every variant on one frame; then the best one of each method, if that may change the
    choice, on more, and on pairs of frames that follow one another.

    Attributes
    ----------
    frames : list of Frame
        On which they are tried.
    """

    def __init__(self, clip: KnownClip, pairs: Sequence[tuple[Frame, Frame]]) -> None:
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
        return best_of([among[name] for name in order if name in among], self.at_pillars) is hoped

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
    if isinstance(trial.segmenter, LevelSegmenter):
        trial.segmenter.forget()
    return trial


def _picture(frame: Frame, channel: str, *, rims: bool) -> Picture:
    image = Signal(channel).of(frame)
    return Picture(image, noise_of(image), rims)


def _busy(
    things: Sequence[T], frames: Sequence[Frame], background: Background, most: int
) -> list[T]:
    """Return what belongs to frames in which much differs from the background, spread over them."""
    if len(frames) <= 1:
        return list(things)
    share = np.array([_activity(frame, background) for frame in frames])
    least = _BUSY * float(np.quantile(share, 0.9))
    return spread([thing for thing, here in zip(things, share, strict=True) if here >= least], most)


def _activity(frame: Frame, background: Background) -> float:
    """Return the share of a frame that is clearly not as in the background."""
    some = (slice(None, None, _GRID), slice(None, None, _GRID))
    empty = background.lamp(frame.luma) * background.luma[some]
    return float((np.abs(frame.luma[some] - empty) > _CLEARLY * background.noise).mean())
