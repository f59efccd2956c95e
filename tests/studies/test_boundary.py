"""The separating line: brackets on real collisions, and their table."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.studies.boundary.search import COLUMNS, write_table


@pytest.fixture(scope="module")
def two_points():
    return po.boundary(po.Parameters(), {"simulation_capillary_number": [20, 40]})


def test_the_prototypes_critical_symmetries_come_out(two_points):
    """An independent program found 0.843 and 0.472."""
    table = two_points.table
    assert table["status"].tolist() == ["found", "found"]
    assert table["critical_symmetry"].tolist() == pytest.approx([0.843, 0.472], rel=0.05)
    assert (table["width"] <= 0.005).all()


def test_the_table_says_what_the_runs_show(two_points):
    table, runs = two_points.table, two_points.runs
    assert list(table) == list(COLUMNS)
    assert table.attrs["units"] == {name: column.unit for name, column in COLUMNS.items()}
    for row in table.itertuples():
        mine = runs[runs["point"] == row.point]
        assert len(mine) == row.runs
        broke, unbroken = mine[mine["broke"]], mine[~mine["broke"]]
        assert row.symmetry_broke == broke["symmetry"].min()
        assert row.symmetry_unbroken == unbroken["symmetry"].max()
        assert row.offset_broke == broke["offset"].max()
        assert row.offset_unbroken == unbroken["offset"].min()
        middle = (row.symmetry_broke + row.symmetry_unbroken) / 2
        assert row.critical_symmetry == pytest.approx(middle)
        ends = mine["offset"].isin([row.offset_broke, row.offset_unbroken])
        assert row.contact_speed == pytest.approx(mine.loc[ends, "contact_speed"].mean())
        assert row.control_parameter == pytest.approx(row.capillary_number * row.normalized_area)
        assert row.drag == 80 * row.simulation_capillary_number


def test_an_end_of_a_bracket_can_be_run_again(two_points):
    row = two_points.table.iloc[0]
    p = po.Parameters(simulation_capillary_number=20)
    broke = po.simulate(p.replace(offset=row["offset_broke"]))
    unbroken = po.simulate(p.replace(offset=row["offset_unbroken"]))
    assert (broke.broke, broke.symmetry) == (True, row["symmetry_broke"])
    assert (unbroken.broke, unbroken.symmetry) == (False, row["symmetry_unbroken"])


@pytest.mark.parametrize("threads", [1, 3])
def test_independent_of_the_number_of_threads(two_points, threads):
    vary = {"simulation_capillary_number": [20, 40]}
    again = po.boundary(po.Parameters(offset=0.2), vary, threads=threads)
    pd.testing.assert_frame_equal(again.table, two_points.table, check_exact=True)
    pd.testing.assert_frame_equal(again.runs, two_points.runs, check_exact=True)


def test_grid_order_and_further_constants():
    line = po.boundary(
        po.Parameters(simulation_capillary_number=40),
        {"size_ratio": (5.0, 8.0), "vertex_count": np.array([48, 64])},
        width=0.05,
        scan=8,
    )
    assert line.table["size_ratio"].tolist() == [5, 5, 8, 8]
    assert line.table["vertex_count"].tolist() == [48, 64, 48, 64]
    assert line.varied == ("size_ratio", "vertex_count")
    assert "4 points" in repr(line)


def test_a_droplet_that_never_breaks_is_reported():
    line = po.boundary(po.Parameters(size_ratio=2, simulation_capillary_number=40), scan=4)
    (row,) = line.table.to_dict("records")
    assert row["status"] == "no break even head-on"
    assert math.isnan(row["critical_symmetry"])
    assert row["symmetry_unbroken"] == pytest.approx(1)
    assert row["captured_runs"] == (line.runs["outcome"] == "captured").sum()
    assert row["captured_runs"] == 1  # head-on: still there at the time limit


def test_a_run_that_has_not_arrived_in_time_says_nothing():
    with pytest.warns(RuntimeWarning, match="no outcome"):
        line = po.boundary(po.Parameters(time_limit=1), scan=4)
    assert line.table["status"].tolist() == ["unresolved"]
    assert len(line.failures) == 5
    assert (line.failures["reject_reason"] != "").all()


def test_failures_are_listed_with_their_place_and_warned_of():
    words = r"of \d+ runs of point 0 have no outcome, at offsets from 0"
    with pytest.warns(RuntimeWarning, match=words):
        line = po.boundary(po.Parameters(area_stiffness=1), scan=4)
    assert line.table["status"].tolist() == ["unresolved"]
    failures = line.failures
    assert len(failures) == line.table["failed_runs"].sum() == len(line.runs)
    assert failures["reject_reason"].str.contains("area must be within 1 %").all()
    assert failures["offset"].is_unique


def test_without_any_failure_no_warning(two_points):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        po.boundary(po.Parameters(simulation_capillary_number=80), scan=4, width=0.2)
    assert two_points.failures.empty


def test_other_numbers_than_the_experiments_drop_its_scale(experiment):
    p = po.Parameters.from_physical(**experiment)
    line = po.boundary(p, {"simulation_capillary_number": [40]}, scan=4, width=0.3)
    assert line.runs["speed_mm_s"].isna().all()
    line = po.boundary(p, {"line_tension": [60]}, scan=4, width=0.3)
    assert line.runs["speed_mm_s"].notna().any()


def test_tables_keep_their_units(two_points, tmp_path):
    import pyarrow.parquet as pq

    write_table(two_points.table, tmp_path / "boundary.parquet")
    schema = pq.read_schema(tmp_path / "boundary.parquet")
    assert schema.field("offset_broke").metadata[b"unit"] == b"D0"
    read = pd.read_parquet(tmp_path / "boundary.parquet")
    pd.testing.assert_frame_equal(read, two_points.table, check_dtype=False)
    write_table(two_points.runs, tmp_path / "runs.parquet")
    assert len(pd.read_parquet(tmp_path / "runs.parquet")) == len(two_points.runs)
    write_table(two_points.table, tmp_path / "boundary.csv")
    assert len(pd.read_csv(tmp_path / "boundary.csv")) == 2


def test_every_varied_constant_is_in_the_files(tmp_path):
    """Also one whose column has another name elsewhere, and a time step that is found."""
    coarse = po.Parameters(vertex_count=32)
    vary = {"time_step": ["auto", 1e-4], "neck_thickness": [0.16, 0.17], "ca_speed": ["contact"]}
    line = po.boundary(coarse, vary, scan=4, width=0.3)
    steps = [coarse.effective_time_step, 1e-4]
    for suffix, read in ((".parquet", pd.read_parquet), (".csv", pd.read_csv)):
        write_table(line.table, tmp_path / f"table{suffix}")
        table = read(tmp_path / f"table{suffix}")
        assert table["time_step"].tolist() == pytest.approx(np.repeat(steps, 2))
        assert table["neck_thickness"].tolist() == [0.16, 0.17] * 2
        assert set(table["ca_speed"]) == {"contact"}


@pytest.mark.parametrize(
    ("argument", "positional", "keywords"),
    [
        ("base", ("default",), {}),
        ("vary", (po.Parameters(), [16]), {}),
        ("vary", (po.Parameters(), {"sise_ratio": [4]}), {}),
        ("vary", (po.Parameters(), {"offset": [0.1]}), {}),
        ("vary", (po.Parameters(), {"follow_daughters": [True]}), {}),
        ("vary['size_ratio']", (po.Parameters(), {"size_ratio": []}), {}),
        ("vary['size_ratio']", (po.Parameters(), {"size_ratio": 4}), {}),
        ("size_ratio", (po.Parameters(), {"size_ratio": [4, -1]}), {}),
        ("size_ratio", (po.Parameters(), {"size_ratio": [math.nan]}), {}),
        ("width", (po.Parameters(),), {"width": 0}),
        ("width", (po.Parameters(),), {"width": math.nan}),
        ("width", (po.Parameters(),), {"width": "narrow"}),
        ("scan", (po.Parameters(),), {"scan": 3}),
        ("scan", (po.Parameters(),), {"scan": 24.0}),
        ("threads", (po.Parameters(),), {"threads": 0}),
        ("time_step", (po.Parameters(time_step=0.05),), {}),
    ],
)
def test_wrong_arguments_are_refused(refused, argument, positional, keywords):
    refused(argument, po.boundary, *positional, **keywords)


def test_a_misspelt_name_suggests_the_right_one(refused):
    error = refused("vary", po.boundary, po.Parameters(), {"sise_ratio": [4]})
    assert "did you mean 'size_ratio'?" in str(error)


def test_the_papers_line_at_its_median_droplet():
    """α and β, and every S_c, within what a reading of the paper allows."""
    values = [16, 20, 25, 32, 40, 50, 64, 80]
    line = po.boundary(po.Parameters(), {"simulation_capillary_number": values})
    fit = line.fit()
    assert fit.alpha.value == pytest.approx(0.089, abs=0.010)
    assert fit.beta.value == pytest.approx(-0.72, abs=0.04)
    paper = 0.089 * line.table["control_parameter"] ** -0.72
    assert line.table["critical_symmetry"].to_numpy() == pytest.approx(paper.to_numpy(), rel=0.10)


def test_a_flow_of_ones_own_takes_the_place_of_the_stokes_flow(refused):
    base, vary = po.Parameters(), {"simulation_capillary_number": [40, 80]}
    own = po.boundary(base, vary, scan=8, width=0.05)
    same = po.boundary(base, vary, scan=8, width=0.05, flow=po.flow.stokes(base.obstacle_radius))
    pd.testing.assert_frame_equal(own.table, same.table)
    faster = po.flow.stokes(0.8 * base.obstacle_radius)  # everywhere, and most at the obstacle
    line = po.boundary(base, vary, scan=8, width=0.05, flow=faster)
    assert (line.table["critical_symmetry"] < own.table["critical_symmetry"]).all()
    refused("flow", po.boundary, base, vary, flow="stokes")


def test_line_tension_and_viscosity_act_through_their_ratio():
    from pinchoff.studies.boundary.collapse import collapse_spread, slopes

    vary = {"line_tension": [60, 600], "simulation_capillary_number": [16, 25, 40, 80]}
    line = po.boundary(po.Parameters(), vary, width=0.002)
    one, other = slopes(line.found).values()
    assert one == pytest.approx(other, abs=0.02)
    assert collapse_spread(line.found).largest < 0.02
