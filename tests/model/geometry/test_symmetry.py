"""The symmetry S, eq. symdef, against closed forms and two other ways of clipping a polygon."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

shapely = pytest.importorskip("shapely")


def clipped_area(outline, point, direction):
    """Area left of a line by Sutherland and Hodgman's clipping, then the shoelace formula."""
    along = np.asarray(direction) / np.hypot(*direction)
    height = (outline - point) @ np.array([-along[1], along[0]])
    kept = []
    for k in range(len(outline)):
        a, b, ha, hb = outline[k - 1], outline[k], height[k - 1], height[k]
        if (ha > 0) != (hb > 0):
            kept.append(a + (b - a) * ha / (ha - hb))
        if hb > 0:
            kept.append(b)
    if len(kept) < 3:
        return 0.0
    x, y = (np.array(kept) - point).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def symmetry_of(left, whole):
    """S = 1 - |A_left - A_right|/A, the definition."""
    return 1 - abs(2 * left - whole) / whole


def random_lines(rng, number):
    for _ in range(number):
        turn = rng.uniform(0, 2 * np.pi)
        speed = rng.choice([1e-3, 1.0, 50.0])
        yield rng.normal(0, 0.25, 2), speed * np.array([np.cos(turn), np.sin(turn)])


def test_symmetry_agrees_with_shapely_on_non_convex_outlines(random_outline):
    """S of random outlines, cut by the line into several parts, equals shapely's intersection."""
    rng = np.random.default_rng(11)
    tested = parts = 0
    while tested < 500:
        outline = random_outline(rng, int(rng.choice([16, 37, 64])))
        polygon = shapely.Polygon(outline)
        if not polygon.is_valid:
            continue
        for point, direction in random_lines(rng, 2):
            along = direction / np.hypot(*direction)
            across = np.array([-along[1], along[0]])
            corners = [-9 * along, 9 * along, 9 * along + 9 * across, -9 * along + 9 * across]
            part = polygon.intersection(shapely.Polygon([point + c for c in corners]))
            expected = symmetry_of(part.area, polygon.area)
            got = _core.symmetry(outline, tuple(point), tuple(direction))
            assert got == pytest.approx(expected, abs=1e-10)
            parts += part.geom_type == "MultiPolygon"
            tested += 1
    assert parts > 20  # lines that cut off more than one part were among them


def test_symmetry_agrees_with_another_clipping_on_any_polygon(random_outline):
    """Also where no library is asked: Sutherland and Hodgman's clipping in NumPy."""
    rng = np.random.default_rng(12)
    for _ in range(300):
        outline = random_outline(rng, 64)
        whole = _core.area(outline)
        for point, direction in random_lines(rng, 2):
            expected = symmetry_of(clipped_area(outline, point, direction), whole)
            got = _core.symmetry(outline, tuple(point), tuple(direction))
            assert got == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("shift", [0.0, 0.1, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("side", [1, -1])
def test_symmetry_of_a_shifted_circle(regular_polygon, shift, side):
    """S = 2 [arccos h - h √(1 - h²)]/π; a polygon of n sides is off by O((2π/n)²)."""
    count = 8192
    circle = regular_polygon(count, 1.0, (-4.0, side * shift))
    expected = 2 * (math.acos(shift) - shift * math.sqrt(1 - shift**2)) / math.pi
    got = _core.symmetry(circle, (0.0, 0.0), (2.0, 0.0))
    assert got == pytest.approx(expected, abs=(2 * math.pi / count) ** 2)


def test_symmetry_is_zero_beside_the_line_and_never_negative(regular_polygon):
    """A droplet wholly on one side has S = 0, however it is placed."""
    for shift in (1.0, 1.5, 40.0):
        for side in (1, -1):
            circle = regular_polygon(64, 1.0, (0.3, side * shift))
            assert _core.symmetry(circle, (0.0, 0.0), (1.0, 0.0)) == pytest.approx(0, abs=1e-12)
            assert _core.symmetry(circle, (0.0, 0.0), (1.0, 0.0)) >= 0


def test_symmetry_depends_on_the_line_only(random_outline):
    """Neither the sense and size of the velocity, nor the point on the line, nor the numbering."""
    rng = np.random.default_rng(13)
    for _ in range(50):
        outline = random_outline(rng, 48)
        point, turn = rng.normal(0, 0.2, 2), rng.uniform(0, 2 * np.pi)
        along = np.array([np.cos(turn), np.sin(turn)])
        expected = _core.symmetry(outline, tuple(point), tuple(along))
        same = [
            _core.symmetry(outline, tuple(point), tuple(-2.5 * along)),
            _core.symmetry(outline, tuple(point + 7 * along), tuple(along)),
            _core.symmetry(np.roll(outline, 5, axis=0), tuple(point), tuple(along)),
            _core.symmetry(np.ascontiguousarray(outline[::-1]), tuple(point), tuple(along)),
        ]
        assert same == pytest.approx([expected] * 4, abs=1e-12)
        flip = np.array([1, -1])
        mirrored = _core.symmetry(outline * flip, tuple(point * flip), tuple(along * flip))
        assert mirrored == pytest.approx(expected, abs=1e-12)


def test_vertices_on_the_line_are_counted_once(regular_polygon):
    """A line through vertices, and along an edge, splits a square as it should."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert _core.symmetry(square, (0.0, 0.0), (1.0, 1.0)) == pytest.approx(1.0, abs=1e-15)
    assert _core.symmetry(square, (5.0, 0.0), (1.0, 0.0)) == pytest.approx(0.0, abs=1e-15)
    assert _core.symmetry(square, (0.0, 0.25), (1.0, 0.0)) == pytest.approx(0.5, abs=1e-15)
    even = regular_polygon(64, 0.5)
    assert _core.symmetry(even, (0.0, 0.0), (1.0, 0.0)) == pytest.approx(1.0, abs=1e-14)
