"""simulate_many: order, determinism, columns, failures, wrong arguments."""

from __future__ import annotations

import math
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
from pinchoff.model.run_table import run_columns

BREAKING = po.Parameters(simulation_capillary_number=30, offset=0.02)
SLIPPING = po.Parameters(simulation_capillary_number=10, offset=0.15)
MISSING = po.Parameters(offset=2)
COLLAPSING = po.Parameters(area_stiffness=1)


def assert_same_row(one: Mapping[str, object], other: Mapping[str, object]) -> None:
    assert list(one) == list(other)
    assert [name for name in one if one[name] != other[name] and one[name] == one[name]] == []


def assert_same(one: pd.DataFrame, other: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(one, other, check_exact=True)


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


def test_a_break_up_before_contact_is_no_collision():
    values = {"size_ratio": 3.21, "simulation_capillary_number": 391, "offset": 0}
    early = po.Parameters(**values, neck_thickness=0.415, start_distance=1.5, line_tension=208)
    table = po.simulate_many([early, po.Parameters()], progress=False)
    assert table["broke"].tolist() == [True, True]
    assert table["breakup_time"][0] < table["contact_time"][0]
    assert table["accepted"].tolist() == [False, True]
    assert table["reject_reason"][0].startswith("broke before first contact")
