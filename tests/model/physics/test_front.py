"""Front tracking: the outline that is line tension alone, against theory and brute force."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff import _core

FIELDS = _core.RESULT_FIELDS
NOWHERE = np.empty((0, 3))


def front_row(*, core=None, **changes):
    """One row for the core, with some of the core's own numbers replaced."""
    base = {"size_ratio": 5.66, "simulation_capillary_number": 25.0, "offset": 0.05}
    row = po.Parameters(model="front-tracking", **{**base, **changes}).model_row()
    for name, value in (core or {}).items():
        row[_core.MODEL_FIELDS.index(name)] = value
    return row


def regular(count, diameter=1.0, center=(0.0, 0.0)):
    """Return the regular polygon with the area of a circle."""
    area = math.pi / 4 * diameter**2
    radius = math.sqrt(2 * area / count / math.sin(2 * math.pi / count))
    angle = 2 * math.pi * (np.arange(count) + 0.5) / count
    return radius * np.column_stack((np.cos(angle), np.sin(angle))) + center


def even(outline):
    """Return vertices at even arcs along a finely sampled closed curve."""
    closed = np.vstack((outline, outline[:1]))
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))))

    def take(count):
        places = np.linspace(0, arc[-1], count, endpoint=False)
        return np.column_stack([np.interp(places, arc, column) for column in closed.T])

    return take


def wavy(count, amplitude, mode):
    """Return a circle of diameter 1 with a wave of that mode, even vertices, area π/4."""
    angle = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    radius = 0.5 * (1 + amplitude * np.cos(mode * angle))
    outline = even(radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle))))(count)
    return outline * math.sqrt(math.pi / 4 / _core.area(outline))


def wave(outline, mode):
    """Return the amplitude of a mode, from the polar form about the centre."""
    x, y = (outline - _core.centroid(outline)).T
    angle = np.unwrap(np.arctan2(y, x))
    radius = np.hypot(x, y)
    weight = np.roll(angle, -1) - np.roll(angle, 1)
    weight = np.mod(weight, 2 * np.pi) / 2
    return abs(np.sum(weight * radius * np.exp(-1j * mode * angle))) / math.pi / 0.5


def edges(outline):
    return np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)


def relaxation_rate(count, mode, capillary=25.0, step=2e-4, steps=500):
    start = wavy(count, 1e-4, mode)
    row = front_row(simulation_capillary_number=capillary, vertex_count=count)
    end, _ = _core.advance_front(row, _core.UniformFlow(0, 0), start, NOWHERE, step, steps)
    return math.log(wave(start, mode) / wave(end, mode)) / (steps * step)


@pytest.mark.parametrize("capillary", [12.0, 25.0, 80.0])
def test_a_wave_relaxes_at_the_rate_of_line_tension(capillary):
    """4π(m² - 1)/Ca_sim for the circle of diameter 1: 12π/Ca_sim for m = 2, to 0.5 % at N = 64."""
    expected = 12 * math.pi / capillary
    assert relaxation_rate(64, 2, capillary) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("mode", [2, 3, 4])
def test_rates_converge_with_the_square_of_the_vertex_count(mode):
    exact = 4 * math.pi * (mode**2 - 1) / 25.0
    errors = [relaxation_rate(n, mode) / exact - 1 for n in (64, 128, 256)]
    orders = [math.log2(abs(a / b)) for a, b in itertools.pairwise(errors)]
    assert min(orders) > 1.9


def test_steps_are_of_second_order():
    """Differences between halved steps fall by four, until the droplet touches."""
    row = front_row(vertex_count=64, simulation_capillary_number=40.0)
    flow = _core.StokesFlow(1 / 5.66)
    start = regular(64, center=(-2.0, 0.2))
    ends = [
        _core.advance_front(row, flow, start, NOWHERE, 0.32 / steps, steps)[0]
        for steps in (80, 160, 320, 640)
    ]
    changes = [np.abs(b - a).max() for a, b in itertools.pairwise(ends)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(changes)]
    assert min(orders) > 1.9


def test_steps_are_of_first_order_through_contact():
    """Which step catches a vertex at the wall is known to one step: differences fall by two."""
    constants = {"vertex_count": 64, "offset": 0.15, "neck_thickness": 0, "time_limit": 3.11}
    before, after = [], []
    for steps in (20, 40, 80, 160):  # in the time between two samples
        p = po.Parameters(model="front-tracking", time_step=0.01 / steps, **constants)
        outlines = po.simulate(p, outlines=0.1).outlines
        for moment, kept in ((2.0, before), (3.1, after)):
            frame = int(np.argmin(np.abs(outlines.times - moment)))
            kept.append(outlines.outline(frame).vertices)
    for kept, order in ((before, 2.0), (after, 1.0)):
        changes = [np.abs(b - a).max() for a, b in itertools.pairwise(kept)]
        orders = [math.log2(a / b) for a, b in itertools.pairwise(changes)]
        assert orders == pytest.approx([order] * len(orders), abs=0.25)


def test_a_circle_is_carried_by_a_uniform_flow_unchanged():
    start = regular(50)
    row = front_row(vertex_count=50)
    end, velocity = _core.advance_front(
        row, _core.UniformFlow(0.7, -0.3), start, NOWHERE, 1e-3, 2000
    )
    np.testing.assert_allclose(end, start + 2.0 * np.array([0.7, -0.3]), atol=1e-11)
    np.testing.assert_allclose(velocity, np.tile([0.7, -0.3], (50, 1)), atol=1e-11)


def test_velocity_is_the_flow_and_the_gradient_of_line_tension_at_fixed_area():
    """The motion beside the flow is along -∇P + p∇A, mobility N_v/μD0, but for a slide."""
    rng = np.random.default_rng(3)
    row = front_row(vertex_count=64)
    angle = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    radius = np.exp(sum(rng.normal(0, 0.15) * np.cos(m * angle + m) for m in range(2, 5))) / 2
    outline = even(radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle))))(64)
    outline *= math.sqrt(math.pi / 4 / _core.area(outline))
    flow = _core.StokesFlow(0.2, -1.5, 0.3)
    _, velocity = _core.advance_front(row, flow, outline, NOWHERE, 1e-4, 0)

    def gradient(function):
        step, out = 1e-6, np.empty_like(outline)
        for i, k in np.ndindex(outline.shape):
            moved = [outline.copy(), outline.copy()]
            moved[0][i, k] -= step
            moved[1][i, k] += step
            out[i, k] = (function(moved[1]) - function(moved[0])) / (2 * step)
        return out

    area, length = gradient(_core.area), gradient(_core.perimeter)
    own = velocity - flow.velocity(outline) + 64 / 25.0 * length
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    tangent = before / edges(np.roll(outline, 1, axis=0))[:, None] + after / edges(outline)[:, None]
    tangent /= np.hypot(*tangent.T)[:, None]
    normal = np.column_stack((tangent[:, 1], -tangent[:, 0]))
    pressure = np.sum(own * normal, axis=1) / np.sum(area * normal, axis=1)
    np.testing.assert_allclose(pressure, pressure[0], rtol=1e-5)
    # But for the slide, which is along the tangent only where edges are equal.
    assert np.sum(velocity * area) == pytest.approx(0, abs=1e-3)
    # All edges lengthen alike.
    rate = np.sum((np.roll(velocity, -1, axis=0) - velocity) * after, axis=1) / edges(outline)
    lack = 50.0 * (edges(outline).mean() - edges(outline))
    np.testing.assert_allclose(rate - lack, np.mean(rate - lack), atol=1e-6)


def history(row, obstacles=None):
    """Every outline of a collision, sample by sample."""
    values = dict(zip(_core.MODEL_FIELDS, row, strict=True))
    radius = values["obstacle_radius"]
    system = _core.System(
        row,
        _core.StokesFlow(radius),
        np.array([[0.0, 0.0, radius]]),
        np.array([[-values["start_distance"], values["offset"], 1.0]]),
    )
    while not system.finished:
        system.advance(system.time + 0.005)
        yield system


@pytest.mark.parametrize(("capillary", "offset"), [(12.0, 0.0), (25.0, 0.05), (80.0, 0.3)])
def test_area_walls_and_spacing_over_a_collision(capillary, offset):
    """Areas to 1e-10 of all droplets together, no vertex inside, edges even before the cut."""
    row = front_row(simulation_capillary_number=capillary, offset=offset, vertex_count=64)
    uneven = 0.0
    for system in history(row):
        outlines = [positions for _, _, positions, _ in system.outlines()]
        total = sum(_core.area(r) for r in outlines)
        assert total == pytest.approx(math.pi / 4, rel=1e-10)
        for r in outlines:
            assert np.hypot(*r.T).min() >= 1 / 5.66 * (1 - 1e-15)
            assert not _core.self_intersects(r)
        if len(outlines) == 1:
            length = edges(outlines[0])
            uneven = max(uneven, length.max() / length.min() - 1)
    assert uneven < 0.15


@pytest.mark.parametrize("spacings", [1.0, 1.5, 3.0])
def test_no_vertex_enters_an_obstacle_down_to_one_spacing(spacings):
    """Head-on and aside, with obstacles of one vertex spacing and more."""
    count = 48
    ratio = count / math.pi / spacings
    for offset in (0.0, 0.08, 0.3):
        row = front_row(size_ratio=ratio, offset=offset, vertex_count=count, time_limit=6.0)
        nearest = math.inf
        for system in history(row):
            for _, _, r, _ in system.outlines():
                nearest = min(nearest, np.hypot(*r.T).min())
        assert nearest >= 1 / ratio * (1 - 1e-15)


def results(rows):
    table = _core.run_many(np.atleast_2d(rows), None, 1, None)
    return [dict(zip(FIELDS, r.tolist(), strict=True)) for r in table]


def critical_symmetry(capillary=32.0, width=2e-4, **changes):
    """S between broken and unbroken, by bisection over the offset."""
    low, high = 0.0, 0.45
    symmetry = {}
    while len(symmetry) < 2 or symmetry["broke"] - symmetry["not"] > width:
        offset = (low + high) / 2
        (end,) = results(
            front_row(
                offset=offset,
                simulation_capillary_number=capillary,
                follow_daughters=False,
                **changes,
            )
        )
        symmetry["broke" if end["outcome"] == 1 else "not"] = end["symmetry"]
        low, high = (offset, high) if end["outcome"] == 1 else (low, offset)
    return (symmetry["broke"] + symmetry["not"]) / 2


def test_the_rate_of_redistribution_does_not_show():
    """S_c within 0.2 % over a factor of a hundred in the rate at which edges even out."""
    found = [
        critical_symmetry(core={"evening_rate": rate}, vertex_count=96)
        for rate in (5.0, 50.0, 500.0)
    ]
    assert max(found) / min(found) - 1 < 2e-3


def test_the_time_step_does_not_show():
    """S_c within 0.2 % of that at a tenth of the automatic step."""
    coarse, fine = (critical_symmetry(vertex_count=64, time_step=h) for h in ("auto", 2e-4))
    assert coarse == pytest.approx(fine, rel=2e-3)


def test_mirror_and_translation():
    """The mirrored collision is the mirror image; one that happens elsewhere is the same."""
    one, two = results([front_row(offset=0.1), front_row(offset=-0.1)])
    for name in FIELDS:
        assert one[name] == pytest.approx(two[name], rel=1e-6, nan_ok=True), name
    row = front_row(offset=0.1)
    away = np.array([3.0, -7.0])
    radius = 1 / 5.66
    system = _core.System(
        row,
        _core.StokesFlow(radius, *away),
        np.array([[*away, radius]]),
        np.array([[away[0] - 5.0, away[1] + 0.1, 1.0]]),
    )
    system.advance(100.0)
    shifted = dict(zip(FIELDS, system.result().tolist(), strict=True))
    for name in FIELDS:
        assert one[name] == pytest.approx(shifted[name], rel=1e-6, nan_ok=True), name


def test_numbering_does_not_show():
    """An outline numbered from another vertex moves the same."""
    start = wavy(60, 0.2, 3) + np.array([-1.2, 0.1])
    row = front_row(vertex_count=60)
    flow, walls = _core.StokesFlow(1 / 5.66), np.array([[0, 0, 1 / 5.66]])
    end, _ = _core.advance_front(row, flow, start, walls, 1e-3, 600)
    rolled, _ = _core.advance_front(row, flow, np.roll(start, 17, axis=0), walls, 1e-3, 600)
    np.testing.assert_allclose(np.roll(rolled, -17, axis=0), end, atol=1e-9)


def test_a_small_droplet_does_not_shorten_the_step_of_others():
    """Beside a droplet a tenth as large the large one moves as it does alone."""
    row = front_row(time_limit=1.0, vertex_count=64)
    flow = _core.UniformFlow(1.0, 0.0)
    ends = []
    for droplets in ([[0, 0, 1.0]], [[0, 0, 1.0], [0, 3, 0.1]]):
        system = _core.System(row, flow, NOWHERE, np.array(droplets))
        system.advance(100.0)
        ends.append(system)
    steps = [dict(zip(FIELDS, s.result().tolist(), strict=True))["steps"] for s in ends]
    assert steps[0] == steps[1]
    np.testing.assert_array_equal(ends[0].outlines()[0][2], ends[1].outlines()[0][2])


def test_vertex_counts_follow_the_size_after_a_cut():
    row = front_row(vertex_count=96, follow_daughters=False)
    *_, last = history(row)
    assert len(last.outlines()) == 2
    for _, _, r, _ in last.outlines():
        diameter = math.sqrt(_core.area(r) / (math.pi / 4))
        assert len(r) == max(16, round(96 * diameter))


def test_necks_lie_inside_the_droplet():
    """A chord across the dent is no neck: daughters have positive areas, in both models."""
    common = {
        "size_ratio": 13.79,
        "simulation_capillary_number": 456.5,
        "offset": 1.9e-5,
        "vertex_count": 96,
        "start_distance": 1.2,
        "neck_separation_unit": "diameter",
        "follow_daughters": False,
        "time_limit": 2,
    }
    rows = [
        po.Parameters(**common, line_tension=7.08).model_row(),
        po.Parameters(**common, model="front-tracking").model_row(),
    ]
    for end in results(rows):
        if end["outcome"] == 1:
            assert end["small_daughter_area"] > 0.01
            total = end["small_daughter_area"] + end["large_daughter_area"]
            assert total == pytest.approx(math.pi / 4, rel=0.01)


@pytest.mark.parametrize(
    ("capillary", "offset", "size_ratio"),
    [(20.0, 0.05, 5.66), (40.0, 0.02, 5.66), (60.0, 0.1, 4.0), (30.0, 0.03, 7.5)],
)
def test_collision_equals_that_of_an_independent_program(reference, capillary, offset, size_ratio):
    """Explicit normal motion, other curvature, other spacing: the same to its accuracy."""
    arguments = (128, 0, capillary, offset, size_ratio, 1e-4)
    expected = reference("front", *arguments)
    (got,) = results(
        front_row(
            simulation_capillary_number=capillary,
            offset=offset,
            size_ratio=size_ratio,
            vertex_count=128,
            follow_daughters=False,
        )
    )
    assert ("slipped", "broke")[int(got["outcome"])] == expected["outcome"]
    assert got["symmetry"] == pytest.approx(expected["symmetry"], abs=5e-3)
    assert got["impact_parameter"] == pytest.approx(expected["impact_parameter"], abs=2e-3)
    assert got["contact_time"] == pytest.approx(expected["contact_time"], abs=3e-3)
    assert got["contact_speed"] == pytest.approx(expected["contact_speed"], rel=0.01)
    assert got["end_time"] == pytest.approx(expected["end_time"], abs=0.02)
    if expected["outcome"] == "broke":
        small = expected["small_daughter_area"]
        assert got["small_daughter_area"] == pytest.approx(small, abs=0.006)
    else:
        assert got["minimum_neck"] == pytest.approx(expected["minimum_neck"], abs=2e-3)


@pytest.mark.slow
def test_random_search_finds_no_impossible_collision():
    """20,000 collisions: areas positive and whole, S in [0, 1], few stopped by guards."""
    rng = np.random.default_rng(20_000)
    rows = [
        front_row(
            vertex_count=int(rng.choice([48, 64, 96])),
            size_ratio=float(np.exp(rng.uniform(math.log(1.5), math.log(10)))),
            simulation_capillary_number=float(np.exp(rng.uniform(math.log(6), math.log(150)))),
            offset=float(rng.uniform(-0.6, 0.6)) * (k % 10 > 0),
            follow_daughters=bool(k % 3),
            neck_separation_unit="diameter" if k % 4 == 0 else "perimeter",
        )
        for k in range(20_000)
    ]
    table = _core.run_many(np.array(rows), None, 2, None)
    column = {name: table[:, k] for k, name in enumerate(FIELDS)}
    failed = column["outcome"] == 3
    assert failed.mean() < 0.01
    broke = column["outcome"] == 1
    small, large = column["small_daughter_area"][broke], column["large_daughter_area"][broke]
    assert (small > 0).all()
    np.testing.assert_allclose(small + large, math.pi / 4, rtol=1e-9)
    touched = ~np.isnan(column["symmetry"])
    assert touched.sum() > 5000
    assert ((column["symmetry"][touched] >= 0) & (column["symmetry"][touched] <= 1)).all()
