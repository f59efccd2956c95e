"""Collisions: droplets that meet obstacles, followed from contact to what came of it."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.contact import FEWEST_FRAMES, Approach, Place
from pinchoff.video.droplets import Droplet
from pinchoff.video.encounters import (
    CLIP_ENDED,
    CUT_BY_FRAME,
    RELEASE,
    Encounter,
    gap_to_circle,
    thinnest_neck,
)
from pinchoff.video.settings import VideoSettings
from pinchoff.video.tracking import Event

Floats = NDArray[np.float64]

TOUCHING = "touching another droplet"
COALESCENCE = "coalescence"
LOST = "lost track"
MANY_DAUGHTERS = "more than two daughters in one frame"
NO_APPROACH = "no approach: in contact when first seen"

_LOOKS_KEPT = 128  # frames of a collision that a late break-up can take back


class _Look(NamedTuple):
    frame: int
    neck: float
    shape: float


@dataclass
class _Meeting:
    """A collision that goes on; pixels."""

    track: int
    obstacle: int
    approach: Approach
    reasons: dict[str, float] = field(default_factory=dict)  # and the last frame of each
    neck: float = math.nan
    shape: float = 1.0
    looks: deque[_Look] = field(default_factory=deque)
    end: int = 0

    def look(self, frame: int, neck: float, shape: float) -> None:
        """Note one frame; the last few are kept apart, because a break-up may be told late."""
        self.looks.append(_Look(frame, neck, shape))
        self.end = frame
        while len(self.looks) > _LOOKS_KEPT:
            self._settle(self.looks.popleft(), self.approach.contact().frame)

    def settle(self, contact: int, before: float) -> float:
        """Count the frames from the contact on and before another one; return the last neck."""
        last = math.nan
        for look in self.looks:
            if look.frame < before:
                self._settle(look, contact)
                last = look.neck
        self.looks.clear()
        return last

    def _settle(self, look: _Look, contact: int) -> None:
        if look.frame >= contact:
            self.neck = float(np.fmin(self.neck, look.neck))
            self.shape = max(self.shape, look.shape)

    def rejected(self, reason: str, frame: float = math.inf) -> None:
        self.reasons[reason] = max(frame, self.reasons.get(reason, 0.0))


@dataclass
class _Follower:
    """What is remembered of one track."""

    places: deque[Place]
    passed: set[int] = field(default_factory=set)  # obstacles at which it, or its mother, has been
    near: dict[int, Approach] = field(default_factory=dict)  # to obstacles that it has not met
    meetings: list[_Meeting] = field(default_factory=list)
    area: float = math.nan


class _Parting(NamedTuple):
    """A break-up that is not yet believed: the daughters may be one droplet again at once."""

    event: Event
    seen: int
    mother: _Follower
    daughters: list[Droplet]


class CollisionFinder:
    """Find the collisions of a clip while its frames go by.

    Parameters
    ----------
    settings : VideoSettings
    obstacles : ndarray, shape (M, 3)
        Centre x, y and radius, pixels.

    Attributes
    ----------
    necks : list of ndarray, shape (2, 2)
        Ends of the necks of the droplets in contact in the last frame, pixels.
    met : list of (int, int)
        Track and obstacle of the collisions whose first contact may be in the last frame.
    """

    def __init__(self, settings: VideoSettings, obstacles: Floats) -> None:
        self._settings, self._obstacles = settings, obstacles
        self._bound = settings.contact_um / settings.pixel_um
        self._tracks: dict[int, _Follower] = {}
        self._times: dict[int, float] = {}  # of the last frames
        self._partings: list[_Parting] = []
        self.necks: list[Floats] = []
        self.met: list[tuple[int, int]] = []

    def step(
        self,
        frame: int,
        time_s: float,
        droplets: Sequence[Droplet],
        numbers: Sequence[int],
        events: Sequence[Event],
    ) -> list[Encounter]:
        """Take one frame and return the collisions that are over.

        Numbers are those of the droplets' tracks, events what has happened since the last frame.
        """
        self._times[frame] = time_s
        self._times.pop(frame - _LOOKS_KEPT, None)
        by_track = dict(zip(numbers, droplets, strict=True))
        over = self._parted(frame - self._settings.memory)
        for event in events:
            over += self._ended(event, frame, by_track)
        self.necks, self.met = [], []
        for number, droplet in by_track.items():
            follower = self._tracks.get(number)
            if follower is None:
                length = self._settings.velocity_frames
                follower = self._tracks[number] = _Follower(deque(maxlen=length))
            follower.places.append(Place(time_s, droplet.x, droplet.y))
            follower.area = droplet.area
            over += self._looked_at(number, follower, frame, droplet)
        return over

    def finish(self) -> list[Encounter]:
        """Return the collisions that the clip's end cut short."""
        over = self._parted(math.inf)
        for follower in self._tracks.values():
            for meeting in follower.meetings:
                meeting.rejected(CLIP_ENDED)
                over.append(self._encounter(meeting, "captured"))
        self._tracks.clear()
        return over

    def _ended(self, event: Event, frame: int, by_track: dict[int, Droplet]) -> list[Encounter]:
        for parting in self._partings:
            if set(parting.event.children) == set(event.parents):
                # The daughters are one again: a neck too thin to be seen did not break.
                daughters = [self._tracks.pop(parent) for parent in event.parents]
                self._tracks[event.children[0]] = parting.mother
                self._partings.remove(parting)
                return [self._lost(meeting, event) for d in daughters for meeting in d.meetings]
        over = []
        children = [by_track[number] for number in event.children]
        for parent in event.parents:
            follower = self._tracks.pop(parent, None)
            if follower is None:
                continue
            if event.kind != "break-up":
                over += [self._lost(meeting, event) for meeting in follower.meetings]
                continue
            self._partings.append(_Parting(event, frame, follower, children))
            for child in event.children:
                born = _Follower(deque(maxlen=self._settings.velocity_frames))
                # Daughters have not met the obstacle at which their mother broke.
                born.passed = {meeting.obstacle for meeting in follower.meetings}
                self._tracks[child] = born
        return over

    def _parted(self, before: float) -> list[Encounter]:
        """Return the collisions that ended in break-ups seen before a frame."""
        due = [parting for parting in self._partings if parting.seen < before]
        self._partings = [parting for parting in self._partings if parting not in due]
        return [
            self._broken(meeting, parting) for parting in due for meeting in parting.mother.meetings
        ]

    def _broken(self, meeting: _Meeting, parting: _Parting) -> Encounter:
        if len(parting.daughters) > 2:
            meeting.rejected(MANY_DAUGHTERS)
        if any(daughter.cut for daughter in parting.daughters):
            meeting.rejected(CUT_BY_FRAME)
        areas = sorted(daughter.area for daughter in parting.daughters)[-2:]
        frame = parting.event.frame
        time_s = self._times.get(frame, math.nan)
        return self._encounter(meeting, "broke", frame, time_s, areas)

    def _lost(self, meeting: _Meeting, event: Event) -> Encounter:
        reasons = {"coalescence": COALESCENCE, "exit": CUT_BY_FRAME}
        meeting.rejected(reasons.get(event.kind, LOST))
        return self._encounter(meeting, "captured")

    def _looked_at(
        self, number: int, follower: _Follower, frame: int, droplet: Droplet
    ) -> list[Encounter]:
        if not len(self._obstacles):
            return []
        distances = np.hypot(*(self._obstacles[:, :2] - (droplet.x, droplet.y)).T)
        beyond = distances - (1.0 + RELEASE) * self._obstacles[:, 2]
        # Nothing of a droplet is farther from its centre than half its perimeter.
        if not follower.meetings and beyond.min() > len(droplet.outline):
            return []
        reach = np.hypot(*(droplet.outline - (droplet.x, droplet.y)).T).max()
        near = np.flatnonzero(
            distances - self._obstacles[:, 2] - reach <= RELEASE * self._obstacles[:, 2]
        )
        open_ones = {meeting.obstacle: meeting for meeting in follower.meetings}
        approaches: dict[int, Approach] = {}
        for obstacle in near.tolist():
            gap = gap_to_circle(droplet.outline, self._obstacles[obstacle])
            if gap > RELEASE * self._obstacles[obstacle, 2]:
                continue  # over, if it had begun
            meeting = open_ones.pop(obstacle, None)
            if meeting is None and obstacle not in follower.passed:
                approach = follower.near.get(obstacle) or self._approach(follower)
                approaches[obstacle] = approach
                if gap <= self._bound:
                    meeting = _Meeting(number, obstacle, approach)
                    follower.meetings.append(meeting)
                    follower.passed.add(obstacle)
                else:
                    approach.add(frame, follower.places[-1], droplet.outline, gap)
            if meeting is not None:
                self._go_on(meeting, frame, follower.places[-1], droplet, gap)
        follower.near = {
            k: approach for k, approach in approaches.items() if k not in follower.passed
        }
        # What is still among the open ones has left its obstacle behind.
        for meeting in open_ones.values():
            follower.meetings.remove(meeting)
        return [self._encounter(meeting, "slipped") for meeting in open_ones.values()]

    def _approach(self, follower: _Follower) -> Approach:
        before = list(follower.places)[:-1]
        fixed = self._settings.contact_distance_um is not None
        return Approach(before, self._settings.velocity_frames, self._bound, fixed=fixed)

    def _go_on(
        self, meeting: _Meeting, frame: int, place: Place, droplet: Droplet, gap: float
    ) -> None:
        if not meeting.approach.known:
            self.met.append((meeting.track, meeting.obstacle))
        meeting.approach.add(frame, place, droplet.outline, gap)
        if droplet.group >= 0:
            meeting.rejected(TOUCHING, frame)
        if droplet.cut:
            meeting.rejected(CUT_BY_FRAME, frame)
        neck, i, j = thinnest_neck(droplet.outline)
        meeting.look(frame, neck, _core.shape_parameter(droplet.outline))
        if not math.isnan(neck):
            self.necks.append(droplet.outline[[i, j]])

    def _encounter(
        self,
        meeting: _Meeting,
        outcome: str,
        breakup_frame: float = math.nan,
        breakup_time_s: float = math.nan,
        areas: Sequence[float] = (math.nan, math.nan),
    ) -> Encounter:
        px = self._settings.pixel_um
        contact = meeting.approach.contact()
        before = math.inf if math.isnan(breakup_frame) else breakup_frame
        last_neck = meeting.settle(contact.frame, before)
        if contact.seen < FEWEST_FRAMES:
            meeting.rejected(NO_APPROACH)
        reasons = [reason for reason, last in meeting.reasons.items() if last >= contact.frame]
        x, y, radius = (self._obstacles[meeting.obstacle] * px).tolist()
        return Encounter(
            obstacle=(x, y, radius),
            outline=contact.outline * px,
            velocity=(contact.velocity[0] * px * 1e-3, contact.velocity[1] * px * 1e-3),
            contact_frame=contact.frame,
            end_frame=meeting.end,
            contact_time_s=contact.time_s,
            outcome=outcome,
            breakup_frame=breakup_frame,
            breakup_time_s=breakup_time_s,
            daughter_areas=(areas[0] * px**2, areas[1] * px**2),
            neck=meeting.neck * px,
            breakup_neck=last_neck * px if outcome == "broke" else math.nan,
            maximum_shape_parameter=meeting.shape,
            reject_reason="; ".join(reasons),
            track_id=meeting.track,
            obstacle_id=meeting.obstacle,
        )
