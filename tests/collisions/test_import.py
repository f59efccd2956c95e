"""Anybody's table: columns, units, outcomes, impossible values, files of all kinds."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pinchoff as po
from pinchoff.collisions.columns import QUANTITIES
from pinchoff.collisions.reading import read_table
from pinchoff.collisions.schema import SHARED_COLUMNS


@pytest.fixture
def physical():
    """Three collisions as a laboratory may write them down."""
    return pd.DataFrame(
        {
            "S_meas": [0.4, 0.9, 1.3],
            "outcome": ["slipped", "broke", "no"],
            "area_mm2": [0.02, 0.18, 0.2],
            "v": [500.0, 1000.0, 2000.0],
            "R": [85.0, 85.0, 60.0],
            "thickness_um": [85.0, 45.0, 85.0],
        }
    )


HOW = {
    "columns": {"symmetry": "S_meas", "broke": "outcome", "speed": "v", "obstacle_radius": "R"},
    "units": {"speed": "um/s", "obstacle_radius": "um"},
    "constants": {"viscosity": "48mPa.s", "surface_tension": "20 mN/m"},
}


def groups(n=6, **changes):
    """A table that has the groups of the law."""
    table = pd.DataFrame(
        {
            "capillary_number": np.linspace(1e-3, 4e-3, n),
            "normalized_area": 20.0,
            "normalized_thickness": 1.0,
            "symmetry": np.linspace(0.3, 0.9, n),
            "broke": np.arange(n) % 2 == 0,
        }
    )
    return table.assign(**changes)


def test_groups_from_physical_columns(physical):
    table = po.import_collisions(physical, **HOW).table
    assert table["capillary_number"].to_numpy() == pytest.approx([1.2e-3, 2.4e-3, 4.8e-3])
    assert table["normalized_area"].to_numpy() == pytest.approx(
        [2e4 / 85**2, 18e4 / 85**2, 2e5 / 3600]
    )
    assert table["normalized_thickness"].to_numpy() == pytest.approx([1, 45 / 85, 85 / 60])
    assert table["area_um2"].to_numpy() == pytest.approx([2e4, 18e4, 2e5])
    assert table["speed_mm_s"].to_numpy() == pytest.approx([0.5, 1, 2])
    assert table["viscosity_mPa_s"].tolist() == [48, 48, 48]
    assert table["broke"].tolist() == [False, True, False]
    assert table["symmetry"].to_numpy() == pytest.approx([0.4, 0.9, 0.7])  # 1.3 is folded
    assert list(table.columns) == [column.name for column in SHARED_COLUMNS]
    assert table["neck_um"].isna().all()


@pytest.mark.parametrize(
    ("name", "column", "ours"),
    [
        ("viscosity", "mu_mPa_s", 48.0),
        ("viscosity", "mu_Pa_s", 48e3),
        ("viscosity", "viscosity_Pa_s", 48e3),
        ("surface_tension", "sigma_mN_m", 48.0),
        ("surface_tension", "sigma_N_m", 48e3),
        ("speed", "v_um_s", 48e-3),
        ("speed", "v_mm_s", 48.0),
        ("speed", "speed_m_s", 48e3),
        ("contact_time", "t_ms", 48e-3),
        ("contact_time", "t_s", 48.0),
        ("area", "A_mm2", 48e6),
        ("neck", "neck_m", 48e6),
    ],
)
def test_the_end_of_a_columns_name_is_read_as_the_longest_unit(name, column, ours):
    columns = {} if column.startswith(name) else {name: column}
    table = po.import_collisions(groups(**{column: 48.0}), columns=columns).table
    assert table[QUANTITIES[name].column].to_numpy() == pytest.approx(ours)


def test_area_from_the_diameter_where_it_is_missing(physical):
    physical["area_mm2"] = [0.02, np.nan, np.nan]
    physical["diameter_um"] = [np.nan, 481.0, 300.0]
    table = po.import_collisions(physical, **HOW).table
    assert table["area_um2"].to_numpy() == pytest.approx(
        [2e4, math.pi / 4 * 481**2, math.pi / 4 * 300**2]
    )


def test_daughters_in_any_order(physical):
    physical["first_daughter_area_mm2"] = [np.nan, 0.12, np.nan]
    physical["second_daughter_area_um2"] = [np.nan, 6e4, np.nan]
    table = po.import_collisions(physical, **HOW).table
    assert table["daughter_area_ratio"].to_numpy()[1] == pytest.approx(0.5)


def test_one_daughter_alone_gives_no_ratio(physical):
    physical["first_daughter_area_mm2"] = [np.nan, 0.12, np.nan]
    table = po.import_collisions(physical, **HOW).table
    assert table["daughter_area_ratio"].isna().all()


@pytest.mark.parametrize(
    ("column", "value", "reason"),
    [
        ("symmetry", 2.1, "symmetry is not from 0 to 2"),
        ("symmetry", -0.1, "symmetry is not from 0 to 2"),
        ("symmetry", math.nan, "symmetry not measured"),
        ("capillary_number", 0.0, "capillary_number is not positive and finite"),
        ("normalized_area", -20.0, "normalized_area is not positive and finite"),
        ("normalized_area", math.inf, "normalized_area is not positive and finite"),
        ("broke", None, "outcome not known"),
    ],
)
def test_impossible_rows_are_listed_with_their_reason(column, value, reason):
    table = groups()
    table[column] = table[column].astype(object)
    table.loc[3, column] = value
    imported = po.import_collisions(table)
    assert len(imported.table) == 5
    assert imported.set_aside["row"].tolist() == [4]  # counted from 1
    assert imported.set_aside["column"].tolist() == [column]
    assert imported.set_aside["reason"].tolist() == [reason]
    (message,) = imported.messages()
    assert message == f"1 of 6 rows are set aside: {reason} (1)"
    assert imported.table["collision_id"].tolist() == [0, 1, 2, 4, 5]


def test_nothing_is_dropped_in_silence():
    table = groups(40)
    rng = np.random.default_rng(0)
    for column in ("symmetry", "capillary_number"):
        table.loc[rng.choice(40, 7, replace=False), column] = -1.0
    imported = po.import_collisions(table)
    assert len(imported.table) + len(imported.set_aside) == imported.count == 40
    assert sum(imported.reasons().values()) == len(imported.set_aside)


def test_rejected_rows_keep_their_reason():
    table = groups(accepted=[True, False, True, True, False, False])
    table["reject_reason"] = [
        "",
        "a must be b; got 3; do c",
        "",
        "",
        "a must be b; got 4; do c",
        "",
    ]
    reasons = po.import_collisions(table).reasons()
    assert reasons == {"rejected: a must be b; do c": 2, "rejected": 1}


@pytest.mark.parametrize(
    "words",
    [
        ["yes", "no", "Yes", "NO", "y", "n"],
        ["true", "false", "True", "FALSE", "t", "f"],
        ["broke", "slipped", "Broke", "captured", "broken", "intact"],
        [1, 0, 1, 0, 1, 0],
        [1.0, 0.0, 1.0, 0.0, 1.0, 0.0],
        pd.array([True, False, True, False, True, False], dtype="boolean"),
    ],
)
def test_outcomes_in_many_words(words):
    assert po.import_collisions(groups(broke=words)).table["broke"].tolist() == [True, False] * 3


@pytest.mark.parametrize("strange", ["perhaps", 2, -1])
def test_strange_outcomes_are_set_aside(strange):
    outcomes = groups()["broke"].astype(object)
    outcomes[2] = strange
    if not isinstance(strange, str):
        outcomes = outcomes.astype(float)
    imported = po.import_collisions(groups(broke=outcomes))
    assert imported.set_aside["row"].tolist() == [3]
    assert "neither true or false" in imported.set_aside["reason"].iloc[0]


def test_repeated_rows_are_noticed():
    table = groups()
    imported = po.import_collisions(pd.concat([table, table.iloc[:2]]))
    assert imported.duplicates == 2
    assert "2 rows repeat others" in imported.messages()[0]


def test_simulated_tables_are_taken_as_they_are():
    runs = po.simulate_many([po.Parameters(offset=y) for y in (0.0, 0.1, 0.9)], progress=False)
    imported = po.import_collisions(runs)
    assert len(imported.table) == 2
    assert imported.reasons() == {"rejected: no contact: the droplet never touched the obstacle": 1}
    assert imported.table["symmetry"].tolist() == runs["symmetry"].tolist()[:2]
    assert imported.table["daughter_area_ratio"].notna().sum() == runs["broke"].sum()


@pytest.mark.parametrize(
    ("argument", "change", "words"),
    [
        ("symmetry", {"columns": {"symmetry": "S_mes"}}, "did you mean 'S_meas'"),
        ("symetry", {"columns": {"symetry": "S_meas"}}, "did you mean 'symmetry'"),
        ("unit of speed", {"units": {"speed": "um"}}, "write it like mm/s"),
        ("unit of speed", {"units": {"obstacle_radius": "um"}}, "say speed=mm/s"),
        ("neck", {"units": {"neck": "um"}}, "say which column it is"),
        ("viscosity", {"constants": {"viscosity": "48 cSt"}}, "dynamic viscosity"),
        ("viscosity", {"constants": {"viscosity": "-48 mPa s"}}, "positive"),
        ("thickness", {"constants": {"thickness": "85 um"}}, "given once"),
        ("capillary_number", {"constants": {"viscosity": "48 mPa s"}}, "no surface_tension"),
        ("colour", {"constants": {"colour": "1"}}, "quantity"),
        ("broke", {"columns": {**HOW["columns"], "broke": None}}, "say which one: broke=COLUMN"),
    ],
)
def test_what_is_said_wrongly_is_refused(physical, refused, argument, change, words):
    how = {key: dict(value) for key, value in HOW.items()}
    for key, value in change.items():
        how[key] = (
            value
            if argument in ("broke", "capillary_number", "unit of speed")
            else (how[key] | value)
        )
    error = refused(argument, po.import_collisions, physical, **how)
    assert words in str(error)


def test_columns_without_numbers_are_refused(refused):
    error = refused("symmetry", po.import_collisions, groups(symmetry=list("abcdef")))
    assert "'a' in the column 'symmetry'" in error.got


def test_a_column_that_the_law_needs_is_named(refused):
    error = refused(
        "normalized_thickness", po.import_collisions, groups().drop(columns="normalized_thickness")
    )
    assert "thickness, obstacle_radius" in error.rule


def test_a_bare_column_must_say_its_unit(refused):
    error = refused("unit of area", po.import_collisions, groups(area=1.0))
    assert "say area=um^2" in error.advice


@pytest.mark.parametrize(
    "write",
    [
        lambda table, path: table.to_csv(path.with_suffix(".csv"), index=False),
        lambda table, path: table.to_csv(path.with_suffix(".tsv"), index=False, sep="\t"),
        lambda table, path: table.to_csv(
            path.with_suffix(".csv"), index=False, sep=";", decimal=","
        ),
        lambda table, path: table.to_excel(path.with_suffix(".xlsx"), index=False),
        lambda table, path: table.to_parquet(path.with_suffix(".parquet")),
    ],
    ids=["csv", "tsv", "csv with decimal commas", "xlsx", "parquet"],
)
def test_files_of_all_kinds(tmp_path, write):
    table = groups()
    write(table, tmp_path / "table")
    (path,) = tmp_path.iterdir()
    read = po.import_collisions(path).table
    assert read["capillary_number"].to_numpy() == pytest.approx(
        table["capillary_number"].to_numpy()
    )
    assert read["broke"].tolist() == table["broke"].tolist()
    assert read["source"].unique().tolist() == [path.name]


def test_text_with_remarks_and_a_byte_order_mark(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(
        "﻿# measured in spring\n\n# by hand\nsymmetry, broke\n0.5, yes\n0.6, no\n", "utf-8"
    )
    assert read_table(path)["symmetry"].tolist() == [0.5, 0.6]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("missing.csv", None),
        ("empty.csv", b""),
        ("head.csv", b"symmetry,broke\n"),
        ("binary.csv", bytes(range(256)) * 10),
        ("no.parquet", b"not parquet"),
        ("no.xlsx", b"not a spreadsheet"),
        ("ragged.csv", b"a,b\n1,2,3\n4,5,6,7\n"),
    ],
)
def test_unreadable_files_are_refused(tmp_path, refused, name, content):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    refused(str(path), po.import_collisions, path)


def test_other_things_are_refused(refused):
    refused("table", po.import_collisions, [1, 2])
    refused("table", po.import_collisions, pd.DataFrame())


# Any table


CELLS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(0, 2),
    st.sampled_from([None, "", "yes", "no", "broke", "0.5", "1", True, False, "x"]),
)
NUMBERS = st.one_of(st.floats(1e-3, 2), st.floats(1e-3, 2), st.just(float("nan")))


@st.composite
def tables(draw):
    """A table with what a fit needs; one column may hold anything."""
    count = draw(st.integers(1, 12))
    names = ["symmetry", "capillary_number", "normalized_area", "normalized_thickness"]
    columns = {name: draw(st.lists(NUMBERS, min_size=count, max_size=count)) for name in names}
    outcomes = st.sampled_from([True, False])
    columns["broke"] = draw(st.lists(outcomes, min_size=count, max_size=count))
    strange = draw(st.sampled_from([*columns, "neck_um", "accepted"]))
    columns[strange] = draw(st.lists(CELLS, min_size=count, max_size=count))
    return pd.DataFrame({name: pd.Series(values) for name, values in columns.items()})


@settings(max_examples=150, deadline=None, derandomize=True)
@given(tables())
def test_every_row_of_any_table_is_kept_or_set_aside_once(table):
    """And what is kept is possible, has an outcome and a breakup number."""
    try:
        found = po.import_collisions(table)
    except po.InputError:
        return
    rows = [*found.table["collision_id"] + 1, *found.set_aside["row"]]
    assert sorted(rows) == list(range(1, len(table) + 1))
    assert found.table["symmetry"].between(0, 1).all()
    assert found.table["broke"].notna().all()
    assert found.table["breakup_number"].notna().all()
