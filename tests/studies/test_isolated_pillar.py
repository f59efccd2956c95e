"""The line of a pillar alone: what an array's contacts are compared with."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.law import breakup_number
from pinchoff.studies.emulsion_contacts import contact_outcomes, contact_table
from pinchoff.studies.isolated_pillar import isolated_pillar, relative_breakup_number

P = po.Parameters(
    model="front-tracking", simulation_capillary_number=60, vertex_count=48, time_limit=40
)


@pytest.fixture(scope="module")
def line():
    return isolated_pillar(P, 0.3, 0.5, np.array([0.8, 1.0, 1.3]))


def test_droplets_break_on_either_side_of_the_line_in_the_engine(line):
    """The line is in units of the droplet: runs in those of D0 must agree."""
    radius, diameter = 0.3, 1.3
    row = line[line["diameter"] == diameter].iloc[0]
    flow = po.flow.brinkman(radius, 0.5)
    runs = [
        po.simulate(P, flow=flow, obstacles=[[0, 0, radius]], droplets=[[-2.5, y, diameter]])
        for y in np.linspace(0.2, 0.5, 13)
    ]
    for run in runs:
        if abs(run.symmetry - row["symmetry"]) > 0.03:
            assert (run.outcome == "broke") == (run.symmetry > row["symmetry"])
    assert {run.outcome for run in runs} == {"broke", "slipped"}


def test_bk_on_the_line_is_that_of_the_contact(line):
    row = line.iloc[1]
    expected = breakup_number(
        9.8e-5 * 60 * row["speed"], normalized_area=math.pi / 4 / 0.09, symmetry=row["symmetry"]
    )
    assert row["breakup_number"] == pytest.approx(float(expected))


def test_a_faster_fluid_is_a_larger_capillary_number(line):
    fast = isolated_pillar(P.replace(simulation_capillary_number=30), 0.3, 0.5, [1.0], speed=2.0)
    slow = line[line["diameter"] == 1.0].iloc[0]
    assert fast["symmetry"].iloc[0] == pytest.approx(slow["symmetry"])
    assert fast["speed"].iloc[0] == pytest.approx(2 * slow["speed"])
    assert fast["breakup_number"].iloc[0] == pytest.approx(slow["breakup_number"])


def test_plane_stokes_flow_has_no_pillar_alone(refused):
    refused("thickness", isolated_pillar, P, 0.3, math.inf, [1.0])


def test_bk_is_relative_to_the_line_of_its_diameter(line):
    contacts = pd.DataFrame(
        {"diameter": [0.8, 1.3, 1.0, 0.5], "breakup_number": [1.0, 1.0, 2.0, 1.0]}
    )
    found = relative_breakup_number(contacts, line)
    assert found[:2] == pytest.approx(1 / line["breakup_number"].to_numpy()[[0, 2]])
    assert found[2] == pytest.approx(2 / line["breakup_number"].iloc[1])
    assert math.isnan(found[3])  # outside the diameters
    np.testing.assert_array_equal(relative_breakup_number(contacts, line[::-1]), found)
    unknown = line.assign(breakup_number=math.nan)
    assert np.isnan(relative_breakup_number(contacts, unknown)).all()


@pytest.fixture
def events():
    names = {"symmetry": 0.5, "speed": 0.8, "area": 0.7, "impact_parameter": 0.1}
    return pd.DataFrame(
        [
            {"kind": "contact", "time": 1.0, "droplet_id": 0, "obstacle": 1, **names},
            {"kind": "contact", "time": 9.0, "droplet_id": 1, "obstacle": 0, **names},
            {"kind": "breakup", "time": 2.0, "droplet_id": 0, "x": 2.0, "y": 0.5},
        ]
    )


def tabled(events, parameters):
    circles = np.array([[0.0, 0.0, 0.3], [2.0, 0.0, 0.4]])
    return contact_table(events, contact_outcomes(events, circles, parameters, 10.0), parameters)


def test_contacts_become_collisions_that_can_be_fitted(events):
    table = tabled(events, P)
    assert table["accepted"].tolist() == [True, False]
    assert table["broke"].tolist() == [True, False]
    assert table["normalized_area"].tolist() == pytest.approx([0.7 / 0.16, 0.7 / 0.09])
    assert table["capillary_number"].tolist() == pytest.approx([9.8e-5 * 60 * 0.8] * 2)
    assert table["ca_speed"].tolist() == ["contact"] * 2
    assert table["breakup_number"].tolist() == pytest.approx(
        breakup_number(
            table["capillary_number"],
            normalized_area=table["normalized_area"],
            symmetry=table["symmetry"],
        ).tolist()
    )


def test_contacts_take_what_ca_stands_for_from_the_parameters(events, line):
    twice = P.replace(conversion_constant=2 * 9.8e-5)
    table, usual = tabled(events, twice), tabled(events, P)
    assert table["ca_per_ca_sim"].tolist() == [2 * 9.8e-5] * 2
    assert table["capillary_number"].tolist() == (2 * usual["capillary_number"]).tolist()
    assert (table["breakup_number"] > usual["breakup_number"]).all()
    (number,) = isolated_pillar(twice, 0.3, 0.5, np.array([1.0]))["breakup_number"]
    assert number > line["breakup_number"].iloc[1]  # and so does the line beside them


def test_contacts_have_lengths_and_speeds_in_the_units_of_the_experiment(events):
    experiment = po.Parameters.from_physical(
        diameter="400 um",
        obstacle_radius="85 um",
        speed="2 mm/s",
        viscosity="48 mPa s",
        surface_tension="20 mN/m",
        thickness="85 um",
    )
    table = tabled(events, experiment)
    assert table["obstacle_radius_um"].tolist() == pytest.approx([0.4 * 400, 0.3 * 400])
    assert table["area_um2"].tolist() == pytest.approx([0.7 * 400**2] * 2)
    assert table["speed_mm_s"].tolist() == pytest.approx([1.6] * 2)
    assert table["capillary_number"].tolist() == pytest.approx([48e-3 * 1.6e-3 / 20e-3] * 2)
