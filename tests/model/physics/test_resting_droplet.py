"""A droplet that nothing touches: at rest in still fluid, and carried by a uniform flow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pinchoff import _core

NO_OBSTACLES = np.zeros((0, 3))
STILL = _core.UniformFlow(0.0, 0.0)


def at_rest(row, count, diameter=1.0):
    """(area, pressure, tension) of the regular polygon in equilibrium.

    With circumradius r: A = n/2 r² sin(2π/n), l = 2 r sin(π/n). dU/dr = 0 is p dA/dr = T n dl/dr,
    with p = k_a (A_eq - A) and T = γ + k_l N_v (l - l_eq): p = T P/(2A), the tension over the
    inner radius, Laplace's law in two dimensions with the edge springs' share.
    """
    value = dict(zip(_core.MODEL_FIELDS, row, strict=True))
    rest_area = math.pi / 4 * diameter**2
    length = math.sqrt(4 * rest_area * math.tan(math.pi / count) / count)
    stiffness = value["area_stiffness"] / diameter**3

    def state(r):
        area = 0.5 * count * r * r * math.sin(2 * math.pi / count)
        edge = 2 * r * math.sin(math.pi / count)
        tension = value["line_tension"] + value["edge_stiffness"] * count * (edge - length)
        return area, stiffness * (rest_area - area), tension, count * edge

    def imbalance(r):
        area, pressure, tension, perimeter = state(r)
        return pressure - tension * perimeter / (2 * area)

    r = brentq(imbalance, 0.4 * diameter, 0.6 * diameter, xtol=1e-15, rtol=1e-15)
    return state(r)[:3]


def settled(system, row, diameter=1.0, time=0.2):
    """The outline after time enough for the breathing to die out, and its System."""
    one = system(row, STILL, NO_OBSTACLES, [[0.3, -0.2, diameter]])
    one.advance(time)
    assert not one.finished
    return one.outlines()[0][2], one


@pytest.mark.parametrize("diameter", [1.0, 0.5])
@pytest.mark.parametrize("stiffness", [1e5, 5e5])
def test_laplace_pressure_and_area_of_the_resting_drop(model, system, stiffness, diameter):
    """The drop that the program settles to has the area and the pressure of theory, to 1e-10."""
    row = model(area_stiffness=stiffness, time_step=5e-5, core={"neck_thickness": 0.0})
    outline, one = settled(system, row, diameter, time=1.0)
    area, pressure, tension = at_rest(row, len(outline), diameter)
    assert _core.area(outline) == pytest.approx(area, rel=1e-10)
    # the pressure as the forces have it: |Σ area force| is p dA/dr on each vertex
    force = _core.term_forces(row, outline, NO_OBSTACLES, diameter)["area"]
    radius = np.hypot(*(outline - _core.centroid(outline)).T)
    outward = ((outline - _core.centroid(outline)) * force).sum() / (2 * area)
    assert outward == pytest.approx(pressure, rel=1e-8)
    assert radius.std() < 1e-10
    # p = T/r up to the polygon's (π/n)²/2, and T = γ up to the springs' small share
    assert pressure * radius.mean() == pytest.approx(tension, rel=(math.pi / len(outline)) ** 2)
    assert tension < row[_core.MODEL_FIELDS.index("line_tension")]
    assert one.energies()["wall"] == one.energies()["contact"] == 0


def test_laplace_pressure_of_a_stiff_drop_is_surface_tension_over_radius(model, system):
    """With no springs p r = γ: A = A_eq - γ/(r k_a), up to the 0.05 % by which r itself shrinks."""
    row = model(vertex_count=256, edge_stiffness=1e-6, time_step=5e-5)
    outline, _ = settled(system, row, time=0.1)
    area = _core.area(outline)
    missing = math.pi / 4 - area
    stiffness = row[_core.MODEL_FIELDS.index("area_stiffness")]
    assert missing * stiffness == pytest.approx(80 / 0.5, rel=missing / area)


def test_energies_of_the_system_are_those_of_its_outlines(model, system):
    """The energy report is the sum of its terms, and each is that of the droplets' outlines."""
    row = model(offset=0.1)
    obstacles = np.array([[0.0, 0.0, row[0]], [2.0, 0.3, 0.2]])
    starts = [[-3.0, 0.1, 1.0], [-5.0, -0.1, 0.7]]
    two = system(row, None, obstacles, starts)
    pressed = 0
    for time in np.arange(0.1, 3.0, 0.1):
        two.advance(time)
        reported = two.energies()
        expected = dict.fromkeys(("area", "edges", "line_tension", "wall"), 0.0)
        if two.breakups() or two.finished:
            break
        for (_, _, outline, _), (_, _, diameter) in zip(two.outlines(), starts, strict=True):
            for term in expected:
                terms = _core.term_energies(row, outline, obstacles, diameter)
                expected[term] += terms[term]
        for term, value in expected.items():
            assert reported[term] == pytest.approx(value, rel=1e-10, abs=1e-12)
        parts = sum(v for k, v in reported.items() if k != "total")
        assert reported["total"] == pytest.approx(parts, rel=1e-14)
        pressed += reported["wall"] > 0
    assert pressed > 3


@pytest.mark.parametrize("time_step", [1e-4, 3.8e-4])
def test_exponential_approach_to_the_uniform_flow(model, system, time_step):
    """⟨v⟩ = V (1 - exp(-ζ t)) with ζ = μ D0/M to round-off, whatever the time step."""
    row = model(
        line_tension=1.0,
        simulation_capillary_number=30.0,
        core={"time_step": time_step, "sample_interval": time_step},
    )
    flow = np.array([0.8, -0.6])
    one = system(row, _core.UniformFlow(*flow), NO_OBSTACLES, [[0.0, 0.0, 1.0]])
    for time in (0.005, 0.02, 0.05, 0.1, 0.3):
        one.advance(time)
        velocity = one.outlines()[0][3].mean(axis=0)
        expected = flow * -math.expm1(-30.0 * one.time)
        np.testing.assert_allclose(velocity, expected, rtol=1e-10)


@pytest.mark.parametrize("diameter", [1.0, 0.5])
def test_rate_of_approach_is_drag_over_mass_of_that_droplet(model, system, diameter):
    """A droplet of diameter D has mass D² and drag μ D, so it follows the fluid at rate μ/D."""
    row = model(line_tension=1.0, simulation_capillary_number=30.0, core={"sample_interval": 1e-9})
    one = system(row, _core.UniformFlow(1.0, 0.0), NO_OBSTACLES, [[0.0, 0.0, diameter]])
    one.advance(0.03)
    velocity = one.outlines()[0][3][:, 0].mean()
    assert velocity == pytest.approx(-math.expm1(-30.0 / diameter * one.time), rel=1e-10)


def test_terminal_drift_is_the_fluid_velocity(model, system):
    """A force-free droplet ends up moving with the fluid, undeformed and without turning."""
    row = model()
    flow = np.array([0.8, -0.6])
    one = system(row, _core.UniformFlow(*flow), NO_OBSTACLES, [[0.0, 0.0, 1.0]])
    one.advance(1.0)
    before, start = np.array(_core.centroid(one.outlines()[0][2])), one.time
    one.advance(2.0)
    _, _, outline, velocity = one.outlines()[0]
    np.testing.assert_allclose(velocity, np.tile(flow, (64, 1)), atol=1e-9)
    moved = np.array(_core.centroid(outline)) - before
    np.testing.assert_allclose(moved, flow * (one.time - start), rtol=1e-9)
    area, _, _ = at_rest(row, 64)
    assert _core.area(outline) == pytest.approx(area, rel=1e-9)
    first = outline[0] - _core.centroid(outline)
    assert math.atan2(first[1], first[0]) == pytest.approx(math.pi / 64, abs=1e-9)


def test_start_is_a_regular_polygon_at_rest(model, system):
    """N_v vertices with the area of the circle, at (-start, offset), not moving."""
    row = model(vertex_count=48, offset=0.2, start_distance=4.0)
    _, generation, outline, velocity = system(row).outlines()[0]
    assert outline.shape == (48, 2)
    assert generation == 0
    assert _core.area(outline) == pytest.approx(math.pi / 4, rel=1e-12)
    assert _core.centroid(outline) == pytest.approx((-4.0, 0.2), rel=1e-12)
    edges = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
    np.testing.assert_allclose(edges, edges.mean(), rtol=1e-12)
    np.testing.assert_allclose(velocity, 0, atol=1e-12)
