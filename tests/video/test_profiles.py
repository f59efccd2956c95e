"""The blurred ring: its width, darkness and edge come back from profiles blurred by brute force."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from pinchoff.video.profiles import across, apparent_width, fit_ring, mean_profile

DARKNESS, WIDTH, INTERIOR = 130.0, 3.4, 27.0
STEP = 0.01
ACROSS = across(12.0)


def blurred_ring(blur, edge=0.0):
    """Darkness across a straight ring, from a fine convolution."""
    x = np.arange(-30.0, 20.0, STEP)
    sharp = np.where(x > edge, 0.0, np.where(x > edge - WIDTH, DARKNESS, INTERIOR))
    return np.interp(ACROSS, x, gaussian_filter1d(sharp, blur / STEP))


def test_width_and_darkness_come_apart_where_the_focus_drifts():
    blurs = np.linspace(0.9, 2.0, 8)
    profiles = [blurred_ring(blur, edge=0.1 * k - 0.4) for k, blur in enumerate(blurs)]
    ring = fit_ring(profiles, ACROSS)
    assert ring.darkness == pytest.approx(DARKNESS, rel=0.005)
    assert ring.width == pytest.approx(WIDTH, abs=0.02)
    assert ring.interior == pytest.approx(INTERIOR, abs=0.3)
    assert ring.blurs == pytest.approx(blurs, abs=0.02)


@pytest.mark.parametrize("blur", [0.8, 1.2, 1.9])
def test_edge_of_a_straight_ring(blur):
    ring = fit_ring([blurred_ring(blur)], ACROSS)
    truth = np.interp(0.0, ACROSS, blurred_ring(blur))
    assert ring.edge(0.0) == pytest.approx(truth, rel=0.02)
    # Where the slope is steepest the darkness is another one as soon as the ring is thin.
    steepest = blurred_ring(blur)[np.argmin(np.gradient(blurred_ring(blur)))]
    assert blur < 1.9 or abs(steepest - truth) > 0.1 * truth


@pytest.mark.parametrize("radius", [12.0, 25.0])
def test_edge_of_a_curved_ring(radius):
    """The darkness at the true radius of a disc that is drawn finely, then blurred."""
    fine, blur = 8, 1.8
    y, x = np.mgrid[-40 * fine : 40 * fine + 1, -40 * fine : 40 * fine + 1] / fine
    away = np.hypot(x, y)
    image = np.where(away > radius, 0.0, np.where(away > radius - WIDTH, DARKNESS, INTERIOR))
    image = cv2.GaussianBlur(image, (0, 0), blur * fine)
    truth = image[40 * fine, round((40 + radius) * fine)]
    ring = fit_ring([blurred_ring(b) for b in (1.0, blur, 2.2)], ACROSS)
    assert ring.edge(1.0 / radius) == pytest.approx(truth, rel=0.01)
    assert ring.edge(0.0) > 1.015 * truth


def test_profile_points_outwards():
    """Dark inside, pale outside: the mean profile falls from its left to its right end."""
    y, x = np.mgrid[:80, :80].astype(np.float32)
    image = np.clip(20.5 - np.hypot(x - 40, y - 40), 0.0, 1.0) * 100
    angles = np.linspace(0.0, 2 * np.pi, 120, endpoint=False)  # clockwise as seen: y is down
    outline = np.array([40.0, 40.0]) + 20.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    profile = mean_profile(image, [outline, outline], ACROSS)
    assert profile[0] == pytest.approx(100.0)
    assert profile[-1] == pytest.approx(0.0)
    assert np.interp(0.0, ACROSS, profile) == pytest.approx(50.0, abs=3.0)


def test_apparent_width_is_between_the_crossings():
    profile = np.interp(ACROSS, [-6.0, -5.0, -1.0, 0.0], [10.0, 90.0, 90.0, 0.0])
    assert apparent_width(profile, ACROSS, 50.0) == pytest.approx(5.5 - 5.0 / 9.0, abs=1e-6)
    assert apparent_width(np.full(len(ACROSS), 100.0), ACROSS, 50.0) == 0.0
    assert apparent_width(np.zeros(len(ACROSS)), ACROSS, 50.0) == 0.0
    assert apparent_width(np.where(ACROSS < 0.0, 100.0, 0.0), ACROSS, 50.0) == 0.0
