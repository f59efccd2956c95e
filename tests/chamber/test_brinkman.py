"""The depth-averaged flow against exact solutions: between walls, and past a cylinder."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from shapely import MultiPolygon, Point, Polygon, box

from pinchoff.chamber.brinkman import Source, solve
from pinchoff.chamber.mesh import build_mesh
from pinchoff.model import flow

LENGTH, WIDTH, END = 1600.0, 400.0, 300.0


def evenly(size):
    return lambda points: np.full(len(points), size)


def channel_flow(thickness, size, rate=1.0):
    mesh = build_mesh(MultiPolygon([box(0, 0, LENGTH, WIDTH)]), evenly(size), 64.0)
    ends = [
        Source(lambda p: p[:, 0] < END, rate),
        Source(lambda p: p[:, 0] > LENGTH - END, -rate),
    ]
    return solve(mesh, thickness, sources=ends)


def profile(thickness, y):
    """The velocity over its mean, between walls at 0 and WIDTH."""
    half, y = WIDTH / 2, y - WIDTH / 2
    if math.isinf(thickness):
        return 1.5 * (1 - (y / half) ** 2)
    kappa = math.sqrt(12) / thickness
    share = 1 - np.cosh(kappa * y) / math.cosh(kappa * half)
    return share / (1 - math.tanh(kappa * half) / (kappa * half))


@pytest.mark.parametrize("thickness", [85.0, 45.0, math.inf])
def test_between_two_walls_the_profile_and_the_pressure_are_exact(thickness):
    field = channel_flow(thickness, 12.0)
    y = np.linspace(0, WIDTH, 201)
    middle = np.column_stack([np.full_like(y, LENGTH / 2), y])
    velocity = field.at(middle) * WIDTH  # over the mean speed
    np.testing.assert_allclose(velocity[:, 0], profile(thickness, y), atol=6e-3)
    np.testing.assert_allclose(velocity[:, 1], 0.0, atol=2e-3)
    kappa2 = 0.0 if math.isinf(thickness) else 12 / thickness**2
    if kappa2:
        k = math.sqrt(kappa2) * WIDTH / 2
        slope = -kappa2 / (1 - math.tanh(k) / k) / WIDTH
    else:
        slope = -12 / WIDTH**3
    ends = np.array([[600.0, WIDTH / 2], [1000.0, WIDTH / 2]])
    assert np.diff(field.pressure_at(ends))[0] / 400 == pytest.approx(slope, rel=1e-3)


def test_the_flow_through_every_section_is_what_comes_in():
    field = channel_flow(85.0, 12.0, rate=3.0)
    y = np.linspace(0, WIDTH, 2001)
    for x in (400.0, 700.0, 1100.0):
        u = field.at(np.column_stack([np.full_like(y, x), y]))[:, 0]
        assert np.trapezoid(u, y) == pytest.approx(3.0, rel=2e-4)


def test_the_flow_is_proportional_to_the_rate_and_turns_with_its_sign():
    one, back = channel_flow(85.0, 25.0), channel_flow(85.0, 25.0, rate=-2.0)
    np.testing.assert_allclose(back.velocity, -2 * one.velocity, atol=1e-9)
    np.testing.assert_allclose(back.pressure, -2 * one.pressure, atol=1e-8)


def past_cylinder(exact, size):
    hole = Point(0, 0).buffer(exact.radius, quad_segs=256)
    outer = box(-350, -350, 350, 350)
    near = lambda p: np.where(np.hypot(*p.T) < 1.5 * exact.radius, size, 2 * size)  # noqa: E731
    mesh = build_mesh(MultiPolygon([Polygon(outer.exterior, [hole.exterior])]), near, 50.0)
    thickness = math.sqrt(12) / exact.kappa
    return solve(mesh, thickness, wall_velocity=exact.velocity)


def test_past_a_cylinder_errors_fall_as_the_cube_of_the_element_size(cylinder):
    exact = cylinder(85.0, 85.0)
    ring = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    points = np.concatenate(
        [r * np.column_stack([np.cos(ring), np.sin(ring)]) for r in (95, 110, 150, 250)]
    )
    sizes = np.array([32.0, 16.0, 8.0])
    errors = [
        np.sqrt(np.mean((past_cylinder(exact, h).at(points) - exact.velocity(points)) ** 2))
        for h in sizes
    ]
    order = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    assert errors[-1] < 1e-3
    assert order > 2.4


def drag_on_cylinder(field, radius):
    """Sum the forces on the nodes of a cylinder about the origin."""
    corners = field.mesh.points
    on_cylinder = np.flatnonzero(np.hypot(*corners[: field.mesh.wall_count].T) < 1.01 * radius)
    nodes = np.zeros(len(field.velocity), dtype=bool)
    nodes[on_cylinder] = True
    for a, b, edge in ((0, 1, 3), (1, 2, 4), (0, 2, 5)):
        both = nodes[field.nodes_of[a]] & nodes[field.nodes_of[b]]
        nodes[field.nodes_of[edge][both]] = True
    return field.reactions[nodes].sum(axis=0)


@pytest.mark.parametrize(("radius", "thickness"), [(85.0, 85.0), (60.0, 45.0)])
def test_the_drag_on_a_cylinder_is_the_exact_one(cylinder, radius, thickness):
    exact = cylinder(radius, thickness)
    drag = drag_on_cylinder(past_cylinder(exact, 6.0), radius)
    assert drag[0] == pytest.approx(exact.drag, rel=5e-3)
    assert drag[1] == pytest.approx(0.0, abs=5e-3 * exact.drag)


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3])
def test_the_drag_on_a_cylinder_in_a_channel_is_faxens(share):
    """Plane Stokes flow: a cylinder half way between walls that move with the far fluid.

    Faxén's series (Proc. R. Swed. Acad. Eng. Sci. 187, 1946) in k, radius over half the width.
    """
    radius = 50.0
    half = radius / share
    hole = Point(0, 0).buffer(radius, quad_segs=128)
    channel = Polygon(box(-5 * half, -half, 5 * half, half).exterior, [hole.exterior])

    def size(points):
        return np.where(np.hypot(*points.T) < 1.6 * radius, 8.0, 24.0)

    def velocity(points):
        far = np.hypot(*points.T) > 1.2 * radius
        return np.column_stack([far.astype(float), np.zeros(len(points))])

    mesh = build_mesh(MultiPolygon([channel]), size, 60.0)
    drag = drag_on_cylinder(solve(mesh, math.inf, wall_velocity=velocity), radius)
    k = share
    series = 1.7244 * k**2 - 1.7302 * k**4 + 2.4056 * k**6 - 4.5913 * k**8
    assert drag[0] == pytest.approx(4 * math.pi / (-math.log(k) - 0.9157 + series), rel=5e-3)
    assert drag[1] == pytest.approx(0.0, abs=1e-3 * drag[0])


def test_outside_the_fluid_there_is_no_velocity_and_no_pressure():
    field = channel_flow(85.0, 25.0)
    outside = np.array([[-10.0, 200.0], [800.0, WIDTH + 1]])
    assert (field.at(outside) == 0).all()
    assert np.isnan(field.pressure_at(outside)).all()


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_the_engine_s_flow_of_a_gap_is_what_the_solver_finds(ratio):
    """Given it on the walls alone, R = 85 µm, the solver tends to it as the elements shrink."""
    radius = 85.0
    engine = flow.brinkman(1.0, ratio)
    given = SimpleNamespace(
        radius=radius,
        kappa=math.sqrt(12) / (ratio * radius),
        velocity=lambda points: engine.velocity(points / radius),
    )
    ring = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    round_it = np.column_stack([np.cos(ring), np.sin(ring)])
    points = np.concatenate([r * round_it for r in (95, 110, 150, 250)])
    coarse, fine = (
        np.sqrt(np.mean((past_cylinder(given, h).at(points) - given.velocity(points)) ** 2))
        for h in (16.0, 8.0)
    )
    assert fine < 3e-3
    assert coarse / fine > 2.8  # an order of 1.5 or more
