"""simulate and simulate_many: order, determinism, failures, recording, wrong arguments, Ctrl-C."""

from __future__ import annotations

import json
import math
import os
import pickle
import signal
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff import _core
from pinchoff.collisions import law
from pinchoff.collisions import schema as collisions
from pinchoff.model import simulation
from pinchoff.model.parameters import SAMPLE_INTERVAL
from pinchoff.model.run_table import run_columns

BREAKING = po.Parameters(simulation_capillary_number=30, offset=0.02)
SLIPPING = po.Parameters(simulation_capillary_number=10, offset=0.15)
MISSING = po.Parameters(offset=2)
COLLAPSING = po.Parameters(area_stiffness=1)
ENDLESS = po.Parameters(time_step=1e-7)


def assert_same_row(one: Mapping[str, object], other: Mapping[str, object]) -> None:
    assert list(one) == list(other)
    assert [name for name in one if one[name] != other[name] and one[name] == one[name]] == []


def assert_same(one: pd.DataFrame, other: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(one, other, check_exact=True)


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


AXIS = np.linspace(-1, 1, 5)
ZEROS = np.zeros((5, 5))


@pytest.mark.parametrize(
    ("argument", "arguments"),
    [
        ("x", (AXIS[:3], AXIS, ZEROS[:, :3], ZEROS[:, :3])),
        ("x", (AXIS[::-1], AXIS, ZEROS, ZEROS)),
        ("y", (AXIS, AXIS**3, ZEROS, ZEROS)),
        ("y", (AXIS, [AXIS], ZEROS, ZEROS)),
        ("x", ([0, 1, 2, math.inf, 4], AXIS, ZEROS, ZEROS)),
        ("u", (AXIS, AXIS, ZEROS[:4], ZEROS)),
        ("v", (AXIS, AXIS, ZEROS, ZEROS + math.nan)),
        ("v", (AXIS, AXIS, ZEROS, "fast")),
    ],
)
def test_unfit_samples_of_a_flow_are_refused(refused, argument, arguments):
    refused(argument, po.flow.sampled, *arguments)


def test_unfit_flows_are_refused(refused):
    refused("radius", po.flow.stokes, 0)
    refused("center[1]", po.flow.stokes, 1, (0, math.nan))
    refused("vx", po.flow.uniform, math.inf)


def test_flows_give_velocities():
    points = np.array([[0.3, -0.2], [0.5, 0.9]])
    np.testing.assert_array_equal(po.flow.uniform(2, 1).velocity(points), [[2, 1], [2, 1]])
    x, y = np.meshgrid(AXIS, AXIS)
    sheared = po.flow.sampled(AXIS, AXIS, 1 + 2 * x, 3 * y)
    inside = np.array([[0.1, -0.2], [-0.3, 0.25]])
    expected = np.column_stack([1 + 2 * inside[:, 0], 3 * inside[:, 1]])
    np.testing.assert_allclose(sheared.velocity(inside), expected, atol=1e-12)
    np.testing.assert_array_equal(po.flow.stokes(1).velocity(np.array([[0.5, 0.5]])), [[0, 0]])


# Many collisions


@pytest.fixture(scope="module")
def mixed() -> list[po.Parameters]:
    """Different collisions of different length, in an order that no sorting gives."""
    offsets = np.random.default_rng(5).permutation(np.linspace(0, 0.4, 11))
    return [po.Parameters(offset=float(y), simulation_capillary_number=30) for y in offsets]


@pytest.fixture(scope="module")
def table(mixed) -> pd.DataFrame:
    return po.simulate_many(mixed, threads=1)


def test_rows_stand_in_the_order_of_the_parameters(mixed, table):
    assert table["offset"].tolist() == [p.offset for p in mixed]
    assert table["collision_id"].tolist() == list(range(len(mixed)))
    assert set(table["outcome"]) == {"broke", "slipped"}


@pytest.mark.parametrize("threads", [2, 3, 16, None])
def test_rows_do_not_depend_on_the_threads(mixed, table, threads):
    assert_same(po.simulate_many(mixed, threads=threads), table)


def test_a_row_is_the_collision_alone(mixed, table):
    for i in (0, 4, 10):
        row = {name: table[name].iloc[i] for name in table.columns}
        alone = {**po.simulate(mixed[i]).to_row(), "collision_id": i}
        assert_same_row({name: alone[name] for name in row}, row)
        assert all(math.isnan(alone[name]) for name in alone.keys() - row.keys())


def test_generator_in_chunks_gives_the_same(mixed, table, monkeypatch):
    monkeypatch.setattr(simulation, "CHUNK_SIZE", 4)
    assert_same(po.simulate_many(p for p in mixed), table)
    assert_same(po.simulate_many(tuple(mixed), progress=True), table)


def test_progress_counts_on_from_chunk_to_chunk(mixed, monkeypatch):
    seen: list[float] = []
    run_many = _core.run_many

    @contextmanager
    def bar(wanted: bool, label: str, total: int, unit: str) -> Iterator[Callable[[float], object]]:
        assert (wanted, total) == (True, len(mixed))
        yield seen.append

    def shown(models, flow, threads, show):
        show(1)  # as when a look finds one run done
        show(len(models))
        return run_many(models, flow, threads, None)

    monkeypatch.setattr(simulation, "CHUNK_SIZE", 4)
    monkeypatch.setattr(simulation, "progress_bar", bar)
    monkeypatch.setattr(_core, "run_many", shown)
    po.simulate_many(mixed, threads=1, progress=True)
    assert seen == [1, 4, 5, 8, 9, 11]


def test_generator_is_never_held_whole(monkeypatch):
    monkeypatch.setattr(simulation, "CHUNK_SIZE", 8)
    alive: weakref.WeakSet[po.Parameters] = weakref.WeakSet()
    most = 0

    def generated() -> Iterator[po.Parameters]:
        nonlocal most
        for i in range(64):
            p = MISSING.replace(offset=2 + i / 64)
            alive.add(p)
            most = max(most, len(alive))
            yield p

    po.simulate_many(generated())
    assert most <= 2 * 8 + 1


def test_no_parameters_make_an_empty_table_with_the_same_columns(table):
    empty = po.simulate_many([])
    assert len(empty) == 0
    assert empty.dtypes.equals(table.dtypes)


def test_columns_follow_the_schema(table):
    whole = po.simulate_many([BREAKING], all_columns=True)
    assert list(whole.columns) == [column.name for column in collisions.COLUMNS]
    assert whole.attrs["units"] == collisions.units()
    assert list(table.columns) == [name for name in whole if name in table]
    assert whole[list({*whole} - {*table})].isna().all(axis=None)
    assert table.attrs["units"] == {name: collisions.units()[name] for name in table}
    assert len(collisions.units()) == len(collisions.COLUMNS)
    names = "source capillary_number normalized_area normalized_thickness symmetry speed broke"
    assert set(names.split()) <= set(table.columns)


def test_groups_and_breakup_number_follow_their_definitions(mixed, table):
    for i, p in enumerate(mixed):
        row = table.iloc[i]
        assert row["capillary_number"] == p.capillary_number
        assert row["normalized_area"] == p.normalized_area
        forcing = p.capillary_number * p.normalized_area
        if row["accepted"] and row["symmetry"] > 0:
            line = 0.089 * forcing**-0.72
            expected = (line / row["symmetry"]) ** (1 / -0.72)
            assert row["breakup_number"] == pytest.approx(expected, rel=1e-12)


def test_breakup_number_is_one_on_the_line():
    forcing = np.array([0.04, 0.1, 0.2])
    for line in (law.PAPER_SIMULATION_LINE, law.PAPER_EXPERIMENT_LINE):
        on_line = line.alpha * forcing**line.beta
        np.testing.assert_allclose(
            law.breakup_number(forcing, normalized_area=1, symmetry=on_line, line=line), 1
        )
        assert (
            law.breakup_number(forcing, normalized_area=1, symmetry=1.1 * on_line, line=line) > 1
        ).all()
    assert np.isnan(law.breakup_number(0.04, normalized_area=1, symmetry=math.nan))


def test_physical_columns_are_the_dimensionless_ones_in_units(experiment):
    p = po.Parameters.from_physical(**experiment)
    t = po.simulate_many([p, BREAKING], all_columns=True)
    row, bare = t.iloc[0], t.iloc[1]
    assert row["contact_time_s"] == pytest.approx(row["contact_time"] * 0.481)
    assert row["speed_mm_s"] == pytest.approx(row["contact_speed"] * 1.0)
    assert row["area_um2"] == pytest.approx(row["contact_area"] * 481**2)
    assert row["neck_um"] == pytest.approx(row["minimum_neck"] * 481)
    assert row["obstacle_radius_um"] == 85
    assert row["viscosity_mPa_s"] == pytest.approx(48)
    physical = [c.name for c in collisions.COLUMNS if c.name.endswith(("_um", "_um2", "_s", "_m"))]
    assert bare[physical].isna().all()
    assert row[["obstacle_x_um", "obstacle_y_um"]].isna().all()  # a simulation has no image


def test_stopped_runs_are_rejected_rows_and_leave_the_others_alone(mixed, table):
    with pytest.warns(RuntimeWarning, match="stopped 2 of 13 runs") as caught:
        t = po.simulate_many([COLLAPSING, *mixed, COLLAPSING])
    assert caught[0].filename == __file__
    failed = t.iloc[[0, -1]]
    assert (failed["outcome"] == "failed").all()
    assert not failed["accepted"].any()
    assert failed["broke"].isna().all()
    assert failed["reject_reason"].str.contains("raise area_stiffness").all()
    rest = t.iloc[1:-1].reset_index(drop=True)
    assert_same(
        rest.drop(columns="collision_id")[table.columns[table.columns != "collision_id"]],
        table.drop(columns="collision_id"),
    )


def test_a_run_that_fails_after_its_first_break_up_broke():
    """Its break-up is an event that was seen; what came after is not trusted."""
    rows = _core.run_many(np.array([p.model_row() for p in (BREAKING, SLIPPING)]), None, 1, None)
    for name, value in (("outcome", collisions.OUTCOMES.index("failed")), ("guard", 1)):
        rows[:, _core.RESULT_FIELDS.index(name)] = value
    columns = run_columns([BREAKING, SLIPPING], rows)
    assert columns["broke"][0] == 1
    assert math.isnan(columns["broke"][1])
    assert columns["accepted"].tolist() == [False, False]


def test_droplet_that_touches_nothing_is_no_collision():
    t = po.simulate_many([MISSING, BREAKING])
    assert t["accepted"].tolist() == [False, True]
    assert t["reject_reason"].tolist() == ["no contact: the droplet never touched the obstacle", ""]
    assert math.isnan(t["symmetry"].iloc[0])
    assert t["broke"].tolist() == [False, True]


def test_one_flow_serves_all_runs():
    flow = po.flow.stokes(BREAKING.obstacle_radius)
    assert_same(
        po.simulate_many([BREAKING, SLIPPING], flow=flow), po.simulate_many([BREAKING, SLIPPING])
    )


def test_wrong_arguments_of_many_are_refused_by_name(refused):
    refused("parameters", po.simulate_many, BREAKING)
    refused("parameters", po.simulate_many, 3)
    refused("parameters[1]", po.simulate_many, [BREAKING, None])
    unstable = BREAKING.replace(time_step=0.1)
    refused("parameters[2].time_step", po.simulate_many, [BREAKING, BREAKING, unstable])
    refused("flow", po.simulate_many, [BREAKING], flow="fast")
    for threads in (0, -1, 1.5, True, 10**6, "all"):
        refused("threads", po.simulate_many, [BREAKING], threads=threads)


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


def test_a_break_up_before_contact_is_no_collision():
    values = {"size_ratio": 3.21, "simulation_capillary_number": 391, "offset": 0}
    early = po.Parameters(**values, neck_thickness=0.415, start_distance=1.5, line_tension=208)
    table = po.simulate_many([early, po.Parameters()], progress=False)
    assert table["broke"].tolist() == [True, True]
    assert table["breakup_time"][0] < table["contact_time"][0]
    assert table["accepted"].tolist() == [False, True]
    assert table["reject_reason"][0].startswith("broke before first contact")


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
