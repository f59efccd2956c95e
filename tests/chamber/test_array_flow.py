"""The flow through arrays against exact drags, and against what must hold in any cell."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.chamber.cell_mesh import build_cell_mesh
from pinchoff.model.arrays import PillarArray

array_flow = po.chamber.array_flow

SQUARE = {0.05: 15.56, 0.1: 24.83, 0.2: 51.53, 0.3: 102.90, 0.4: 217.89, 0.5: 532.55}
"""Drag over μ U by share of solid: Sangani and Acrivos, Int. J. Multiphase Flow 8, 193 (1982)."""


def square_of(share):
    radius = math.sqrt(share / math.pi)
    return po.arrays.square(rows=1, columns=1, radius=radius, gap=1 - 2 * radius)


@pytest.mark.parametrize("share", SQUARE)
def test_the_drag_in_a_square_lattice_is_the_exact_one(share):
    flow = array_flow(square_of(share), thickness=math.inf)
    assert flow.drag == pytest.approx(SQUARE[share], rel=0.01)


@pytest.mark.parametrize("share", [0.02, 0.05, 0.1])
def test_the_drag_in_a_hexagonal_lattice_is_that_of_its_series(share):
    # Sangani and Acrivos' series for small shares c, cut off at its fourth power.
    series = -0.5 * math.log(share) - 0.745 + share - 0.25 * share**2
    radius = math.sqrt(share * math.sqrt(0.75) / math.pi)
    lattice = po.arrays.hexagonal(rows=1, columns=2, radius=radius, gap=1 - 2 * radius)
    flow = array_flow(lattice, thickness=math.inf)
    assert flow.drag == pytest.approx(4 * math.pi / series, rel=0.01)


def test_the_drag_converges_with_the_elements():
    errors = [
        abs(array_flow(square_of(0.4), thickness=math.inf, elements=n).drag / 217.89 - 1)
        for n in (4, 8, 16)
    ]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]


def test_several_cells_are_the_same_array():
    one = array_flow(square_of(0.2), thickness=0.7)
    radius = math.sqrt(0.2 / math.pi)
    six = po.arrays.square(rows=2, columns=3, radius=radius, gap=1 - 2 * radius)
    many = array_flow(six, thickness=0.7)
    assert many.permeability == pytest.approx(one.permeability, rel=2e-3)
    assert many.drag == pytest.approx(one.drag, rel=2e-3)


def test_where_the_cell_is_cut_does_not_matter():
    array = po.arrays.disordered(
        length=3, width=2, radius=0.25, porosity=0.75, least_gap=0.2, seed=4
    )
    moved = array.circles.copy()
    moved[:, 0] = np.mod(moved[:, 0] + 1.3, 3.0)
    moved[:, 1] = np.mod(moved[:, 1] + 0.7, 2.0)
    here = array_flow(array, thickness=0.5, elements=8)
    there = array_flow(PillarArray(moved, 3.0, 2.0), thickness=0.5, elements=8)
    points = np.random.default_rng(0).uniform(0, [3, 2], (400, 2))
    np.testing.assert_allclose(
        there.velocity(points + np.array([1.3, 0.7])), here.velocity(points), atol=0.02
    )
    assert there.permeability == pytest.approx(here.permeability, rel=2e-3)


def test_as_much_flows_through_every_section():
    array = po.arrays.disordered(
        length=4, width=3, radius=0.25, porosity=0.8, least_gap=0.2, seed=2
    ).with_margins(1.0, 1.0)
    flow = array_flow(array, thickness=0.25)
    assert flow.mean_velocity[0] == pytest.approx(1.0, abs=1e-9)
    y = np.linspace(0, array.width, 2001)
    for x in (0.2, 1.7, 3.1, 4.4):
        u = flow.velocity(np.column_stack([np.full_like(y, x), y]))[:, 0]
        assert np.trapezoid(u, y) / array.width == pytest.approx(1.0, abs=2e-3)


def test_a_mirrored_array_has_the_mirrored_flow():
    array = po.arrays.disordered(
        length=3, width=2, radius=0.25, porosity=0.8, least_gap=0.25, seed=1
    )
    circles = array.circles * [1, -1, 1] + [0, 2.0, 0]
    flow = array_flow(array, thickness=0.5, elements=8)
    mirrored = array_flow(PillarArray(circles, 3.0, 2.0), thickness=0.5, elements=8)
    u, v = flow.mean_velocity
    assert mirrored.mean_velocity == pytest.approx((u, -v), abs=2e-3)


def test_between_near_plates_the_pressure_drives_against_their_friction_alone():
    # Hele-Shaw's limit: without pillars' layers, porosity and tortuosity are all that is left;
    # for a dilute square lattice the share of solid c slows the flow by (1 - c)/(1 + c).
    share = 0.05
    flow = array_flow(square_of(share), thickness=0.02, elements=12)
    plates = 0.02**2 / 12
    assert flow.permeability / plates == pytest.approx((1 - share) / (1 + share), rel=0.06)
    assert flow.drag > 0


def test_speed_and_pressure_are_two_ways_to_drive_one_flow():
    lattice = square_of(0.2)
    by_speed = array_flow(lattice, thickness=0.5, mean_speed=2.0)
    by_pressure = array_flow(lattice, thickness=0.5, pressure_gradient=by_speed.pressure_gradient)
    assert by_pressure.mean_velocity[0] == pytest.approx(2.0, rel=1e-9)


def test_the_sampled_flow_is_the_computed_one_and_goes_on_beyond_the_cell():
    array = po.arrays.staggered(rows=1, columns=2, radius=0.25, gap=0.5)
    flow = array_flow(array, thickness=0.25)
    grid = flow.sampled(pad=1.0)
    points = np.random.default_rng(1).uniform(0, [array.length, array.width], (500, 2))
    exact = flow.velocity(points)
    assert np.sqrt(np.mean((grid.velocity(points) - exact) ** 2)) < 0.01
    beyond = points[points[:, 0] < 0.8] + [array.length, 0]
    np.testing.assert_allclose(
        grid.velocity(beyond), grid.velocity(beyond - [array.length, 0]), atol=1e-9
    )


def test_the_mesh_covers_the_torus_once():
    array = po.arrays.disordered(
        length=3, width=2, radius=0.25, porosity=0.7, least_gap=0.15, seed=7
    )
    mesh = build_cell_mesh(array, 6)
    assert mesh.areas().min() > 0
    assert mesh.areas().sum() == pytest.approx(array.porosity * 6.0, rel=1e-9)
    corners = np.unique(mesh.representative).size
    ends = mesh.representative[mesh.triangles[:, [[0, 1], [1, 2], [0, 2]]]]
    edges, count = np.unique(np.sort(ends, axis=2).reshape(-1, 2), axis=0, return_counts=True)
    assert set(count) == {1, 2}
    # Euler's number of a torus is zero; each pillar's hole takes one away.
    assert corners - len(edges) + len(mesh.triangles) == -len(array.circles)


def test_the_imaging_area_is_an_array():
    array = po.chamber.imaging_array(po.chamber.Chamber())
    assert array.least_gap > 0
    assert len(array.circles) == 30  # five rows; of seven staggered columns six repeat


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thickness": 0}, "thickness must be positive"),
        ({"thickness": math.nan}, "thickness must be positive"),
        ({"mean_speed": -1}, "mean_speed must be"),
        ({"mean_speed": 1, "pressure_gradient": 1}, "alone"),
        ({"elements": 1}, "elements must be"),
    ],
)
def test_bad_arguments_are_refused(change, words):
    with pytest.raises(po.InputError, match=words):
        array_flow(square_of(0.2), **{"thickness": 0.5, **change})


def test_a_grid_too_fine_for_memory_is_refused():
    flow = array_flow(square_of(0.2), thickness=0.5)
    with pytest.raises(po.InputError, match="spacing must be"):
        flow.sampled(spacing=1e-5)
