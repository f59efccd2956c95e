"""simulate: outcomes, recording, own flows, wrong arguments; Ctrl-C, of simulate_many too."""

from __future__ import annotations

import json
import math
import os
import pickle
import signal
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import pytest

import pinchoff as po
from pinchoff.model.parameters import SAMPLE_INTERVAL

BREAKING = po.Parameters(simulation_capillary_number=30, offset=0.02)
SLIPPING = po.Parameters(simulation_capillary_number=10, offset=0.15)
MISSING = po.Parameters(offset=2)
COLLAPSING = po.Parameters(area_stiffness=1)
ENDLESS = po.Parameters(time_step=1e-7)


def assert_same_row(one: Mapping[str, object], other: Mapping[str, object]) -> None:
    assert list(one) == list(other)
    assert [name for name in one if one[name] != other[name] and one[name] == one[name]] == []


# One collision


def test_a_collision_breaks_and_another_slips():
    c = po.simulate(BREAKING)
    assert (c.outcome, c.broke, c.droplet_count, c.generations) == ("broke", True, 2, 1)
    assert c.contact_time < c.breakup_time < c.end_time
    assert c.breakup_neck < BREAKING.neck_thickness
    small, large = c.daughter_areas
    assert small <= large
    assert c.daughter_area_ratio == small / large
    assert small + large == pytest.approx(math.pi / 4, rel=0.01)
    assert len(c.contacts) >= 1
    assert len(c.breakups) == c.breakup_count == 1
    assert c.outlines is None

    c = po.simulate(SLIPPING)
    assert (c.outcome, c.broke, c.droplet_count, c.generations) == ("slipped", False, 1, 0)
    assert 0 < c.symmetry < 1
    assert c.minimum_neck > SLIPPING.neck_thickness
    assert math.isnan(c.breakup_time)
    assert math.isnan(c.daughter_area_ratio)


def test_time_limit_captures_and_daughters_may_be_left_alone():
    assert po.simulate(BREAKING.replace(time_limit=2.5)).outcome == "captured"
    c = po.simulate(BREAKING.replace(follow_daughters=False))
    assert c.broke
    assert c.end_time == pytest.approx(c.breakup_time)


def test_collision_shows_what_happened():
    assert "broke" in repr(po.simulate(BREAKING))
    assert "no contact" in repr(po.simulate(MISSING))


def test_collision_is_json_without_nan():
    for p in (BREAKING, MISSING):
        c = po.simulate(p)
        read = json.loads(json.dumps(c.to_dict(), allow_nan=False))
        assert po.Parameters(**read.pop("parameters")) == p
        assert read["outcome"] == c.outcome
        assert (read["symmetry"] is None) == math.isnan(c.symmetry)


def test_stopped_run_raises_with_the_number_the_time_and_advice():
    with pytest.raises(po.SimulationError) as caught:
        po.simulate(COLLAPSING)
    error = caught.value
    assert error.guard == "area"
    assert abs(error.value) > 0.01
    assert error.time > 0
    message = str(error)
    assert " must be " in message
    assert f"got {error.value:+.2%} at t = {error.time:.4g} t0" in message
    assert "raise area_stiffness" in message
    copy = pickle.loads(pickle.dumps(error))
    assert (copy.guard, copy.value, copy.time) == (error.guard, error.value, error.time)
    assert copy.exit_code == 1


def test_obstacle_that_passes_between_vertices_is_no_result():
    with pytest.raises(po.SimulationError, match="raise edge_stiffness or vertex_count"):
        po.simulate(po.Parameters(offset=0.2, edge_stiffness=1e-3))


def test_droplet_that_leaves_the_sampled_flow_is_no_result():
    x, y = np.linspace(-6, 0, 25), np.linspace(-2, 2, 17)
    short = po.flow.sampled(x, y, np.ones((17, 25)), np.zeros((17, 25)))
    with pytest.raises(po.SimulationError, match="the droplet's whole way") as caught:
        po.simulate(MISSING.replace(offset=0), flow=short)
    assert caught.value.guard == "flow_domain"


# Recording


@pytest.mark.parametrize("interval", [True, 0.01, 0.033, 1000.0])
def test_recording_does_not_change_the_results(interval):
    plain, recorded = po.simulate(BREAKING).to_row(), po.simulate(BREAKING, outlines=interval)
    assert_same_row(recorded.to_row(), plain)
    assert recorded.outlines is not None
    times = recorded.outlines.times
    assert times[0] == 0
    assert times[-1] == recorded.end_time
    assert (np.diff(times) > 0).all()


def test_recording_interval_is_rounded_up_to_samples():
    outlines = po.simulate(BREAKING, outlines=2.5 * SAMPLE_INTERVAL).outlines
    assert outlines is not None
    steps = np.diff(outlines.times)[:-1]
    np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
    assert steps[0] == pytest.approx(3 * SAMPLE_INTERVAL, rel=0.02)


def test_outlines_carry_obstacles_and_parameters():
    outlines = po.simulate(BREAKING, outlines=True).outlines
    assert outlines is not None
    np.testing.assert_allclose(outlines.obstacles, [[0, 0, BREAKING.obstacle_radius]])
    assert po.Parameters(**outlines.parameters) == BREAKING
    assert {o.generation for o in outlines[len(outlines) - 1]} == {1}


def test_frames_are_handed_out_as_they_come():
    seen = []
    c = po.simulate(BREAKING, outlines=0.5, on_frame=lambda t, drops: seen.append((t, drops)))
    assert c.outlines is not None
    assert [t for t, _ in seen] == c.outlines.times.tolist()
    assert len(seen[-1][1]) == 2
    only_handed = []
    po.simulate(BREAKING, on_frame=lambda t, _: only_handed.append(t))
    assert len(only_handed) > 20


# Other flows, obstacles and droplets


@pytest.mark.parametrize(
    ("interval", "expected"), [(0.05, 0.05), (0.01, 0.01), (0.011, 0.02), (0.1, 0.1)]
)
def test_records_are_as_far_apart_as_asked_rounded_up_to_samples(interval, expected):
    times = po.simulate(BREAKING.replace(time_limit=0.5), outlines=interval).outlines.times
    assert np.diff(times)[:-1] == pytest.approx(expected, abs=0.002)


def test_defaults_can_be_spelt_out():
    radius, start = BREAKING.obstacle_radius, BREAKING.start_distance
    c = po.simulate(
        BREAKING,
        flow=po.flow.stokes(radius),
        obstacles=[[0, 0, radius]],
        droplets=[[-start, BREAKING.offset, 1]],
    )
    assert_same_row(c.to_row(), po.simulate(BREAKING).to_row())


def test_default_flow_is_that_around_the_first_obstacle():
    shifted = po.simulate(
        BREAKING,
        obstacles=[[3, -2, BREAKING.obstacle_radius]],
        droplets=[[3 - BREAKING.start_distance, BREAKING.offset - 2, 1]],
    )
    assert shifted.symmetry == pytest.approx(po.simulate(BREAKING).symmetry, rel=1e-6)


def test_free_droplets_drift_until_the_time_limit():
    c = po.simulate(
        po.Parameters(time_limit=1),
        flow=po.flow.uniform(1, 0.5),
        obstacles=[],
        droplets=[[0, 0, 1], [3, 0, 0.5]],
        outlines=True,
    )
    assert c.outcome == "slipped"
    assert c.end_time >= 1
    assert c.droplet_count == 2
    assert c.outlines is not None
    first = c.outlines[len(c.outlines) - 1][0]
    np.testing.assert_allclose(first.velocities.mean(axis=0), [1, 0.5], rtol=1e-6)


@pytest.mark.parametrize(
    ("argument", "keywords"),
    [
        ("flow", {"flow": 3}),
        ("flow", {"flow": lambda points: points}),
        ("flow", {"obstacles": []}),
        ("obstacles", {"obstacles": [[0, 0]]}),
        ("obstacles", {"obstacles": [0, 0, 1]}),
        ("obstacles", {"obstacles": "round"}),
        ("obstacles[1]", {"obstacles": [[0, 0, 1], [5, 5, 0]]}),
        ("obstacles[0]", {"obstacles": [[0, math.nan, 1]]}),
        ("droplets", {"droplets": []}),
        ("droplets[0]", {"droplets": [[0, 0, 1]]}),
        ("droplets[0]", {"droplets": [[-5, 0, -1]]}),
        ("droplets[1]", {"droplets": [[-5, 0, 1], [-5.5, 0, 1]]}),
        ("outlines", {"outlines": 0}),
        ("outlines", {"outlines": -1.0}),
        ("outlines", {"outlines": math.nan}),
        ("outlines", {"outlines": "often"}),
    ],
)
def test_wrong_argument_is_refused_by_name(refused, argument, keywords):
    refused(argument, po.simulate, BREAKING, **keywords)


@pytest.mark.parametrize("parameters", [None, {}, 3, [BREAKING]])
def test_what_is_no_parameters_is_refused(refused, parameters):
    refused("parameters", po.simulate, parameters)


# Ctrl-C


@contextmanager
def interrupt_after(seconds: float) -> Iterator[None]:
    """Press Ctrl-C once, and require that the block ends soon after."""
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    start = time.monotonic()
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            yield
    finally:
        timer.cancel()
    assert time.monotonic() - start < seconds + 5


def test_interrupt_stops_one_collision_at_once():
    with interrupt_after(0.3):
        po.simulate(ENDLESS)


@pytest.mark.parametrize("progress", [False, True])
def test_interrupt_stops_many_collisions_at_once(progress):
    with interrupt_after(0.3):
        po.simulate_many([BREAKING.replace(time_step=1e-5)] * 1000, threads=2, progress=progress)


def test_the_last_outline_is_looked_at_too():
    """Crossing edges are sought every ten samples; here they come in the last of them."""
    thin = {"model": "front-tracking", "vertex_count": 32, "neck_thickness": 0.034663}
    values = {"size_ratio": 2.4813, "simulation_capillary_number": 170.659, "offset": 0.0}
    end = {"start_distance": 2.82558, "neck_separation": 0.332047, "follow_daughters": False}
    with pytest.raises(po.SimulationError) as caught:
        po.simulate(po.Parameters(**thin, **values, **end, time_limit=6.82268))
    assert caught.value.guard == "self_intersection"


def test_a_daughter_that_touches_as_she_is_made_is_no_collision():
    values = {"size_ratio": 9.0393, "simulation_capillary_number": 254.473, "offset": 0.0}
    values |= {"line_tension": 42.8418, "neck_thickness": 0.38637, "neck_separation": 0.1943}
    row = po.simulate(po.Parameters(**values, vertex_count=64, start_distance=2.3862)).to_row()
    assert row["breakup_time"] == row["contact_time"]
    assert row["contact_area"] < row["small_daughter_area"] + row["large_daughter_area"] - 0.1
    assert not row["accepted"]
    assert row["reject_reason"].startswith("broke before first contact")
