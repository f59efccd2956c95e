"""Contact lists stay complete as long as no vertex has moved further than their budget."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core


def nearest_points(points, outline):
    """Distance (n,) and nearest point (n, 2) and edge (n,) of an outline for each point (n, 2)."""
    a, e = outline, np.roll(outline, -1, axis=0) - outline
    along = ((points[:, None] - a) * e).sum(axis=2) / (e * e).sum(axis=1)
    foot = a + np.clip(along, 0, 1)[..., None] * e
    distance = np.hypot(*np.moveaxis(points[:, None] - foot, 2, 0))
    edge = distance.argmin(axis=1)
    rows = np.arange(len(points))
    return distance[rows, edge], foot[rows, edge], edge


def range_of(outline, other):
    """Distance at which two droplets of diameter 1 begin to push each other: half an edge."""
    return 0.25 * sum(
        math.sqrt(math.pi * math.tan(math.pi / n) / n) for n in map(len, (outline, other))
    )


def pressed_together(one, other, budget):
    """Move every vertex of both by the budget, straight towards the other outline."""
    _, feet, _ = nearest_points(one, other)
    way = feet - one
    one_moved = one + budget * way / np.hypot(*way.T)[:, None]
    _, feet, _ = nearest_points(other, one)
    way = feet - other
    return one_moved, other + budget * way / np.hypot(*way.T)[:, None]


@pytest.mark.parametrize("seed", range(60))
def test_no_contact_is_missed_within_the_budget(model, droplet, seed):
    """An adversary moves all vertices towards the other droplet: whatever feels it is listed.

    With the edge that it then is nearest to. A list that promised twice what it holds would fail.
    """
    rng = np.random.default_rng(seed)
    row = model()
    one = droplet(rng, int(rng.choice([32, 64])))
    other = droplet(rng, int(rng.choice([40, 64])))
    turn = rng.uniform(0, 2 * math.pi)
    other = other + 3.0 * np.array([math.cos(turn), math.sin(turn)])
    reach = range_of(one, other)
    gap = rng.choice([rng.uniform(0.2, 3.0), rng.uniform(3.0, 40.0)]) * reach
    for _ in range(60):  # along the line between them until they are that far apart
        distance, feet, _ = nearest_points(one, other)
        near = distance.argmin()
        other = other + (gap - distance[near]) * (feet[near] - one[near]) / distance[near]
    budget, depth, listed = _core.touches(row, one, other)
    assert depth == 0
    assert budget > 0
    moved, other_moved = pressed_together(one, other, 0.999 * budget)
    distance, _, edge = nearest_points(moved, other_moved)
    runs = {vertex: (first, count) for vertex, first, count in listed}
    for vertex in np.flatnonzero(distance < reach):
        assert vertex in runs, f"vertex {vertex} at {distance[vertex]:.4g} is not listed"
        first, count = runs[vertex]
        assert (edge[vertex] - first) % len(other) < count


def test_budget_is_spent_before_two_discs_can_meet(model):
    """Two round droplets apart by a gap along x: half of it each, and the range of the force."""
    row = model()
    angle = (np.arange(64) + 0.5) * 2 * math.pi / 64
    disc = 0.5 * np.column_stack((np.cos(angle), np.sin(angle)))
    reach = range_of(disc, disc)
    for gap in (0.1, 0.3, 0.8):
        width = 2 * disc[:, 0].max()
        budget, _, listed = _core.touches(row, disc, disc + np.array([width + gap, 0.0]))
        assert listed == []
        assert budget == pytest.approx((gap - reach) / 2, rel=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_no_vertex_reaches_an_obstacle_unlisted(model, droplet, seed):
    """All vertices move by the budget straight at the obstacle: those in its range are listed."""
    rng = np.random.default_rng(seed)
    row = model()
    outline, radius = droplet(rng), rng.uniform(0.05, 0.3)
    reach = radius + 2 * range_of(outline, outline) / 2
    turn = rng.uniform(0, 2 * math.pi)
    centre = 3.0 * np.array([math.cos(turn), math.sin(turn)])
    gap = rng.choice([rng.uniform(-0.3, 1.0) * 0.03, rng.uniform(0.03, 0.5)])
    distance = np.hypot(*(outline - centre).T)
    for _ in range(60):
        near = distance.argmin()
        pull = (outline[near] - centre) / distance[near]
        centre = centre + (distance[near] - reach - gap) * pull
        distance = np.hypot(*(outline - centre).T)
    budget, runs = _core.wall_vertices(row, outline, *centre, radius)
    moved = distance - 0.999 * budget
    listed = {i for first, last in runs for i in range(first, last)}
    assert set(np.flatnonzero(moved < reach)) <= listed


@pytest.mark.parametrize(("depth", "stopped"), [(0.97, False), (1.03, True)])
def test_droplets_may_overlap_by_one_vertex_spacing(model, system, depth, stopped):
    """The guard sits at one mean spacing: just below it the run goes on, just above it stops."""
    row = model(core={"neck_thickness": 0.0})
    length = math.sqrt(math.pi * math.tan(math.pi / 64) / 64)
    apothem = 0.5 * length / math.tan(math.pi / 64)
    vertex = 0.5 * length / math.sin(math.pi / 64)  # the vertex at the right looks at an edge
    turned = math.pi / 64
    middle = (apothem + vertex - depth * length) * np.array([math.cos(turned), math.sin(turned)])
    two = system(row, _core.UniformFlow(0.0, 0.0), np.zeros((0, 3)), [[0, 0, 1], [*middle, 1]])
    inside = two.outlines()[0][2]
    distance, _, _ = nearest_points(inside, two.outlines()[1][2])
    assert distance.max() > 0
    two.advance(1e-4)
    guard = _core.GUARDS[int(two.result()[_core.RESULT_FIELDS.index("guard")])]
    assert guard == ("overlap" if stopped else "")


@pytest.mark.parametrize("seed", range(6))
def test_looking_at_every_step_gives_the_same_bits_in_a_crowd(model, system, seed):
    """Six droplets among three obstacles: where blocks end shows in no bit of any outline."""
    rng = np.random.default_rng(seed)
    row = model(
        simulation_capillary_number=rng.uniform(10, 60),
        vertex_count=int(rng.choice([32, 48])),
        time_limit=3,
    )
    obstacles = [[0, 0, 0.18], [1.2, 0.3, 0.2], [1.3, -0.6, 0.15]]
    droplets = []
    while len(droplets) < 6:
        x, y, d = rng.uniform(-3.5, -0.9), rng.uniform(-1.3, 1.3), rng.uniform(0.4, 1)
        if all(math.hypot(x - a, y - b) > (d + c) / 2 + 0.1 for a, b, c in droplets):
            droplets.append([x, y, d])
    every = row.copy()
    every[_core.MODEL_FIELDS.index("sample_interval")] = row[_core.MODEL_FIELDS.index("time_step")]
    ends = []
    for one in (row, every):
        crowd = system(one, _core.StokesFlow(0.18), obstacles, droplets)
        crowd.advance(1.2)
        assert crowd.result()[_core.RESULT_FIELDS.index("guard")] == 0
        ends.append([outline for _, _, outline, _ in crowd.outlines()])
    for usual, looked in zip(*ends, strict=True):
        np.testing.assert_array_equal(usual, looked)


def crowd(droplet, rng, count, width):
    """Rough droplets of several sizes, many of them across each other."""
    sizes = rng.uniform(0.3, 1.0, count)
    places = rng.uniform(-width, width, (count, 2))
    return [
        s * droplet(rng, int(rng.choice([16, 24, 40]))) + place
        for s, place in zip(sizes, places, strict=True)
    ]


@pytest.mark.parametrize("periodic", [(0.0, 0.0), (0.0, 5.0), (6.0, 5.0)])
@pytest.mark.parametrize("seed", range(7))
def test_neighbours_give_the_contacts_of_brute_force(model, droplet, seed, periodic):
    """Boxes and grids leave out nobody: the lists are those of comparing everybody, in order.

    A hundred random crowded scenes for each seed and kind of space, with 3 to 40 droplets.
    """
    rng = np.random.default_rng((seed, int(sum(periodic))))
    row, seen = model(), 0
    for _ in range(100):
        outlines = crowd(droplet, rng, int(rng.choice([3, 14, 40])), rng.uniform(2.0, 4.0))
        obstacles = np.column_stack((rng.uniform(-4, 4, (30, 2)), rng.choice([0.02, 0.1, 0.4], 30)))
        some, everybody = (
            _core.contact_lists(row, outlines, obstacles, *periodic, exhaustive=brute)
            for brute in (False, True)
        )
        assert some == everybody
        seen += len(some[1])
    assert seen > 10_000


@pytest.mark.parametrize("seed", range(4))
def test_lists_hold_what_an_independent_search_finds(model, droplet, seed):
    """NumPy over all vertices, edges and images of a periodic scene: the same vertices, nearest
    edges in the listed stretch, and all obstacles within the margin.
    """
    rng = np.random.default_rng(seed)
    outlines, period = crowd(droplet, rng, 5, 2.0), np.array([5.0, 4.5])
    obstacles = np.column_stack((rng.uniform(-3, 3, (6, 2)), rng.uniform(0.05, 0.3, 6)))
    walls, touches = _core.contact_lists(model(), outlines, obstacles, *period)
    listed = {
        (a, i, b, round(x / 5.0), round(y / 4.5)): (first, n)
        for a, i, b, first, n, x, y in touches
        if a != b
    }
    expected = set()
    images = [(i, j) for i in range(-3, 4) for j in range(-3, 4)]
    lengths = [rest_length(o) for o in outlines]
    for a, one in enumerate(outlines):
        for b, other in enumerate(outlines):
            for image in images if a != b else ():
                distance, _, edge = nearest_points(one - period * image, other)
                within = 0.75 * (lengths[a] + lengths[b])
                for i in np.flatnonzero(distance <= within):
                    key = (a, int(i), b, *image)
                    expected.add(key)
                    first, n = listed[key]
                    assert (edge[i] - first) % len(other) < n
    assert set(listed) == expected
    near = set()
    for a, one in enumerate(outlines):
        for x, y, radius in obstacles:
            for image in images:
                centre = np.array([x, y]) + period * image
                reach = radius + 0.5 * lengths[a] + min(0.03, 0.25 * radius)
                for i in np.flatnonzero(np.hypot(*(one - centre).T) < reach):
                    near.add((a, int(i), *centre.round(9)))
    held = {
        (a, i, *np.round((x, y), 9))
        for a, first, last, x, y in walls
        for i in range(first, min(last, len(outlines[a])))
    }
    assert near <= held


def rest_length(outline):
    """l_eq of a droplet with the area and the number of vertices of an outline."""
    n = len(outline)
    return math.sqrt(4 * _core.area(outline) * math.tan(math.pi / n) / n)
