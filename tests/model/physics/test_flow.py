"""The flows: Stokes' solution near a cylinder, uniform, and sampled on a grid."""

from __future__ import annotations

import numpy as np

from pinchoff import _core

RADIUS = 0.1767


def around(rng, number, nearest=1.001, farthest=60.0):
    """Points around the origin, evenly spread over the logarithm of r/R."""
    r = RADIUS * np.exp(rng.uniform(np.log(nearest), np.log(farthest), number))
    angle = rng.uniform(0, 2 * np.pi, number)
    return np.column_stack((r * np.cos(angle), r * np.sin(angle)))


def test_stokes_flow_is_the_papers_polar_form():
    """v_r and v_θ of the paper's two equations, turned to x and y, to 1e-13 of the speed."""
    points = around(np.random.default_rng(1), 5000)
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    radial = (np.log(r / RADIUS) - 0.5 + 0.5 * RADIUS**2 / r**2) * np.cos(angle)
    tangential = -(np.log(r / RADIUS) + 0.5 - 0.5 * RADIUS**2 / r**2) * np.sin(angle)
    expected = np.column_stack(
        (
            radial * np.cos(angle) - tangential * np.sin(angle),
            radial * np.sin(angle) + tangential * np.cos(angle),
        )
    )
    got = _core.StokesFlow(RADIUS).velocity(points)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_stokes_flow_is_divergence_free():
    """Central differences: |div v| stays below their error, h² times third derivatives ~ R⁻³."""
    points = around(np.random.default_rng(2), 2000, nearest=1.01)
    h = 1e-4 * RADIUS
    flow = _core.StokesFlow(RADIUS)
    step_x, step_y = np.array([h, 0.0]), np.array([0.0, h])
    du = flow.velocity(points + step_x)[:, 0] - flow.velocity(points - step_x)[:, 0]
    dv = flow.velocity(points + step_y)[:, 1] - flow.velocity(points - step_y)[:, 1]
    shear = np.abs(du / (2 * h)).max()
    assert shear > 1
    # third derivatives of ln r and R²/r² forms are below 30/R³ at r = R
    bound = 30 * h**2 / RADIUS**3 / 3 + 1e-15 * 5 / h
    assert np.abs((du + dv) / (2 * h)).max() < bound


def test_stokes_flow_is_zero_on_the_wall_and_inside():
    """No slip, from the wall inwards; linear growth just outside."""
    flow = _core.StokesFlow(RADIUS, 2.0, -1.0)
    angle = np.linspace(0, 2 * np.pi, 100)
    ring = np.column_stack((np.cos(angle), np.sin(angle)))
    center = np.array([2.0, -1.0])
    for radius in (0.999999, 0.9, 0.1, 1e-6):
        assert not flow.velocity(center + radius * RADIUS * ring).any()
    assert np.abs(flow.velocity(center + RADIUS * ring)).max() < 1e-14
    # near the wall v_θ = -2 (r/R - 1) sin θ + O((r/R - 1)²)
    for gap in (1e-3, 1e-6):
        v = flow.velocity(center + (1 + gap) * RADIUS * ring)
        tangential = -v[:, 0] * np.sin(angle) + v[:, 1] * np.cos(angle)
        np.testing.assert_allclose(tangential, -2 * gap * np.sin(angle), atol=4 * gap**2)


def test_stokes_flow_is_zero_at_the_very_centre():
    """The one point where R²/r² is not finite is inside the obstacle like the others."""
    center = np.array([[2.0, -1.0]])
    np.testing.assert_array_equal(_core.StokesFlow(RADIUS, 2.0, -1.0).velocity(center), [[0, 0]])


def test_stokes_flow_has_its_stream_function():
    """It is (∂ψ/∂y, -∂ψ/∂x) with ψ = y [ln(r/R) - 1/2 + R²/2r²]: the sign of both components."""
    points = around(np.random.default_rng(3), 1000, nearest=1.05, farthest=20)

    def stream(p):
        r2 = (p**2).sum(axis=1)
        return p[:, 1] * (0.5 * np.log(r2 / RADIUS**2) - 0.5 + 0.5 * RADIUS**2 / r2)

    h = 1e-5 * RADIUS
    step_x, step_y = np.array([h, 0.0]), np.array([0.0, h])
    u = (stream(points + step_y) - stream(points - step_y)) / (2 * h)
    v = -(stream(points + step_x) - stream(points - step_x)) / (2 * h)
    got = _core.StokesFlow(RADIUS).velocity(points)
    np.testing.assert_allclose(got, np.column_stack((u, v)), rtol=0, atol=1e-8)


def test_flow_moves_with_its_obstacle_and_scales_with_it():
    """It depends on (r - centre)/R only."""
    points = around(np.random.default_rng(4), 200)
    base = _core.StokesFlow(RADIUS).velocity(points)
    moved = _core.StokesFlow(RADIUS, 3.0, -4.0).velocity(points + np.array([3.0, -4.0]))
    np.testing.assert_allclose(moved, base, atol=1e-12)
    np.testing.assert_allclose(_core.StokesFlow(5 * RADIUS).velocity(5 * points), base, atol=1e-13)


def test_uniform_flow_is_the_same_everywhere():
    points = around(np.random.default_rng(5), 50)
    velocity = _core.UniformFlow(0.3, -1.2).velocity(points)
    np.testing.assert_array_equal(velocity, np.tile([0.3, -1.2], (50, 1)))


def sampled(function, nodes, low=(-1.0, -0.5), high=(1.0, 1.5)):
    """A sampled flow of `nodes` along x and 3/2 of that along y."""
    x = np.linspace(low[0], high[0], nodes)
    y = np.linspace(low[1], high[1], nodes * 3 // 2)
    u, v = function(*np.meshgrid(x, y))
    u, v = np.ascontiguousarray(u), np.ascontiguousarray(v)
    return _core.SampledFlow(x[0], y[0], x[1] - x[0], y[1] - y[0], u, v)


def smooth(x, y):
    return np.sin(2 * x + y), np.cos(3 * y) * np.exp(-x)


def test_sampled_flow_passes_through_its_nodes():
    x, y = np.meshgrid(np.linspace(-1, 1, 12), np.linspace(-0.5, 1.5, 18))
    nodes = np.column_stack((x.ravel(), y.ravel()))
    got = sampled(smooth, 12).velocity(nodes)
    np.testing.assert_allclose(got, np.column_stack(smooth(*nodes.T)), atol=1e-13)


def test_sampled_flow_reproduces_quadratics_away_from_the_rim():
    """Cubic convolution is exact for quadratic fields, and for linear ones up to the rim."""
    rng = np.random.default_rng(6)

    def quadratic(x, y):
        return 1 + 2 * x - y + 3 * x * x - x * y + 0.5 * y * y, x * y - 2 * y * y + x - 4

    def linear(x, y):
        return 1 + 2 * x - y, 3 * y - x

    inner = np.column_stack((rng.uniform(-0.75, 0.75, 500), rng.uniform(-0.3, 1.3, 500)))
    whole = np.column_stack((rng.uniform(-1, 1, 500), rng.uniform(-0.5, 1.5, 500)))
    got = sampled(quadratic, 12).velocity(inner)
    np.testing.assert_allclose(got, np.column_stack(quadratic(*inner.T)), atol=1e-12)
    got = sampled(linear, 12).velocity(whole)
    np.testing.assert_allclose(got, np.column_stack(linear(*whole.T)), atol=1e-12)


def test_sampled_flow_converges_to_a_smooth_field():
    """Largest error against the spacing has slope 3 (theory), 2.5 at least, away from the rim."""
    rng = np.random.default_rng(7)
    points = np.column_stack((rng.uniform(-0.7, 0.7, 3000), rng.uniform(-0.2, 1.2, 3000)))
    exact = np.column_stack(smooth(*points.T))
    nodes = np.array([16, 32, 64, 128])
    errors = [np.abs(sampled(smooth, n).velocity(points) - exact).max() for n in nodes]
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(nodes - 1))
    assert (slopes > 2.5).all()


def test_sampled_flow_has_no_jump_and_no_kink_between_cells():
    """Across a line of nodes the value is continuous and so is the slope."""
    flow = sampled(smooth, 12)
    spacing, h = 2 / 11, 1e-6
    y = np.linspace(-0.2, 1.2, 40)
    for line in (-1 + 3 * spacing, -1 + 7 * spacing):
        left, right = (
            flow.velocity(np.column_stack((np.full(40, line + s * h), y))) for s in (-1, 1)
        )
        middle = flow.velocity(np.column_stack((np.full(40, line), y)))
        np.testing.assert_allclose(left, right, atol=20 * h)
        np.testing.assert_allclose((right - middle) - (middle - left), 0, atol=100 * h**2)
