"""One clip from its first frame to its collisions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.background import sample
from pinchoff.video.choice import Choice, choose
from pinchoff.video.collisions import CollisionFinder, NeckSeen
from pinchoff.video.droplets import Droplet
from pinchoff.video.encounters import Encounter
from pinchoff.video.obstacles import is_obstacle, obstacles_of
from pinchoff.video.reading import Frame
from pinchoff.video.scale import clip_of, scaled
from pinchoff.video.settings import VideoSettings
from pinchoff.video.tracking import Event, Tracker
from pinchoff.video.workers import segmented

Floats = NDArray[np.float64]

_NOTHING_FOUND = (
    "no droplets were found; look at the smallest diameter and the pixel's size, give edge_level "
    "or clicks, or try packed where droplets fill the view"
)


class Measured(NamedTuple):
    """What was seen in one frame.

    Attributes
    ----------
    frame : Frame
    droplets : list of Droplet
    tracks : list of int
        The track of each droplet.
    events : list of Event
        Between the frame before and this one.
    necks : list of NeckSeen
        Of the droplets in contact.
    met : list of (int, int)
        Track and obstacle of the collisions that begin here.
    over : list of Encounter
        The collisions that are over.
    """

    frame: Frame
    droplets: list[Droplet]
    tracks: list[int]
    events: list[Event]
    necks: list[NeckSeen]
    met: list[tuple[int, int]]
    over: list[Encounter]


@dataclass(frozen=True, eq=False)
class ClipResult:
    """What came of a clip.

    Attributes
    ----------
    encounters : list of Encounter
        In the order of their contacts.
    obstacles : ndarray, shape (M, 3)
        Centre x, y and radius, pixels.
    choice : Choice
        The method, and what it was chosen from.
    frame_count, track_count : int
    duration_s : float
        Time of the last frame.
    warning : str
        What was wrong with the file, or that it shows no droplets; empty if nothing was.
    """

    encounters: list[Encounter]
    obstacles: Floats
    choice: Choice
    frame_count: int
    track_count: int
    duration_s: float
    warning: str


def measure_clip(
    path: Path,
    settings: VideoSettings,
    begin: Callable[[Choice, Floats], Callable[[Measured], object]] | None = None,
    *,
    processes: int = 1,
) -> ClipResult:
    """Find the collisions of one clip.

    The clip is read twice: a sample for the background and the thresholds, then every frame. Of
    the frames one is held at a time, whatever their number.

    Parameters
    ----------
    path : Path
    settings : VideoSettings
    begin : callable, optional
        Called with background, thresholds and obstacles, (M, 3) in pixels, once they are known;
        what it returns is called with every frame that is measured.
    processes : int, optional
        How many look for droplets at the same time; the results do not depend on it.

    Raises
    ------
    InputError
        The clip cannot be read.
    """
    clip = clip_of(path, settings)
    settings, notes = scaled(clip, settings)
    choice = choose(sample(clip.frames(sparse=True)), settings)
    obstacles = obstacles_of(choice.background, settings)
    on_frame = None if begin is None else begin(choice, obstacles)
    segmenter = choice.segmenter
    tracker, finder = Tracker(settings), CollisionFinder(settings, obstacles)
    encounters: list[Encounter] = []
    count, duration = 0, 0.0
    for frame, found in segmented(clip.frames(), segmenter, processes):
        seen = [each for each in found if not is_obstacle(each, obstacles)]
        droplets = tracker.resolved(frame.number, seen)
        tracks, events = tracker.step(frame.number, droplets)
        over = finder.step(frame.number, frame.time_s, droplets, tracks, events)
        if on_frame is not None:
            on_frame(Measured(frame, droplets, tracks, events, finder.necks, finder.met, over))
        encounters += over
        count, duration = count + 1, frame.time_s
    encounters += finder.finish()
    encounters.sort(key=lambda each: (each.contact_frame, each.track_id))
    notes += [clip.warning] if clip.warning else []
    warning = "; ".join(notes if tracker.count else [*notes, _NOTHING_FOUND])
    return ClipResult(encounters, obstacles, choice, count, tracker.count, duration, warning)
