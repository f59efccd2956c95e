"""The law fitted to collisions of a known law, and to awkward ones."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.law import Line
from pinchoff.fits.intervals import normal_quantile


def numbers(fit):
    return {name: each.value for name, each in fit.estimates.items()}


def test_the_truth_comes_back(many):
    fit = po.fit_law(many)
    for estimate, truth in ((fit.alpha, 0.083), (fit.beta, -0.74), (fit.w, 0.098)):
        assert estimate.low < truth < estimate.high
        assert estimate.high - estimate.low < 0.35 * abs(truth)
    assert (fit.count, fit.broke_count) == (5056, int(many["broke"].sum()))


@pytest.mark.parametrize("line", [Line(0.3, -0.5), Line(0.02, -1.4)])
def test_another_truth_comes_back(collisions, line):
    fit = po.fit_law(collisions(4000, 3, width=0.2, line=line))
    assert fit.alpha.low < line.alpha < fit.alpha.high
    assert fit.beta.low < line.beta < fit.beta.high
    assert fit.w.low < 0.2 < fit.w.high


def test_free_exponents_come_back():
    table = po.virtual_experiment(4, symmetry_noise=0)
    quantities = ("area", "thickness", "viscosity")
    fit = po.fit_law(table, free=quantities)
    truth = {"epsilon_1": 1, "epsilon_2": -3, "epsilon_3": 1, "epsilon_mu": 1}
    for name, value in truth.items():
        estimate = fit.estimates[name]
        assert estimate.low < value < estimate.high
        assert estimate.high - estimate.low < 0.35 * max(1, abs(value))


def test_exponents_that_are_not_1_come_back():
    """A law with Ã^0.5 and μ^2, v and γ as they are."""
    table = po.virtual_experiment(5, symmetry_noise=0)
    rng = np.random.default_rng(0)
    relative = table["viscosity_mPa_s"] / 48
    bk = po.breakup_number(
        table["capillary_number"],
        normalized_area=table["normalized_area"] ** 0.5,
        symmetry=table["symmetry"],
        normalized_thickness=table["normalized_thickness"],
        line=Line(0.03, -0.74),
    )
    table["broke"] = rng.random(len(table)) < 1 / (1 + (bk * relative) ** -10)
    fit = po.fit_law(table, free=("area", "viscosity"))
    for name, truth in (("epsilon_1", 0.5), ("epsilon_mu", 2), ("epsilon_2", -2), ("alpha", 0.03)):
        assert fit.estimates[name].low < truth < fit.estimates[name].high
    assert fit.breakup_number(table) == pytest.approx(
        po.breakup_number(
            table["capillary_number"],
            normalized_area=table["normalized_area"] ** fit.estimates["epsilon_1"].value,
            symmetry=table["symmetry"],
            normalized_thickness=table["normalized_thickness"],
            line=fit,
        )
        * relative ** (fit.estimates["epsilon_mu"].value - 1)
    )


@pytest.mark.parametrize(
    ("quantity", "key", "reference", "power"),
    [("surface_tension", "epsilon_gamma", 20.0, -1), ("speed", "epsilon_v", 1.0, 1)],
)
def test_exponents_of_surface_tension_and_speed_come_back(quantity, key, reference, power):
    """Bk ∝ v^ε_v/γ^ε_γ, with one of them 2; tensions spread by a factor 3."""
    table = po.virtual_experiment(6, symmetry_noise=0)
    rng = np.random.default_rng(1)
    table["surface_tension_mN_m"] *= rng.uniform(0.5, 1.5, len(table))
    table["capillary_number"] *= 20 / table["surface_tension_mN_m"]
    column = {"surface_tension": "surface_tension_mN_m", "speed": "speed_mm_s"}[quantity]
    bk = (
        po.breakup_number(
            table["capillary_number"],
            normalized_area=table["normalized_area"],
            symmetry=table["symmetry"],
            normalized_thickness=table["normalized_thickness"],
            line="paper-experiment",
        )
        * (table[column] / reference) ** power
    )
    table["broke"] = rng.random(len(table)) < 1 / (1 + bk**-10)
    fit = po.fit_law(table, free=quantity)
    found = fit.estimates[key]
    assert found.low < 2 < found.high
    assert found.high - found.low < 0.4
    near = bk.between(0.3, 3)
    assert fit.breakup_number(table[near]) == pytest.approx(bk[near].to_numpy(), rel=0.15)


def test_half_of_the_collisions_on_the_line_break(many):
    fit = po.fit_law(many)
    assert fit.probability(1.0) == pytest.approx(0.5)
    bk = fit.breakup_number(many)
    # At the maximum the expected number of break-ups is the number seen.
    assert fit.probability(bk).sum() == pytest.approx(many["broke"].sum(), rel=1e-9)


def test_the_order_of_rows_shows_in_no_digit(many):
    one, other = po.fit_law(many), po.fit_law(many.sample(frac=1, random_state=1))
    assert numbers(one) == numbers(other)
    assert one.profile() == other.profile()
    assert one.bootstrap(samples=5).estimates == other.bootstrap(samples=5).estimates


def test_every_row_twice_narrows_the_intervals_by_the_root_of_2(many):
    with pytest.warns(UserWarning, match="5056 rows repeat others"):
        twice = po.fit_law(pd.concat([many, many]))
    once = po.fit_law(many)
    assert numbers(twice) == pytest.approx(numbers(once), rel=1e-6)
    widths = [each.beta.high - each.beta.low for each in (once, twice)]
    assert widths[0] / widths[1] == pytest.approx(2**0.5, rel=1e-3)


def test_extreme_imbalance(collisions):
    """Some thirty break-ups among tens of thousands: a fit, and honest about itself."""
    table = collisions(40_000, 6)
    broke = np.flatnonzero(table["broke"])
    table = table.drop(index=broke[30:])
    fit = po.fit_law(table)
    assert fit.broke_count == 30
    assert fit.beta.low < fit.beta.value < fit.beta.high < 0


def test_few_break_ups_come_with_a_warning(collisions):
    table = collisions(4000, 6)
    broke = np.flatnonzero(table["broke"])
    with pytest.warns(UserWarning, match="12 of which broke, are few: the 95% interval of β is"):
        po.fit_law(table.drop(index=broke[12:]))


def test_fewer_than_20_rows_come_with_the_width_of_the_interval(collisions):
    table = collisions(18, 9, width=0.2)
    with pytest.warns(UserWarning, match="are few") as caught:
        fit = po.fit_law(table)
    (message,) = (str(one.message) for one in caught)
    assert message.startswith("18 collisions")
    assert f"{fit.beta.low:.3g} to {fit.beta.high:.3g}" in message
    assert message.endswith("wide")


@pytest.mark.parametrize("broke", [True, False])
def test_one_outcome_only_is_refused(many, refused, broke):
    error = refused("table", po.fit_law, many[many["broke"] == broke])
    assert "some broke and some did not" in error.rule
    assert ("all broke" if broke else "did not break") in error.got


def test_rows_that_do_not_decide_an_exponent_are_refused(many, refused):
    same = many.assign(normalized_thickness=1.0)
    error = refused("table", po.fit_law, same, free="thickness")
    assert "differ in normalized_thickness" in error.rule
    error = refused("table", po.fit_law, many.assign(symmetry=0.5))
    assert "differ in S" in error.rule


def test_an_exponent_that_follows_from_others_is_refused(refused):
    """With every quantity free, one number too many: w sets the scale already."""
    table = po.virtual_experiment(1, 800, symmetry_noise=0)
    table["surface_tension_mN_m"] *= np.random.default_rng(0).uniform(0.5, 1.5, len(table))
    table["capillary_number"] = (
        table["viscosity_mPa_s"] * table["speed_mm_s"] / table["surface_tension_mN_m"] * 1e-3
    )
    everything = ("area", "thickness", "viscosity", "surface_tension", "speed")
    error = refused("table", po.fit_law, table, free=everything)
    assert "independently of each other" in error.rule
    refused("free", po.fit_law, table, free="symmetry")


def test_break_up_that_gets_rarer_with_symmetry_is_no_such_law(many, refused):
    error = refused("table", po.fit_law, many.assign(symmetry=1.02 - many["symmetry"]))
    assert "larger S" in error.rule


def test_arguments_are_checked(many, refused):
    refused("confidence", po.fit_law, many, confidence=95)
    refused("symmetry_noise", po.fit_law, many, symmetry_noise=-0.1)
    refused("table", po.fit_law, 3)


def test_s_0_is_left_out_and_said(many):
    table = many.copy()
    table.loc[table.index[:7], "symmetry"] = 0.0
    with pytest.warns(UserWarning, match="7 collisions are left out: S = 0"):
        fit = po.fit_law(table)
    assert fit.count == len(fit.used) == 5049
    assert list(fit.left_out.values()) == [7]


def test_aic_of_the_likelihood(many):
    fit = po.fit_law(many)
    probability = fit.probability(fit.breakup_number(many))
    broke = many["broke"].to_numpy()
    value = np.log(np.where(broke, probability, 1 - probability)).sum()
    assert fit.log_likelihood == pytest.approx(value)
    assert fit.aic == pytest.approx(6 - 2 * value)


def test_quantiles():
    assert normal_quantile(0.95) == pytest.approx(1.959964, abs=1e-6)
