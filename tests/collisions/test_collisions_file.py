"""Tables of collisions that were not simulated: made, written, read back, summarized."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions import parquet
from pinchoff.collisions.parquet import write_collisions
from pinchoff.collisions.schema import (
    SHARED_COLUMNS,
    Column,
    measure_column,
    measured_table,
    synthetic,
)
from pinchoff.studies.sweep.summary import summarize


@pytest.fixture
def measured():
    return measured_table(
        {
            "source": np.array(["clip.mp4"] * 3, dtype=object),
            "symmetry": np.array([0.2, 0.9, math.nan]),
            "capillary_number": np.full(3, 2e-3),
            "normalized_area": np.full(3, 20.0),
            "normalized_thickness": np.ones(3),
            "broke": np.array([False, True, math.nan], dtype=object),
        }
    )


def test_what_is_not_given_was_not_measured(measured):
    assert list(measured.columns) == [column.name for column in SHARED_COLUMNS]
    assert measured["collision_id"].tolist() == [0, 1, 2]
    assert measured["accepted"].all()
    assert measured["neck_um"].isna().all()
    assert measured["broke"].tolist()[:2] == [False, True]
    assert measured["broke"].isna().tolist() == [False, False, True]
    assert measured.attrs["units"]["area_um2"] == "µm²"
    assert not synthetic(measured)


def test_parquet_reads_back_equal(measured, tmp_path):
    write_collisions(measured, tmp_path / "table.parquet")
    read = po.read_collisions(tmp_path / "table.parquet")
    pd.testing.assert_frame_equal(read, measured)
    assert read.attrs["units"] == measured.attrs["units"]


def test_further_columns_keep_their_unit(measured, tmp_path):
    more = Column("focus_um", "µm", "float64", "height of the focus")
    measured["focus_um"] = [1.0, 2.0, 3.0]
    write_collisions(measured, tmp_path / "table.parquet", [more])
    read = po.read_collisions(tmp_path / "table.parquet")
    assert read["focus_um"].tolist() == [1, 2, 3]
    assert read.attrs["units"]["focus_um"] == "µm"


def test_simulated_rows_are_written_too(tmp_path):
    table = po.simulate_many([po.Parameters(offset=y) for y in (0.0, 0.3)])
    write_collisions(table, tmp_path / "table.parquet")
    read = po.read_collisions(tmp_path / "table.parquet")
    pd.testing.assert_frame_equal(read[list(table)], table)
    assert read[list({*read} - {*table})].isna().all(axis=None)


def test_csv_for_other_programs(measured, tmp_path):
    write_collisions(measured, tmp_path / "table.csv")
    read = pd.read_csv(tmp_path / "table.csv")
    assert read["symmetry"].tolist()[:2] == [0.2, 0.9]
    assert read["broke"].tolist()[:2] == [False, True]


def test_what_cannot_be_written_is_refused(measured, tmp_path, refused):
    refused(str(tmp_path / "a.txt"), write_collisions, measured, tmp_path / "a.txt")
    missing = tmp_path / "no" / "a.csv"
    refused(str(missing), write_collisions, measured, missing)


def test_summary_counts_what_broke(measured, tmp_path):
    write_collisions(measured, tmp_path / "table.parquet")
    found = summarize(tmp_path / "table.parquet")
    assert found.outcomes == {"did not break": 1, "broke": 1, "unknown": 1}
    assert found.points.population == 2


def test_rows_that_come_one_by_one_are_one_table(tmp_path, monkeypatch):
    columns = (measure_column("x_um", "µm", "place"), Column("parents", "1", "int64s", "tracks"))
    monkeypatch.setattr(parquet, "_ROWS_HELD", 2)
    with parquet.TableWriter(tmp_path / "rows.parquet", columns) as table:
        for number in range(5):
            table.append((number / 2, list(range(number))))
    found = pd.read_parquet(tmp_path / "rows.parquet")
    assert found["x_um"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert [len(parents) for parents in found["parents"]] == [0, 1, 2, 3, 4]
    assert found.attrs["units"] == {"x_um": "µm", "parents": "1"}


def test_a_table_that_ends_in_an_error_is_not_there(tmp_path):
    with pytest.raises(RuntimeError), parquet.TableWriter(tmp_path / "rows.parquet", ()) as table:
        table.append(())
        raise RuntimeError
    assert not list(tmp_path.iterdir())
