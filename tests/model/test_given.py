"""What simulate_many takes, which columns it gives, and what is read back of a run."""

from __future__ import annotations

import json
import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.model.collision_report import collision_report

SEVERAL = [po.Parameters(offset=y, line_tension=g) for y in (0.0, 0.2) for g in (40.0, 80.0)]


def assert_same(one, other):
    pd.testing.assert_frame_equal(one, other)
    assert one.attrs == other.attrs


@pytest.fixture(scope="module")
def table():
    return po.simulate_many(SEVERAL)


@pytest.mark.parametrize(
    "given",
    [
        {"offset": [0, 0.2], "line_tension": np.array([40, 80])},
        {"offset": pd.Series([0, 0.2]), "line_tension": (40, 80), "size_ratio": 5.66},
        [{"offset": y, "line_tension": g} for y in (0, 0.2) for g in (40, 80)],
        pd.DataFrame({"offset": [0, 0, 0.2, 0.2], "line_tension": [40, math.nan, 40, 80]}),
        [{"offset": 0, "line_tension": 40}, *SEVERAL[1:]],
    ],
    ids=["grid", "grid with a constant", "dicts", "table", "both"],
)
def test_every_form_gives_the_same(table, given):
    assert_same(po.simulate_many(given), table)


def test_a_varied_parameter_is_a_column_and_others_are_not(table):
    assert table["line_tension"].tolist() == [40, 80, 40, 80]
    assert table.attrs["units"]["line_tension"] == "M v_f∞²/D0"
    assert "edge_stiffness" not in table
    assert "area_stiffness" not in table  # follows from the line tension
    models = po.simulate_many({"model": ["deformable-particle", "front-tracking"]})
    assert models["model"].tolist() == ["deformable-particle", "front-tracking"]


def test_unknown_or_wrong_is_refused_by_its_place(refused):
    refused("parameters", po.simulate_many, {"ofset": [0, 1]})
    refused("parameters[1].ofset", po.simulate_many, [{"offset": 0}, {"ofset": 0}])
    refused("parameters[0].offset", po.simulate_many, [{"offset": "high"}])
    refused("parameters", po.simulate_many, "offset")
    refused("outlines", po.simulate_many, SEVERAL[:1], outlines=[1])
    refused("outlines", po.simulate_many, SEVERAL[:1], outlines="all")


def test_outlines_of_some_rows():
    table = po.simulate_many(SEVERAL, outlines=[2])
    assert [found is not None for found in table["outlines"]] == [False, False, True, False]
    alone = po.simulate(SEVERAL[2], outlines=True).outlines
    np.testing.assert_array_equal(table["outlines"][2].vertices, alone.vertices)
    assert po.simulate_many(SEVERAL[:2], outlines=True)["outlines"].notna().all()


def test_a_table_without_columns_of_the_laboratory_is_read_as_before(table, tmp_path):
    table.to_csv(tmp_path / "runs.csv", index=False)
    taken = po.import_collisions(tmp_path / "runs.csv").table
    assert taken["symmetry"].tolist() == pytest.approx(table["symmetry"].tolist())


@pytest.mark.parametrize("outlines", [True, False])
def test_a_run_is_read_back(tmp_path, experiment, outlines):
    run = po.simulate(po.Parameters.from_physical(**experiment), outlines=outlines)
    text = json.dumps(collision_report(run, "default"), allow_nan=False)
    (tmp_path / "collision.json").write_text(text, encoding="utf-8")
    if outlines:
        run.outlines.save(tmp_path / "outlines.gsd")
    for place in (tmp_path, tmp_path / "collision.json"):
        read = po.Collision.load(place)
        assert read.parameters == run.parameters
        assert read.to_dict() == run.to_dict()
        assert pd.Series(read.to_row()).equals(pd.Series(run.to_row()))
        assert (read.outlines is not None) == outlines


def test_no_run_is_refused(refused, tmp_path):
    missing = tmp_path / "collision.json"
    refused(str(missing), po.Collision.load, tmp_path)
    missing.write_text('{"results": 3}', encoding="utf-8")
    refused(str(missing), po.Collision.load, missing)


def test_units_are_those_of_the_laboratory(experiment):
    run = po.simulate(po.Parameters.from_physical(**experiment))
    found = run.in_units()
    assert found["contact_time_s"] == pytest.approx(run.contact_time * 0.481) == run.contact_time_s
    assert found["minimum_neck_um"] == pytest.approx(run.minimum_neck * 481)
    assert found["contact_area_um2"] == pytest.approx(run.contact_area * 481**2)
    with pytest.raises(po.InputError, match="from_physical"):
        po.simulate(po.Parameters()).in_units()


def test_help_and_completion_show_what_a_user_may_call():
    import inspect

    text = str(inspect.signature(po.Parameters))
    assert "offset=0.05" in text
    assert "Annotated" not in text
    names = [name for name in dir(po.Parameters()) if not name.startswith("_")]
    assert "replace" in names
    assert not [name for name in names if name.startswith("model_") and name != "model_row"]
