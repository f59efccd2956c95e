"""The mesh fits the geometry, is well shaped, and is as fine as it is asked to be."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from shapely import MultiPolygon, Point, Polygon, box

from pinchoff.chamber.mesh import GROWTH, build_mesh, wall_size

SQUARE = box(0, 0, 1000, 800)


def holed(*circles):
    rings = [Point(x, y).buffer(r, quad_segs=32).exterior for x, y, r in circles]
    return MultiPolygon([Polygon(SQUARE.exterior, rings)])


def mesh_of(shape, size=12.0):
    return build_mesh(shape, lambda points: np.full(len(points), size), 64.0)


def test_triangles_fill_the_shape_without_holes_or_overlaps():
    shape = holed((300, 400, 85), (700, 300, 120), (620, 620, 60))
    mesh = mesh_of(shape)
    assert (mesh.areas() > 0).all()
    # The nodes' chords stand off the circles by less than h²/8R.
    assert mesh.areas().sum() == pytest.approx(shape.area, rel=1e-3)
    edges = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    assert counts.max() == 2
    assert (counts == 1).sum() == mesh.wall_count  # as many wall edges as wall nodes
    assert len(np.unique(mesh.triangles)) == len(mesh.points)


def test_corners_are_nodes():
    mesh = mesh_of(holed((300, 400, 85)))
    corners = itertools.product((0, 1000), (0, 800))
    assert all(np.hypot(*(mesh.points - corner).T).min() < 1e-9 for corner in corners)


def test_no_triangle_is_a_sliver():
    mesh = mesh_of(holed((300, 400, 85), (700, 300, 120)))
    corners = mesh.points[mesh.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    sides.sort(axis=1)
    cosine = (sides[:, 1] ** 2 + sides[:, 2] ** 2 - sides[:, 0] ** 2) / (
        2 * sides[:, 1:].prod(axis=1)
    )
    angles = np.degrees(np.arccos(cosine))  # over the shortest side: the smallest
    assert angles.min() > 15
    assert np.median(angles) > 42


def test_a_gap_narrower_than_an_element_gets_elements_of_its_own():
    shape = holed((400, 400, 100), (604, 400, 100))  # 4 µm apart, at 12 µm elements
    mesh = mesh_of(shape)
    assert mesh.areas().sum() == pytest.approx(shape.area, rel=1e-3)
    middle = np.array([[502.0, 400.0]])
    assert mesh.locate(middle)[0] >= 0


@pytest.mark.parametrize("elements", [6, 12, 20])
def test_at_least_so_many_elements_span_a_gap(elements):
    gap = 400.0
    shape = MultiPolygon([box(0, 0, 1500, gap)])
    mesh = mesh_of(shape, wall_size(gap, elements))
    y = np.linspace(0.1, gap - 0.1, 4000)
    counts = []
    for x in np.linspace(500, 1000, 41):
        triangle = mesh.locate(np.column_stack([np.full_like(y, x), y]))
        edges = np.sqrt(mesh.areas()[triangle] * 4 / np.sqrt(3))
        counts.append(gap * np.mean(1 / edges))
    assert elements <= np.mean(counts) < 1.35 * elements


def test_wall_size_solves_its_equation():
    h = wall_size(730.0, 20)
    assert np.log1p(GROWTH * 730.0 / 2 / h) / GROWTH == pytest.approx(10)


def test_locate_says_which_triangle_and_none_in_a_hole():
    mesh = mesh_of(holed((300, 400, 85)))
    points = np.random.default_rng(1).uniform((0, 0), (1000, 800), (300, 2))
    found = mesh.locate(points)
    inside = np.hypot(*(points - [300, 400]).T) > 86
    assert (found[inside] >= 0).all()
    assert mesh.locate(np.array([[300.0, 400.0]]))[0] == -1
    for point, triangle in zip(points[inside], found[inside], strict=True):
        assert Polygon(mesh.points[mesh.triangles[triangle]]).buffer(1e-6).contains(Point(point))
