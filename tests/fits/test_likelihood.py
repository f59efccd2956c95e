"""The likelihood: by hand, by differences, under constraints, and beside a library."""

from __future__ import annotations

import math

import numpy as np
import pytest
import statsmodels.api as sm

import pinchoff as po
from pinchoff.fits.form import LOGARITHMIC, Form, unscaled
from pinchoff.fits.likelihood import Constraint, LogisticLikelihood, maximum
from pinchoff.fits.noise import NoisyLikelihood
from pinchoff.fits.rows import rows_of

FREE = ("area", "thickness")


@pytest.fixture(scope="module")
def rows(many):
    return rows_of(po.import_collisions(many).table, Form(FREE))


def test_of_three_collisions_by_hand():
    """P of each from Bk, as the paper writes it, multiplied."""
    alpha, beta, w = 0.083, -0.74, 0.098
    forcing, symmetry = np.array([0.05, 0.1, 0.03]), np.array([0.7, 0.4, 0.9])
    outcome = np.array([True, False, False])
    x = (forcing * alpha ** (1 / beta) / symmetry ** (1 / beta)) ** (1 / w)
    by_hand = np.prod([x[0] / (1 + x[0]), 1 / (1 + x[1]), 1 / (1 + x[2])])
    coefficients = np.array([math.log(alpha) / (beta * w), 1 / w, -1 / (beta * w)])
    features = np.stack([np.ones(3), np.log(forcing), np.log(symmetry)], axis=1)
    value = LogisticLikelihood(features, outcome).at(coefficients).value
    assert math.exp(value) == pytest.approx(by_hand)


@pytest.mark.parametrize("noise", [0.0, 0.088])
def test_derivatives_are_those_of_the_value(rows, noise):
    likelihood = (
        NoisyLikelihood(rows.features, rows.symmetry, rows.broke, noise)
        if noise
        else LogisticLikelihood(rows.features, rows.broke)
    )
    at = np.array([24.0, 8.0, 11.0, 0.5, -0.3])
    slope = likelihood.at(at)
    step = 1e-5
    for k in range(5):
        aside = np.eye(5)[k] * step
        above, below = likelihood.at(at + aside), likelihood.at(at - aside)
        assert slope.gradient[k] == pytest.approx(
            (above.value - below.value) / (2 * step), rel=1e-5
        )
        hessian = (above.gradient - below.gradient) / (2 * step)
        assert slope.hessian[k] == pytest.approx(hessian, rel=1e-4, abs=1e-3)


def test_same_as_statsmodels(rows):
    ours = maximum(LogisticLikelihood(rows.features, rows.broke))
    theirs = sm.Logit(rows.broke.astype(float), rows.features).fit(disp=False, tol=1e-12)
    assert ours.coefficients == pytest.approx(theirs.params, rel=1e-8)
    assert ours.value == pytest.approx(theirs.llf, rel=1e-12)
    assert np.linalg.inv(-ours.hessian) == pytest.approx(theirs.cov_params(), rel=1e-6)
    assert not ours.doubtful


def test_numbers_of_the_law_follow_from_coefficients_and_back():
    form = Form(FREE)
    c = np.array([24.0, 10.0, 13.0, 0.7, -1.2])
    numbers = {name: unscaled(name, value) for name, value in form.scaled(c).items()}
    assert numbers["w"] == pytest.approx(1 / 10)
    assert numbers["beta"] == pytest.approx(-10 / 13)
    assert numbers["alpha"] == pytest.approx(math.exp(-24 / 13))
    assert numbers["epsilon_1"] == pytest.approx(1.07)
    assert numbers["epsilon_3"] == pytest.approx(0.88)
    # dimensionless: lengths cancel
    assert 2 * numbers["epsilon_1"] + numbers["epsilon_2"] + numbers["epsilon_3"] == pytest.approx(
        0
    )


@pytest.mark.parametrize("name", Form(FREE).names)
def test_gradients_and_equations_of_the_numbers(name):
    form = Form(FREE)
    c = np.array([24.0, 10.0, 13.0, 0.7, -1.2])
    gradient = form.gradients(c)[name]
    for k in range(5):
        aside = np.eye(5)[k] * 1e-6
        difference = (form.scaled(c + aside)[name] - form.scaled(c - aside)[name]) / 2e-6
        assert gradient[k] == pytest.approx(difference, abs=1e-7)
    a, b = form.equation(name, form.scaled(c)[name])
    assert a @ c == pytest.approx(b)
    other, value = form.equation(name, form.scaled(c)[name] + 0.1)
    assert other @ c != pytest.approx(value)


@pytest.mark.parametrize("free", [(), ("area",), ("thickness",), FREE])
def test_a_constraint_holds_and_leaves_everything_else_free(free):
    form = Form(free)
    for name in form.names:
        scaled = -0.3 if name in LOGARITHMIC else 0.8
        constraint = Constraint.of([form.equation(name, scaled)])
        assert constraint.matrix.shape == (form.size, form.size - 1)
        for free_numbers in np.random.default_rng(0).normal(size=(5, form.size - 1)):
            c = constraint.matrix @ free_numbers + constraint.offset
            a, b = form.equation(name, scaled)
            assert a @ c == pytest.approx(b, abs=1e-12)


def test_a_constrained_maximum_is_that_of_fewer_columns(rows):
    """ε1 = ε3 = 1 is the fit without the columns of Ã and z̃."""
    form = Form(FREE)
    likelihood = LogisticLikelihood(rows.features, rows.broke)
    paper = Constraint.of([form.equation("epsilon_1", 1.0), form.equation("epsilon_3", 1.0)])
    held = maximum(likelihood, paper)
    small = maximum(LogisticLikelihood(rows.features[:, :3], rows.broke))
    assert held.value == pytest.approx(small.value, rel=1e-12)
    assert held.coefficients[:3] == pytest.approx(small.coefficients, rel=1e-6)


@pytest.mark.parametrize("name", Form(FREE).names)
def test_a_constrained_maximum_is_that_of_statsmodels(rows, name):
    """Its GLM takes a·c = b; the numbers are moved off their best values by a few errors."""
    form, broke = Form(FREE), rows.broke.astype(float)
    likelihood = LogisticLikelihood(rows.features, rows.broke)
    scaled = form.scaled(maximum(likelihood).coefficients)[name]
    a, b = form.equation(name, scaled + 0.05)
    ours = maximum(likelihood, Constraint.of([(a, b)]))
    model = sm.GLM(broke, rows.features, family=sm.families.Binomial())
    theirs = model.fit_constrained((a[None, :], np.array([b])))
    assert ours.value == pytest.approx(theirs.llf, rel=1e-10)
    assert ours.coefficients == pytest.approx(theirs.params, rel=1e-6)


def test_a_start_on_the_wrong_side_finds_the_maximum(rows):
    likelihood = LogisticLikelihood(rows.features[:, :3], rows.broke)
    good = maximum(likelihood)
    far = maximum(likelihood, start=np.array([-500.0, -400.0, 300.0]))
    assert far.coefficients == pytest.approx(good.coefficients, rel=1e-6)
