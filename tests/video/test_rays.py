"""Rays across borders: analytic pictures, and the same in NumPy."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pinchoff import _core

SIZE = (160, 120)
CENTRE, RADIUS = np.array([81.3, 58.7]), 30.0


def circle(radius=RADIUS, count=400):
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return CENTRE + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def depth():
    """Pixels within the circle, at every pixel."""
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    return RADIUS - np.hypot(columns - CENTRE[0], rows - CENTRE[1])


def border(line, size=(0, 0)):
    return _core.region_border(line, 1.5, 24, 256, 1.5, 1.5, size)


@pytest.mark.parametrize("turned", [1, -1])
def test_a_border_is_even_and_its_normals_point_outwards(turned):
    points, normals, at_edge = border(np.ascontiguousarray(circle()[::turned]))
    outwards = points - CENTRE
    away = np.hypot(*outwards.T)
    assert np.allclose(away, away[0], atol=0.02)
    assert np.allclose(normals, outwards / away[:, None], atol=0.01)
    sides = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    assert sides == pytest.approx(2.0 * np.pi * RADIUS / len(points), rel=0.01)
    x, y = points.T
    assert np.dot(x, np.roll(y, -1)) > np.dot(y, np.roll(x, -1))  # clockwise, y down
    assert not at_edge.any()


def test_a_border_ends_where_the_frame_does():
    points, _, at_edge = border(circle(), (int(CENTRE[0]), SIZE[1]))
    assert at_edge.any()
    assert np.array_equal(at_edge, points[:, 0] >= int(CENTRE[0]) - 1.0 - 1.5)


def test_running_median_is_that_of_rolled_values():
    values = np.random.default_rng(1).standard_normal(57)
    rolled = np.median([np.roll(values, k) for k in range(-4, 5)], axis=0)
    assert np.array_equal(_core.running_median(values, 4), rolled)


def rim_at(dark, width, level=5.0):
    points, normals, _ = border(circle(RADIUS - width))
    return _core.rim_ends(dark, points, normals, -2.0, 0.5, 60, level, 0.5, 5, 6)


@pytest.mark.parametrize("darkness", [20.0, 150.0])
def test_a_rim_ends_where_it_has_lost_half_of_its_darkness(darkness):
    width = 6.0
    rim = np.clip(np.minimum(depth() + 0.5, width - depth() + 0.5), 0.0, 1.0)
    ends, contrasts = rim_at((darkness * rim).astype(np.float32), width)
    assert ends == pytest.approx(width, abs=0.2)
    assert contrasts == pytest.approx(darkness, rel=0.05)


def test_a_rim_that_goes_on_has_no_end():
    dark = np.full(SIZE[::-1], 50.0, dtype=np.float32)
    assert np.isnan(rim_at(dark, 6.0)[0]).all()


def test_a_spot_ends_halfway():
    dark = (10.0 + 80.0 * np.clip(depth() + 0.5, 0.0, 1.0)).astype(np.float32)
    points, normals, _ = border(circle(RADIUS - 1.0))
    contrast, beyond, steepest, place = _core.spot_edges(dark, points, normals, 6.0, 0.5, 4.0).T
    assert contrast == pytest.approx(80.0, abs=0.01)
    assert beyond == pytest.approx(10.0, abs=0.01)
    assert steepest == pytest.approx(60.0, rel=0.4)  # most of it within a pixel
    assert place == pytest.approx(1.0, abs=0.2)
    nowhere = _core.spot_edges(np.zeros_like(dark), points, normals, 6.0, 0.5, 4.0)
    assert np.isnan(nowhere[:, 3]).all()


def test_an_outline_is_traced_about_a_centre_that_is_off():
    image = (60.0 + 100.0 * np.clip(0.5 - depth(), 0.0, 1.0)).astype(np.float32)
    about = np.array([[CENTRE[0] + 3.0, CENTRE[1] - 2.0, 27.0]], dtype=np.float32)
    x, y, contrast, inner, outer = _core.traced_outlines(
        image, about, 64, 44, (0.5, 1.7), 5, 2, 0.02, 0.5, 1.0
    )[:, 0]
    away = np.hypot(x - CENTRE[0], y - CENTRE[1])
    assert away == pytest.approx(RADIUS, abs=0.5)
    assert inner == pytest.approx(60.0, abs=20.0)
    assert outer == pytest.approx(160.0, abs=20.0)  # of a few pixels
    assert contrast == pytest.approx((outer - inner) / (outer + inner + 2.0), abs=1e-4)


def looked_across(image, points, normals, least):
    """What `across` returns, in NumPy; for an outline away from the frame's edge."""
    middle = points.mean(axis=0)
    radius = np.hypot(*(points - middle).T).mean()

    def at(places):
        x, y = places[..., 0].astype(np.float32), places[..., 1].astype(np.float32)
        return cv2.remap(image, x, y, cv2.INTER_LINEAR)

    def along(reach):
        return at(points[:, None] + reach[None, :, None] * normals[:, None])

    profiles, close = along(np.arange(-3, max(6.0, 0.35 * radius))), along(np.arange(-4, 4.1, 0.5))
    change = np.abs(close[:, 11] - close[:, 5])
    placed = np.median(change / np.maximum(np.ptp(close, axis=1), 1.0))
    edge = profiles[:, 4:7].mean(axis=1) - profiles[:, :3].mean(axis=1)
    core = np.median(at(0.5 * (points + middle)[None]))

    def happening(sign):
        rim, beyond = sign * profiles[:, :5], sign * profiles[:, 3:]
        depths = sign * core - rim.min(axis=1)
        ended = np.minimum(sign * core, beyond.max(axis=1)) - rim.min(axis=1)
        ends = np.mean(ended >= 0.25 * max(np.median(depths), 0.0)) >= 0.3
        return np.maximum(sign * edge, depths if ends else ended)

    sign = 1.0 if np.median(happening(1.0)) >= np.median(happening(-1.0)) else -1.0
    happens, outside = happening(sign), sign * profiles[:, 3:]
    undone = (np.maximum.accumulate(outside, axis=1) - outside).max(axis=1)
    rise = outside.max(axis=1) - (sign * profiles[:, :4]).min(axis=1)
    strength = np.median(happens)
    closed = (happens >= max(0.25 * strength, least)).mean()
    inwards = np.median(along(np.arange(3.0, -0.6 * radius, -1.0)), axis=0)
    brightest = inwards.argmax()
    halo, darkest = inwards[brightest] - inwards[0], inwards[brightest:].min()
    is_halo = inwards[0] - darkest >= 0.4 * halo > 0.0 and core - darkest >= 0.25 * halo
    return closed, strength, (undone >= 0.6 * rise).mean(), placed, sign < 0.0 and is_halo


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("look", ["disc", "rim", "halo", "noise"])
def test_what_is_seen_across_an_outline_is_what_numpy_sees(look, sign):
    within = depth()
    shape = {
        "disc": np.clip(0.5 - within, 0.0, 1.0),
        "rim": -np.exp(-0.5 * ((within - 2.0) / 1.5) ** 2),
        "halo": np.exp(-0.5 * (within / 2.0) ** 2) - np.exp(-0.5 * ((within - 8.0) / 2.0) ** 2),
        "noise": 0.0 * within,
    }[look]
    noise = np.random.default_rng(2).standard_normal(shape.shape)
    image = (120.0 + sign * 60.0 * shape + 2.0 * noise).astype(np.float32)
    points, normals, _ = border(circle(RADIUS - 0.4))
    radius = float(np.hypot(*(points - points.mean(axis=0)).T).mean())
    seen = _core.across(
        image,
        points,
        normals,
        3,
        max(6.0, 0.35 * radius),
        4,
        0.25,
        0.3,
        0.6,
        3.0,
        (0.6 * radius, 0.4, 0.25),
    )
    assert seen == pytest.approx(looked_across(image, points, normals, 3.0), abs=0.03, rel=0.02)
    assert seen[4] == (look == "halo" and sign > 0.0)


def test_places_that_are_nowhere_are_read_as_some_pixel():
    """A point that is not a number makes no function look beside the picture."""
    image = np.zeros(SIZE[::-1], dtype=np.float32)
    points, normals, _ = border(circle())
    points[0], normals[1] = np.nan, np.inf
    with np.errstate(invalid="ignore"):
        _core.rim_ends(image, points, normals, -2.0, 0.5, 60, 1.0, 0.5, 5, 6)
        _core.spot_edges(image, points, normals, 6.0, 0.5, 4.0)
        _core.across(image, points, normals, 8, 16.0, 2, 0.2, 0.8, 0.5, 1.0, (4.0, 0.5, 0.5))
        nowhere = np.full((1, 3), np.nan, dtype=np.float32)
        _core.traced_outlines(image, nowhere, 16, 8, (0.5, 1.5), 3, 1, 0.1, 1.0, 1.0)
    assert len(border(np.full((5, 2), np.nan))[0]) == 24


def test_what_would_be_read_beside_the_arrays_is_refused():
    image, none = np.zeros((4, 4), dtype=np.float32), np.zeros((0, 4), dtype=np.float32)
    two, three = np.ones((2, 2)), np.ones((3, 2))
    halo, circles = (4.0, 0.5, 0.5), np.ones((1, 3), dtype=np.float32)
    for call in (
        lambda: border(np.zeros((0, 2))),
        lambda: _core.running_median(np.zeros(4), -1),
        lambda: _core.rim_ends(image, three, two, 0.0, 1.0, 4, 1.0, 0.5, 1, 1),
        lambda: _core.rim_ends(none, two, two, 0.0, 1.0, 4, 1.0, 0.5, 1, 1),
        lambda: _core.rim_ends(image, two, two, 0.0, 1.0, 0, 1.0, 0.5, 1, 1),
        lambda: _core.spot_edges(image, two, two, 6.0, 0.0, 4.0),
        lambda: _core.across(image, three, two, 8, 16.0, 2, 0.2, 0.8, 0.5, 1.0, halo),
        lambda: _core.across(image, two, two, 8, 8.0, 2, 0.2, 0.8, 0.5, 1.0, halo),
        lambda: _core.traced_outlines(image, circles, 16, 0, (0.5, 1.5), 3, 1, 0.1, 1.0, 1.0),
    ):
        with pytest.raises(ValueError, match=r" must .*; got "):
            call()
