"""The closed-form flow past a cylinder in a gap: the chamber's solver, drag, and Stokes' limit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import kv

import pinchoff as po
from pinchoff.model import flow

RADIUS = 0.1767


def around(number, nearest=1.0001, farthest=60.0, seed=1):
    rng = np.random.default_rng(seed)
    r = RADIUS * np.exp(rng.uniform(np.log(nearest), np.log(farthest), number))
    angle = rng.uniform(0, 2 * np.pi, number)
    return np.column_stack((r * np.cos(angle), r * np.sin(angle)))


@pytest.mark.parametrize(("gap", "within"), [(0.02, 1e-5), (0.3, 1e-10), (1, 1e-12), (100, 1e-7)])
def test_the_table_is_the_closed_form(gap, within):
    """Stream function ψ = (r + a/r + b K₁(κr)) sin θ by differences of its own formula."""
    points = around(3000)
    kappa = math.sqrt(12) / (gap * RADIUS)
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    b = 2 / (kappa * kv(0, kappa * RADIUS))
    a = -(RADIUS**2) - b * RADIUS * kv(1, kappa * RADIUS)
    radial = 1 + a / r**2 + b * kv(1, kappa * r) / r
    slope = -(kv(0, kappa * r) + kv(1, kappa * r) / (kappa * r))
    around_it = 1 - a / r**2 + b * kappa * slope
    expected = np.column_stack(
        (
            radial * np.cos(angle) ** 2 + around_it * np.sin(angle) ** 2,
            (radial - around_it) * np.cos(angle) * np.sin(angle),
        )
    )
    got = flow.brinkman(RADIUS, gap * RADIUS).velocity(points)
    np.testing.assert_allclose(got, expected, rtol=0, atol=within)


def test_it_solves_brinkmans_equation_with_the_known_drag():
    """Pressure and friction on the wall, by differences, give πμ(2x² + 4x K₁(x)/K₀(x)), x = κR."""
    x = math.sqrt(12)
    field = flow.brinkman(RADIUS, RADIUS)
    angle = (np.arange(720) + 0.5) * 2 * np.pi / 720
    normal = np.column_stack((np.cos(angle), np.sin(angle)))
    h = 1e-4 * RADIUS
    # friction: no slip leaves μ dv/dn along the wall
    shear = (
        4 * field.velocity((RADIUS + h) * normal) - field.velocity((RADIUS + 2 * h) * normal)
    ) / (2 * h)
    friction = shear[:, 0].mean() * 2 * np.pi * RADIUS
    # pressure far out is that of the potential part, p = -κ² (r - a/r) cos θ, and so at the wall
    a = (field.velocity(np.array([[30 * RADIUS, 0.0]]))[0, 0] - 1) * (30 * RADIUS) ** 2
    pressure = (x / RADIUS) ** 2 * (RADIUS - a / RADIUS) * np.pi * RADIUS
    drag = np.pi * (2 * x**2 + 4 * x * kv(1, x) / kv(0, x))
    assert friction + pressure == pytest.approx(drag, rel=1e-4)


def test_a_wide_gap_is_stokes_flow():
    """Times K₀(κR) it is the paper's flow near the obstacle, to order (κr)² ln κr."""
    gap = 100 * RADIUS
    x = math.sqrt(12) / 100
    points = around(500, farthest=2.0)
    near = flow.brinkman(RADIUS, gap).velocity(points) * kv(0, x)
    stokes = flow.stokes(RADIUS).velocity(points)
    assert np.abs(near - stokes).max() < 20 * x**2
    assert np.abs(stokes).max() > 0.5


def test_no_slip_no_flow_inside_and_the_centre_moves_it():
    field = flow.brinkman(RADIUS, RADIUS, (2.0, -1.0))
    centre = np.array([2.0, -1.0])
    assert not field.velocity(centre + 0.5 * around(50, 0.1, 1.9) / 2).all()
    assert not field.velocity(centre[None]).any()
    moved = field.velocity(centre + around(100))
    np.testing.assert_array_equal(moved.shape, (100, 2))
    np.testing.assert_allclose(
        moved, flow.brinkman(RADIUS, RADIUS).velocity(around(100)), atol=1e-9
    )


def test_it_is_the_flow_that_a_run_sees():
    """A run in it is not a run in Stokes' flow; its contact is later, where the fluid is slower."""
    p = po.Parameters(follow_daughters=False)
    wide = po.simulate_many([p], progress=False)
    thin = po.simulate_many(
        [p], flow=flow.brinkman(p.obstacle_radius, p.obstacle_radius), progress=False
    )
    assert thin["contact_time"][0] > 1.5 * wide["contact_time"][0]
    assert thin["contact_speed"][0] < wide["contact_speed"][0]


@pytest.mark.parametrize("gap", [0.01, 1000.0, -1.0])
def test_a_gap_out_of_range_is_refused(refused, gap):
    refused("thickness", flow.brinkman, RADIUS, gap * RADIUS)
