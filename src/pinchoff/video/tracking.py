"""Tracking: the same droplet from frame to frame, and what becomes of it.

Droplets are linked to the nearest place where they are expected, all at once (Crocker and Grier,
J. Colloid Interface Sci. 179, 298, 1996), if their areas agree. What is left over on either side
is explained by events: one droplet that became two of the same area in all, around the same centre
of mass, two that became one, entry, exit. A lost droplet is waited for.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pinchoff.video.droplets import Droplet
from pinchoff.video.settings import VideoSettings

T = TypeVar("T")
Floats = NDArray[np.float64]

_FORBIDDEN = 1e12
_VELOCITY_MEMORY = 0.5  # share of the newest displacement in a track's velocity
_MOST_DAUGHTERS = 4
_MOST_NEAR = 8  # droplets that are tried as parts of another
_STRIDES = 8  # frames whose steps are remembered
_STILL = 0.1  # of the longest of them: a shorter one is a frame that repeats the one before
_MOVES = 1.0  # pixels: droplets that move less may stand
_KNOWN = 2  # frames in which a droplet is seen before it may break or merge
_LOOK_BACK = 12  # frames in which a daughter may be too thin to be seen


class Event(NamedTuple):
    """What happened to droplets between two frames.

    Attributes
    ----------
    kind : str
        "entry", "exit", "break-up", "coalescence", "found" or "lost".
    frame : int
        The first frame after it. A daughter too small to be seen at once is reported late, with
        the frame in which its area was first missing.
    parents, children : tuple of int
        Tracks that end and that begin.
    """

    kind: str
    frame: int
    parents: tuple[int, ...]
    children: tuple[int, ...]


@dataclass(eq=False)
class _Track:
    """A droplet that is being followed."""

    number: int
    frame: int
    droplet: Droplet
    velocity: Floats | None = None
    missed: int = 0
    seen: int = 1
    recent: deque[tuple[int, float]] = field(  # frames and whole areas
        default_factory=lambda: deque(maxlen=_LOOK_BACK)
    )

    def whole_area(self) -> float:
        """Return the largest area of late: a small daughter may be seen frames after it left."""
        return max((area for _, area in self.recent), default=self.droplet.area)

    def lost_at(self, frame: int, missing: float) -> int:
        """Return the first frame in which an area was missing, or else a given one."""
        whole = self.whole_area()
        late = [k for k, area in self.recent if area < whole - 0.5 * missing]
        return min([*late, frame])

    def expected(self, frame: int, flow: Floats) -> Floats:
        velocity = flow if self.velocity is None else self.velocity
        return np.array([self.droplet.x, self.droplet.y]) + velocity * (frame - self.frame)

    def moved_to(self, frame: int, droplet: Droplet) -> None:
        step = np.array([droplet.x - self.droplet.x, droplet.y - self.droplet.y])
        step = step / (frame - self.frame)
        before = step if self.velocity is None else self.velocity
        self.velocity = before + _VELOCITY_MEMORY * (step - before)
        self.frame, self.droplet, self.missed = frame, droplet, 0
        self.seen += 1

    def remember(self) -> None:
        """Keep the last areas; none across the frame's edge."""
        if self.droplet.cut:
            self.recent.clear()
        else:
            self.recent.append((self.frame, self.droplet.area))


@dataclass
class Tracker:
    """Follow the droplets of a clip, one frame after the other."""

    settings: VideoSettings
    _tracks: list[_Track] = field(default_factory=list)
    count: int = 0  # of tracks so far
    _flow: Floats = field(default_factory=lambda: np.zeros(2))
    _begun_at: int | None = None
    _strides: deque[float] = field(default_factory=lambda: deque(maxlen=_STRIDES))

    def resolved(self, frame: int, droplets: Sequence[Droplet]) -> list[Droplet]:
        """Return droplets with parts taken together that were one droplet and still may be one."""
        kept: list[Droplet] = []
        done: set[int] = set()
        for droplet in droplets:
            if droplet.whole is None or not self._is_expected(frame, droplet.whole):
                kept.append(droplet)
            elif droplet.group not in done:
                done.add(droplet.group)
                kept.append(droplet.whole)
        return kept

    def _is_expected(self, frame: int, droplet: Droplet) -> bool:
        for track in self._tracks:
            before, after = track.droplet.area, droplet.area
            if abs(after - before) > self.settings.area_tolerance * max(after, before):
                continue
            off = track.expected(frame, self._flow) - (droplet.x, droplet.y)
            if np.hypot(*off) <= self.reach(np.array(before)):
                return True
        return False

    def step(self, frame: int, droplets: Sequence[Droplet]) -> tuple[list[int], list[Event]]:
        """Take the droplets of a later frame; return the track of each, and what happened."""
        if self._begun_at is None:
            self._begun_at = frame
        links = self._links(frame, droplets)
        partners = {k: self._tracks[t] for t, k in links.items()}
        free_tracks = [t for k, t in enumerate(self._tracks) if k not in links]
        free = [k for k in range(len(droplets)) if k not in partners]

        def expected(track: _Track) -> Floats:
            return track.expected(frame, self._flow)

        events: list[Event] = []
        begun: dict[int, _Track] = {}
        leftovers = _Leftovers(self, droplets, free_tracks, free, partners, expected)
        for parents, children in leftovers.explained():
            born = {k: self._new(frame, droplets[k], parents[-1]) for k in children}
            events.append(_event(frame, parents, list(born.values())))
            begun |= born
            self._tracks = [t for t in self._tracks if t not in parents]
        steps = []
        for k, track in partners.items():
            if k not in begun and track in self._tracks:
                before = (track.droplet.x, track.droplet.y, track.frame)
                track.moved_to(frame, droplets[k])
                step = math.hypot(droplets[k].x - before[0], droplets[k].y - before[1])
                steps.append(step / (frame - before[2]))
        if steps:
            self._strides.append(float(np.median(steps)))
        for k in range(len(droplets)):
            if k not in begun and partners.get(k) not in self._tracks:
                begun[k] = self._new(frame, droplets[k])
                # In the first frame everything comes into view.
                seen_to_enter = droplets[k].cut or frame == self._begun_at
                kind = "entry" if seen_to_enter else "found"
                events.append(Event(kind, frame, (), (begun[k].number,)))
        events += self._forget(frame, repeated=bool(steps) and self._repeats())
        self._tracks += begun.values()
        for track in self._tracks:
            if track.frame == frame:
                track.remember()
        self._learn_flow(frame)
        numbers = [(begun.get(k) or partners[k]).number for k in range(len(droplets))]
        return numbers, events

    def finish(self, frame: int) -> list[Event]:
        """Return the ends of the tracks that were still waited for."""
        waiting = [t for t in self._tracks if t.missed > 0]
        return [self._end(track, frame) for track in waiting]

    def _new(self, frame: int, droplet: Droplet, parent: _Track | None = None) -> _Track:
        track = _Track(self.count, frame, droplet)
        if parent is not None:
            track.velocity, track.seen = parent.velocity, parent.seen + 1
        self.count += 1
        return track

    def _links(self, frame: int, droplets: Sequence[Droplet]) -> dict[int, int]:
        """Return the position of a droplet for each position of a track that goes on in it."""
        if not self._tracks or not droplets:
            return {}
        expected = np.array([t.expected(frame, self._flow) for t in self._tracks])
        found = np.array([[d.x, d.y] for d in droplets])
        before = np.array([t.droplet.area for t in self._tracks])
        after = np.array([d.area for d in droplets])
        square = ((expected[:, None] - found[None]) ** 2).sum(axis=2)
        # What has just come into view may be slower than the others.
        new = np.array([t.velocity is None for t in self._tracks])
        reach = self.reach(before) + np.where(new, float(np.hypot(*self._flow)), 0.0)
        reach = reach + self._jerk()
        change = np.abs(after[None] - before[:, None]) / np.maximum(after[None], before[:, None])
        cut = np.array([t.droplet.cut for t in self._tracks])[:, None]
        cut = cut | np.array([d.cut for d in droplets])[None]
        allowed = (square <= reach[:, None] ** 2) & ((change <= self.settings.area_tolerance) | cut)
        # Areas that differ by the tolerance count like a distance of the whole reach.
        strange = np.where(cut, 0.0, change / max(self.settings.area_tolerance, 1e-6))
        cost = np.where(allowed, square / reach[:, None] ** 2 + strange**2, _FORBIDDEN)
        rows, columns = linear_sum_assignment(cost)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return {row: column for row, column in pairs if cost[row, column] < _FORBIDDEN}

    def reach(self, area: Floats) -> Floats:
        """Return how far from its expected place a droplet is looked for, pixels."""
        if self.settings.maximum_step_px is not None:
            return np.full(np.shape(area), self.settings.maximum_step_px)
        reach: Floats = np.sqrt(np.asarray(area) / math.pi)  # half its diameter
        return reach

    def _jerk(self) -> float:
        """Return by how much the next step may be longer than the last ones, pixels.

        A film whose frames repeat moves in jerks: nothing for some frames, then all at once.
        """
        if not self._strides or min(self._strides) > _STILL * max(self._strides):
            return 0.0
        return max(self._strides)

    def _repeats(self) -> bool:
        """Return whether the last frame is the one before again, as cameras and players give."""
        longest = max(self._strides)
        return longest > _MOVES and self._strides[-1] <= _STILL * longest

    def _forget(self, frame: int, *, repeated: bool) -> list[Event]:
        events, kept = [], []
        for track in self._tracks:
            # A frame that repeats the one before is no second chance.
            if track.frame < frame and not (repeated and track.missed):
                track.missed += 1
            if track.missed > self.settings.memory or (track.missed and track.droplet.cut):
                events.append(self._end(track, frame))
            else:
                kept.append(track)
        self._tracks = kept
        return events

    @staticmethod
    def _end(track: _Track, frame: int) -> Event:
        kind = "exit" if track.droplet.cut else "lost"
        return Event(kind, frame, (track.number,), ())

    def _learn_flow(self, frame: int) -> None:
        moving = [t.velocity for t in self._tracks if t.velocity is not None and t.frame == frame]
        if moving:
            self._flow = np.median(np.array(moving), axis=0)


def _event(frame: int, parents: Sequence[_Track], born: Sequence[_Track]) -> Event:
    ends, begins = tuple(t.number for t in parents), tuple(t.number for t in born)
    if len(parents) > 1:
        return Event("coalescence", frame, ends, begins)
    since = parents[0].lost_at(frame, min(t.droplet.area for t in born))
    return Event("break-up", since, ends, begins)


class _Part(NamedTuple):
    """Area and place of a droplet, pixels."""

    area: float
    place: Floats


class _Leftovers:
    """Tracks and droplets of one frame without a partner, and the events that explain them.

    A partner may have been found for the larger of two daughters, whose area differs little from
    its mother's, or for the larger of two droplets that merged: then it takes part too.
    """

    def __init__(
        self,
        tracker: Tracker,
        droplets: Sequence[Droplet],
        tracks: Sequence[_Track],
        free: Sequence[int],
        partners: dict[int, _Track],
        expected: Callable[[_Track], Floats],
    ) -> None:
        self._tracker, self._expected = tracker, expected
        self._tracks, self._free, self._partners = tracks, free, partners
        self._parts = [
            _Part(droplet.area, np.array([droplet.x, droplet.y])) for droplet in droplets
        ]
        self._used: set[int] = set()
        self._ended: set[int] = set()

    def explained(self) -> list[tuple[list[_Track], list[int]]]:
        """Return the tracks that end and the droplets that begin in every event."""
        if not self._tracks and not self._free:
            return []
        return [*self._break_ups(), *self._coalescences()]

    def _break_ups(self) -> Iterator[tuple[list[_Track], list[int]]]:
        for track in [*self._tracks, *self._partners.values()]:
            children = self._children_of(track)
            if children:
                self._used.update(children)
                self._ended.add(track.number)
                yield [track], children

    def _children_of(self, track: _Track) -> list[int]:
        """Return two droplets or more that a track became; none if it did not break."""
        if track.seen < _KNOWN:
            return []  # what was seen once may be two that were taken for one
        whole = _Part(track.whole_area(), self._expected(track))
        reach = self._reach(track.droplet.area)
        own = [k for k, t in self._partners.items() if t is track]
        unused = [k for k in self._free if k not in self._used]
        near = _nearest(unused, lambda k: self._parts[k].place, whole.place, 4.0 * reach)
        for count in range(max(1, 2 - len(own)), _MOST_DAUGHTERS + 1 - len(own)):
            for chosen in itertools.combinations(near, count):
                children = [*own, *chosen]
                if self._agree(whole, reach, [self._parts[k] for k in children]):
                    return children
        return []

    def _coalescences(self) -> Iterator[tuple[list[_Track], list[int]]]:
        lone = [t for t in self._tracks if t.number not in self._ended and t.seen >= _KNOWN]
        for k in [*self._free, *self._partners] if lone else []:
            own = self._partners.get(k)
            if k in self._used or (own is not None and own.number in self._ended):
                continue
            whole = self._parts[k]
            reach = self._reach(whole.area)
            left = [t for t in lone if t.number not in self._ended]
            near = _nearest(left, self._expected, whole.place, 4.0 * reach)
            pairs = itertools.combinations(near, 2) if own is None else ((t, own) for t in near)
            for pair in pairs:
                before = [_Part(t.droplet.area, self._expected(t)) for t in pair]
                if self._agree(whole, reach, before):
                    self._used.add(k)
                    self._ended.update(t.number for t in pair)
                    yield list(pair), [k]
                    break

    def _reach(self, area: float) -> float:
        return float(self._tracker.reach(np.array(area)))

    def _agree(self, whole: _Part, reach: float, parts: Sequence[_Part]) -> bool:
        """Return whether parts have the area of the whole, about its centre of mass."""
        total = sum(part.area for part in parts)
        centre = sum((part.area * part.place for part in parts), np.zeros(2)) / total
        # The smallest part must be what is missing, not a trifle within the tolerance.
        smallest = min(part.area for part in parts)
        allowed = min(self._tracker.settings.area_tolerance * whole.area, 0.5 * smallest)
        return (
            abs(total - whole.area) <= allowed
            and _distance(centre, whole.place) <= reach
            and all(_distance(part.place, whole.place) <= 4.0 * reach for part in parts)
        )


def _nearest(
    candidates: Sequence[T], place: Callable[[T], Floats], centre: Floats, reach: float
) -> list[T]:
    """Return those within reach of a centre, no more than can be tried in all combinations."""
    away = [_distance(place(candidate), centre) for candidate in candidates]
    order = sorted(range(len(candidates)), key=away.__getitem__)[:_MOST_NEAR]
    return [candidates[k] for k in order if away[k] <= reach]


def _distance(one: Floats, other: Floats) -> float:
    return float(np.hypot(*(one - other)))
