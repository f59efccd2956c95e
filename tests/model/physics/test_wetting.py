"""Wet pillars: a droplet meets one at its contact angle; a dry pillar is as before."""

from __future__ import annotations

import functools

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff import _core

PILLAR = 10.0  # D0: flat, to a droplet
EVEN = {"edge_stiffness": 0.01}  # springs that hardly pull
MODELS = {"deformable-particle": EVEN, "front-tracking": {"vertex_count": 96}}


@functools.cache
def at_rest(model, angle, **constants):
    """Let a droplet drift onto a large pillar, as slowly as that line tension rules its shape."""
    p = po.Parameters(
        model=model,
        size_ratio=1 / PILLAR,
        simulation_capillary_number=2,
        contact_angle=angle,
        start_distance=11,
        time_limit=9,
        neck_thickness=0,
        **constants,
    )
    gentle = po.flow.uniform(0.01, 0)
    run = po.simulate(p, flow=gentle, droplets=[[-PILLAR - 0.555, 0, 1]], outlines=1.0)
    outlines = run.outlines
    return outlines.outline(len(outlines.offsets) - 2).vertices, p.vertex_count


def angle_of(outline, surface, free):
    """Angle inside the droplet between the circle of its free part and the pillar's surface."""
    x, y = outline[np.hypot(*outline.T) > surface + free].T
    (a, b, c), *_ = np.linalg.lstsq(
        np.column_stack((x, y, np.ones(len(x)))), x**2 + y**2, rcond=None
    )
    radius, distance = np.sqrt(c + (a**2 + b**2) / 4), np.hypot(a, b) / 2
    cosine = (distance**2 - radius**2 - surface**2) / (2 * radius * surface)
    return 180 - np.degrees(np.arccos(cosine))


def spacing_of(count):
    return np.sqrt(np.pi * np.tan(np.pi / count) / count)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("angle", [60, 90, 120])
def test_droplet_at_rest_meets_a_large_pillar_at_the_contact_angle(model, angle):
    """Within 3 degrees, and at 90 and 120 within 1.5."""
    outline, count = at_rest(model, angle, **MODELS[model])
    spacing = spacing_of(count)
    away = 0.5 * spacing if model == "deformable-particle" else 0.0
    met = angle_of(outline, PILLAR + away, 4.5 * spacing)
    assert met == pytest.approx(angle, abs=3 if angle == 60 else 1.5)


def test_contact_line_is_not_pinned_to_vertices():
    """One that recedes, from 60 degrees, and one that advances, from 120, end at one angle."""
    p = po.Parameters(
        model="front-tracking",
        size_ratio=1 / PILLAR,
        simulation_capillary_number=2,
        contact_angle=90,
        start_distance=11,
        **MODELS["front-tracking"],
    )
    pillar, gentle, ends = np.array([[0.0, 0.0, PILLAR]]), po.flow.uniform(0.01, 0), []
    for angle in (60, 120):
        outline, count = at_rest("front-tracking", angle, **MODELS["front-tracking"])
        outline, _ = _core.advance_front(p.model_row(), gentle, outline, pillar, 2e-5, 100_000)
        ends.append(angle_of(outline, PILLAR, 4.5 * spacing_of(count)))
    assert ends[0] == pytest.approx(ends[1], abs=0.01)


def test_stiff_springs_pull_the_droplet_off():
    """With their tension T, cos θ' = (1 + cos θ)/(1 + T/γ) - 1: at 90 it is far from 90."""
    outline, count = at_rest("deformable-particle", 90)
    spacing = spacing_of(count)
    edges = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
    tension = 3 * (edges.sum() - count * spacing)
    expected = np.degrees(np.arccos(1 / (1 + tension) - 1))
    met = angle_of(outline, PILLAR + spacing / 2, 2.5 * spacing)
    assert met == pytest.approx(expected, abs=4)
    assert met > 105


@pytest.mark.parametrize("model", MODELS)
def test_at_180_nothing_pulls_to_the_bit(model):
    p = po.Parameters(model=model, contact_angle=180)
    row = dict(zip(_core.MODEL_FIELDS, p.model_row(), strict=True))
    assert row["adhesion"] == 0.0
    outline = circle(-0.5 - p.obstacle_radius - 0.01)
    assert not po.term_forces(p, outline)["adhesion"].any()
    vary = {"model": model, "offset": [0.0, 0.1, 0.3], "follow_daughters": False}
    dry = po.simulate_many({**vary, "contact_angle": 180.0})
    default = po.simulate_many(vary)
    shared = list(default)
    pd.testing.assert_frame_equal(dry[shared], default[shared], check_exact=True)


@pytest.mark.parametrize("model", MODELS)
def test_pull_is_towards_the_pillar_and_grows_as_the_angle_falls(model):
    """Of a circle a little away from a pillar."""
    pulls = []
    for angle in (150, 120, 90, 60):
        p = po.Parameters(model=model, contact_angle=angle)
        outline = circle(-0.5 - p.obstacle_radius - 0.03)
        pulls.append(po.term_forces(p, outline)["adhesion"][:, 0].sum() / (p.line_tension or 1))
    expected = 1 + np.cos(np.radians([150, 120, 90, 60]))
    assert pulls[0] > 0
    np.testing.assert_allclose(np.array(pulls) / pulls[0], expected / expected[0], rtol=1e-12)


def test_outline_that_goes_back_along_a_pillar_gains_nothing():
    """The energy of a fold is that of the way round the pillar, not of its length."""
    p = po.Parameters(contact_angle=60, size_ratio=0.1, start_distance=11)
    plain = circle(-10.48, 96)
    near = np.argmax(plain[:, 0])
    folded = np.insert(plain, near + 1, plain[[near, near - 1, near]][1:], axis=0)
    energy = [po.total_energy(p, outline)["adhesion"] for outline in (plain, folded)]
    spacing = [spacing_of(len(outline)) for outline in (plain, folded)]
    assert energy[0] < 0
    assert energy[1] == pytest.approx(energy[0], rel=2 * (spacing[0] / spacing[1] - 1))


def circle(x, count=64):
    turn = (np.arange(count) + 0.5) * 2 * np.pi / count
    return np.column_stack((x + 0.5 * np.cos(turn), 0.5 * np.sin(turn)))
