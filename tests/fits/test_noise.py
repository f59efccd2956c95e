"""Errors of S: how they bias a fit, and that the correction takes the bias away."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.circle_segments import symmetry_of_impact
from pinchoff.fits.noise import reflected_normal, true_distribution

NOISE = 0.088


def test_the_kernel_is_a_density_of_what_is_measured():
    measured = (np.arange(2000) + 0.5) / 2000
    density = reflected_normal(measured, np.array([0.02, 0.5, 0.97]), NOISE)
    assert density.mean(axis=0) == pytest.approx(np.ones(3), abs=1e-3)


def test_the_kernel_is_how_measured_symmetries_are_made():
    rng = np.random.default_rng(0)
    measured = np.abs(0.95 + rng.normal(0, NOISE, 400_000))
    measured = np.where(measured > 1, 2 - measured, measured)
    counts, edges = np.histogram(measured, bins=25, range=(0.6, 1.0), density=False)
    middle = (edges[1:] + edges[:-1]) / 2
    expected = reflected_normal(middle, np.array([0.95]), NOISE)[:, 0] * np.diff(edges)
    assert counts / 400_000 == pytest.approx(expected, rel=0.1, abs=2e-4)


def test_the_distribution_of_true_symmetries_comes_back():
    rng = np.random.default_rng(1)
    truth = symmetry_of_impact(rng.uniform(0, 0.5, 40_000))
    measured = np.abs(truth + rng.normal(0, NOISE, truth.size))
    measured = np.where(measured > 1, 2 - measured, measured)
    places, share = true_distribution(measured, NOISE)
    assert share.sum() == pytest.approx(1)
    for quantile in (0.2, 0.5, 0.8):
        found = np.interp(quantile, np.cumsum(share), places)
        assert found == pytest.approx(np.quantile(truth, quantile), abs=0.03)


def test_without_noise_the_correction_changes_next_to_nothing():
    table = po.virtual_experiment(1, symmetry_noise=0)
    plain, corrected = po.fit_law(table), po.fit_law(table, symmetry_noise=0.005)
    for name, estimate in plain.estimates.items():
        other = corrected.estimates[name]
        assert other.value == pytest.approx(estimate.value, rel=0.02)


def test_noise_biases_beta_and_w_and_the_correction_takes_it_away():
    """The paper's ±0.088 as an error of each row, over ten virtual experiments of its size."""
    naive, corrected = [], []
    for seed in range(10):
        table = po.virtual_experiment(seed, symmetry_noise=NOISE)
        for found, noise in ((naive, 0.0), (corrected, NOISE)):
            fit = po.fit_law(table, symmetry_noise=noise)
            found.append([fit.alpha.value, fit.beta.value, fit.w.value])
    biased, mean = np.mean(naive, axis=0), np.mean(corrected, axis=0)
    error = np.std(corrected, axis=0, ddof=1) / np.sqrt(10)
    truth = np.array([0.083, -0.74, 0.098])
    assert biased[1] < -0.77
    assert biased[2] > 0.13
    assert (np.abs(mean - truth) < 3 * error + 0.01 * np.abs(truth)).all()


def test_more_noise_than_there_is_makes_a_step(collisions):
    """Where the assumed noise explains all of the overlap, w = 0 is said, with a bound."""
    fit = po.fit_law(collisions(400, 3, width=0.0), symmetry_noise=0.05)
    assert "explains all of the overlap" in fit.step
    assert fit.w.value == 0
    assert 0 < fit.w.high < 0.1
    assert fit.beta.low < -0.74 < fit.beta.high


def test_noise_that_hides_the_width_leaves_it_without_a_lower_end(collisions):
    fit = po.fit_law(collisions(400, 3, width=0.01), symmetry_noise=0.05)
    assert fit.w.low < 1e-6
    assert 0.01 < fit.w.high < 0.1


def test_three_collisions_do_not_decide_a_law_with_noise(refused):
    """Their likelihood has no maximum that a profile could follow: refused, in a sentence."""
    three = pd.DataFrame(
        {
            "capillary_number": [
                0.0010311269738800088,
                0.007371640991975628,
                0.0029144599856249383,
            ],
            "normalized_area": [36.22705412222036, 14.931208482374867, 25.330377996748492],
            "normalized_thickness": 1.0,
            "symmetry": [0.07060321739476261, 0.7341666920593226, 0.01608877945694176],
            "broke": [False, True, False],
        }
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        error = refused("table", po.fit_law, three, symmetry_noise=0.088)
    assert error.got == "a likelihood without a clear maximum"
