"""The virtual experiment: the paper's conditions, seeded, and labelled as what it is."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.circle_segments import symmetry_of_impact
from pinchoff.collisions.parquet import write_collisions
from pinchoff.studies.virtual import CONDITIONS, TRUE_SYMMETRY


@pytest.fixture(scope="module")
def table():
    return po.virtual_experiment(1)


def test_it_has_the_papers_size_conditions_and_ranges(table):
    assert len(table) == 5056
    conditions = table[["obstacle_radius_um", "thickness_um", "viscosity_mPa_s"]].drop_duplicates()
    assert {tuple(row) for row in conditions.to_numpy()} == {each[:3] for each in CONDITIONS}
    assert sum(each.share for each in CONDITIONS) == pytest.approx(1)
    assert (table["surface_tension_mN_m"] == 20).all()
    assert table["speed_mm_s"].between(0.5, 2).all()
    diameter = np.sqrt(4 / np.pi * table["area_um2"])
    assert diameter.between(100, 600).all()
    assert (diameter.min(), diameter.max()) == pytest.approx((100, 600), rel=0.02)


def test_groups_follow_from_the_physical_columns(table):
    ca = table["viscosity_mPa_s"] * table["speed_mm_s"] / table["surface_tension_mN_m"] * 1e-3
    assert table["capillary_number"].to_numpy() == pytest.approx(ca.to_numpy())
    assert ca.between(1e-3, 1e-2).all()  # O(1e-3), as the paper says: its oils are 48 and 96 mPa s
    imported = po.import_collisions(
        table.drop(columns=["capillary_number", "normalized_area", "normalized_thickness"])
    )
    for name in ("capillary_number", "normalized_area", "normalized_thickness"):
        assert imported.table[name].to_numpy() == pytest.approx(table[name].to_numpy())


def test_break_up_is_drawn_from_the_law_with_the_true_symmetry(table):
    bk = po.breakup_number(
        table["capillary_number"],
        normalized_area=table["normalized_area"],
        symmetry=table["true_symmetry"],
        normalized_thickness=table["normalized_thickness"],
        line="paper-experiment",
    )
    assert np.log10(bk.max() / bk.min()) > 6  # the paper: over six orders of magnitude
    broke = table["broke"].to_numpy(dtype=bool)
    expected = 1 / (1 + bk ** (-1 / 0.098))
    error = np.sqrt((expected * (1 - expected)).sum())
    assert broke.sum() == pytest.approx(expected.sum(), abs=4 * error)
    assert broke[bk > 2].mean() > 0.99
    assert broke[bk < 0.5].mean() < 0.01


def test_measured_symmetry_has_the_noise(table):
    away = table[table["true_symmetry"].between(0.3, 0.7)]
    error = away["symmetry"] - away["true_symmetry"]
    assert error.std() == pytest.approx(0.088, rel=0.05)
    assert error.mean() == pytest.approx(0, abs=0.006)
    assert table["symmetry"].between(0, 1).all()
    assert not table["symmetry"].isin([0.0, 1.0]).any()  # reflected there, not cut off
    assert table["true_symmetry"].to_numpy() == pytest.approx(
        symmetry_of_impact(table["impact_parameter"])
    )
    clean = po.virtual_experiment(1, symmetry_noise=0)
    pd.testing.assert_series_equal(clean["symmetry"], clean["true_symmetry"], check_names=False)


def test_the_same_seed_gives_the_same_table(table):
    pd.testing.assert_frame_equal(po.virtual_experiment(1), table)
    assert not po.virtual_experiment(2)["symmetry"].equals(table["symmetry"])


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_every_file_says_that_it_is_synthetic(table, tmp_path, suffix):
    path = tmp_path / f"table{suffix}"
    write_collisions(table, path, [TRUE_SYMMETRY])
    imported = po.import_collisions(path)
    assert imported.synthetic
    assert imported.table["source"].str.startswith("synthetic").all()
    assert po.fit_law(path).to_dict()["synthetic"] is True


def test_outcomes_of_the_engine_do_not_depend_on_threads():
    one, two = (
        po.virtual_experiment(3, 60, outcomes="engine", threads=n, progress=False) for n in (1, 2)
    )
    pd.testing.assert_frame_equal(one, two)
    assert len(one) == 60
    assert one["true_symmetry"].notna().all()
    broke = one[one["broke"].fillna(False).astype(bool)]
    assert broke["daughter_area_ratio"].notna().all()
    assert (one["neck_um"].dropna() > 0).all()


def test_the_engine_breaks_what_the_law_says_mostly():
    table = po.virtual_experiment(3, 150, outcomes="engine", symmetry_noise=0, progress=False)
    known = table[table["broke"].notna()]
    bk = po.breakup_number(
        known["capillary_number"],
        normalized_area=known["normalized_area"],
        symmetry=known["symmetry"],
        normalized_thickness=known["normalized_thickness"],
    )
    broke = known["broke"].to_numpy(dtype=bool)
    assert broke[bk > 3].mean() > 0.9
    assert broke[bk < 0.2].mean() < 0.02


def test_wrong_arguments_are_refused(refused):
    refused("seed", po.virtual_experiment, -1)
    refused("seed", po.virtual_experiment, 1.5)
    refused("n", po.virtual_experiment, 1, 0)
    refused("outcomes", po.virtual_experiment, 1, outcomes="both")
    refused("width", po.virtual_experiment, 1, width=float("nan"))
    refused("symmetry_noise", po.virtual_experiment, 1, symmetry_noise=2)
    refused("line", po.virtual_experiment, 1, line="mine")
    refused("base", po.virtual_experiment, 1, outcomes="engine", base="default")


def test_a_model_whose_droplets_never_touch_is_refused(refused):
    short = po.Parameters(time_limit=0.05, vertex_count=16)
    refused("base", po.virtual_experiment, 1, 1, outcomes="engine", base=short)
