"""Intervals in three ways: against brute force, a library, and each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
import statsmodels.api as sm
from scipy.optimize import minimize
from scipy.stats import chi2

import pinchoff as po
from pinchoff.fits.intervals import BOOTSTRAP, DELTA, PROFILE

FREE = ("area", "thickness")


@pytest.fixture(scope="module")
def few(collisions):
    """Few enough that the likelihood is not a parabola."""
    return collisions(400, 11)


@pytest.fixture(scope="module")
def fit(few):
    return po.fit_law(few)


def log_likelihood(table, alpha, beta, w):
    """Of the law as the paper writes it."""
    bk = po.breakup_number(
        table["capillary_number"],
        normalized_area=table["normalized_area"],
        symmetry=table["symmetry"],
        normalized_thickness=table["normalized_thickness"],
        line=po.Line(alpha, beta),
    )
    sign = np.where(table["broke"], 1.0, -1.0)
    return -np.logaddexp(0.0, -sign * np.log(bk) / w).sum()


def test_delta_method_is_statsmodels_covariance_carried_over(few, fit):
    """The numbers w = 1/c1 and β = -c1/c2, with the covariance of c from the library."""
    forcing = few["capillary_number"] * few["normalized_area"] * few["normalized_thickness"]
    design = sm.add_constant(np.log(np.stack([forcing, few["symmetry"]], axis=1)))
    theirs = sm.Logit(few["broke"].to_numpy(float), design).fit(disp=False, tol=1e-12)
    (_, c1, c2), covariance = theirs.params, theirs.cov_params()
    found = fit.delta()
    error_of_log_w = math.sqrt(covariance[1, 1]) / c1
    assert found["w"].high / found["w"].value == pytest.approx(
        math.exp(1.96 * error_of_log_w), rel=1e-4
    )
    slope = np.array([0, 1 / c1, -1 / c2])
    error = math.sqrt(slope @ covariance @ slope)
    assert found["beta"].low / found["beta"].value == pytest.approx(
        math.exp(1.96 * error), rel=1e-4
    )
    assert found["alpha"].method == DELTA


@pytest.mark.parametrize(("name", "place"), [("alpha", 0), ("beta", 1), ("w", 2)])
def test_profile_ends_where_a_search_over_the_others_says(few, fit, name, place):
    """Twice the drop of the likelihood at either end is χ²(0.95), by another optimizer."""
    numbers = [fit.alpha.value, fit.beta.value, fit.w.value]
    best = log_likelihood(few, *numbers)
    estimate = fit.profile()[name]
    assert estimate.method == PROFILE
    for end in (estimate.low, estimate.high):

        def drop(others, end=end):
            trial = np.insert(np.array(others), place, end)
            if trial[0] <= 0 or trial[1] >= 0 or trial[2] <= 0:
                return math.inf
            return 2 * (best - log_likelihood(few, *trial))

        start = np.delete(numbers, place)
        options = {"xatol": 1e-7, "fatol": 1e-7, "maxiter": 4000}
        found = minimize(drop, start, method="Nelder-Mead", options=options)
        assert found.fun == pytest.approx(chi2.ppf(0.95, 1), rel=2e-3)


def test_profile_of_dependent_exponents(collisions):
    """With ε3 = 1 fixed, ε2 = -2ε1 - 1, and so are the ends of its interval."""
    found = po.fit_law(collisions(1500, 12), free="area").profile()
    assert found["epsilon_2"].low == pytest.approx(-2 * found["epsilon_1"].high - 1, rel=1e-3)
    assert found["epsilon_2"].high == pytest.approx(-2 * found["epsilon_1"].low - 1, rel=1e-3)


def test_with_many_collisions_all_three_agree(collisions):
    fit = po.fit_law(collisions(30_000, 1), free=FREE)
    delta, profile = fit.delta(), fit.profile()
    bootstrap = fit.bootstrap(samples=300, seed=3).estimates
    for name, estimate in delta.items():
        width = estimate.high - estimate.low
        for other in (profile[name], bootstrap[name]):
            assert other.value == estimate.value
            assert other.high - other.low == pytest.approx(width, rel=0.15)
    assert bootstrap["alpha"].method == BOOTSTRAP


def test_more_confidence_is_wider(few):
    narrow, wide = (po.fit_law(few, confidence=c) for c in (0.68, 0.99))
    for intervals in (lambda fit: fit.delta(), lambda fit: fit.profile()):
        low, high = intervals(narrow)["beta"], intervals(wide)["beta"]
        assert high.low < low.low < low.high < high.high


def test_bootstrap_is_seeded(many):
    fit = po.fit_law(many)
    one, same, other = (fit.bootstrap(samples=10, seed=seed) for seed in (1, 1, 2))
    assert one.estimates == same.estimates
    assert one.spread != other.spread
    assert (one.samples, one.size, one.failed) == (10, 2528, 0)


@pytest.mark.parametrize("fraction", [0.25, 0.8])
def test_the_size_of_the_parts_does_not_show_in_the_interval(many, fraction):
    """The spread of m of n collisions, drawn without replacement, is √((n - m)/m) of the error."""
    fit = po.fit_law(many)
    half = fit.bootstrap(samples=500, seed=1)
    other = fit.bootstrap(samples=500, seed=2, fraction=fraction)
    widths = [each.estimates["beta"].high - each.estimates["beta"].low for each in (half, other)]
    assert widths[0] == pytest.approx(widths[1], rel=0.12)
    expected = math.sqrt((1 - fraction) / fraction)
    assert other.spread["beta"] / half.spread["beta"] == pytest.approx(expected, rel=0.12)


def test_bootstrap_arguments_are_checked(many, refused):
    fit = po.fit_law(many)
    refused("samples", fit.bootstrap, samples=1)
    refused("fraction", fit.bootstrap, fraction=1.0)
    refused("fraction", fit.bootstrap, fraction=float("nan"))


def test_parts_without_a_fit_are_counted_or_too_many(collisions, refused):
    table = collisions(60, 1, width=0.3)
    with pytest.warns(UserWarning, match="are few"):
        fit = po.fit_law(table)
    found = fit.bootstrap(samples=60, fraction=0.8, seed=0)
    assert 0 < found.failed < 30
    refused("fraction", fit.bootstrap, samples=60, fraction=0.1)


def test_an_end_that_the_data_do_not_have_is_infinite(collisions):
    table = collisions(16, 1, width=0.5)
    with pytest.warns(UserWarning, match="are few"):
        found = po.fit_law(table).profile()
    assert found["beta"].low == -math.inf
    assert found["beta"].high > -0.7
