"""The separating line: brackets against a brute-force oracle, then on real collisions."""

from __future__ import annotations

import itertools
import math
import warnings

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.studies.boundary.bracketing import (
    GLANCING,
    STATUSES,
    Interval,
    Search,
    Trial,
    run_searches,
)
from pinchoff.studies.boundary.search import COLUMNS, write_table

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


# Collisions


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
    with pytest.warns(RuntimeWarning, match=r"of \d+ runs have no outcome"):
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
