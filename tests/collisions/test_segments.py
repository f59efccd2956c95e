"""Circular segments, and the exponent that one height gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core
from pinchoff.collisions.circle_segments import (
    SMALL_SEGMENT_EXPONENT,
    area_ratio_bound,
    local_exponent,
    segment_area,
    symmetry_of_height,
    symmetry_of_impact,
)
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE


def test_areas_of_known_segments():
    assert segment_area([0.0, 1.0, 2.0], 2.0) == pytest.approx([0, math.pi / 2, math.pi])
    # height r/2 of the unit circle: a sector of 120° less a triangle
    assert segment_area(0.5, 2.0) == pytest.approx(math.pi / 3 - math.sqrt(3) / 4)


def test_symmetry_is_that_of_an_outline():
    """The geometry that measures simulated and filmed droplets gives the same S."""
    angles = np.linspace(0, 2 * math.pi, 4000, endpoint=False)
    for impact in (0.0, 0.1, 0.31, 0.49):
        outline = np.stack([np.cos(angles), np.sin(angles)], axis=1) / 2 + (-1.0, impact)
        measured = _core.symmetry(outline, (0.0, 0.0), (1.0, 0.0))
        assert symmetry_of_impact(impact) == pytest.approx(measured, abs=1e-5)
    assert symmetry_of_impact([-0.2, 0.5, 0.8])[1:].tolist() == [0, 0]
    assert symmetry_of_impact(-0.2) == symmetry_of_impact(0.2)


def test_one_height_gives_minus_three_quarters_for_large_droplets():
    """S of circles that share h, by their areas: the slope of ln S against ln A."""
    height = 1.0
    slopes = []
    for relative in (0.2, 0.05, 0.02, 0.002):
        diameters = height / relative * np.array([1.0, 1.01])
        symmetry = 2 * segment_area(height, diameters) / (math.pi / 4 * diameters**2)
        slopes.append(np.diff(np.log(symmetry))[0] / np.diff(np.log(diameters**2))[0])
    assert slopes[-1] == pytest.approx(SMALL_SEGMENT_EXPONENT, abs=4e-4)
    assert np.all(np.diff(slopes) < 0)
    # the first correction is proportional to h/D
    deviations = np.array(slopes) + 0.75
    assert deviations[2] / deviations[3] == pytest.approx(10, rel=0.02)


def test_local_exponent_is_the_derivative():
    relative = np.array([0.01, 0.1, 0.3, 0.5 - 1e-4])
    step = 1e-6
    logs = np.log(symmetry_of_height(relative * (1 + step))), np.log(symmetry_of_height(relative))
    by_difference = -0.5 * (logs[0] - logs[1]) / math.log(1 + step)
    assert local_exponent(relative) == pytest.approx(by_difference, rel=1e-4)
    assert local_exponent(0.5) == pytest.approx(-2 / math.pi)


def test_the_papers_ratio_of_the_smaller_parts():
    """Twice the radius on the separating line: A_small grows as A^(1 + β), 4^0.26 = 1.43."""
    assert 4 ** (1 + PAPER_EXPERIMENT_LINE.beta) == pytest.approx(1.434, abs=1e-3)


def test_the_bound_on_daughters_is_the_ratio_of_the_two_sides():
    """S is twice the smaller side's share of the area, so the other side has the rest."""
    smaller = np.linspace(0.01, 0.5, 20)
    np.testing.assert_allclose(area_ratio_bound(2.0 * smaller), smaller / (1.0 - smaller))
