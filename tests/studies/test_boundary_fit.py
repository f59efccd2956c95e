"""The fit of the separating line: known lines, a reference fit, and intervals that hold."""

from __future__ import annotations

import json
import math

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import pinchoff as po
from pinchoff.collisions.law import breakup_number
from pinchoff.studies.boundary.line_fit import fit_line
from pinchoff.studies.boundary.search import Boundary

CA = np.geomspace(0.0015, 0.008, 9)
AREA = np.full(9, 25.16)
GRID_CA, GRID_AREA = (each.ravel() for each in np.meshgrid(CA, np.geomspace(3, 50, 5)))


def noisy(rng, symmetry, sigma):
    return symmetry * np.exp(rng.normal(0, sigma, symmetry.shape))


def test_an_exact_line_comes_back():
    fit = fit_line(CA, AREA, 0.089 * (CA * AREA) ** -0.72)
    assert fit.alpha[:3] == pytest.approx([0.089] * 3)
    assert fit.beta[:3] == pytest.approx([-0.72] * 3)
    assert fit.area_exponent[:3] == (1, 1, 1)
    assert fit.scatter == pytest.approx(0, abs=1e-12)
    assert fit.control_range == pytest.approx((CA[0] * 25.16, CA[-1] * 25.16))
    assert fit.size_ratio_range == pytest.approx((5.66, 5.66), rel=1e-4)
    assert fit.count == 9


def test_points_on_the_line_have_breakup_number_one():
    fit = fit_line(CA, AREA, 0.1 * (CA * AREA) ** -0.6)
    on_line, _, _ = fit.symmetry(CA, AREA)
    assert breakup_number(
        CA, normalized_area=AREA, symmetry=on_line, line=fit.line
    ) == pytest.approx(np.ones(9))


def test_a_free_exponent_of_the_area_comes_back():
    fit = fit_line(GRID_CA, GRID_AREA, 0.02 * (GRID_CA * GRID_AREA**0.4) ** -0.7, free_area=True)
    assert fit.alpha.value == pytest.approx(0.02)
    assert fit.beta.value == pytest.approx(-0.7)
    assert fit.area_power.value == pytest.approx(-0.28)
    assert fit.area_exponent[:3] == pytest.approx([0.4] * 3)
    value, low, high = fit.symmetry(0.004, 20.0)
    assert value == pytest.approx(0.02 * (0.004 * 20**0.4) ** -0.7)
    assert low == pytest.approx(high)


def test_intervals_are_those_of_linear_regression():
    symmetry = noisy(np.random.default_rng(1), 0.089 * (CA * AREA) ** -0.72, 0.03)
    fit = fit_line(CA, AREA, symmetry)
    reference = stats.linregress(np.log(CA * AREA), np.log(symmetry))
    reach = stats.t.ppf(0.975, 7)
    beta = np.array([0, -1, 1]) * reach * reference.stderr + reference.slope
    alpha = np.exp(np.array([0, -1, 1]) * reach * reference.intercept_stderr + reference.intercept)
    assert fit.beta[:3] == pytest.approx(beta)
    assert fit.alpha[:3] == pytest.approx(alpha)


@pytest.mark.parametrize("free_area", [False, True])
def test_intervals_hold_the_truth_as_often_as_they_say(free_area):
    """A thousand noisy lines: 95 % intervals miss α, β and p in 50 of them, give or take."""
    rng = np.random.default_rng(2)
    p = 0.4 if free_area else 1.0
    exact = 0.05 * (GRID_CA * GRID_AREA**p) ** -0.7
    missed = dict.fromkeys(("alpha", "beta", "area_exponent"), 0)
    for _ in range(1000):
        fit = fit_line(GRID_CA, GRID_AREA, noisy(rng, exact, 0.05), free_area=free_area)
        for name, truth in (("alpha", 0.05), ("beta", -0.7), ("area_exponent", p)):
            estimate = getattr(fit, name)
            missed[name] += not estimate.low <= truth <= estimate.high
    assert all(25 <= missed[name] <= 80 for name in ("alpha", "beta"))
    assert missed["area_exponent"] == 0 if not free_area else 25 <= missed["area_exponent"] <= 80


def test_the_brackets_widen_the_intervals():
    """Where every point lies on the line, the brackets alone make the intervals."""
    symmetry = 0.089 * (CA * AREA) ** -0.72
    fit = fit_line(CA, AREA, symmetry, 0.01)
    rng = np.random.default_rng(3)
    slopes = [
        np.polyfit(np.log(CA * AREA), np.log(symmetry + rng.uniform(-0.005, 0.005, 9)), 1)[0]
        for _ in range(4000)
    ]
    expected = stats.t.ppf(0.975, 7) * np.std(slopes)
    assert fit.beta.high - fit.beta.value == pytest.approx(expected, rel=0.05)


def test_the_band_is_narrowest_amid_the_points():
    symmetry = noisy(np.random.default_rng(4), 0.089 * (CA * AREA) ** -0.72, 0.03)
    fit = fit_line(CA, AREA, symmetry)
    value, low, high = fit.symmetry(CA * 25.16)
    assert ((low < value) & (value < high)).all()
    relative = high / value
    assert np.argmin(relative) in (3, 4, 5)


def test_more_confidence_is_wider():
    symmetry = noisy(np.random.default_rng(5), 0.089 * (CA * AREA) ** -0.72, 0.03)
    narrow, wide = (fit_line(CA, AREA, symmetry, confidence=c).beta for c in (0.68, 0.99))
    assert wide.low < narrow.low < narrow.high < wide.high


def test_as_json_and_as_text():
    symmetry = noisy(np.random.default_rng(6), GRID_CA**-0.7, 0.03)
    fit = fit_line(GRID_CA, GRID_AREA, symmetry, free_area=True, speed="contact")
    report = json.loads(json.dumps(fit.to_dict(), allow_nan=False))
    assert report["beta"]["value"] == fit.beta.value
    assert (report["speed"], report["area_exponent_free"]) == ("contact", True)
    assert "Ã^" in str(fit)
    assert "45 points" in str(fit)


@pytest.mark.parametrize(
    ("points", "free_area"), [(slice(0, 0), False), (slice(0, 2), False), (slice(0, 9), True)]
)
def test_too_few_points_are_refused(refused, points, free_area):
    """Two points leave no freedom; nine of one size do not tell Ã from α."""
    ca, area = CA[points], AREA[points]
    refused("boundary", fit_line, ca, area, 0.1 * ca**-0.7, free_area=free_area)


def test_points_in_one_place_are_refused(refused):
    same = np.full(5, 0.004)
    refused("boundary", fit_line, same, np.full(5, 25.0), np.linspace(0.4, 0.5, 5))


@pytest.mark.parametrize("confidence", [0, 1, 95, math.nan])
def test_wrong_confidence_is_refused(refused, confidence):
    refused("confidence", fit_line, CA, AREA, CA**-0.7, confidence=confidence)


# Of a boundary


@pytest.fixture
def synthetic():
    """A boundary whose line has p = 0.4 with v_f∞ and p = 0.1 with the speed at contact."""
    speed = GRID_AREA**0.3
    symmetry = 0.02 * (GRID_CA * speed * GRID_AREA**0.1) ** -0.7
    table = pd.DataFrame(
        {
            "status": "found",
            "capillary_number": GRID_CA,
            "normalized_area": GRID_AREA,
            "normalized_thickness": 1.0,
            "critical_symmetry": symmetry,
            "width": 0.0,
            "contact_speed": speed,
        }
    )
    table.loc[3, ["status", "critical_symmetry"]] = ["non-monotonic", math.nan]
    table.loc[7, ["status", "critical_symmetry"]] = ["unresolved", math.nan]
    return Boundary(table, pd.DataFrame(), po.Parameters(), ())


def test_only_what_was_found_is_fitted(synthetic):
    fit = synthetic.fit(free_area=True)
    assert fit.count == 43
    assert fit.area_exponent.value == pytest.approx(0.4)
    assert synthetic.fit().beta.value != pytest.approx(-0.7, abs=0.05)


def test_capillary_number_of_the_speed_at_contact(synthetic):
    fit = synthetic.fit(free_area=True, speed="contact")
    assert fit.area_exponent.value == pytest.approx(0.1)
    assert fit.speed == "contact"


def test_wrong_speed_is_refused(refused, synthetic):
    refused("speed", synthetic.fit, speed="far")
