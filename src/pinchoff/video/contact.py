"""First contact: where the gap between a droplet and an obstacle stops closing.

A fixed distance is crossed before the droplet touches, and droplets slow down where they touch. So
the gap's own history tells: contact is the first frame in which the gap is within a pixel of the
one at which it comes to rest, whatever film of oil stays between.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FEWEST_FRAMES = 3
"""Frames up to the contact without which there is no velocity."""

_STOPPED = 0.2  # of the fastest closing before: slower than that it has stopped
_BEFORE, _AFTER = 6, 3  # frames over which closing is compared
_SMOOTH = 0.1  # of a frame's displacement: how far places may be off a motion without jumps
_MOST_KEPT = 256  # frames of one approach: of a longer one the last


class Place(NamedTuple):
    """Where a droplet is: time in s, centre of mass in pixels."""

    time_s: float
    x: float
    y: float


class Contact(NamedTuple):
    """A first contact.

    Attributes
    ----------
    frame : int
    time_s : float
    outline : ndarray, shape (n, 2)
        The droplet then, pixels.
    velocity : (float, float)
        Of its centre of mass then, pixels a second.
    seen : int
        Frames up to then in which it was seen.
    """

    frame: int
    time_s: float
    outline: Floats
    velocity: tuple[float, float]
    seen: int


def rest_begins(gaps: Sequence[float] | Floats, bound: float) -> int | None:
    """Return from which frame on a gap closes no more; None as long as it closes.

    Only a gap as small as `bound`, in the same unit, can have come to rest.
    """
    history = np.maximum(gaps, 0.0)
    near = np.flatnonzero(history[1 : len(history) - _AFTER + 1] <= bound) + 1
    if not len(near):
        return None
    closing = -np.diff(history)
    for k in near.tolist():
        fastest = max(0.0, float(closing[max(0, k - 1 - _BEFORE) : k - 1].max(initial=0.0)))
        later = (history[k - 1] - history[k + _AFTER - 1]) / _AFTER
        if later <= _STOPPED * fastest:
            return k
    return None


def first_contact(gaps: Sequence[float] | Floats, bound: float, within: float) -> int:
    """Return the frame of the first contact in the history of a gap, from the approach on.

    Only a gap as small as `bound` can have come to rest; `within` is how near to the gap at rest
    counts as contact: a pixel.
    """
    history = np.maximum(gaps, 0.0)  # nothing comes nearer than to touch
    rest = rest_begins(history, bound)
    settled = history if rest is None else history[: rest + _AFTER]
    return int(np.argmax(history <= settled.min() + within))


def contact_velocity(
    places: Sequence[tuple[float, float, float]], at_s: float | None = None
) -> tuple[float, float]:
    """Return the velocity at the last of several places, or at another time, pixels a second.

    A parabola in time through all of them, by least squares: droplets slow down as they approach.
    Across their way they are taken to bend only where the places show it, by Akaike's corrected
    criterion: a bend that is noise would turn the velocity. With three places or fewer a straight
    line; with one, NaN.

    Places are times in s, x and y.
    """
    if len(places) < 2:
        return math.nan, math.nan
    since = np.array([place[0] for place in places]) - (places[-1][0] if at_s is None else at_s)
    where = np.array([place[1:] for place in places])
    way = where[-1] - where[0]
    way = way / np.hypot(*way) if way.any() else np.array([1.0, 0.0])
    aside = np.array([-way[1], way[0]])
    along, _ = _slope(since, where @ way, 3 if len(places) > FEWEST_FRAMES else 2)
    straight, bent = (_slope(since, where @ aside, order) for order in (2, 3))
    across = bent[0] if bent[1] < straight[1] else straight[0]
    vx, vy = (along * way + across * aside).tolist()
    return vx, vy


def _slope(since: Floats, values: Floats, order: int) -> tuple[float, float]:
    """Return the slope at zero of a polynomial fit, and Akaike's corrected criterion."""
    powers = np.vander(since, order, increasing=True)
    fit, *_ = np.linalg.lstsq(powers, values, rcond=None)
    spare = len(since) - order - 2  # the noise is a parameter too
    if spare <= 0:
        return float(fit[1]), math.inf
    left = float(np.mean((powers @ fit - values) ** 2))
    parameters = order + 1
    criterion = len(since) * math.log(max(left, 1e-24)) + 2 * parameters
    return float(fit[1]), criterion + 2 * parameters * (parameters + 1) / spare


def touching_velocity(
    places: Sequence[tuple[float, float, float]], at: int, touch_s: float
) -> tuple[float, float]:
    """Return the velocity at first contact, pixels a second.

    A parabola in time by least squares, whose curvature changes where the droplet touches: there
    it begins to be slowed down, but its velocity does not jump. Where it does jump, as that of
    what is not soft, the velocity is that of the approach at the touch.

    Places are times in s, x and y before, in and after the frame of contact, which is number `at`;
    it touches at `touch_s`, not later than that.
    """
    times = np.array([place[0] for place in places])
    approach = [place for place in places if place[0] < touch_s] or list(places[: at + 1])
    if at < 1 or len(approach) < 2:
        return contact_velocity(places[: at + 1])
    since, pushed = times - times[at], np.maximum(times - touch_s, 0.0)
    if len(approach) <= FEWEST_FRAMES or np.count_nonzero(pushed) < 2:
        return contact_velocity(approach, touch_s)
    columns = np.column_stack([np.ones_like(since), since, since**2, pushed**2])
    where = np.array([place[1:] for place in places])
    fit, *_ = np.linalg.lstsq(columns, where, rcond=None)
    off = np.sqrt(np.mean(((columns @ fit - where) ** 2).sum(axis=1)))
    vx, vy = (fit[1] + 2.0 * pushed[at] * fit[3]).tolist()
    step = math.hypot(vx, vy) * float(np.diff(times).mean())
    return (vx, vy) if off <= _SMOOTH * step else contact_velocity(approach, touch_s)


class Approach:
    """What is remembered of one droplet near one obstacle until its first contact is known.

    Parameters
    ----------
    places : sequence of Place
        Of the frames before.
    velocity_frames : int
        Frames up to the contact to which the velocity is fitted; half as many after it help.
    bound_px : float
        Gap below which it is a contact at all, pixels.
    fixed : bool
        Whether the first gap below it is the contact, whatever comes later.
    """

    def __init__(
        self, places: Sequence[Place], velocity_frames: int, bound_px: float, *, fixed: bool
    ) -> None:
        self._before, self._length = list(places), velocity_frames
        self._bound, self._fixed = bound_px, fixed
        self._frames: list[int] = []
        self._places: list[Place] = []
        self._outlines: list[Floats] = []
        self._gaps: list[float] = []
        self._left = -1  # frames that are still wanted; -1: not known yet

    @property
    def known(self) -> bool:
        """Whether later frames change nothing."""
        return self._left == 0

    def add(self, frame: int, place: Place, outline: Floats, gap: float) -> None:
        """Take one frame, unless all is known."""
        if self.known:
            return
        if len(self._gaps) == _MOST_KEPT:
            self._before = [*self._before[1:], self._places[0]]
            for kept in (self._frames, self._places, self._outlines, self._gaps):
                del kept[0]
        self._frames.append(frame)
        self._places.append(place)
        self._outlines.append(outline)
        self._gaps.append(gap)
        if self._left > 0:
            self._left -= 1
        elif self._fixed:
            self._left = 0 if gap <= self._bound else -1
        elif rest_begins(self._gaps, self._bound) is not None:
            self._left = max(0, self._length // 2 - _AFTER + 1)

    def contact(self) -> Contact:
        """Return the first contact, as far as is known."""
        if self._fixed:
            k = int(np.argmax(np.array(self._gaps) <= self._bound))
        else:
            k = first_contact(self._gaps, self._bound, 1.0)
        places = [*self._before, *self._places]
        at = len(self._before) + k
        first = max(0, at + 1 - self._length)
        if self._fixed:
            velocity = contact_velocity(places[first : at + 1])
        else:
            near = places[first : at + 1 + self._length // 2]
            velocity = touching_velocity(near, at - first, self._touch_s(k))
        place = self._places[k]
        return Contact(self._frames[k], place.time_s, self._outlines[k], velocity, at + 1)

    def _touch_s(self, k: int) -> float:
        """Return when the gap, closing as before the contact, comes to rest."""
        at = self._places[k].time_s
        if k < 2:
            return at
        gaps, times = self._gaps, [place.time_s for place in self._places]
        speed = (gaps[k - 2] - gaps[k - 1]) / (times[k - 1] - times[k - 2])
        rest = min(gaps[k : k + _AFTER])
        if speed <= 0.0:
            return at
        return min(at, times[k - 1] + max(0.0, gaps[k - 1] - rest) / speed)
