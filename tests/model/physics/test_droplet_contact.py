"""Droplets against each other: energy, reaction, and that they keep apart."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

shapely = pytest.importorskip("shapely")

NO_OBSTACLES = np.zeros((0, 3))
STILL = _core.UniformFlow(0.0, 0.0)
UNBROKEN = {"neck_thickness": 0.0}


def rest_length(outline, diameter):
    """l_eq of a droplet of that diameter with as many vertices as the outline."""
    count = len(outline)
    return math.sqrt(math.pi * diameter**2 * math.tan(math.pi / count) / count)


def contact_energy(outlines, diameters, line_tension):
    """Σ over vertices near the other droplet of k/2 (1 - 2d/l)²; l the mean l_eq, k = γ l.

    d is the distance of the vertex from the other outline, by shapely; negative inside.
    """
    lengths = [rest_length(o, d) for o, d in zip(outlines, diameters, strict=True)]
    length = sum(lengths) / 2
    total = 0.0
    for one, other in (outlines, outlines[::-1]):
        polygon = shapely.Polygon(other)
        for vertex in one:
            point = shapely.Point(vertex)
            distance = polygon.exterior.distance(point) * (-1 if polygon.contains(point) else 1)
            total += 0.5 * line_tension * length * max(0.0, 1 - 2 * distance / length) ** 2
    return total


@pytest.mark.parametrize("second", [1.0, 0.7])
@pytest.mark.parametrize("turn", [0.0, 0.3, 2.0])
def test_contact_energy_is_that_of_the_distances(model, system, second, turn):
    """The report equals a sum over vertices with distances from another library."""
    row = model()
    for gap in (1.02, 0.995, 0.98):
        apart = gap * (0.5 + second / 2) * np.array([math.cos(turn), math.sin(turn)])
        two = system(row, STILL, NO_OBSTACLES, [[0.0, 0.0, 1.0], [*apart, second]])
        outlines = [outline for _, _, outline, _ in two.outlines()]
        expected = contact_energy(outlines, (1.0, second), 80.0)
        assert two.energies()["contact"] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert expected > 0


def collision_without_drag(model, system, time_step, turn):
    """Two drops pressed together in still fluid, let go: energies, momenta, contact, parting."""
    row = model(
        line_tension=1.0,
        core={
            "time_step": time_step,
            "sample_interval": time_step,
            "drag": 1e-9,
            "neck_thickness": 0.0,
        },
    )
    apart = 0.98 * np.array([math.cos(turn), math.sin(turn)])
    two = system(row, STILL, NO_OBSTACLES, [[0.0, 0.0, 1.0], [*apart, 1.0]])
    energy, momentum, touch = [], [], []
    for time in np.arange(100) * 0.02:
        two.advance(time)
        velocities = [v for _, _, _, v in two.outlines()]
        report = two.energies()
        energy.append(report["total"] + sum(0.5 * (v**2).sum() / len(v) for v in velocities))
        momentum.append(sum(v.mean(axis=0) for v in velocities))
        touch.append(report["contact"])
    parting = velocities[1].mean(axis=0) - velocities[0].mean(axis=0)
    return np.array(energy), np.array(momentum), np.array(touch), parting @ apart


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_contact_force_is_the_gradient_of_its_energy_and_has_its_reaction(model, system, turn):
    """Without drag the pressed drops fly apart: total energy kept to O(Δt²), momentum exactly.

    A force that is not minus the gradient of the reported energy, or has the wrong sign, would
    change the total by the order of the contact energy whatever the step.
    """
    coarse = collision_without_drag(model, system, 1e-3, turn)
    fine = collision_without_drag(model, system, 2.5e-4, turn)
    assert fine[2][0] > 0.3
    assert fine[2][-1] == 0
    assert fine[3] > 0  # they part
    assert np.ptp(fine[0]) < np.ptp(coarse[0]) / 10  # 16 for an exact square law
    assert np.ptp(fine[0]) < 1e-3 * fine[2][0]
    for _, momentum, _, _ in (coarse, fine):
        assert np.abs(momentum).max() < 1e-13


def test_two_droplets_pressed_together_keep_apart(model, system):
    """A second droplet runs into one that an obstacle holds: they press, and do not overlap.

    A vertex may come as near as the range of the repulsion, l_eq/2, or a little into the other:
    2γ per vertex holds more than line tension can press.
    """
    row = model(offset=0.0, simulation_capillary_number=8.0, time_limit=8.0, core=UNBROKEN)
    two = system(row, None, None, [[-3.0, 0.0, 1.0], [-4.2, 0.02, 1.0]])
    pressed, deepest = 0, 0.0
    while not two.finished:
        two.advance(two.time + 0.05)
        first, second = (outline for _, _, outline, _ in two.outlines())
        one, other = shapely.Polygon(first), shapely.Polygon(second)
        pressed += two.energies()["contact"] > 0
        for polygon, vertices in ((one, second), (other, first)):
            inside = [p for p in shapely.points(vertices) if polygon.contains(p)]
            deepest = max([deepest, *(polygon.exterior.distance(p) for p in inside)])
        assert one.is_valid
        assert other.is_valid
        assert _core.area(first) == pytest.approx(math.pi / 4, rel=0.01)
    assert two.result()[_core.RESULT_FIELDS.index("guard")] == 0
    assert pressed > 5
    assert deepest < 0.5 * rest_length(first, 1.0)


def test_small_droplet_beside_the_reference_droplet_is_stable(model, system):
    """A droplet of a quarter of the diameter is stiffer; the step must do for it as well."""
    row = model(time_limit=1.0)
    two = system(row, STILL, NO_OBSTACLES, [[0.0, 0.0, 1.0], [2.0, 0.0, 0.25]])
    two.advance(1.0)
    assert two.result()[_core.RESULT_FIELDS.index("guard")] == 0
