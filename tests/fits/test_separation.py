"""Outcomes that a line separates without exception."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.fits.form import Form
from pinchoff.fits.likelihood import LogisticLikelihood, maximum
from pinchoff.fits.rows import rows_of
from pinchoff.fits.separation import widest_gap


@pytest.fixture(scope="module")
def separated(collisions):
    return collisions(1000, 21, width=0.0)


@pytest.fixture(scope="module")
def fit(separated):
    return po.fit_law(separated)


def test_it_is_detected_and_said(fit):
    assert "without exception" in fit.step
    assert f"a factor {math.exp(fit.gap):.4g} in Bk" in fit.step
    assert fit.log_likelihood == pytest.approx(0, abs=1e-9)


def test_the_line_and_its_intervals_hold_the_truth(fit):
    assert fit.w.value == fit.w.low == 0
    assert 0 < fit.w.high < 0.03
    assert fit.alpha.low < 0.083 < fit.alpha.high
    assert fit.beta.low < -0.74 < fit.beta.high
    assert fit.beta.high - fit.beta.low < 0.08


def test_no_outcome_is_on_the_wrong_side(separated, fit):
    bk = fit.breakup_number(separated)
    broke = separated["broke"].to_numpy()
    assert bk[broke].min() == pytest.approx(math.exp(fit.gap))
    assert bk[~broke].max() == pytest.approx(math.exp(-fit.gap))


def test_no_other_line_has_a_wider_gap(separated, fit):
    """By trying very many lines."""
    forcing = np.log(separated["capillary_number"] * separated["normalized_area"])
    forcing += np.log(separated["normalized_thickness"])
    symmetry = np.log(separated["symmetry"])
    broke = separated["broke"].to_numpy()
    widest = 0.0
    for steepness in np.linspace(-1 / -0.9, -1 / -0.6, 4001):
        level = forcing + steepness * symmetry
        widest = max(widest, (level[broke].min() - level[~broke].max()) / 2)
    assert fit.gap == pytest.approx(widest, rel=0.02)
    assert fit.gap >= widest - 1e-9


def test_the_bound_of_w_is_where_the_likelihood_gets_too_small(separated, fit):
    """P of what was seen at w.high, at its greatest over lines, is exp(-2.706/2)."""
    rows = rows_of(po.import_collisions(separated).table, Form())
    likelihood = LogisticLikelihood(rows.features, rows.broke)
    c1 = 1 / fit.w.high
    best = -math.inf
    for beta in np.linspace(fit.beta.low * 1.1, fit.beta.high * 0.9, 200):
        for log_alpha in np.linspace(-0.3, 0.3, 200) + math.log(0.083) * beta / -0.74:
            c2 = -c1 / beta
            best = max(best, likelihood.at(np.array([-log_alpha * c2, c1, c2])).value)
    assert best == pytest.approx(-1.353, abs=0.05)


def test_delta_and_bootstrap_are_refused_with_the_reason(fit, refused):
    assert "without exception" in refused("delta", fit.delta).got
    assert "without exception" in refused("bootstrap", fit.bootstrap).got


def test_one_exception_makes_an_overlap(separated, fit):
    bk = fit.breakup_number(separated)
    turned = separated.copy()
    worst = np.argsort(np.abs(np.log(bk)))[40]
    turned.loc[turned.index[worst], "broke"] = not turned["broke"].iloc[worst]
    overlapping = po.fit_law(turned)
    assert overlapping.step == ""
    assert overlapping.w.value > 0


def test_a_narrow_overlap_is_no_separation(collisions):
    fit = po.fit_law(collisions(30_000, 5, width=0.004))
    assert fit.step == ""
    assert fit.w.low < 0.004 < fit.w.high


def test_few_rows_decide_among_very_many(collisions):
    table = collisions(60_000, 7, width=0.0)
    rows = rows_of(po.import_collisions(table).table, Form(("area",)))
    near = maximum(LogisticLikelihood(rows.features, rows.broke)).coefficients
    gap = widest_gap(rows.features, rows.broke, near)
    signed = np.where(rows.broke[:, None], rows.features, -rows.features)
    assert (signed @ gap.coefficients).min() == pytest.approx(gap.half_width, abs=1e-9)
    assert gap.half_width > 0


def test_outcomes_that_overlap_have_a_negative_gap(many):
    rows = rows_of(po.import_collisions(many).table, Form())
    near = maximum(LogisticLikelihood(rows.features, rows.broke)).coefficients
    assert widest_gap(rows.features, rows.broke, near).half_width < 0


def test_simulations_of_one_size():
    """The engine has no chance in it: at one size and offsets off the line w is 0."""
    runs = po.simulate_many(
        [
            po.Parameters(simulation_capillary_number=ca, offset=y, follow_daughters=False)
            for ca in (20, 32, 50)
            for y in (0.01, 0.05, 0.1, 0.15, 0.2)
        ],
        progress=False,
    )
    with pytest.warns(UserWarning, match="are few"):
        fit = po.fit_law(runs)
    assert fit.step
    assert fit.beta.low < -0.73 < fit.beta.high
