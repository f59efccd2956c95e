"""Parameters refuse what is wrong, say so in one form, and keep what is right."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pinchoff as po
from pinchoff import _core
from pinchoff.collisions.schema import Column
from pinchoff.model.entry import documented, entries_of, parameter
from pinchoff.model.parameters import (
    CORE_CONSTANTS,
    PARAMETERS,
    core_numbers,
)
from pinchoff.model.run_table import varied_columns
from pinchoff.support.checked import Number

NUMBERS = tuple(name for name, entry in PARAMETERS.items() if entry.kind in ("float", "int"))
HUGE = pytest.param(10**400, id="huge")


# Single values


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e300, -1e300, HUGE])
def test_number_without_sense_is_refused_by_name(refused, name, value):
    refused(name, po.Parameters, **{name: value})


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [True, "wide", [1.0], {}, 1j, b"\xff"])
def test_what_is_no_number_is_refused_by_name(refused, name, value):
    refused(name, po.Parameters, **{name: value})


@pytest.mark.parametrize(
    ("name", "inside", "outside"),
    [
        ("size_ratio", 0.5, 0.0),
        ("size_ratio", 100, 101),
        ("simulation_capillary_number", 1e-3, 0.0),
        ("offset", -5, -5.01),
        ("vertex_count", 16, 15),
        ("vertex_count", 1024, 1025),
        ("vertex_count", 64, 64.5),
        ("line_tension", 20, -20),
        ("edge_stiffness", 1e-6, 0),
        ("area_stiffness", 1e4, -1),
        ("wall_stiffness", 100, 0),
        ("start_distance", 0.93, 0.92),  # 1/5.66 + 0.75 = 0.9267
        ("time_step", 1e-4, 0),
        ("time_step", "auto", "fast"),
        ("time_limit", 1, 0),
        ("neck_thickness", 0, -0.1),
        ("neck_separation", 0.49, 0.5),
        ("neck_separation_unit", "diameter", "radius"),
        ("follow_daughters", False, "perhaps"),
    ],
)
def test_range_ends_where_it_says(refused, name, inside, outside):
    size = {"start_distance": 10.0} if name == "size_ratio" else {}
    assert getattr(po.Parameters(**size, **{name: inside}), name) == inside
    error = refused(name, po.Parameters, **size, **{name: outside})
    assert error.got == repr(outside) or float(error.got) == outside


def test_longest_separation_depends_on_its_unit(refused):
    po.Parameters(neck_separation=0.6, neck_separation_unit="diameter")
    refused("neck_separation", po.Parameters, neck_separation=0.6)


def test_neck_is_no_side_of_a_resting_droplet(refused):
    """Arcs shorter than three edges, and chords of the undeformed circle, are no necks."""
    fraction = {"vertex_count": 30, "neck_thickness": 0.0}
    po.Parameters(neck_separation=0.1, **fraction)
    assert (
        "3/vertex_count"
        in refused("neck_separation", po.Parameters, neck_separation=0.099, **fraction).rule
    )
    for unit, separation, chord in (
        ("perimeter", 0.28, math.sin(0.28 * math.pi)),
        ("diameter", 0.28, math.sin(0.28)),
    ):
        neck = {"neck_separation": separation, "neck_separation_unit": unit}
        po.Parameters(neck_thickness=0.999 * chord, **neck)
        refused("neck_thickness", po.Parameters, neck_thickness=1.001 * chord, **neck)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("size_ration", "size_ratio"),
        ("capillary_number", "simulation_capillary_number"),
        ("vertexcount", "vertex_count"),
        ("neck_seperation", "neck_separation"),
        ("Offset", "offset"),
    ],
)
def test_misspelt_name_suggests_the_nearest(refused, wrong, right):
    assert f"'{right}'" in refused(wrong, po.Parameters, **{wrong: 1.0}).advice


def test_foreign_name_lists_the_known(refused):
    assert "vertex_count" in refused("zzz", po.Parameters, zzz=1).advice


def test_numpy_numbers_are_numbers():
    p = po.Parameters(offset=np.float32(0.25), vertex_count=np.int64(48), line_tension=np.int8(60))
    assert p == po.Parameters(offset=0.25, vertex_count=48, line_tension=60)


def test_none_is_the_default():
    assert po.Parameters(offset=None, area_stiffness=None, scale=None) == po.Parameters()


def test_input_error_is_a_value_error_and_survives_pickling(refused):
    error = refused("offset", po.Parameters, offset=99)
    copy = pickle.loads(pickle.dumps(error))
    assert isinstance(copy, ValueError)
    assert (str(copy), copy.argument, copy.exit_code) == (str(error), "offset", 2)


# The object


def test_stiffnesses_follow_the_line_tension_until_given():
    p = po.Parameters(line_tension=40)
    assert (p.area_stiffness, p.wall_stiffness) == (2e5, 50)
    assert p.replace(line_tension=20).area_stiffness == 1e5
    assert p.replace(area_stiffness=3e5).replace(line_tension=20).area_stiffness == 3e5
    assert p.replace(area_stiffness=3e5).replace(area_stiffness=None) == p


def test_groups():
    p = po.Parameters(size_ratio=4, simulation_capillary_number=30, line_tension=50)
    assert p.obstacle_radius == 0.25
    assert p.capillary_number == pytest.approx(30 * 9.8e-5, rel=1e-15)
    assert p.normalized_area == pytest.approx(4 * math.pi, rel=1e-15)
    assert p.normalized_thickness == 1
    assert p.drag == 1500


def test_parameters_stay_as_made(refused):
    p = po.Parameters()
    refused("offset", setattr, p, "offset", 0.5)
    assert p.offset == po.Parameters().offset
    refused("offset", p.replace, offset=math.nan)
    refused("offset", p.model_copy, update={"offset": math.nan})


def test_parameters_survive_pickling_and_hash():
    p = po.Parameters(offset=0.3, scale=None)
    copy = pickle.loads(pickle.dumps(p))
    assert copy == p
    assert hash(copy) == hash(p)
    assert copy.replace(line_tension=20).area_stiffness == 1e5


def test_model_row_holds_every_field_in_the_core_s_units():
    p = po.Parameters(
        size_ratio=4,
        simulation_capillary_number=30,
        line_tension=50,
        edge_stiffness=2,
        neck_separation=0.3,
        neck_separation_unit="diameter",
        follow_daughters=False,
        time_step=1e-5,
    )
    row = dict(zip(_core.MODEL_FIELDS, p.model_row(), strict=True))
    assert np.isfinite(p.model_row()).all()
    assert row["obstacle_radius"] == 0.25
    assert row["drag"] == 1500
    assert row["edge_stiffness"] == 100  # k_l = k̃_l γ_2D/D0
    assert row["area_stiffness"] == 250000
    assert row["wall_stiffness"] == 62.5
    assert row["neck_separation_in_diameters"] == 1
    assert row["stop_at_breakup"] == 1
    assert row["time_step"] == 1e-5


def test_unstable_time_step_is_refused_with_the_limit(refused):
    p = po.Parameters()
    error = refused("time_step", p.replace(time_step=0.1).model_row)
    limit = float(error.rule.split()[2].rstrip(","))
    assert p.effective_time_step < limit
    p.replace(time_step=0.99 * limit).model_row()
    refused("time_step", p.replace(time_step=1.01 * limit).model_row)


def test_automatic_time_step_shrinks_with_stiffness():
    p = po.Parameters()
    assert p.replace(area_stiffness=100 * p.area_stiffness).effective_time_step < (
        p.effective_time_step
    )
    assert p.replace(time_step=1e-5).effective_time_step == 1e-5


# One entry a parameter


def test_every_parameter_is_an_entry_with_a_place_in_the_core_s_row():
    assert {*PARAMETERS, "scale"} == {*po.Parameters.model_fields}
    places = {entry.place for entry in PARAMETERS.values() if entry.in_core}
    assert places | {*CORE_CONSTANTS} == {*_core.MODEL_FIELDS}
    for name, entry in PARAMETERS.items():
        assert f"    {name} : {entry.kind}\n" in po.Parameters.__doc__
        assert entry.advice in refused_by_name(name)


def refused_by_name(name):
    with pytest.raises(po.InputError) as caught:
        po.Parameters(**{name: object()})
    return str(caught.value)


def test_an_entry_says_all_there_is_of_a_parameter():
    class Tilted(po.Parameters):
        tilt: Number = parameter(
            0.5, "the slope", symbol="g", unit="v_f∞²/D0", low=-2, high=2, column="slope"
        )

    entry = entries_of(Tilted)["tilt"]
    assert entry.as_column() == Column("slope", "v_f∞²/D0", "float64", "the slope")
    assert (entry.place, entry.core_value(Tilted(tilt=1))) == ("tilt", 1.0)
    shown = documented("    **values\n        Any.\n", {"tilt": entry})
    assert shown.split("\n", 1)[0] == "    tilt : float"
    assert "number from -2 to 2, by default 0.5" in shown
    with pytest.raises(po.InputError) as caught:
        Tilted(tilt=3)
    assert str(caught.value) == (
        "tilt must be a finite number from -2 to 2; got 3; give the slope, g, in v_f∞²/D0, or "
        "leave it out for 0.5"
    )


def test_an_entry_without_a_place_in_the_core_s_row_is_refused(monkeypatch):
    """It must not be dropped without a word."""
    with monkeypatch.context() as changed:
        lost = replace(PARAMETERS["offset"], name="tilt")
        changed.setitem(PARAMETERS, "tilt", lost)
        core_numbers.cache_clear()
        with pytest.raises(RuntimeError, match="got tilt in one of them alone"):
            po.Parameters().model_row()
    core_numbers.cache_clear()


def test_columns_of_varied_parameters_are_those_that_a_table_does_not_show_anyway():
    found = varied_columns(["offset", "neck_thickness", "vertex_count", "speed", "time_step"])
    assert {name: column.name for name, column in found.items()} == {
        "neck_thickness": "neck_thickness_limit",
        "vertex_count": "vertex_count",
        "time_step": "time_step",
    }
    kinds = {column.name: column.dtype for column in varied_columns(PARAMETERS).values()}
    assert kinds["vertex_count"] == "int64"
    assert kinds["follow_daughters"] == "bool"
    assert kinds["neck_separation_unit"] == "str"
    assert kinds["line_tension"] == "float64"


# Any values


SCHEMA = po.Parameters.model_json_schema()["properties"]


def number_of(name):
    """Numbers within the limits of a parameter, at them, and one beyond."""
    kinds = SCHEMA[name].get("anyOf", [SCHEMA[name]])  # a number, or null in the other model
    low, high = kinds[0]["minimum"], kinds[0]["maximum"]
    inside = st.floats(low, high) if PARAMETERS[name].kind == "float" else st.integers(low, high)
    return st.one_of(inside, inside, inside, st.just(low), st.just(high), st.just(2 * high + 1))


LIMITED = [name for name in NUMBERS if name != "time_step"]
VALUES = st.fixed_dictionaries(
    {},
    optional={
        **{name: number_of(name) for name in LIMITED},
        "model": st.sampled_from(["deformable-particle", "front-tracking", "fluid"]),
        "neck_separation_unit": st.sampled_from(["perimeter", "diameter", "metre"]),
        "follow_daughters": st.booleans(),
    },
)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(VALUES)
def test_any_values_are_refused_in_one_form_or_kept_as_they_are(values):
    """What is accepted comes back equal from a dump, a pickle and a copy, and makes a whole row."""
    error = None
    try:
        p = po.Parameters(**values)
    except po.InputError as refusal:
        error = refusal
    if error:
        assert error.argument in {*values, "start_distance", "neck_separation", "neck_thickness"}
        pieces = (error.argument, error.rule, error.got, error.advice)
        assert str(error) == "{} must be {}; got {}; {}".format(*pieces)
        return
    assert {name: getattr(p, name) for name in values} == values
    dumped = {name: value for name, value in p.model_dump(mode="json").items() if name != "scale"}
    assert po.Parameters.from_config(dumped) == p
    assert pickle.loads(pickle.dumps(p)) == p == p.replace()
    row = p.model_row()
    assert np.isfinite(row).all()
    assert row[_core.MODEL_FIELDS.index("obstacle_radius")] == 1 / p.size_ratio


def test_the_defaults_are_these():
    assert po.Parameters().model_dump() == {
        "model": "deformable-particle",
        "size_ratio": 5.66,
        "simulation_capillary_number": 25.0,
        "offset": 0.05,
        "vertex_count": 64,
        "line_tension": 80.0,
        "edge_stiffness": 3.0,
        "area_stiffness": 400000.0,
        "wall_stiffness": 100.0,
        "contact_angle": 180.0,
        "start_distance": 5.0,
        "time_step": "auto",
        "time_limit": 30.0,
        "neck_thickness": 0.167,
        "neck_thickness_unit": "diameter",
        "neck_separation": 0.28,
        "neck_separation_unit": "perimeter",
        "follow_daughters": True,
        "ca_conversion": "constant",
        "conversion_constant": 9.8e-5,
        "ca_speed": "far",
        "scale": None,
    }
