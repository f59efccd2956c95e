"""Events are found at the very step, and neither sampling nor threads change a result."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff import _core

BREAKING = {"offset": 0.02, "simulation_capillary_number": 40.0}
TWICE = {"offset": 0.01, "simulation_capillary_number": 200.0, "size_ratio": 4.0}
SLIPPING = {"offset": 0.05, "simulation_capillary_number": 20.0}
AT_CONTACT = (
    "symmetry",
    "impact_parameter",
    "contact_time",
    "contact_speed",
    "contact_area",
    "contact_shape_parameter",
)
AT_BREAKUP = ("small_daughter_area", "large_daughter_area", "breakup_time", "breakup_neck")


@pytest.mark.parametrize("constants", [BREAKING, SLIPPING, TWICE])
def test_looking_at_every_step_finds_the_same_events(model, run, constants):
    """A run that is looked at after each step gives the numbers of one that skips most looks.

    The steps are the same, so nothing but the round-off of other loops may differ; only what is
    sampled on the way, the thinnest neck and the largest shape, may be missed: by what a chord
    can lose and win back between two samples 0.01 t0 apart, at relative speeds of order v_f∞.
    """
    row = model(**constants)
    every = row.copy()
    every[_core.MODEL_FIELDS.index("sample_interval")] = row[_core.MODEL_FIELDS.index("time_step")]
    usual, looked = run([row, every])
    assert looked["outcome"] == usual["outcome"]
    for name in (*AT_CONTACT, *AT_BREAKUP, "breakup_count", "generations"):
        assert looked[name] == pytest.approx(usual[name], rel=1e-9, nan_ok=True), name
    assert looked["minimum_neck"] <= usual["minimum_neck"] * (1 + 1e-9)
    assert usual["minimum_neck"] == pytest.approx(looked["minimum_neck"], abs=0.01)
    assert usual["maximum_shape_parameter"] == pytest.approx(
        looked["maximum_shape_parameter"], rel=0.01
    )


@pytest.mark.parametrize("drag_rate", [1.0, 30.0])
def test_block_that_speeds_up_does_not_run_past_an_event(model, system, drag_rate):
    """A droplet at rest just off the obstacle: its speed at first says nothing about the block.

    With samples 1 t0 apart the first blocks are far too long; they must be undone and halved.
    """
    times = []
    for interval in (1.0, 1e-9):
        row = model(
            line_tension=1.0,
            simulation_capillary_number=drag_rate,
            core={"sample_interval": interval},
        )
        start = [-(row[0] + 0.5 + 0.06), 0.02, 1.0]
        one = system(row, _core.UniformFlow(2.0, 0.0), None, [start])
        while not one.contacts() and not one.finished:
            one.advance(one.time + 0.01)
        (contact,) = one.contacts()
        times.append((contact["time"], contact["symmetry"], contact["speed"]))
    assert times[0][0] > 0
    assert times[0] == pytest.approx(times[1], rel=1e-9)


def test_contact_is_the_first_step_at_which_a_vertex_feels_the_wall(model, system):
    """One step before no vertex is within l_eq/2 of the obstacle, at contact one is.

    What is measured there is that of the outline of that step. Its velocities are those with which
    it arrives: the wall's push, which depends on how far into its range the step happened to end,
    does not belong to them. (With half a step of that push S errs by up to 2 % at the automatic
    step, without it by 0.04 %.)
    """
    row = model(**BREAKING)
    step = row[_core.MODEL_FIELDS.index("time_step")]
    row[_core.MODEL_FIELDS.index("sample_interval")] = step
    usual = system(model(**BREAKING))
    usual.advance(3.0)
    time = usual.contacts()[0]["time"]
    one = system(row)
    reach = np.sqrt(np.pi * np.tan(np.pi / 64) / 64) / 2
    gaps = []
    for at in (time - step, time):
        one.advance(at)
        assert one.time == pytest.approx(at, rel=1e-12)
        gaps.append(np.hypot(*one.outlines()[0][2].T).min() - row[0] - reach)
    assert gaps[0] > 0 > gaps[1]
    contact = usual.contacts()[0]
    _, _, outline, velocity = one.outlines()[0]
    mean = velocity.mean(axis=0)
    assert contact["speed"] == pytest.approx(np.hypot(*mean), rel=1e-9)
    assert contact["symmetry"] == pytest.approx(
        _core.symmetry(outline, (0.0, 0.0), tuple(mean)), abs=1e-9
    )
    assert contact["impact_parameter"] == pytest.approx(
        _core.impact_parameter(outline, (0.0, 0.0), tuple(mean)), abs=1e-9
    )
    assert contact["area"] == pytest.approx(_core.area(outline), rel=1e-9)
    assert contact["shape_parameter"] == pytest.approx(_core.shape_parameter(outline), rel=1e-9)
    assert (contact["x"], contact["y"]) == pytest.approx(_core.centroid(outline), abs=1e-9)
    assert (contact["centroid_velocity_x"], contact["centroid_velocity_y"]) == pytest.approx(
        _core.centroid_velocity(outline, velocity), abs=1e-9
    )


@pytest.mark.parametrize("unit", ["perimeter", "diameter"])
def test_neck_breaks_at_the_first_step_below_the_threshold(model, system, unit):
    """Brute force over the outline of every step: above the threshold until the cut, then below."""
    constants = {**BREAKING, "neck_separation_unit": unit, "follow_daughters": False}
    row = model(**constants)
    usual = system(row)
    usual.advance(1e9)
    (breakup,) = usual.breakups()
    row[_core.MODEL_FIELDS.index("sample_interval")] = row[_core.MODEL_FIELDS.index("time_step")]
    one, necks = system(row), []
    one.advance(breakup["time"] - 0.05)
    while not one.finished:
        (_, _, outline, _), *_ = one.outlines()
        necks.append((one.time, _core.neck(outline, 0.28, unit == "diameter")[0]))
        one.advance(one.time + 0.5 * row[_core.MODEL_FIELDS.index("time_step")])
    *before, last = necks
    assert min(thickness for _, thickness in before) >= 0.167
    assert last[1] < 0.167
    assert breakup["time"] == pytest.approx(last[0], rel=1e-12)
    assert breakup["neck_thickness"] == pytest.approx(last[1], rel=1e-9)
    assert breakup["neck_thickness"] > 0.167 * 0.99  # a step later it would have been thinner


@pytest.mark.parametrize("constants", [BREAKING, TWICE])
def test_stopping_at_the_breakup_gives_the_same_breakup(model, run, constants):
    """Not following the daughters changes nothing up to the break-up."""
    follow, stop = run([model(**constants), model(**constants, follow_daughters=False)])
    for name in (*AT_CONTACT, *AT_BREAKUP, "minimum_neck", "maximum_shape_parameter"):
        assert stop[name] == follow[name], name
    assert stop["outcome"] == follow["outcome"] == 1
    assert stop["breakup_count"] == 1
    assert stop["end_time"] == stop["breakup_time"] < follow["end_time"]


def test_results_do_not_depend_on_the_number_of_threads(any_collisions):
    """Rows on 1 and on 4 threads are equal to the last bit, in the order of the models."""
    rows = any_collisions(np.random.default_rng(1), 60)
    one, four = (_core.run_many(rows, None, n, None) for n in (1, 4))
    np.testing.assert_array_equal(one, four)
    again = _core.run_many(np.array(rows[::-1]), None, 2, None)[::-1]
    np.testing.assert_array_equal(one, again)
    assert {0.0, 1.0} <= set(one[:, 0])


def test_advancing_in_pieces_gives_the_same_run(model, system, result):
    """However a run is cut into pieces and looked at in between, the result is the same."""
    row = model(**BREAKING)
    whole, pieces = system(row), system(row)
    whole.advance(1e9)
    while not pieces.finished:
        pieces.advance(pieces.time + 0.013)
        pieces.outlines()
        pieces.energies()
    np.testing.assert_equal(result(pieces), result(whole))
