"""Which exponents the data need."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

import pinchoff as po
from pinchoff.fits.law_comparison import COLUMNS, compare_laws


@pytest.fixture(scope="module")
def virtual():
    return po.virtual_experiment(2, symmetry_noise=0)


@pytest.fixture(scope="module")
def laws(virtual):
    return compare_laws(virtual).set_index("law")


def test_every_quantity_of_the_true_law_is_needed(laws):
    for name in ("area", "thickness", "viscosity", "radius", "symmetry"):
        assert laws.loc[f"without {name}", "p_value"] < 1e-20
        assert laws.loc[f"without {name}", "delta_aic"] > 50


def test_the_true_law_is_not_refused_and_has_the_least_aic(laws):
    assert laws.loc["paper", "p_value"] > 0.05
    assert laws.loc["paper", "delta_aic"] == 0
    assert laws.loc["paper", "freedom"] == 4


def test_numbers_are_those_of_fits(virtual, laws):
    paper = po.fit_law(virtual)
    full = po.fit_law(virtual, free=("viscosity", "radius"))
    assert laws.loc["paper", "log_likelihood"] == pytest.approx(paper.log_likelihood)
    assert laws.loc["full", "log_likelihood"] == pytest.approx(full.log_likelihood)
    assert laws.loc["full", "aic"] == pytest.approx(full.aic)
    ratio = 2 * (full.log_likelihood - paper.log_likelihood)
    assert laws.loc["paper", "likelihood_ratio"] == pytest.approx(ratio, abs=1e-6)
    assert laws.loc["paper", "p_value"] == pytest.approx(chi2.sf(ratio, 4), rel=1e-4)


def test_a_quantity_that_does_not_matter_does_not_earn_its_exponent(virtual):
    """Outcomes drawn without z̃: ε3 = 0 stands, ε3 = 1 falls."""
    rng = np.random.default_rng(0)
    bk = po.breakup_number(
        virtual["capillary_number"],
        normalized_area=virtual["normalized_area"],
        symmetry=virtual["symmetry"],
    )
    table = virtual.assign(broke=rng.random(len(bk)) < 1 / (1 + bk**-10))
    laws = compare_laws(table).set_index("law")
    assert laws.loc["without thickness", "p_value"] > 0.01
    assert laws.loc["thickness as in the paper", "p_value"] < 1e-6


def test_what_does_not_vary_is_left_out(virtual):
    standard = virtual[(virtual["thickness_um"] == 85) & (virtual["obstacle_radius_um"] == 85)]
    laws = compare_laws(standard)
    assert "without thickness" not in laws["law"].tolist()
    assert laws["claim"].iloc[0] == "ε1, ε_μ free"


def test_columns_have_units(laws):
    assert laws.attrs["units"] == COLUMNS


def test_separated_outcomes_are_refused(collisions, refused):
    refused("table", compare_laws, collisions(500, 1, width=0.0))
