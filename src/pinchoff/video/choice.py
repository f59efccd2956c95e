"""The choice of a method by the clip itself.

Every method is tried on frames spread over the clip; the best is used, and all scores are kept.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from pinchoff.video.background import Background, Sample, median_background
from pinchoff.video.droplets import Segmenter
from pinchoff.video.methods.function import FunctionSegmenter, SegmentFunction, function_name
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.methods.surroundings import LevelSegmenter
from pinchoff.video.reading import Frame
from pinchoff.video.settings import SMALLEST_DROPLET_PX, SMALLEST_RIM_PX, VideoSettings
from pinchoff.video.signal import best_channel, strong_tint
from pinchoff.video.standing import rows_of, standing_rows
from pinchoff.video.steadiness import PictureMoved, picture_moved
from pinchoff.video.trials import Contest, Trial, best_of
from pinchoff.video.variants import METHODS, KnownClip, Variant, known_before, spread

_SEEN = 4  # frames in which it is looked whether what is found moves
_SMALL = 0.25  # of the usual diameter: what is smaller is none of the droplets
_SMALLER = 0.5  # of the smallest droplet that is looked for: tried where none is found
_HARDLY_LARGER = 1.5  # times that one, in diameter: then smaller ones are looked for too
_MUCH_BETTER = 1.5  # times the score: then smaller ones are taken
_MOVING = 3  # frames from which it is known what moves
_LARGEST_CUT = 2.0  # times the largest whole droplet: what the frame cuts of one is no larger
_NEAR_LEAST = 0.6  # of the usual diameter: where the least looked for is more, less is


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
    moved : PictureMoved or None
        Whether the picture itself moves, so that what is fixed in it passes for droplets.
    """

    background: Background
    trial: Trial
    trials: list[Trial]
    frames: list[Frame]
    moved: PictureMoved | None = None

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
    clip = KnownClip(sample.frames, settings, background, channel, tint)
    if segment is not None:
        contest = Contest(clip, sample.pairs)
        own = FunctionSegmenter(segment, settings.minimum_area_px)
        variant: Variant = (partial(known_before, own), {"function": function_name(segment)})
        (trial,) = contest.tried({OWN: [[variant]]})
        return Choice(background, trial, [trial], contest.frames)
    choice = _among_methods(clip, sample.pairs)
    least_px = _SMALLER * SMALLEST_DROPLET_PX
    if settings.method == "packed":
        least_px = max(least_px, SMALLEST_RIM_PX)
    if settings.minimum_diameter_um is None and _may_be_smaller(choice.trial):
        least_um = least_px * settings.pixel_um
        smaller = settings.replace(minimum_diameter_um=least_um)
        other = _among_methods(clip._replace(settings=smaller), sample.pairs)
        better = other.trial.quality.score > _MUCH_BETTER * max(choice.trial.quality.score, 0.0)
        if better and _move(other.trial, sample.frames):
            choice = other
    last = _without_small(choice.trial, given=settings.minimum_diameter_um is not None)
    trials = [last if each is choice.trial else each for each in choice.trials]
    neighbours = list(itertools.pairwise(sample.frames))
    moved = [picture_moved(pairs, last.segmenter) for pairs in (sample.pairs, neighbours)]
    return choice._replace(trial=last, trials=trials, moved=moved[0] or moved[1])


def _among_methods(clip: KnownClip, pairs: Sequence[tuple[Frame, Frame]]) -> Choice:
    """Return the best of the methods that may be used."""
    contest = Contest(clip, pairs)
    wanted = clip.settings.method
    names = [wanted] if wanted is not None else list(METHODS)
    trials = contest.tried({name: list(METHODS[name](clip)) for name in names})
    chosen = best_of(trials, contest.at_pillars)
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
    seen = [rows_of(trial.segmenter.droplets(frame)) for frame in spread(frames, _SEEN)]
    return len(seen) < _MOVING or len(standing_rows(seen, always=True)) < sum(map(len, seen)) / 2


def _usual_area(trial: Trial) -> float | None:
    """Return the median area, weighted by area: half of what is covered is in larger droplets."""
    areas = np.sort([each.area for found in trial.found for each in found if not each.cut])
    if not len(areas):
        return None
    return float(areas[np.searchsorted(np.cumsum(areas), 0.5 * areas.sum())])


def _without_small(trial: Trial, *, given: bool) -> Trial:
    """Let a method leave out what is much smaller than its droplets usually are, unless `given`."""
    segmenter, usual = trial.segmenter, _usual_area(trial)
    if usual is None or not isinstance(segmenter, LevelSegmenter):
        return trial
    whole = [droplet.area for found in trial.found for droplet in found if not droplet.cut]
    largest = _LARGEST_CUT * max(whole)
    if given:
        return trial._replace(segmenter=segmenter.between(segmenter.minimum_area, largest))
    least = max(min(segmenter.minimum_area, _NEAR_LEAST**2 * usual), _SMALL**2 * usual)
    kept = [[each for each in here if each.area >= least] for here in trial.found]
    variant = {**trial.variant, "minimum_area_px": least}
    return trial._replace(segmenter=segmenter.between(least, largest), variant=variant, found=kept)
