"""`total_energy` and `term_forces`: what they report and what they refuse."""

import numpy as np
import pytest

import pinchoff as po


def polygon(count, radius=0.5, x=-2.0):
    angle = 2 * np.pi * np.arange(count) / count
    return np.column_stack([x + radius * np.cos(angle), radius * np.sin(angle)])


def test_regular_polygon_at_its_rest_area_has_line_tension_only():
    p = po.Parameters()
    count = p.vertex_count
    radius = np.sqrt(np.pi / 2 / count / np.sin(2 * np.pi / count))  # area π/4
    energy = po.total_energy(p, polygon(count, radius))
    perimeter = 2 * count * radius * np.sin(np.pi / count)
    assert energy["line_tension"] == pytest.approx(p.line_tension * perimeter, rel=1e-12)
    assert energy["area"] == pytest.approx(0, abs=1e-12)
    assert energy["edges"] == pytest.approx(0, abs=1e-12)
    assert energy["wall"] == 0
    assert energy["total"] == pytest.approx(energy["line_tension"], rel=1e-12)


def test_forces_point_down_the_energy():
    p = po.Parameters()
    outline = polygon(64, 0.5, x=-0.66)  # a little inside the wall's reach
    forces = po.term_forces(p, outline)
    step = 1e-9
    total = sum(forces.values())
    before = po.total_energy(p, outline)["total"]
    along = po.total_energy(p, outline + step * total)["total"]
    assert po.total_energy(p, outline)["wall"] > 0
    assert along - before == pytest.approx(-step * np.sum(total**2), rel=1e-3)


@pytest.mark.parametrize(
    ("outline", "got"),
    [
        (polygon(15), "shape (15, 2)"),
        (np.zeros((20, 3)), "shape (20, 3)"),
        ("circle", "str"),
        (np.where(polygon(20) > 0.3, np.nan, polygon(20)), "not finite"),
        (polygon(20)[::-1], "clockwise"),
        (np.column_stack([np.arange(20.0), np.zeros(20)]), "clockwise"),
    ],
)
def test_refuses(outline, got):
    with pytest.raises(po.InputError, match=r"outline must be .*; got .*; ") as error:
        po.total_energy(po.Parameters(), outline)
    assert got in str(error.value)
