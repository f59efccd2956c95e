"""The neck and its look-ahead against brute force on thousands of random non-convex outlines."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff import _core

UNITS = pytest.mark.parametrize(
    ("separation", "in_diameters"), [(0.28, False), (0.1, False), (0.28, True), (0.9, True)]
)


def pair_table(outline):
    """For every pair of vertices i < j: i, j, chord and the arcs either way."""
    edges = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
    arc = np.concatenate(([0.0], np.cumsum(edges)))
    i, j = np.triu_indices(len(outline), 1)
    chord = np.hypot(*(outline[j] - outline[i]).T)
    forward = arc[j] - arc[i]
    return i, j, chord, forward, arc[-1] - forward


def threshold_arc(outline, separation, in_diameters, diameter=1.0):
    """The arc that both sides of a neck must exceed."""
    if in_diameters:
        return separation * diameter
    return separation * np.hypot(*(np.roll(outline, -1, axis=0) - outline).T).sum()


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def leaves_inwards(outline, i, j):
    """Whether the chord leaves both ends to the left of the line through their neighbours."""
    along = np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)
    chord = outline[j] - outline[i]
    return (cross(along[i], chord) > 0) & (cross(along[j], -chord) > 0)


def crosses_no_edge(outline, i, j):
    """Whether the open chord meets no edge, by the signs of four triangles."""
    a, b, c, d = outline[i], outline[j], outline, np.roll(outline, -1, axis=0)
    astride = cross(b - a, c - a) * cross(b - a, d - a) < 0
    return not np.any(astride & (cross(d - c, a - c) * cross(d - c, b - c) < 0))


def brute_force(outline, separation, in_diameters, diameter=1.0, *, uncrossed=False):
    """Thinnest chord whose shorter arc exceeds the threshold and which leaves both ends inwards."""
    i, j, chord, forward, backward = pair_table(outline)
    admissible = np.minimum(forward, backward) > threshold_arc(
        outline, separation, in_diameters, diameter
    )
    admissible &= leaves_inwards(outline, i, j)
    if uncrossed:
        for pair in np.flatnonzero(admissible)[np.argsort(chord[admissible])]:
            if crosses_no_edge(outline, i[pair], j[pair]):
                return chord[pair]
        return np.inf
    return chord[admissible].min() if admissible.any() else np.inf


def exact_budgets(outline, separation, in_diameters, threshold, cap):
    """For every pair, the displacement that could make it a neck (see `scan_neck`), and i, j."""
    i, j, chord, forward, backward = pair_table(outline)
    count, steps = len(outline), j - i
    least = threshold_arc(outline, separation, in_diameters)
    fraction = 0.0 if in_diameters else separation
    gain_forward = 2 * (steps * (1 - fraction) + (count - steps) * fraction)
    gain_backward = 2 * ((count - steps) * (1 - fraction) + steps * fraction)
    budget = np.maximum.reduce(
        [
            (np.minimum(chord, cap) - threshold) / 2,
            (least - forward) / gain_forward,
            (least - backward) / gain_backward,
        ]
    )
    return budget, i, j


@UNITS
@pytest.mark.parametrize("count", [16, 37, 64, 90])
def test_neck_equals_brute_force(random_outline, separation, in_diameters, count):
    """Thickness, and the pair named has that chord and is admissible; both ways of looking."""
    rng = np.random.default_rng(count)
    for _ in range(150):
        outline = random_outline(rng, count)
        if _core.self_intersects(outline):
            continue  # a coarse, twisted star may: it has no inside
        expected = brute_force(outline, separation, in_diameters)
        thickness, i, j = _core.neck(outline, separation, in_diameters)
        inside = brute_force(outline, separation, in_diameters, uncrossed=True)
        # Among chords equal to 1e-6 of each other `neck` may take another than the very thinnest.
        assert thickness == pytest.approx(inside, rel=2e-6)
        scanned, _ = _core.scan_neck(outline, separation, in_diameters, 0.167)
        assert scanned == pytest.approx(expected, rel=1e-13)
        if np.isfinite(inside):
            assert 0 <= i < j < count
            assert thickness == pytest.approx(np.hypot(*(outline[j] - outline[i])), rel=1e-14)
            _, _, _, forward, backward = pair_table(outline)
            pair = i * count - i * (i + 1) // 2 + (j - i - 1)
            shorter = min(forward[pair], backward[pair])
            assert shorter > threshold_arc(outline, separation, in_diameters)
            assert leaves_inwards(outline, i, j)
            assert crosses_no_edge(outline, i, j)


def test_neck_in_diameters_scales_with_the_diameter(random_outline):
    """The diameter only multiplies a separation in diameters, and does nothing to a fraction."""
    rng = np.random.default_rng(21)
    for _ in range(100):
        outline = random_outline(rng, 48)
        assert _core.neck(outline, 0.28, True, 1.7) == _core.neck(outline, 0.28 * 1.7, True, 1.0)
        assert _core.neck(outline, 0.28, False, 1.7) == _core.neck(outline, 0.28, False, 1.0)


def test_no_neck_where_no_pair_is_far_enough_apart(random_outline):
    """A separation of half the perimeter or more admits no pair."""
    outline = random_outline(np.random.default_rng(22), 64)
    assert _core.neck(outline, 0.5, False) == (np.inf, -1, -1)
    assert _core.scan_neck(outline, 0.5, False, 0.167)[0] == np.inf


def test_neck_does_not_depend_on_numbering_or_mirror(random_outline):
    """The same two points are named wherever the numbering starts, and in the mirror."""
    rng = np.random.default_rng(23)
    for _ in range(100):
        outline = random_outline(rng, 64)
        thickness, i, j = _core.neck(outline)
        ends = np.sort(outline[[i, j]], axis=0)
        for other in (np.roll(outline, 11, axis=0), np.ascontiguousarray(outline[::-1])):
            again, k, m = _core.neck(other)
            assert again == pytest.approx(thickness, rel=1e-13)
            np.testing.assert_allclose(np.sort(other[[k, m]], axis=0), ends, rtol=1e-14)
        assert _core.neck(outline * [1, -1])[0] == pytest.approx(thickness, rel=1e-13)


@UNITS
def test_budget_lies_between_half_of_the_exact_one_and_the_exact_one(
    random_outline, separation, in_diameters
):
    """Safe: never more than the smallest budget of any pair. Useful: at least half of it.

    Pairs that leave an end outwards may have a larger budget than their chord and arcs give them,
    so only the others bound the outline's from above. The secant of r(r²) below the cap 3d gives
    (r - d)/2 times (r + d)/4d, which is at least half; the budgets of the arcs are taken exactly.
    """
    rng = np.random.default_rng(31)
    for _ in range(400):
        outline = random_outline(rng, int(rng.choice([16, 37, 64])))
        threshold = rng.uniform(0.02, 1.0) * min(
            1.0, brute_force(outline, separation, in_diameters)
        )
        _, budget = _core.scan_neck(outline, separation, in_diameters, threshold)
        own, i, j = exact_budgets(outline, separation, in_diameters, threshold, 3 * threshold)
        inwards = own[leaves_inwards(outline, i, j)].min()
        assert 0.5 * own.min() - 1e-14 <= budget <= min(inwards, threshold) + 1e-14


def adversarial_displacements(rng, outline, i, j):
    """Unit displacement fields that try to turn the pair i, j into a neck at the least cost.

    Its ends approach each other; the vertices of one arc zigzag, which lengthens it most; those of
    the other straighten, which shortens the perimeter, or zigzag too.
    """
    count = len(outline)
    edge = np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)
    normal = np.column_stack((edge[:, 1], -edge[:, 0])) / np.hypot(*edge.T)[:, None]
    zigzag = normal * np.where(np.arange(count) % 2, 1.0, -1.0)[:, None]
    middle = 0.5 * (np.roll(outline, 1, axis=0) + np.roll(outline, -1, axis=0)) - outline
    flatten = middle / np.maximum(np.hypot(*middle.T), 1e-300)[:, None]
    inside = ((np.arange(count) - i) % count < (j - i) % count)[:, None]
    chord = outline[j] - outline[i]
    toward = chord / np.hypot(*chord)
    for base in (
        np.where(inside, zigzag, flatten),
        np.where(inside, flatten, zigzag),
        np.where(inside, -zigzag, flatten),
        zigzag,
        np.where(inside, zigzag, toward),
    ):
        field = base.copy()
        field[i], field[j] = toward, -toward
        yield field
    turn = rng.uniform(0, 2 * np.pi, count)
    field = np.column_stack((np.cos(turn), np.sin(turn)))
    field[i], field[j] = toward, -toward
    yield field


@UNITS
def test_no_motion_within_the_budget_makes_a_neck(random_outline, separation, in_diameters):
    """Neither random nor adversarial displacements shorter than the budget cross the threshold."""
    rng = np.random.default_rng(41)
    closest = np.inf
    for _ in range(30):
        outline = random_outline(rng, int(rng.choice([16, 37, 64])))
        thinnest = min(1.0, brute_force(outline, separation, in_diameters))
        threshold = rng.uniform(0.3, 0.98) * thinnest
        _, budget = _core.scan_neck(outline, separation, in_diameters, threshold)
        assert budget > 0
        reach = budget * (1 - 1e-9)
        drift = rng.normal(size=2)  # a common translation costs nothing
        own, i, j = exact_budgets(outline, separation, in_diameters, threshold, 3 * threshold)
        inwards = leaves_inwards(outline, i, j)
        nearest = np.argsort(own)
        for pair in (*nearest[inwards[nearest]][:12], *nearest[~inwards[nearest]][:6]):
            for field in adversarial_displacements(rng, outline, i[pair], j[pair]):
                moved = outline + reach * field + drift
                left = brute_force(moved, separation, in_diameters) / threshold
                assert left >= 1 - 1e-12
                closest = min(closest, left)
    assert closest < 1.2  # the displacements came near to what they were to do


def test_budget_is_spent_once_the_neck_is_below_the_threshold(random_outline):
    """With an admissible chord thinner than the threshold nothing may be skipped."""
    rng = np.random.default_rng(51)
    for _ in range(100):
        outline = random_outline(rng, 64)
        thickness = brute_force(outline, 0.28, False)
        assert _core.scan_neck(outline, 0.28, False, 1.01 * thickness)[1] <= 0
        assert _core.scan_neck(outline, 0.28, False, 0.99 * thickness)[1] > 0
