"""How results are read: Ca's conversion and speed, necks in z, springs against line tension."""

from __future__ import annotations

import math

import pytest

import pinchoff as po
from pinchoff.model.run_table import spring_tension_ratio

PHYSICAL = {
    "diameter": "340 um",
    "obstacle_radius": "60 um",
    "speed": "1 mm/s",
    "viscosity": "48 mPa s",
    "surface_tension": "20 mN/m",
}
RUN = {"offset": 0.02, "follow_daughters": False, "time_limit": 6}


def test_the_reading_of_ca_changes_no_motion():
    plain = po.simulate(po.Parameters(**RUN)).to_row()
    film = po.simulate(
        po.Parameters(**RUN, ca_conversion="fixed-film", ca_speed="contact")
    ).to_row()
    changed = {name for name in plain if plain[name] == plain[name] and plain[name] != film[name]}
    assert changed == {"capillary_number", "ca_per_ca_sim", "ca_speed", "breakup_number"}
    assert film["capillary_number"] == pytest.approx(
        9.8e-5 * (481 / (5.66 * 85)) ** 2 * 25 * film["contact_speed"], rel=1e-12
    )
    assert (plain["ca_speed"], film["ca_speed"]) == ("far", "contact")


def test_a_fixed_film_goes_by_the_diameter_in_micrometres():
    p = po.Parameters.from_physical(**PHYSICAL, thickness="60 um", ca_conversion="fixed-film")
    assert p.ca_per_ca_sim == pytest.approx(9.8e-5 * (481 / 340) ** 2)
    assert p.capillary_number == pytest.approx(48e-3 * 1e-3 / 20e-3)
    assert p.simulation_capillary_number == pytest.approx(2.4e-3 / p.ca_per_ca_sim)


def test_boundary_and_fit_follow_the_reading():
    vary = {"simulation_capillary_number": [20, 32, 50]}
    own = po.boundary(po.Parameters(ca_speed="contact"), vary, width=0.02, progress=False)
    far = po.boundary(po.Parameters(), vary, width=0.02, progress=False)
    assert own.fit().beta.value == pytest.approx(far.fit().beta.value)  # both by v_f∞
    contact = own.fit(speed="contact")
    assert contact.alpha.value == pytest.approx(far.fit(speed="contact").alpha.value)
    assert (own.table["control_parameter"] > far.table["control_parameter"]).all()


def test_a_neck_in_z_is_a_length():
    scale = PHYSICAL | {"thickness": "30 um"}
    p = po.Parameters.from_physical(**scale, neck_thickness=0.945, neck_thickness_unit="thickness")
    assert p.neck_threshold == pytest.approx(0.945 * 30 / 340)
    assert p.normalized_thickness == 0.5
    # z = R without a scale, and a multiple of D0 that is the same length breaks at the same neck
    thick = po.Parameters(**RUN, neck_thickness_unit="thickness", neck_thickness=0.167 * 5.66)
    plain = po.simulate(po.Parameters(**RUN))
    assert po.simulate(thick).breakup_time == pytest.approx(plain.breakup_time)


def test_spring_tension_by_hand():
    """Each of N edges of length P/N pulls with k_l N (P/N - l_eq), in units of γ."""
    p = po.Parameters(edge_stiffness=2, vertex_count=16)
    edge = math.sqrt(math.pi / 4 * 4 * math.tan(math.pi / 16) / 16)
    assert spring_tension_ratio(p, 16 * edge) == pytest.approx(0, abs=1e-12)
    assert spring_tension_ratio(p, 16 * (edge + 0.1)) == pytest.approx(2 * 16 * 0.1)


def test_springs_pull_harder_than_line_tension_and_fronts_have_none():
    springs = po.simulate(po.Parameters(**RUN))
    assert 4 < springs.spring_tension_ratio < 7
    perimeter = math.sqrt(springs.maximum_shape_parameter * 4 * math.pi * math.pi / 4)
    assert springs.spring_tension_ratio == pytest.approx(3 * (perimeter - math.pi), rel=0.02)
    front = po.simulate(po.Parameters(**RUN, model="front-tracking"))
    assert front.spring_tension_ratio == 0


def test_soft_edges_meet_the_line_better():
    """Two points of the paper's line, at D0/R = 5.66, nearer than the default's."""
    off = {}
    for name, scale in (("default", 1.0), ("soft-edges", 0.5)):
        base = po.Parameters.preset(name)
        points = {"simulation_capillary_number": [scale * ca for ca in (16, 80)]}
        found = po.boundary(base, points, width=0.01, progress=False).found
        line = 0.089 * found["control_parameter"] ** -0.72
        off[name] = abs(math.log(found["critical_symmetry"][0] / line[0])) + abs(
            math.log(found["critical_symmetry"][1] / line[1])
        )
    assert off["soft-edges"] < off["default"]
