"""Where on a line of offsets a droplet stops breaking: a scan, then brackets that close on it.

Nothing here simulates. A search asks for offsets, takes what came of them, and ends with what it
may say about the edge between breaking and not breaking; many searches advance together.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple, TypeAlias

Status: TypeAlias = Literal[
    "found", "no break even head-on", "breaks at every contact", "non-monotonic", "unresolved"
]

STATUSES: dict[Status, str] = {
    "found": "the outcome changes once, between the two offsets",
    "no break even head-on": "no run broke, and the one at offset 0 was among them",
    "breaks at every contact": "every run that touched the obstacle broke",
    "non-monotonic": "the outcome changes more than once; see the intervals",
    "unresolved": "guards stopped runs that decide, or the symmetry jumps at the edge",
}
"""What a search can end with, and what it means."""

SECTIONS = 4
"""Parts into which a round divides a bracket. More than two, so that few brackets still keep many
cores busy; not as many as there are cores, so that results do not depend on those."""

GLANCING = 0.05
"""A scan may end at an unbroken contact of a smaller symmetry than this."""

_MOST_BLOCKS = 8  # a scan may grow by so many blocks, each half as long as the scan
_MOST_ROUNDS = 10  # rounds of closing; a bracket is then a millionth of the scan's spacing


class Trial(NamedTuple):
    """What a search knows of one run."""

    offset: float  # start y, D0
    symmetry: float  # S at first contact; NaN: the droplet never touched the obstacle
    broke: bool | None  # None: a guard stopped the run, so that it has no outcome


class Interval(NamedTuple):
    """Neighbouring runs of one outcome."""

    first_symmetry: float  # of the run nearest to head-on
    last_symmetry: float
    broke: bool


class Bracket(NamedTuple):
    """What a search found."""

    status: Status
    # The ends of the bracket: the run of the smallest S that broke and that of the largest S that
    # did not. None where there is no such end, both where the outcome changes more than once.
    broke: Trial | None
    unbroken: Trial | None
    intervals: tuple[Interval, ...]  # of all runs that touched, from head-on outwards
    trials: int
    failures: int  # runs that a guard stopped

    @property
    def width(self) -> float:
        """Distance of the two ends in S; NaN without both."""
        if self.broke is None or self.unbroken is None:
            return math.nan
        return self.broke.symmetry - self.unbroken.symmetry


class Search:
    """Search for the edge at one point of parameter space.

    The scan has `scan` intervals up to the offset `reach`, D0, and goes on from there as far as
    droplets touch the obstacle with more than a glance, but not beyond `limit`. The two ends of a
    finished bracket are at most `width` apart in S.
    """

    def __init__(self, reach: float, width: float, scan: int, limit: float) -> None:
        self._spacing = reach / scan
        self._width = width
        self._scan = scan
        self._limit = limit
        self._blocks = 0
        self._rounds = 0
        self._trials: list[Trial] = []

    def wanted(self) -> list[float]:
        """Return the offsets to run next; none when the search is over."""
        if not self._trials:
            return [k * self._spacing for k in range(self._scan + 1)]
        if not self._covered() and (block := self._next_block()):
            return block
        if self._changes() != 1 or self._rounds >= _MOST_ROUNDS:
            return []
        return self._sections()

    def take(self, trials: Sequence[Trial]) -> None:
        """Take the outcomes at the offsets that were asked for."""
        if self._trials and trials[0].offset > self._trials[-1].offset:
            self._blocks += 1
        elif self._trials:
            self._rounds += 1
        for trial in trials:
            bisect.insort(self._trials, trial, key=lambda one: one.offset)

    def bracket(self) -> Bracket:
        """Return what the search found."""
        status = self._status()
        edge = self._edge()
        broke, unbroken = (None, None) if status == "non-monotonic" else edge
        if unbroken is not None and math.isnan(unbroken.symmetry):
            unbroken = None
        return Bracket(
            status,
            broke,
            unbroken,
            self._intervals(),
            trials=len(self._trials),
            failures=sum(trial.broke is None for trial in self._trials),
        )

    def _sound(self) -> list[Trial]:
        return [trial for trial in self._trials if trial.broke is not None]

    def _covered(self) -> bool:
        sound = self._sound()
        if not sound or sound[-1].broke:
            return False
        return math.isnan(sound[-1].symmetry) or sound[-1].symmetry < GLANCING

    def _next_block(self) -> list[float]:
        if self._blocks == _MOST_BLOCKS or not self._sound():
            return []
        last = round(self._trials[-1].offset / self._spacing)
        more = [k * self._spacing for k in range(last + 1, last + 2 + self._scan // 2)]
        return [offset for offset in more if offset <= self._limit]

    def _changes(self) -> int:
        return sum(a.broke != b.broke for a, b in itertools.pairwise(self._sound()))

    def _edge(self) -> tuple[Trial | None, Trial | None]:
        """Return the outermost run that broke, and the innermost that did not."""
        sound = self._sound()
        broke = [trial for trial in sound if trial.broke]
        unbroken = [trial for trial in sound if not trial.broke]
        return (broke[-1] if broke else None), (unbroken[0] if unbroken else None)

    def _sections(self) -> list[float]:
        """Return offsets that divide the bracket, or none when it is narrow enough."""
        broke, unbroken = self._edge()
        if broke is None or unbroken is None or broke.offset > unbroken.offset:
            return []
        if _narrow(broke, unbroken, self._width):
            return []
        between = [t.offset for t in self._trials if broke.offset < t.offset < unbroken.offset]
        if between:
            # All of these failed: close in on them from both sides.
            return [(broke.offset + between[0]) / 2, (between[-1] + unbroken.offset) / 2]
        part = (unbroken.offset - broke.offset) / SECTIONS
        return [broke.offset + k * part for k in range(1, SECTIONS)]

    def _status(self) -> Status:
        broke, unbroken = self._edge()
        if self._changes() > 1 or (broke and unbroken and broke.offset > unbroken.offset):
            return "non-monotonic"
        if broke is None:
            head_on = self._trials[0]
            sound = head_on.broke is not None and not math.isnan(head_on.symmetry)
            return "no break even head-on" if sound else "unresolved"
        if unbroken is None:
            return "unresolved"
        if not math.isnan(unbroken.symmetry):
            return "found" if _narrow(broke, unbroken, self._width) else "unresolved"
        fails = any(broke.offset < one.offset < unbroken.offset for one in self._trials)
        return "unresolved" if fails else "breaks at every contact"

    def _intervals(self) -> tuple[Interval, ...]:
        touched = [trial for trial in self._sound() if not math.isnan(trial.symmetry)]
        groups = [list(group) for _, group in itertools.groupby(touched, key=lambda t: t.broke)]
        return tuple(
            Interval(group[0].symmetry, group[-1].symmetry, bool(group[0].broke))
            for group in groups
        )


def _narrow(broke: Trial, unbroken: Trial, width: float) -> bool:
    # A droplet that never touches has no symmetry: next to it every contact breaks down to S = 0.
    outer = 0.0 if math.isnan(unbroken.symmetry) else unbroken.symmetry
    return broke.symmetry - outer <= width


def run_searches(
    searches: Sequence[Search], run: Callable[[list[tuple[int, float]]], list[Trial]]
) -> list[Bracket]:
    """Advance many searches together until each is over; return what each found.

    All that the searches want at once goes to `run` as (position of the search, offset), which
    returns one `Trial` for each, in that order.
    """
    active = dict(enumerate(searches))
    while active:
        wanted = {k: search.wanted() for k, search in active.items()}
        active = {k: search for k, search in active.items() if wanted[k]}
        batch = [(k, offset) for k in active for offset in wanted[k]]
        if not batch:
            break
        trials = iter(run(batch))
        for k, search in active.items():
            search.take(list(itertools.islice(trials, len(wanted[k]))))
    return [search.bracket() for search in searches]
