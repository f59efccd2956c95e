"""Every force is minus the gradient of its energy, and the time step uses just these forces."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

TERMS = _core.TERMS
EVERY_TERM: dict[str, float] = {"contact_angle": 70.0}
"""Parameters with which every term is at work; those that are so by default are left out."""


def obstacles_near(rng, outline):
    """Obstacles that overlap some of the vertices' range, some deep and some barely."""
    picked = outline[rng.choice(len(outline), 3, replace=False)]
    away = rng.normal(size=(3, 2))
    away /= np.hypot(*away.T)[:, None]
    radius = rng.uniform(0.1, 0.3, 3)
    centers = picked + away * (radius + rng.uniform(-0.01, 0.01, 3))[:, None]
    return np.column_stack((centers, radius))


def rest_length(row, count, diameter):
    """l_eq of the regular polygon with the area of a circle of that diameter."""
    return math.sqrt(math.pi * diameter**2 * math.tan(math.pi / count) / count)


def feels_kink(outline, obstacles, reach, margin):
    """Whether a vertex is so near to where a wall begins that a difference would straddle it."""
    for x, y, radius in obstacles:
        distance = np.hypot(outline[:, 0] - x, outline[:, 1] - y) - radius
        if (np.abs(distance - reach) < margin).any():
            return True
    return False


@pytest.mark.parametrize("diameter", [1.0, 0.6])
@pytest.mark.parametrize("count", [16, 37, 64])
def test_forces_are_minus_the_gradient_of_the_energies(model, droplet, count, diameter):
    """Central differences of each term, for every coordinate of random non-convex droplets.

    Each energy is smooth over h = 1e-6 (polygons with a vertex at the wall's onset are left out),
    so the difference errs by h² U'''/6 and by round-off of 1e-16 U/h: 1e-6 of the largest force.
    """
    rng = np.random.default_rng(count)
    row, h = model(**EVERY_TERM), 1e-6
    touched = 0
    for _ in range(4):
        outline = diameter * droplet(rng, count)
        obstacles = obstacles_near(rng, outline)
        if feels_kink(outline, obstacles, rest_length(row, count, diameter) / 2, 3 * h):
            continue
        forces = _core.term_forces(row, outline, obstacles, diameter)
        differences = {term: np.zeros_like(outline) for term in TERMS}
        for index in np.ndindex(outline.shape):
            ahead, behind = outline.copy(), outline.copy()
            ahead[index] += h
            behind[index] -= h
            up = _core.term_energies(row, ahead, obstacles, diameter)
            down = _core.term_energies(row, behind, obstacles, diameter)
            for term in TERMS:
                differences[term][index] = -(up[term] - down[term]) / (2 * h)
        energies = _core.term_energies(row, outline, obstacles, diameter)
        for term in TERMS:
            scale = np.abs(forces[term]).max()
            round_off = 1e-15 * abs(energies[term]) / h
            np.testing.assert_allclose(
                differences[term], forces[term], rtol=0, atol=1e-6 * scale + round_off, err_msg=term
            )
        touched += scale > 0
    assert touched >= 2


def test_energies_and_forces_agree_with_automatic_differentiation(model, droplet):
    """An energy written anew in NumPy, and its gradient by autograd, equal the core's to 1e-10."""
    anp = pytest.importorskip("autograd.numpy")
    from autograd import grad

    row = model(vertex_count=48, **EVERY_TERM)
    value = dict(zip(_core.MODEL_FIELDS, row, strict=True))
    rng = np.random.default_rng(7)
    outline = droplet(rng, 48)
    obstacles = obstacles_near(rng, outline)
    length_at_rest = rest_length(row, 48, 1.0)

    def lengths(r):
        return anp.sqrt(anp.sum((anp.roll(r, -1, axis=0) - r) ** 2, axis=1))

    def area(r):
        x, y = r[:, 0], r[:, 1]
        a = 0.5 * anp.sum(x * anp.roll(y, -1) - anp.roll(x, -1) * y)
        return 0.5 * value["area_stiffness"] * (a - math.pi / 4) ** 2

    def edges(r):
        return 0.5 * value["edge_stiffness"] * 48 * anp.sum((lengths(r) - length_at_rest) ** 2)

    def line_tension(r):
        return value["line_tension"] * anp.sum(lengths(r))

    def wall(r):
        total = 0.0
        for x, y, radius in obstacles:
            d = anp.sqrt((r[:, 0] - x) ** 2 + (r[:, 1] - y) ** 2) - radius
            overlap = 1 - 2 * d / length_at_rest
            total = total + anp.sum(anp.where(overlap > 0, overlap, 0.0) ** 2)
        return 0.5 * value["wall_stiffness"] * total

    def adhesion(r):
        places, weights = np.polynomial.legendre.leggauss(3)
        total, after = 0.0, anp.roll(r, -1, axis=0)
        for x, y, radius in obstacles:
            ax, ay, bx, by = r[:, 0] - x, r[:, 1] - y, after[:, 0] - x, after[:, 1] - y
            far_a, far_b = anp.sqrt(ax**2 + ay**2), anp.sqrt(bx**2 + by**2)
            round_pillar = (ay * bx - ax * by) / (0.5 * (far_a + far_b))
            for place, weight in zip(places, weights, strict=True):
                d = far_a + 0.5 * (1 + place) * (far_b - far_a) - radius
                s = anp.clip((d - length_at_rest / 2) / length_at_rest, 0.0, 1.0)
                total = total + 0.5 * weight * anp.sum((1 - 3 * s**2 + 2 * s**3) * round_pillar)
        return -value["line_tension"] * (1 + math.cos(math.radians(70))) * total

    energies = _core.term_energies(row, outline, obstacles)
    forces = _core.term_forces(row, outline, obstacles)
    ours = (area, edges, line_tension, wall, adhesion)
    assert tuple(energy.__name__ for energy in ours) == TERMS
    for term, energy in zip(TERMS, ours, strict=True):
        assert energies[term] == pytest.approx(energy(outline), rel=1e-11)
        expected = -grad(energy)(outline)
        scale = np.abs(expected).max()
        assert scale > 0
        np.testing.assert_allclose(forces[term], expected, rtol=0, atol=1e-10 * scale)
    assert energies["total"] == pytest.approx(sum(energies[t] for t in TERMS), rel=1e-14)


@pytest.mark.parametrize("count", [16, 17, 37, 64, 71])
def test_acceleration_is_the_sum_of_the_forces_and_the_drag(model, droplet, count):
    """It is N_v/M Σ F + (μ D0/M)(v_f - v), in the loop that the time step itself uses."""
    rng = np.random.default_rng(count)
    row = model(vertex_count=64, **EVERY_TERM)
    value = dict(zip(_core.MODEL_FIELDS, row, strict=True))
    flow = _core.StokesFlow(0.2, -1.5, 0.3)
    for diameter in (1.0, 0.7):
        outline = diameter * droplet(rng, count)
        velocity = rng.normal(size=outline.shape)
        obstacles = obstacles_near(rng, outline)
        terms = _core.term_forces(row, outline, obstacles, diameter)
        mass = diameter**2
        expected = sum(terms.values()) * count / mass
        expected += value["drag"] * diameter / mass * (flow.velocity(outline) - velocity)
        got = _core.acceleration(row, flow, outline, velocity, obstacles, diameter)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-11 * scale)


def test_internal_forces_carry_no_net_force_and_no_torque(model, droplet):
    """Area, edges and line tension do not move or turn a droplet as a whole."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        outline = droplet(rng, 64, (0.4, -0.2))
        forces = _core.term_forces(model(), outline, np.zeros((0, 3)))
        for term in ("area", "edges", "line_tension"):
            f = forces[term]
            scale = np.abs(f).max()
            assert f.sum(axis=0) == pytest.approx([0, 0], abs=1e-12 * scale * 64)
            torque = (outline[:, 0] * f[:, 1] - outline[:, 1] * f[:, 0]).sum()
            assert torque == pytest.approx(0, abs=1e-12 * scale * 64)
        assert not forces["wall"].any()


def test_signs_of_the_forces(model):
    """A drop too small swells, line tension shrinks it, long edges pull, the wall pushes off."""
    angle = (np.arange(64) + 0.5) * 2 * np.pi / 64
    outward = np.column_stack((np.cos(angle), np.sin(angle)))
    small, large = 0.49 * outward, 0.51 * outward
    touching = np.array([[-0.6, 0.0, 0.11]])

    def radial(outline, term):
        return (_core.term_forces(model(), outline, touching)[term] * outward).sum(axis=1)

    assert (radial(small, "area") > 0).all()
    assert (radial(large, "area") < 0).all()
    assert (radial(small, "edges") > 0).all()
    assert (radial(large, "edges") < 0).all()
    assert (radial(small, "line_tension") < 0).all()
    assert _core.term_forces(model(), small, touching)["wall"][:, 0].max() > 0
    assert _core.term_forces(model(), small, touching)["wall"][:, 0].min() >= 0


@pytest.mark.parametrize("count", [37, 64])
def test_acceleration_does_not_depend_on_numbering_or_mirror(model, droplet, count):
    """Relabelling relabels the accelerations; the mirror mirrors them; so do turn and shift."""
    rng = np.random.default_rng(count)
    row = model()
    outline, velocity = droplet(rng, count, (-0.8, 0.1)), rng.normal(size=(count, 2))
    obstacles = obstacles_near(rng, outline)
    flow = _core.StokesFlow(0.25)
    base = _core.acceleration(row, flow, outline, velocity, obstacles)
    scale = np.abs(base).max()

    def close(got, expected):
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-11 * scale)

    for shift in (1, 5, count - 1):
        rolled = [np.roll(a, shift, axis=0) for a in (outline, velocity)]
        close(_core.acceleration(row, flow, *rolled, obstacles), np.roll(base, shift, axis=0))
    flip = np.array([1.0, -1.0])
    mirrored = [np.ascontiguousarray((a * flip)[::-1]) for a in (outline, velocity)]
    seen = _core.acceleration(row, flow, *mirrored, obstacles * [1, -1, 1])
    close(seen, (base * flip)[::-1])
    offset = np.array([3.0, -2.0])
    moved = _core.StokesFlow(0.25, *offset)
    shifted = obstacles + np.array([*offset, 0.0])
    close(_core.acceleration(row, moved, outline + offset, velocity, shifted), base)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    straight = _core.acceleration(row, _core.UniformFlow(1.0, 0.0), outline, velocity, obstacles)
    circles = np.column_stack((obstacles[:, :2] @ turn.T, obstacles[:, 2]))
    turned = _core.acceleration(
        row, _core.UniformFlow(0.6, 0.8), outline @ turn.T, velocity @ turn.T, circles
    )
    close(turned, straight @ turn.T)
