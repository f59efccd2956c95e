"""Links are the cheapest there are, and events explain what is left over."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from pinchoff.video.droplets import Droplet
from pinchoff.video.settings import VideoSettings
from pinchoff.video.tracking import Tracker


def droplet(x, y, area=800.0, *, cut=False, group=-1, whole=None):
    radius = math.sqrt(area / math.pi)
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    outline = np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])
    return Droplet(outline, area, x, y, cut, group, whole)


@pytest.fixture
def tracker():
    return Tracker(VideoSettings(pixel_size_um=5.0))


def kinds(events):
    return [event.kind for event in events]


def test_a_droplet_keeps_its_number(tracker):
    for frame in range(10):
        (number,), events = tracker.step(frame, [droplet(50 + 6 * frame, 40)])
        assert number == 0
        assert kinds(events) == ([] if frame else ["entry"])


def test_fast_droplets_in_a_row_are_not_exchanged(tracker):
    """Droplets that move farther than they stand apart are told by their motion."""
    for frame in range(12):
        # The first frames are slow, so that the motion is known; then a step exceeds the gap.
        shift = (
            2 * frame if frame < 4 else 8 + sum(min(4 * (k - 3), 28) for k in range(4, frame + 1))
        )
        numbers, _ = tracker.step(frame, [droplet(40 * k + shift, 50) for k in range(4)])
        assert numbers == [0, 1, 2, 3]


def test_slow_droplets_that_enter_among_fast_ones(tracker):
    """What has just come into view is expected at the others' speed, or at rest."""
    for frame in range(10):
        fast = [droplet(20 + 60 * k + 14 * frame, 50) for k in range(3)]
        slow = []
        if frame >= 4:
            slow = [droplet(2.0 + 1.5 * (frame - 4), 100, 60.0 + 40.0 * (frame - 4), cut=True)]
        numbers, events = tracker.step(frame, [*fast, *slow])
        assert numbers == [0, 1, 2, 3][: len(numbers)]
        assert kinds(events) == (["entry"] * 3 if not frame else ["entry"] if frame == 4 else [])


def test_links_have_the_least_cost(tracker):
    """Against brute force over all permutations: the same total of squared distances."""
    random = np.random.default_rng(5)
    for _ in range(50):
        tracker = Tracker(VideoSettings(pixel_size_um=5.0, maximum_step_px=1e3))
        before = random.uniform(0, 100, (5, 2))
        after = before + random.normal(0, 15, (5, 2))
        tracker.step(0, [droplet(x, y) for x, y in before])
        numbers, events = tracker.step(1, [droplet(x, y) for x, y in after])
        assert not events
        ours = sum(((before[n] - after[k]) ** 2).sum() for k, n in enumerate(numbers))
        best = min(
            sum(((before[n] - after[k]) ** 2).sum() for k, n in enumerate(order))
            for order in itertools.permutations(range(5))
        )
        assert ours == pytest.approx(best)


def test_order_of_droplets_does_not_matter():
    random = np.random.default_rng(2)
    places = random.uniform(0, 300, (8, 2))
    chains = []
    for seed in (0, 1):
        tracker = Tracker(VideoSettings(pixel_size_um=5.0))
        shuffled = np.random.default_rng(seed)
        ways = {}
        for frame in range(6):
            order = shuffled.permutation(8)
            moved = [droplet(*(places[k] + np.array([3 * frame, frame]))) for k in order]
            numbers, _ = tracker.step(frame, moved)
            for number, k in zip(numbers, order, strict=True):
                ways.setdefault(number, set()).add(int(k))
        chains.append(sorted(map(tuple, ways.values())))
    assert chains[0] == chains[1] == [(k,) for k in range(8)]


def test_lost_droplet_is_waited_for(tracker):
    for frame in range(5):
        tracker.step(frame, [droplet(20 + 5 * frame, 40)])
    assert tracker.step(5, []) == ([], [])
    assert tracker.step(6, []) == ([], [])
    (number,), events = tracker.step(7, [droplet(20 + 5 * 7, 40)])
    assert number == 0
    assert not events


def test_droplet_lost_for_too_long_ends(tracker):
    tracker.step(0, [droplet(20, 40)])
    ends = [kinds(tracker.step(frame, [])[1]) for frame in range(1, 6)]
    assert list(itertools.chain(*ends)) == ["lost"]
    assert ends[3] == ["lost"]  # after a memory of three frames


def test_entry_and_exit(tracker):
    assert kinds(tracker.step(0, [droplet(50, 50)])[1]) == ["entry"]
    numbers, events = tracker.step(1, [droplet(52, 50), droplet(2, 90, cut=True)])
    assert kinds(events) == ["entry"]
    tracker.step(2, [droplet(54, 50, cut=True), droplet(6, 90)])
    _, events = tracker.step(3, [droplet(10, 90)])
    assert [(event.kind, event.parents) for event in events] == [("exit", (numbers[0],))]


@pytest.mark.parametrize("share", [0.5, 0.3, 0.12, 0.05])
def test_break_up(tracker, share):
    """One droplet becomes two with its area, around its centre of mass: also very unequal ones."""
    for frame in range(4):
        tracker.step(frame, [droplet(50 + 4 * frame, 50, 1000.0), droplet(50, 200, 900.0)])
    away = 30.0
    parts = [
        droplet(66, 50 - away * share, 1000 * (1 - share)),
        droplet(66, 50 + away * (1 - share), 1000 * share),
        droplet(50, 200, 900.0),
    ]
    numbers, events = tracker.step(4, parts)
    (event,) = events
    assert event.kind == "break-up"
    assert event.frame == 4
    assert event.parents == (0,)
    assert set(event.children) == set(numbers[:2])
    assert not {0, 1} & set(numbers[:2])
    assert numbers[2] == 1


def test_break_up_into_three(tracker):
    for frame in range(3):
        tracker.step(frame, [droplet(50 + 4 * frame, 50, 1200.0)])
    _, events = tracker.step(3, [droplet(62, y, 400.0) for y in (25, 50, 75)])
    assert kinds(events) == ["break-up"]
    assert len(events[0].children) == 3


@pytest.mark.parametrize("areas", [(600.0, 500.0), (900.0, 120.0)])
def test_coalescence(tracker, areas):
    for frame in range(4):
        tracker.step(frame, [droplet(50, 40, areas[0]), droplet(50, 68, areas[1])])
    total = sum(areas)
    y = (40 * areas[0] + 68 * areas[1]) / total
    (number,), events = tracker.step(4, [droplet(50, y, total)])
    (event,) = events
    assert event.kind == "coalescence"
    assert set(event.parents) == {0, 1}
    assert event.children == (number,)


def test_break_up_that_is_seen_late(tracker):
    """A daughter too small to be seen at once still makes a break-up, at its own frame."""
    for frame in range(6):
        tracker.step(frame, [droplet(50 + 4 * frame, 50, 1000.0)])
    large = [droplet(50 + 4 * frame, 47, 900.0) for frame in (6, 7, 8)]
    for frame in (6, 7):
        numbers, events = tracker.step(frame, [large[frame - 6]])
        assert numbers == [0]
        assert not events
    numbers, (event,) = tracker.step(8, [large[2], droplet(84, 75, 100.0)])
    assert event == ("break-up", 6, (0,), tuple(numbers))


def test_a_newcomer_is_no_break_up(tracker):
    """A small droplet that appears beside a large one which keeps its area came from elsewhere."""
    for frame in range(3):
        tracker.step(frame, [droplet(50, 50, 1000.0)])
    numbers, events = tracker.step(3, [droplet(50, 50, 1000.0), droplet(80, 50, 120.0)])
    assert numbers[0] == 0
    assert kinds(events) == ["found"]


def test_a_droplet_that_passes_a_lost_one_is_no_coalescence(tracker):
    for frame in range(3):
        tracker.step(frame, [droplet(50, 40, 600.0), droplet(50, 75, 500.0)])
    numbers, events = tracker.step(3, [droplet(50, 40, 600.0)])
    assert numbers == [0]
    assert not events


def test_parts_are_one_droplet_while_one_is_expected(tracker):
    """A neck without an inside parts nothing that was whole, but keeps apart what was apart."""
    whole = droplet(60, 50, 1000.0)
    parts = [
        droplet(60, 35, 500.0, group=0, whole=whole),
        droplet(60, 65, 500.0, group=0, whole=whole),
    ]
    for frame in range(4):
        tracker.step(frame, [droplet(48 + 3 * frame, 50, 1000.0)])
    assert tracker.resolved(4, parts) == [whole]
    two = Tracker(VideoSettings(pixel_size_um=5.0))
    for frame in range(4):
        two.step(frame, [droplet(48 + 3 * frame, y, 500.0) for y in (35, 65)])
    assert two.resolved(4, parts) == parts


def test_agrees_with_trackpy():
    """The same links as trackpy's, for discs that wander in a flow, enter and leave."""
    trackpy = pytest.importorskip("trackpy")
    trackpy.quiet()
    random = np.random.default_rng(8)
    places = random.uniform(0, 400, (20, 2))
    flow = np.array([5.0, 0.0])
    resting, ours = [], []
    tracker = Tracker(VideoSettings(pixel_size_um=5.0, maximum_step_px=14.0, memory=0))
    for frame in range(30):
        places = places + flow + random.normal(0, 1.0, places.shape)
        seen = [place for place in places if 0 < place[0] < 400]
        numbers, _ = tracker.step(frame, [droplet(x, y, 100.0) for x, y in seen])
        resting.append(np.array(seen) - frame * flow)  # trackpy is told of the flow
        ours.append(numbers)
    theirs = [numbers for _, numbers in trackpy.link_iter(resting, search_range=9.0)]
    flat = [list(itertools.chain(*each)) for each in (ours, theirs)]
    assert len(set(zip(*flat, strict=True))) == len(set(flat[0])) == len(set(flat[1]))
