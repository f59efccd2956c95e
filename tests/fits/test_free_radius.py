"""The exponents of A, R and z without the dimensional constraint."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po
from pinchoff.fits.law_comparison import compare_laws


def drawn(dimension, seed=3, count=20_000):
    """Collisions of the paper's law times R^dimension, R relative to 85 µm, noiseless in S."""
    table = po.virtual_experiment(seed, count, symmetry_noise=0)
    hidden = (table["obstacle_radius_um"] / 85.0) ** dimension
    # x = Bk^(1/w); Bk of the paper's experiments with its own α and β
    bk = po.breakup_number(
        table["capillary_number"] * hidden,
        normalized_area=table["normalized_area"],
        symmetry=table["symmetry"],
        normalized_thickness=table["normalized_thickness"],
        line="paper-experiment",
    )
    x = bk ** (1 / 0.098)
    outcome = np.random.default_rng(seed + 1000).random(len(table)) < x / (1 + x)
    return table.assign(broke=outcome)


@pytest.mark.parametrize("dimension", [0.0, 1.5, -0.8])
def test_a_hidden_length_comes_back(dimension):
    fit = po.fit_law(drawn(dimension), free="radius")
    assert fit.free == ("area", "thickness", "radius")
    truth = {"epsilon_1": 1, "epsilon_3": 1, "epsilon_2": dimension - 3, "dimension": dimension}
    for name, value in truth.items():
        estimate = fit.estimates[name]
        error = (estimate.high - estimate.low) / 4
        assert abs(estimate.value - value) < 4 * error, name
        assert error < 0.1


def test_intervals_by_profile_and_delta_agree():
    fit = po.fit_law(drawn(1.0), free="radius")
    profile, delta = fit.profile(), fit.delta()
    for name in ("epsilon_2", "dimension"):
        assert profile[name].low == pytest.approx(delta[name].low, abs=0.02)
        assert profile[name].high == pytest.approx(delta[name].high, abs=0.02)


def test_bk_carries_the_fitted_radius():
    """A probability of one half at Bk = 1: with the wrong sign of the exponent it is not."""
    table = drawn(1.5)
    fit = po.fit_law(table, free="radius")
    near = np.abs(np.log(fit.breakup_number(table))) < 0.02
    for radius in (60.0, 120.0):
        share = table["broke"][near & (table["obstacle_radius_um"] == radius)].astype(float)
        assert share.mean() == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(len(share)) + 0.05)


def test_one_radius_decides_nothing(refused):
    table = drawn(0.0, count=3000)
    refused("table", po.fit_law, table[table["obstacle_radius_um"] == 85.0], free="radius")


def test_the_comparison_finds_a_hidden_length():
    laws = compare_laws(drawn(1.5, count=5000)).set_index("law")
    assert laws.loc["radius as in the paper", "p_value"] < 1e-6
    assert laws.loc["paper", "p_value"] < 1e-6
    laws = compare_laws(drawn(0.0, count=5000)).set_index("law")
    assert laws.loc["radius as in the paper", "p_value"] > 1e-3
