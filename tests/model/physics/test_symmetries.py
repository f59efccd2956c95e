"""What must not change a collision: mirror, place, direction, a neighbour far away."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

COLLISIONS = [
    {"offset": 0.05},  # slips
    {"offset": 0.02, "simulation_capillary_number": 40.0},  # breaks
    {"offset": 0.12, "simulation_capillary_number": 60.0, "size_ratio": 4.0},
    {"offset": 0.15, "simulation_capillary_number": 80.0},
]
MEASURED = (
    "symmetry",
    "impact_parameter",
    "contact_time",
    "contact_speed",
    "contact_area",
    "contact_shape_parameter",
    "minimum_neck",
    "small_daughter_area",
    "large_daughter_area",
    "breakup_time",
    "breakup_neck",
)


def assert_same_collision(got, expected, rel=1e-6):
    """Equal up to round-off that the motion has amplified."""
    assert got["outcome"] == expected["outcome"]
    for name in MEASURED:
        assert got[name] == pytest.approx(expected[name], rel=rel, nan_ok=True), name


def at_end(one):
    one.advance(1e9)
    return one


@pytest.mark.parametrize("constants", COLLISIONS)
def test_mirrored_offset_gives_the_mirrored_collision(model, system, result, constants):
    """The same numbers for -offset, and at contact outlines mirrored vertex by vertex."""
    constants = {**constants, "follow_daughters": False}
    up = at_end(system(model(**constants)))
    down = at_end(system(model(**{**constants, "offset": -constants["offset"]})))
    assert_same_collision(result(down), result(up))
    (one,), (other,) = up.contacts(), down.contacts()
    for name in ("y", "velocity_y", "centroid_velocity_y"):
        assert one[name] == pytest.approx(-other[name], rel=1e-6)
    assert one["y"] > 0
    time = one["time"]
    first, second = (
        system(model(**constants)),
        system(model(**{**constants, "offset": -constants["offset"]})),
    )
    for each in (first, second):
        each.advance(time)
    flip = np.array([1, -1])
    for of in (2, 3):
        seen, mirror = first.outlines()[0][of], second.outlines()[0][of]
        np.testing.assert_allclose((seen * flip)[::-1], mirror, atol=1e-7)


@pytest.mark.parametrize("constants", COLLISIONS)
def test_collision_moves_with_its_obstacle(model, system, result, constants):
    """Droplet, obstacle and flow shifted together: the same collision elsewhere."""
    row = model(**constants, follow_daughters=False)
    shift = np.array([2.5, -7.25])
    base = at_end(system(row))
    start = [-5.0 + shift[0], constants["offset"] + shift[1], 1.0]
    moved = at_end(system(row, _core.StokesFlow(row[0], *shift), [[*shift, row[0]]], [start]))
    assert_same_collision(result(moved), result(base))
    one, other = base.contacts()[0], moved.contacts()[0]
    assert (other["x"], other["y"]) == pytest.approx(
        np.array([one["x"], one["y"]]) + shift, abs=1e-6
    )


def test_collision_turns_with_its_flow(model, system, result):
    """A droplet that a uniform flow carries against an obstacle, turned by 9/64 of a circle.

    The polygon's vertices fall on themselves under that turn, renumbered.
    """
    row = model(simulation_capillary_number=200.0, follow_daughters=False)
    angle = 2 * math.pi * 9 / 64
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    runs = []
    for rotation in (np.eye(2), turn):
        center, start = rotation @ [0.3, 0.1], rotation @ [-2.0, 0.25]
        flow = _core.UniformFlow(*(rotation @ [1.0, 0.0]))
        runs.append(at_end(system(row, flow, [[*center, 0.2]], [[*start, 1.0]])))
    assert result(runs[0])["contact_time"] > 0.5
    assert runs[0].breakups()
    assert_same_collision(result(runs[1]), result(runs[0]))
    first, second = (np.array(one.breakups()[0]["neck"]) for one in runs)
    pairs = np.hypot(*((first @ turn.T)[:, None] - second[None]).T)  # its ends, in either order
    assert pairs.min(axis=0).max() < 1e-5


def test_several_obstacles_are_met_in_any_order(model, system, result):
    """The order in which obstacles are listed changes nothing; the second is hit second."""
    row = model(offset=0.03)
    near, far = [0.0, 0.0, row[0]], [1.2, 0.6, 0.15]
    one = at_end(system(row, None, [near, far]))
    other = at_end(system(row, None, [far, near]))
    assert_same_collision(result(other), result(one))
    assert [c["obstacle"] for c in one.contacts()][:2] == [0, 1]
    assert [c["obstacle"] for c in other.contacts()][:2] == [1, 0]


@pytest.mark.parametrize("constants", COLLISIONS)
def test_far_second_droplet_changes_nothing(model, system, result, run, constants):
    """N = 1 is the special case: run_many, a System of one, and one beside a far bystander."""
    row = model(**constants)
    (expected,) = run(row)
    alone = result(at_end(system(row)))
    np.testing.assert_equal(alone, expected)
    start = [-5.0, constants["offset"], 1.0]
    bystander = [-5.0, 40.0, 1.0]
    pair = system(row, None, None, [start, bystander])
    at_end(pair)
    assert_same_collision(result(pair), expected, rel=1e-9)
    assert pair.contacts()[0]["droplet_id"] == 0


def stream_function(points, radius):
    """ψ = y [ln(r/R) - 1/2 + R²/2r²]: constant along a streamline of the Stokes flow."""
    r2 = (points**2).sum(axis=1)
    return points[:, 1] * (0.5 * np.log(r2 / radius**2) - 0.5 + 0.5 * radius**2 / r2)


@pytest.mark.parametrize("offset", [5.0, -3.0])
def test_tracer_small_droplet_follows_the_streamline(model, system, offset):
    """ψ at the centre changes by less than D0²/4R all the way round an obstacle with R ≫ D0.

    A droplet feels the mean flow along its outline, which differs from that at the centre by
    D0²/16 ∇²v with |∇²v| ≤ 2/R², the pressure gradient on the wall. At speeds ~ 1 it needs ~ 2R to
    pass: ψ, here 2 to 3, shifts by up to D0²/16 · 2/R² · 2R.
    """
    ratio = 0.05
    radius = 1 / ratio
    row = model(size_ratio=ratio, offset=offset, start_distance=60.0, time_limit=400.0)
    one = system(row)
    path = []
    while not one.finished:
        path.append(_core.centroid(one.outlines()[0][2]))
        one.advance(one.time + 1.0)
    path = np.array(path)
    assert path[-1, 0] > radius
    assert not one.contacts()
    assert np.abs(path[:, 1]).max() > abs(offset) + 0.5 * radius  # it went round
    assert np.hypot(*path.T).min() > radius
    psi = stream_function(path, radius)
    assert np.abs(psi - psi[0]).max() < ratio / 4
