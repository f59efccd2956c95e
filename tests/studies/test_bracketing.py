"""Brackets of the edge between breaking and not, against a brute-force oracle."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from pinchoff.studies.boundary.bracketing import (
    GLANCING,
    STATUSES,
    Interval,
    Search,
    Trial,
    run_searches,
)

WIDTH = 0.005
REACH = 0.25
TOUCHING = 0.31  # offset beyond which a synthetic droplet misses the obstacle


def symmetry_at(offset):
    """S of a synthetic collision: 1 head-on, falling smoothly to 0 at a grazing contact."""
    return (1 - offset / TOUCHING) ** 1.2 if offset < TOUCHING else math.nan


class Oracle:
    """A synthetic outcome function, which counts and records what it is asked."""

    def __init__(self, breaks, fails=lambda k, offset: False):
        self.breaks, self.fails = breaks, fails
        self.batches = []

    def __call__(self, batch):
        self.batches.append(batch)
        return [self.trial(k, offset) for k, offset in batch]

    def trial(self, k, offset):
        symmetry = symmetry_at(offset)
        if self.fails(k, offset):
            return Trial(offset, symmetry, None)
        touches = not math.isnan(symmetry)
        return Trial(offset, symmetry, touches and bool(self.breaks(k, symmetry)))


def searched(oracle, count=1, width=WIDTH, scan=24):
    searches = [Search(REACH, width, scan, limit=5.0) for _ in range(count)]
    return run_searches(searches, oracle)


def brute_force(breaks, k, step=1e-5):
    """Return the largest unbroken and the smallest broken S on a fine grid of offsets."""
    symmetry = np.array([symmetry_at(offset) for offset in np.arange(0, TOUCHING, step)])
    broke = np.array([breaks(k, s) for s in symmetry])
    return symmetry[~broke].max(), symmetry[broke].min()


# Brackets


def test_brackets_hold_the_line_of_a_brute_force_scan():
    critical = np.linspace(0.004, 0.998, 40)

    def breaks(k, symmetry):
        return symmetry > critical[k]

    oracle = Oracle(breaks)
    brackets = searched(oracle, len(critical))
    for k, bracket in enumerate(brackets):
        assert bracket.status == "found"
        assert 0 < bracket.width <= WIDTH
        unbroken, broke = brute_force(breaks, k)
        tolerance = 1e-4  # of the brute-force grid
        assert bracket.unbroken.symmetry <= unbroken + tolerance
        assert bracket.broke.symmetry >= broke - tolerance
        assert bracket.unbroken.symmetry <= critical[k] < bracket.broke.symmetry
        assert bracket.intervals == (
            Interval(1.0, bracket.broke.symmetry, True),
            Interval(bracket.unbroken.symmetry, bracket.intervals[-1].last_symmetry, False),
        )
        assert bracket.failures == 0
    assert sum(bracket.trials for bracket in brackets) == sum(map(len, oracle.batches))


def test_all_brackets_advance_together():
    oracle = Oracle(lambda k, symmetry: symmetry > 0.1 + 0.02 * k)
    searched(oracle, 40)
    assert len(oracle.batches) <= 5
    assert all(len({k for k, _ in batch}) == 40 for batch in oracle.batches[:1])


def test_a_row_does_not_depend_on_the_other_points():
    def breaks(k, symmetry):
        return symmetry > 0.3 + 0.1 * k

    together = searched(Oracle(breaks), 5)
    for k, bracket in enumerate(together):
        alone = Oracle(lambda _, symmetry, k=k: breaks(k, symmetry))
        assert searched(alone)[0] == bracket


@pytest.mark.parametrize("width", [0.05, 0.005, 1e-4, 1e-6])
def test_brackets_are_as_narrow_as_asked(width):
    (bracket,) = searched(Oracle(lambda k, symmetry: symmetry > 0.637), width=width)
    assert bracket.status == "found"
    assert 0 < bracket.width <= width
    assert bracket.unbroken.symmetry <= 0.637 < bracket.broke.symmetry


def test_no_break_even_head_on():
    oracle = Oracle(lambda k, symmetry: False)
    (bracket,) = searched(oracle)
    assert bracket.status == "no break even head-on"
    assert bracket.broke is None
    assert bracket.unbroken == Trial(0.0, 1.0, False)
    assert math.isnan(bracket.width)


def test_breaking_head_on_alone_is_bracketed():
    (bracket,) = searched(Oracle(lambda k, symmetry: symmetry == 1.0))
    assert bracket.status == "found"
    assert bracket.broke == Trial(0.0, 1.0, True)
    assert 1 - WIDTH <= bracket.unbroken.symmetry < 1


def test_breaks_at_every_contact():
    (bracket,) = searched(Oracle(lambda k, symmetry: True))
    assert bracket.status == "breaks at every contact"
    assert bracket.unbroken is None
    assert bracket.broke.symmetry <= WIDTH


def test_a_scan_goes_on_until_droplets_hardly_touch():
    oracle = Oracle(lambda k, symmetry: symmetry > 0.1)  # beyond the first reach
    (bracket,) = searched(oracle)
    assert symmetry_at(REACH) > GLANCING
    assert max(offset for _, offset in oracle.batches[0]) == pytest.approx(REACH)
    assert len(oracle.batches[1]) == 13
    furthest = [max(offset for _, offset in batch) for batch in oracle.batches]
    assert symmetry_at(furthest[1]) < GLANCING or math.isnan(symmetry_at(furthest[1]))
    assert max(furthest[2:]) < furthest[1]  # and no further than that
    assert bracket.status == "found"
    assert bracket.unbroken.symmetry <= 0.1 < bracket.broke.symmetry


@pytest.mark.parametrize(
    ("breaks", "outcomes"),
    [
        (lambda s: 0.5 < s < 0.9, [False, True, False]),
        (lambda s: s < 0.4, [False, True]),
        (lambda s: s > 0.8 or 0.3 < s < 0.5, [True, False, True, False]),
    ],
)
def test_non_monotonic_is_reported_and_not_bisected(breaks, outcomes):
    oracle = Oracle(lambda k, symmetry: breaks(symmetry))
    (bracket,) = searched(oracle)
    assert bracket.status == "non-monotonic"
    assert bracket.broke is None
    assert bracket.unbroken is None
    assert [interval.broke for interval in bracket.intervals] == outcomes
    for interval in bracket.intervals:
        assert interval.first_symmetry >= interval.last_symmetry
        assert breaks(interval.first_symmetry) == breaks(interval.last_symmetry) == interval.broke
    edges = [one.last_symmetry - two.first_symmetry for one, two in itertools.pairwise(bracket[3])]
    assert max(edges) < 2 / 24
    steps = np.diff(sorted(offset for batch in oracle.batches for _, offset in batch))
    assert np.allclose(steps, REACH / 24)  # the scan alone


def test_an_island_inside_a_bracket_is_seen_when_a_section_falls_on_it():
    """What the scan missed and the closing met is reported too."""
    edge = symmetry_at(10.5 * REACH / 24)
    island = symmetry_at(10.75 * REACH / 24)

    def breaks(k, symmetry):
        return symmetry > edge + 0.01 or abs(symmetry - island) < 1e-3

    (bracket,) = searched(Oracle(breaks))
    assert bracket.status == "non-monotonic"
    assert [interval.broke for interval in bracket.intervals] == [True, False, True, False]


# Failed runs


def test_failed_runs_are_never_an_outcome():
    """Failures everywhere but near the line change neither the bracket nor its status."""
    critical = 0.6

    def fails(k, offset):
        return abs(symmetry_at(offset) - critical) > 0.08 and 0.3 < symmetry_at(offset) < 0.95

    plain = Oracle(lambda k, symmetry: symmetry > critical)
    failing = Oracle(lambda k, symmetry: symmetry > critical, fails)
    (expected,), (bracket,) = searched(plain), searched(failing)
    assert (bracket.broke, bracket.unbroken) == (expected.broke, expected.unbroken)
    assert bracket.failures > 0 == expected.failures


def test_a_narrow_gap_of_failures_is_closed_in_on_from_both_sides():
    fails_near = 0.001
    oracle = Oracle(
        lambda k, symmetry: symmetry > 0.6,
        lambda k, offset: abs(symmetry_at(offset) - 0.6) < fails_near,
    )
    (bracket,) = searched(oracle)
    assert bracket.status == "found"
    assert bracket.unbroken.symmetry <= 0.6 - fails_near
    assert bracket.broke.symmetry >= 0.6 + fails_near
    assert bracket.width <= WIDTH


def test_a_wide_gap_of_failures_is_unresolved():
    oracle = Oracle(
        lambda k, symmetry: symmetry > 0.6, lambda k, offset: 0.5 < symmetry_at(offset) < 0.7
    )
    (bracket,) = searched(oracle)
    assert bracket.status == "unresolved"
    assert bracket.broke.symmetry == pytest.approx(0.7, abs=1e-3)
    assert bracket.unbroken.symmetry == pytest.approx(0.5, abs=1e-3)
    assert bracket.failures >= 4


@pytest.mark.parametrize("fails", [lambda k, offset: True, lambda k, offset: offset == 0])
def test_failing_head_on_leaves_open_whether_anything_breaks(fails):
    (bracket,) = searched(Oracle(lambda k, symmetry: False, fails))
    assert bracket.status == "unresolved"
    assert bracket.broke is None
    assert bracket.trials <= 25 + 13  # where nothing works no more is tried


def test_a_jump_of_the_symmetry_is_unresolved():
    def run(batch):
        return [Trial(y, 0.8 if y < 0.1 else 0.3 - y, y < 0.1) for _, y in batch]

    (bracket,) = run_searches([Search(0.3, WIDTH, 24, 5.0)], run)
    assert bracket.status == "unresolved"
    assert bracket.width == pytest.approx(0.6, abs=1e-3)


def test_every_status_is_explained():
    assert set(STATUSES) >= {"found", "non-monotonic", "unresolved"}
