"""One clip from its first frame to its collisions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.background import sample
from pinchoff.video.choice import Choice, choose
from pinchoff.video.collisions import CollisionFinder
from pinchoff.video.droplets import Droplet
from pinchoff.video.encounters import Encounter
from pinchoff.video.methods.function import SegmentFunction
from pinchoff.video.obstacles import is_obstacle, obstacles_of
from pinchoff.video.quality import covered_twice
from pinchoff.video.reading import Frame
from pinchoff.video.scale import clip_of, scaled
from pinchoff.video.settings import VideoSettings
from pinchoff.video.standing import Travels
from pinchoff.video.tracking import Event, Tracker
from pinchoff.video.workers import segmented

Floats = NDArray[np.float64]

_FEW_FRAMES = 0.5  # of the clip: with droplets in fewer it is worth a word
_SHORT_TRACK = 5  # frames: where most tracks are shorter they are fragments
_LONG_CLIP = 20  # frames from which tracks can be judged
_PROMISING = 0.3  # of the best score: another method that is worth a try
_AS_GOOD, _OTHERWISE = 0.92, 0.25  # of the best score; how differently another method counts
_SELDOM = 0.5  # of the droplets of a frame in the next one: with fewer a method is a guess
_APART = ("rings", "enclosed", "spots")  # methods whose droplets do not overlap
_COVERED_TWICE = 0.05  # of what they cover, by two: with more a method is a guess


class Measured(NamedTuple):
    """What was seen in one frame."""

    frame: Frame
    droplets: list[Droplet]
    tracks: list[int]  # of each droplet
    events: list[Event]  # between the frame before and this one
    necks: list[Floats]  # ends of those of the droplets in contact, (2, 2)
    met: list[tuple[int, int]]  # track and obstacle of the collisions that begin here
    over: list[Encounter]


@dataclass(frozen=True, eq=False)
class ClipResult:
    """What came of a clip."""

    encounters: list[Encounter]  # in the order of their contacts
    obstacles: Floats  # (M, 3): centre x, y and radius, pixels
    choice: Choice  # the method, and what it was chosen from
    frame_count: int
    track_count: int
    duration_s: float  # time of the last frame
    warning: str  # what was wrong with the file, or that it shows no droplets; empty if nothing was


def measure_clip(
    path: Path,
    settings: VideoSettings,
    begin: Callable[[Choice, Floats], Callable[[Measured], object]] | None = None,
    *,
    processes: int = 1,
    segment: SegmentFunction | None = None,
) -> ClipResult:
    """Find the collisions of one clip.

    The clip is read twice: a sample for the background and the thresholds, then every frame. Of
    the frames one is held at a time, whatever their number.

    Parameters
    ----------
    begin : callable, optional
        Called with the choice of the method and the obstacles, (M, 3) in pixels, once they are
        known; what it returns is called with every frame that is measured.
    processes : int, optional
        How many look for droplets at the same time; the results do not depend on it.
    segment : callable, optional
        A user's own segmentation, as in `measure_videos`.

    Raises
    ------
    InputError
        The clip cannot be read.
    """
    clip = clip_of(path, settings)
    settings, notes = scaled(clip, settings)
    first = next(clip.frames())
    settings.require_scale((first.luma.shape[1], first.luma.shape[0]))
    choice = choose(sample(clip.frames(sparse=True)), settings, segment)
    obstacles = obstacles_of(choice.background, settings)
    on_frame = None if begin is None else begin(choice, obstacles)
    segmenter = choice.segmenter
    tracker, finder = Tracker(settings), CollisionFinder(settings, obstacles)
    encounters: list[Encounter] = []
    lengths: Counter[int] = Counter()
    travels = Travels()
    count, with_droplets, duration = 0, 0, 0.0
    for frame, found in segmented(clip.frames(), segmenter, processes):
        seen = [droplet for droplet in found if not is_obstacle(droplet, obstacles)]
        droplets = tracker.resolved(frame.number, seen)
        tracks, events = tracker.step(frame.number, droplets)
        over = finder.step(frame.number, frame.time_s, droplets, tracks, events)
        if on_frame is not None:
            on_frame(Measured(frame, droplets, tracks, events, finder.necks, finder.met, over))
        encounters += over
        lengths.update(
            track for droplet, track in zip(droplets, tracks, strict=True) if not droplet.cut
        )
        travels.append(droplets, tracks)
        with_droplets += bool(droplets)
        count, duration = count + 1, frame.time_s
    encounters += finder.finish()
    encounters.sort(key=lambda encounter: (encounter.contact_frame, encounter.track_id))
    told = _what_was_seen(count, with_droplets, sorted(lengths.values()), choice)
    if not told or choice.moved:
        told = reason_for_doubt(choice)
    still = "" if choice.moved else _standing(travels.standing())
    warning = "; ".join(filter(None, [*notes, clip.warning, told, still]))
    return ClipResult(encounters, obstacles, choice, count, tracker.count, duration, warning)


def _standing(count: int) -> str:
    """Return that tracks never move while others do; empty where there are none."""
    if not count:
        return ""
    what = "a track never moves" if count == 1 else f"{count} tracks never move"
    return (
        f"{what} while others do: look at the annotated film, and if that is dirt, leave it out "
        "with crop or a larger minimum_diameter_um"
    )


def reason_for_doubt(choice: Choice) -> str:
    """Return that the picture itself moves, or why the method is a guess; empty where neither."""
    if choice.moved:
        pixels, first, last = choice.moved
        return (
            f"the picture itself moves, by {pixels:.1f} pixels from frame {first} to frame {last}: "
            "what is fixed in it, dirt and walls, may pass for droplets, and speeds are wrong by "
            "as much; align the frames first (in ImageJ: Linear Stack Alignment), or film from a "
            "stage that stands still"
        )
    seen, scores = choice.trial.quality, choice.scores()
    if seen.persistent < _SELDOM:
        return (
            f"the choice of method {choice.method!r} is a guess: {100 * seen.persistent:.0f} % of "
            "what it finds in a frame is again in the next; look at a preview"
        )
    for other in choice.trials:
        count = other.quality.droplets
        # What got no closer look was tried on another frame, and could not change the choice.
        comparable = len(other.found) == len(choice.trial.found) and other.method != choice.method
        differs = abs(count - seen.droplets) > _OTHERWISE * seen.droplets
        if comparable and differs and scores[other.method] >= _AS_GOOD:
            return (
                f"the choice of method {choice.method!r} is a guess: it finds {seen.droplets:.1f} "
                f"whole droplets a frame, {other.method!r}, with as good a score, {count:.1f}; "
                "look at a preview"
            )
    if choice.method in _APART:
        height, width = choice.frames[0].luma.shape
        twice = covered_twice(choice.trial.found, (width, height))
        if twice > _COVERED_TWICE:
            return (
                f"the choice of method {choice.method!r} is a guess: its outlines overlap, by "
                f"{100 * twice:.0f} % of what they cover, as where gaps pass for droplets; "
                "look at a preview"
            )
    return ""


def _what_was_seen(count: int, with_droplets: int, lengths: list[int], choice: Choice) -> str:
    """Return a warning where little was seen, with what helps; empty where nothing is wrong.

    All are counts of frames; lengths are those in which the droplet of a track is whole, in order.
    """
    if not lengths:
        told = "no droplets were found"
    else:
        middle = lengths[len(lengths) // 2]
        few = with_droplets < _FEW_FRAMES * count
        fragments = count >= _LONG_CLIP and middle < _SHORT_TRACK
        if not few and not fragments:
            return ""
        told = f"droplets in {with_droplets} of {count} frames, tracks of {middle} frames (median)"
    scores = choice.scores()
    others = [name for name in scores if name != choice.method and scores[name] >= _PROMISING]
    if others:
        best = max(others, key=scores.__getitem__)
        return f"{told}; method {best!r} found droplets too (score {scores[best]:.2f}): try it"
    if len(scores) == 1:
        return f"{told} by method {choice.method!r}: leave it out, and the clip decides"
    tried = ", ".join(scores)
    return (
        f"{told}; none of the methods {tried} did better: look at a preview, check the smallest "
        "diameter and the pixel's size, or give a segmentation of your own"
    )
