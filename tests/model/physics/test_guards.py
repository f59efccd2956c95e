"""A run whose result cannot be trusted ends with a guard, never with an outcome."""

from __future__ import annotations

import signal
import threading

import numpy as np
import pytest

from pinchoff import _core

FAILED = 3.0


def guard_of(got):
    """Name of the guard that stopped a run; the run must say so in every field."""
    assert got["outcome"] == FAILED
    assert got["guard_time"] == pytest.approx(got["end_time"])
    return _core.GUARDS[int(got["guard"])]


def test_weak_springs_let_the_obstacle_through_and_are_caught(model, run):
    """With k̃_l ≪ 1 vertices gather, the front edge stretches, and the obstacle enters it.

    The exact polygon knows: without the guard the obstacle would end up inside the droplet. The
    run must stop, whichever guard is the first to see it.
    """
    rows = [
        model(
            edge_stiffness=stiffness,
            offset=offset,
            simulation_capillary_number=capillary,
            vertex_count=32,
        )
        for stiffness in (1e-3, 1e-2)
        for offset in (0.0, 0.05)
        for capillary in (60.0, 200.0)
    ]
    got = run(rows)
    guards = [guard_of(g) for g in got if g["outcome"] == FAILED]
    assert "penetration" in guards


@pytest.mark.parametrize("seed", range(3))
def test_no_outcome_when_the_obstacle_went_through_an_edge(model, system, result, seed):
    """Seen from outside, sample by sample: an edge 40 % of R inside the obstacle, no outcome.

    The guard's limit is 25 %; a sample apart it may be passed by a little before the run stops.
    """
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(seed)
    stopped = 0
    for _ in range(12):
        row = model(
            edge_stiffness=10 ** rng.uniform(-2, 0),
            offset=rng.uniform(-0.1, 0.1),
            simulation_capillary_number=rng.uniform(100, 200),
            vertex_count=int(rng.choice([16, 24])),
        )
        one, deepest = system(row), 0.0
        while not one.finished:
            one.advance(one.time + 0.02)
            for _, _, outline, _ in one.outlines():
                gap = shapely.LinearRing(outline).distance(shapely.Point(0.0, 0.0))
                deepest = max(deepest, 1 - gap / row[0])
        ended = result(one)
        stopped += guard_of(ended) == "penetration"
        assert deepest < 0.4 or ended["outcome"] == FAILED
    assert stopped > 0


def test_obstacle_smaller_than_a_step_is_not_passed_unseen(model, system, result):
    """R = 1e-9 D0: no vertex and no edge is ever within R/4, yet the centre is in the droplet."""
    row = model(offset=0.05)
    one = system(row, None, [[0.0, 0.0, 1e-9]], [[-1.0, 0.05, 1.0]])
    one.advance(10.0)
    ended = result(one)
    assert guard_of(ended) == "penetration"
    assert ended["guard_value"] > 1  # past the centre
    assert ended["guard_time"] < 1


def test_soft_area_is_caught(model, run):
    """k̃_a so small that line tension squeezes out more than 1 % of the area."""
    (got,) = run(model(area_stiffness=5e3))
    assert guard_of(got) == "area"
    assert abs(got["guard_value"]) > 0.01


@pytest.mark.parametrize(("factor", "stopped"), [(0.97, True), (1.03, False)])
def test_area_guard_sits_at_one_percent(model, system, factor, stopped):
    """A resting drop loses γ/(r k_a) of its area: 1 % of it at k_a = γ/(0.01 r A), not before.

    The drag is so large that the drop creeps to its rest; r and the springs' share are off by
    half of 1 %, within the 3 % on either side.
    """
    stiffness = factor * 80 / (0.01 * 0.5 * np.pi / 4)
    row = model(area_stiffness=stiffness, edge_stiffness=1e-6)
    one = system(row, _core.UniformFlow(0.0, 0.0), np.zeros((0, 3)))
    one.advance(1.0)
    assert one.finished == stopped


@pytest.mark.parametrize("factor", [1.2, 1.5, 2.0, 10.0, 1e3])
def test_unstable_time_step_never_gives_a_wrong_outcome(model, run, factor):
    """Above the stable step, which `Parameters` would refuse: stopped, or right after all.

    The stable step is that of every vertex on the wall at once, so a little above it a run may
    be sound; its S is then within the 0.5 % that holds for the automatic step.
    """
    row = model()
    step = _core.MODEL_FIELDS.index("time_step")
    (expected,) = run(row)
    row[step] = factor * _core.stable_time_step(row)
    row[_core.MODEL_FIELDS.index("sample_interval")] = max(0.01, row[step])
    (got,) = run(row)
    if got["outcome"] == FAILED or factor >= 2:
        assert guard_of(got) in ("blow_up", "area", "self_intersection", "penetration")
    else:
        assert got["outcome"] == expected["outcome"]
        assert got["symmetry"] == pytest.approx(expected["symmetry"], rel=0.005)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (name, value)
        for name in ("drag", "line_tension", "area_stiffness", "offset")
        for value in (np.nan, np.inf)
        if (name, value) != ("drag", np.inf)  # a droplet that goes with the fluid
    ],
)
def test_numbers_that_are_not_finite_are_caught(model, run, name, value):
    """NaN checks survive the compiler's flags: such a run ends at once, as failed."""
    (got,) = run(model(core={name: value}))
    assert guard_of(got) in ("blow_up", "area")
    assert got["end_time"] < 0.1


def test_wall_too_stiff_for_the_step_is_caught(model, run):
    """A wall 100 times as stiff as the step allows gives no plausible-looking nonsense."""
    row = model(offset=0.0)
    row[_core.MODEL_FIELDS.index("wall_stiffness")] *= 1e4
    (got,) = run(row)
    assert got["outcome"] == FAILED


def test_leaving_the_sampled_flow_is_caught(model, run, system, result):
    """A grid that ends before the droplet does: the run stops where the first vertex leaves it."""

    def sampled(right):
        x, y = np.linspace(-6.5, right, 200), np.linspace(-2, 2, 100)
        points = np.column_stack([a.ravel() for a in np.meshgrid(x, y)])
        v = _core.StokesFlow(1 / 5.66).velocity(points)
        u, v = (np.ascontiguousarray(v[:, k].reshape(100, 200)) for k in (0, 1))
        return _core.SampledFlow(x[0], y[0], x[1] - x[0], y[1] - y[0], u, v)

    (got,) = run(model(), flow=sampled(-1.0))
    assert guard_of(got) == "flow_domain"
    assert 0 < got["guard_value"] < 0.01 * 2.5  # at most a sample's way past the rim
    one = system(model(), sampled(-1.0))
    one.advance(1e9)
    assert result(one)["guard_time"] == got["guard_time"]
    front = max(outline[:, 0].max() for _, _, outline, _ in one.outlines())
    assert front == pytest.approx(-1.0 + got["guard_value"], abs=1e-9)
    (got,) = run(model(), flow=sampled(6.0))
    assert got["guard"] == 0


def test_captured_droplet_is_said_to_be_captured(model, run):
    """Head-on and too slow to break: still on the obstacle at the time limit."""
    (got,) = run(model(offset=0.0, simulation_capillary_number=8.0, time_limit=5.0))
    assert got["outcome"] == 2
    assert got["guard"] == 0
    assert got["end_time"] == pytest.approx(5.0, abs=0.011)


@pytest.mark.parametrize(
    "constants",
    [
        {"neck_thickness": 0.655},
        {
            "size_ratio": 5.138,
            "simulation_capillary_number": 1154.8,
            "offset": -0.352,
            "vertex_count": 32,
            "neck_thickness": 0.2146,
            "neck_separation_unit": "diameter",
        },
    ],
)
def test_breaking_without_end_is_stopped(model, run, constants):
    """Thresholds at which everything breaks, its daughters too: a guard says so, soon."""
    (got,) = run(model(**constants))
    assert guard_of(got) in ("generations", "daughter_size", "time_step")
    assert got["vertex_updates"] < 1e9


def test_generations_are_bounded(model, run):
    """Every line of descent that a run reports is within the guard's limit."""
    got = run([model(neck_thickness=t) for t in (0.3, 0.4, 0.5)])
    assert max(g["generations"] for g in got) <= _core.GUARD_LIMITS["generations"] + 1


@pytest.mark.parametrize("value", [np.nan, 0.0, -1e-4, np.inf, 1e-300])
@pytest.mark.parametrize("name", ["time_step", "sample_interval", "time_limit", "vertex_count"])
def test_numbers_that_count_steps_are_refused(model, run, system, name, value):
    """No such model starts: a clock that stands still would never end."""
    if (name, value) in (("time_limit", 0.0), ("time_limit", 1e-300), ("sample_interval", 1e-300)):
        pytest.skip("a run that ends at once, or samples at every step, is a sound one")
    row = model(core={name: value})
    for start in (run, system):
        with pytest.raises(ValueError, match=f"{name} must be|sample_interval must be"):
            start(row)


def test_interrupt_ends_a_piece_of_any_length(model, system):
    """Ctrl-C acts within `advance`, whatever the time that it was asked for."""
    row = model(core={"time_limit": 1e6})
    one = system(row, _core.UniformFlow(0.0, 0.0), np.zeros((0, 3)))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            one.advance(1e6)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert not one.finished
