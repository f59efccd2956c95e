"""The flow of a whole device: rates, pressures, symmetry, and the engine that takes it over."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
import shapely

from pinchoff.chamber import Chamber, check_flow, check_rules, compare_with_stokes, flow_around
from pinchoff.chamber.flow_check import narrowest_gap
from pinchoff.chamber.layout import Pillar
from pinchoff.chamber.obstacle_flow import collision_parameters, start_distance


@pytest.fixture(scope="module")
def check(small):
    return check_flow(small)


@pytest.fixture(scope="module")
def compared(check):
    return compare_with_stokes(check, capillary_numbers=[40.0, 80.0])


def test_the_small_device_keeps_the_rules(small):
    assert check_rules(small) == []


def test_what_comes_in_flows_through_every_section(check, small):
    assert check.summary["mass_error"] < 2e-3
    at = small.layout.stations
    oil, water = small.operation.oil_rate_uL_min, small.operation.water_rate_uL_h / 60
    arms = (at.water_port + at.water_trap) / 2
    half = small.inlets.port_diameter_um / 2 + small.inlets.wall_um - 1
    assert check.flow_rate_uL_min(arms, half, 1e4) == pytest.approx(oil / 2, rel=5e-3)
    assert check.flow_rate_uL_min(arms, -half, half) == pytest.approx(water, rel=5e-3)
    whole = check.flow_rate_uL_min(at.exit - 5, -1e4, 1e4)
    assert whole == pytest.approx(oil + water, rel=5e-3)


def test_the_mean_speed_is_that_of_what_flows_through_the_imaging_area(check, small):
    """Flow averaged along it over its section, corrected for the part that obstacles fill."""
    at, half = small.layout.stations, 1.5 * small.imaging.pitch_um
    sections = np.linspace(at.imaging, at.exit, 102)[1:-1]
    rates = [check.flow_rate_uL_min(x, -half, half) for x in sections]
    section_mm2 = 2 * half * small.thickness_um * 1e-6
    open_share = small.layout.regions["imaging"].area / small.layout.walls["imaging"].area
    speed = np.mean(rates) / 60 / section_mm2 / open_share  # 1 µL is 1 mm³
    assert check.imaging_speed_mm_s == pytest.approx(speed, rel=0.02)


def test_the_droplet_channel_carries_its_share_of_what_comes_in(check, small):
    at, half = small.layout.stations, small.junction.channel_width_um / 2
    central = check.flow_rate_uL_min((at.channel + at.imaging) / 2, -half, half)
    whole = small.operation.oil_rate_uL_min + small.operation.water_rate_uL_h / 60
    summary = check.summary
    assert summary["droplet_channel_share"] == pytest.approx(
        central / whole, rel=0.02
    )  # near corners
    speed = central / 60 / (2 * half * small.thickness_um * 1e-6)
    assert summary["droplet_channel_speed_mm_s"] == pytest.approx(speed)
    ratio = summary["droplet_channel_over_imaging_speed"]
    assert ratio == pytest.approx(speed / check.imaging_speed_mm_s)


def test_groups_follow_from_the_speed(check):
    speed, summary = check.imaging_speed_mm_s, check.summary
    assert summary["capillary_number"] == pytest.approx(0.048 * speed * 1e-3 / 0.020)
    reynolds = 960 * speed * 1e-3 * 85e-6 / 0.048
    assert summary["reynolds_number"] == pytest.approx(reynolds)
    table = check.table((20.0, 40.0, 60.0))
    np.testing.assert_allclose(table["speed_mm_s"], speed * np.array([0.5, 1.0, 1.5]))
    assert table["pressure_drop_Pa"].iloc[1] == pytest.approx(summary["pressure_drop_Pa"])


def test_the_pressure_falls_downstream_as_in_a_slit(check, small):
    """In the straight arm, -dp/dx = 12 μ U/z² over the width that no-slip leaves."""
    at = small.layout.stations
    y = small.inlets.port_diameter_um / 2 + small.inlets.wall_um + small.inlets.arm_width_um / 2
    ends = np.array([[at.water_port, y], [at.water_port + 600, y]])
    fall = -np.diff(check.pressure_Pa(ends))[0] / 600e-6
    width, z = small.inlets.arm_width_um * 1e-6, small.thickness_um * 1e-6
    rate = small.operation.oil_rate_uL_min / 2 * 1e-9 / 60
    k = math.sqrt(12) / z * width / 2
    slit = 12 * 0.048 * rate / (z**3 * width * (1 - math.tanh(k) / k))
    assert fall == pytest.approx(slit, rel=2e-3)
    ports = small.layout.ports
    places = np.array([[ports[n].x_um, ports[n].y_um] for n in ("oil", "water", "outlet")])
    oil, water, outlet = check.pressure_Pa(places)
    assert oil > water > outlet == 0


def test_the_flow_is_symmetric_and_still_in_the_unused_inlets(check, small):
    at = small.layout.stations
    x = np.linspace(at.expansion, at.exit, 60)
    y = np.linspace(50, small.width_um / 2, 40)
    above = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    one, other = check.velocity(above), check.velocity(above * [1, -1])
    assert np.abs(one - other * [1, -1]).max() < 0.05 * np.abs(one).max()
    port = small.layout.ports["extra_oil_left"]
    still = check.velocity(np.array([[port.x_um, port.y_um]]))
    assert np.abs(still).max() < 5e-3 * check.imaging_speed_mm_s


def test_extra_oil_makes_it_asymmetric(small):
    operation = {"elements_across_gap": 4, "extra_oil_rate_uL_min": 20}
    check = check_flow(Chamber(**{**small.model_dump(), "operation": operation}))
    at = small.layout.stations
    middle = (at.imaging + at.exit) / 2 - 200
    below = check.flow_rate_uL_min(middle, -1e4, 0)
    above = check.flow_rate_uL_min(middle, 0, 1e4)
    assert above > 1.1 * below
    assert above + below == pytest.approx(61, rel=5e-3)


def test_the_narrowest_gap_is_that_of_the_lattice(paper):
    wide = Chamber(expansion={"straight_um": 1800}, imaging={"pitch_um": 500, "rows": 9})
    assert narrowest_gap(wide).width_um <= 330
    gap = narrowest_gap(paper)
    assert math.dist(gap.start, gap.end) == pytest.approx(gap.width_um)
    others = [p for p in paper.layout.pillars if p.region == "imaging"]
    assert any(
        math.hypot(gap.start[0] - p.x_um, gap.start[1] - p.y_um) == pytest.approx(85, abs=0.2)
        for p in others
    )


def test_the_engine_gets_the_computed_velocities(check):
    obstacle = check.central_obstacle()
    flow = flow_around(check, obstacle)
    diameter = check.chamber.operation.droplet_diameter_um
    radius = obstacle.radius_um / diameter
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    for distance in (1.5, 2.5, 4.0):
        points = distance * radius * ring
        places = points * diameter + [obstacle.x_um, obstacle.y_um]
        wanted = check.velocity(places) / check.imaging_speed_mm_s
        np.testing.assert_allclose(flow.velocity(points), wanted, atol=0.02)
    assert np.abs(flow.velocity(0.7 * radius * ring)).max() < 1e-9
    far = np.array([[-2.0 * radius, 0.0]])
    assert 0.2 < flow.velocity(far)[0, 0] < 1.5


def test_collisions_have_the_operations_groups_and_start_clear_of_other_pillars(check):
    obstacle = check.central_obstacle()
    parameters = collision_parameters(check, obstacle, 0.05)
    assert parameters.offset == pytest.approx(0.05)
    assert parameters.capillary_number == pytest.approx(check.summary["capillary_number"])
    diameter = check.chamber.operation.droplet_diameter_um
    start = np.array([obstacle.x_um - parameters.start_distance * diameter, obstacle.y_um])
    for other in check.chamber.layout.pillars:
        clear = math.hypot(other.x_um - start[0], other.y_um - start[1]) - other.radius_um
        assert clear > 0.599 * diameter


@pytest.fixture
def slit_of():
    """Function (length, half width) -> a straight slit of fluid up to the obstacle, and that.

    Droplets have a diameter of 100 µm, the obstacle a radius of 50 µm.
    """

    def build(length_um, half_width_um):
        fluid = shapely.box(-length_um, -half_width_um, 500.0, half_width_um)
        obstacle = Pillar(0.0, 0.0, 50.0, "imaging")
        hole = shapely.Point(0.0, 0.0).buffer(obstacle.radius_um)
        chamber = SimpleNamespace(
            layout=SimpleNamespace(fluid=fluid.difference(hole)),
            operation=SimpleNamespace(droplet_diameter_um=100.0),
        )
        return SimpleNamespace(chamber=chamber), obstacle

    return build


@pytest.mark.parametrize("length_um", [211.0, 277.0, 341.0])
def test_the_way_of_a_droplet_is_clear_by_a_tenth_of_its_diameter(slit_of, length_um):
    """It starts where its front side's far end still has 0.1 D0 of fluid behind it."""
    start = start_distance(*slit_of(length_um, 61.0))
    assert start == pytest.approx(length_um / 100 - 0.6, abs=0.05)
    assert start <= length_um / 100 - 0.6


def test_a_way_that_is_too_narrow_or_too_short_is_refused(slit_of, refused):
    for slit in (slit_of(500.0, 59.0), slit_of(165.0, 61.0)):
        error = refused("operation.droplet_diameter_um", start_distance, *slit)
        assert error.got == "100.0"
    assert start_distance(*slit_of(176.0, 61.0)) == pytest.approx(1.15)


def test_both_flows_give_a_collision_and_a_line(compared):
    for collision in (compared.in_chamber, compared.in_stokes):
        assert collision.outcome in ("broke", "slipped", "captured")
        assert 0 < collision.symmetry <= 1
    for line in (compared.line_in_chamber, compared.line_in_stokes):
        assert (line.table["status"] == "found").all()
        assert line.table["failed_runs"].sum() == 0
        low, high = line.table["critical_symmetry"]
        assert low > high  # faster droplets break in less symmetric collisions
    said = compared.to_dict()
    assert said["chamber"]["critical_symmetry"] != said["stokes"]["critical_symmetry"]
    assert said["chamber"]["line"] is None  # two points make no fit


@pytest.mark.slow
def test_the_papers_device_at_coarse_and_fine_meshes_agrees():
    coarse, fine = (
        check_flow(Chamber(operation={"elements_across_gap": n})).summary for n in (8, 16)
    )
    for name in ("imaging_speed_mm_s", "droplet_channel_speed_mm_s", "pressure_drop_Pa"):
        assert coarse[name] == pytest.approx(fine[name], rel=0.01)
    # The appendix's claim, and the speeds of section 2.
    assert fine["droplet_channel_over_imaging_speed"] == pytest.approx(1.0, abs=0.05)
    assert 0.5 < fine["imaging_speed_mm_s"] < 2.0
