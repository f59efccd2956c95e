"""Area, perimeter, centre, shape parameter and impact parameter against independent values."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

shapely = pytest.importorskip("shapely")

COUNTS = [5, 16, 37, 64]


def simple_outlines(random_outline, seed, number):
    """Outlines that shapely accepts, with their shapely polygons."""
    rng = np.random.default_rng(seed)
    found = 0
    while found < number:
        outline = random_outline(rng, int(rng.choice(COUNTS))) + rng.normal(0, 3, 2)
        polygon = shapely.Polygon(outline)
        if polygon.is_valid:
            found += 1
            yield outline, polygon


def test_measures_agree_with_shapely_on_random_non_convex_outlines(random_outline):
    """Area, perimeter and centroid equal those of another library to round-off."""
    for outline, polygon in simple_outlines(random_outline, 1, 500):
        assert _core.area(outline) == pytest.approx(polygon.area, rel=1e-11)
        assert _core.perimeter(outline) == pytest.approx(polygon.length, rel=1e-12)
        expected = (polygon.centroid.x, polygon.centroid.y)
        assert _core.centroid(outline) == pytest.approx(expected, rel=1e-10, abs=1e-11)


@pytest.mark.parametrize("count", [3, 4, 6, 64, 1000])
def test_regular_polygon_in_closed_form(regular_polygon, count):
    """A = n/2 r² sin(2π/n), P = 2 n r sin(π/n), and 𝒜 = (n/π) tan(π/n)."""
    outline = regular_polygon(count, 0.7, (3.0, -2.0))
    assert _core.area(outline) == pytest.approx(
        0.5 * count * 0.49 * math.sin(2 * math.pi / count), rel=1e-12
    )
    assert _core.perimeter(outline) == pytest.approx(
        2 * count * 0.7 * math.sin(math.pi / count), rel=1e-12
    )
    assert _core.shape_parameter(outline) == pytest.approx(
        count / math.pi * math.tan(math.pi / count), rel=1e-12
    )


def test_shape_parameter_of_an_ellipse_converges_to_the_elliptic_integral(regular_polygon):
    """P = 4 a E(1 - b²/a²); a polygon misses it by O(1/n²): four times as many, 1/16 the error."""
    special = pytest.importorskip("scipy.special")
    a, b = 1.3, 0.4
    perimeter = 4 * a * special.ellipe(1 - b**2 / a**2)
    exact = perimeter**2 / (4 * math.pi * math.pi * a * b)
    errors = [_core.shape_parameter(regular_polygon(n) * (a, b)) - exact for n in (64, 256, 1024)]
    assert abs(errors[2]) < 1e-4 * exact
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.05)


def test_measures_do_not_depend_on_numbering_direction_or_place(random_outline):
    """Relabelled, reversed, shifted and turned outlines measure the same."""
    rng = np.random.default_rng(2)
    for count in COUNTS:
        outline = random_outline(rng, count)
        shift, turn = rng.normal(0, 2, 2), rng.uniform(0, 2 * np.pi)
        rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        moved = outline @ rotation.T + shift
        center = np.array(_core.centroid(outline))
        same = [np.roll(outline, 3, axis=0), np.ascontiguousarray(outline[::-1]), moved]
        for other in same:
            for measure in (_core.area, _core.perimeter, _core.shape_parameter):
                assert measure(other) == pytest.approx(measure(outline), rel=1e-12)
        assert _core.centroid(same[0]) == pytest.approx(center, abs=1e-13)
        assert _core.centroid(same[1]) == pytest.approx(center, abs=1e-13)
        assert _core.centroid(moved) == pytest.approx(rotation @ center + shift, abs=1e-12)


def test_digits_survive_far_from_the_origin(random_outline):
    """A droplet 1e4 diameters away keeps its area and centre to the digits of its coordinates."""
    outline = random_outline(np.random.default_rng(3), 64)
    far = outline + np.array([1e4, -1e4])
    assert _core.area(far) == pytest.approx(_core.area(outline), rel=1e-10)
    expected = np.array(_core.centroid(outline)) + np.array([1e4, -1e4])
    assert _core.centroid(far) == pytest.approx(expected, abs=1e-10)


def test_centroid_velocity_is_the_derivative_of_the_centroid(random_outline):
    """Central differences of the centroid along the vertices' motion, error O(h²)."""
    rng = np.random.default_rng(4)
    for count in COUNTS:
        for _ in range(20):
            outline, velocity = random_outline(rng, count), rng.normal(size=(count, 2))
            h = 1e-5
            ahead = np.array(_core.centroid(outline + h * velocity))
            behind = np.array(_core.centroid(outline - h * velocity))
            expected = (ahead - behind) / (2 * h)
            scale = np.abs(expected).max() + 1.0
            assert _core.centroid_velocity(outline, velocity) == pytest.approx(
                expected, abs=1e-6 * scale
            )


def test_centroid_velocity_of_a_rigid_motion(random_outline):
    """It is V + ω × (c - o) exactly when the outline moves as a rigid body."""
    rng = np.random.default_rng(5)
    outline = random_outline(rng, 37) + np.array([2.0, -1.0])
    drift, omega = np.array([0.3, -1.7]), 2.5
    velocity = drift + omega * np.column_stack((-outline[:, 1], outline[:, 0]))
    x, y = _core.centroid(outline)
    expected = drift + omega * np.array([-y, x])
    assert _core.centroid_velocity(outline, velocity) == pytest.approx(expected, rel=1e-12)


def test_impact_parameter_is_the_distance_of_the_centre_from_the_line(random_outline):
    """It is |r_cc × v|/|v|, whatever the speed and the sense of the velocity."""
    rng = np.random.default_rng(6)
    for _ in range(100):
        outline = random_outline(rng, 32) + rng.normal(0, 2, 2)
        point, turn = rng.normal(size=2), rng.uniform(0, 2 * np.pi)
        along, across = [np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]
        expected = abs(np.dot(np.array(_core.centroid(outline)) - point, across))
        for speed in (1.0, -3.0, 1e-3):
            direction = tuple(speed * np.array(along))
            assert _core.impact_parameter(outline, tuple(point), direction) == pytest.approx(
                expected, rel=1e-9, abs=1e-12
            )


@pytest.mark.parametrize("seed", range(5))
def test_self_intersection_agrees_with_shapely(seed):
    """Random closed polylines, from nearly convex to tangled: just the crossing ones are found."""
    rng = np.random.default_rng(seed)
    seen = {True: 0, False: 0}
    for _ in range(300):
        count = int(rng.integers(5, 70))
        angle = np.arange(count) * 2 * np.pi / count
        outline = np.column_stack((np.cos(angle), np.sin(angle)))
        outline += rng.normal(0, rng.choice([0.5, 1.0, 2.0]) * 2 / count, (count, 2))
        crosses = not shapely.LinearRing(outline).is_simple
        assert _core.self_intersects(outline) == crosses
        seen[crosses] += 1
    assert min(seen.values()) > 30


def test_self_intersection_of_every_pair_of_edges():
    """One spike that reaches over the far side is found wherever the numbering starts."""
    angle = np.arange(24) * 2 * np.pi / 24
    outline = np.column_stack((np.cos(angle), np.sin(angle)))
    outline[7] = outline[19] * 1.2 + [0.05, 0.0]
    for first in range(24):
        assert _core.self_intersects(np.roll(outline, first, axis=0))
    outline[7] = outline[19] * 0.8
    for first in range(24):
        assert not _core.self_intersects(np.roll(outline, first, axis=0))


def test_cut_keeps_area_and_centre_of_both_parts(random_outline):
    """The parts of a cut along a chord, re-spaced, have the area and the centre of the pieces."""
    rng = np.random.default_rng(8)
    tested = 0
    while tested < 100:
        outline = random_outline(rng, 64)
        i, j = sorted(rng.choice(64, 2, replace=False).tolist())
        if not 16 <= j - i <= 48:
            continue
        pieces = [outline[i : j + 1], np.concatenate((outline[j:], outline[: i + 1]))]
        polygons = [shapely.Polygon(piece) for piece in pieces]
        if not all(p.is_valid for p in polygons) or not shapely.Polygon(outline).is_valid:
            continue
        if not all(p.exterior.is_ccw for p in polygons):
            continue  # a chord outside the droplet, which is none of the neck's
        tested += 1
        counts = (int(rng.integers(16, 80)), int(rng.integers(16, 80)))
        parts = _core.cut(outline, i, j, *counts)
        for part, polygon, count in zip(parts, polygons, counts, strict=True):
            assert len(part) == count
            assert _core.area(part) == pytest.approx(polygon.area, rel=1e-10)
            expected = (polygon.centroid.x, polygon.centroid.y)
            assert _core.centroid(part) == pytest.approx(expected, abs=1e-10)
        total = _core.area(parts[0]) + _core.area(parts[1])
        assert total == pytest.approx(_core.area(outline), rel=1e-10)
