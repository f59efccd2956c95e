"""The breakup number, its constants, and the probability of break-up."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po
from pinchoff.collisions.law import (
    LINES,
    PAPER_EXPERIMENT_LINE,
    PAPER_SIMULATION_LINE,
    Line,
    breakup_number,
    breakup_probability,
    transition_factor,
)


@pytest.mark.parametrize("line", LINES.values(), ids=LINES)
def test_bk_is_1_on_the_line(line):
    forcing = np.geomspace(0.03, 1, 7)
    symmetry = line.alpha * forcing**line.beta
    assert breakup_number(
        forcing, normalized_area=1.0, symmetry=symmetry, line=line
    ) == pytest.approx(np.ones(7))


def test_bk_is_the_papers_definition_term_by_term():
    """Bk = α^(1/β) Ca A^1 R^-3 z^1 S^(-1/β), from a droplet in micrometres."""
    alpha, beta = PAPER_EXPERIMENT_LINE
    ca, area, radius, thickness, symmetry = 2.4e-3, 181_000.0, 85.0, 45.0, 0.6
    by_hand = alpha ** (1 / beta) * ca * area / radius**3 * thickness / symmetry ** (1 / beta)
    ours = po.breakup_number(
        ca,
        normalized_area=area / radius**2,
        symmetry=symmetry,
        normalized_thickness=thickness / radius,
        line="paper-experiment",
    )
    assert float(ours) == pytest.approx(by_hand)


def test_the_rounded_form_has_the_sign_of_the_abstract():
    """Bk = 28 Ca Ã z̃ S^(+4/3); printed is -4/3, which would make grazing blows break first."""
    symmetry = np.array([0.2, 0.5, 1.0])
    ours = po.breakup_number(
        1e-3,
        normalized_area=20.0,
        symmetry=symmetry,
        normalized_thickness=0.7,
        line="paper-rounded",
    )
    assert ours == pytest.approx(28 * 1e-3 * 20 * 0.7 * symmetry ** (4 / 3))
    assert (np.diff(ours) > 0).all()


def test_the_rounded_form_is_near_the_exact_one():
    """α^(1/β) is 28.9, which the paper rounds to 28, and -1/β is 1.351."""
    exact = po.breakup_number(1.0, normalized_area=1.0, symmetry=1.0, line="paper-experiment")
    assert float(exact) == pytest.approx(28.89, abs=0.005)


def test_default_constants_are_those_of_the_simulations():
    named = po.breakup_number(1e-3, normalized_area=20, symmetry=0.5, line="paper-simulation")
    assert float(po.breakup_number(1e-3, normalized_area=20, symmetry=0.5)) == float(named)
    assert LINES["paper-simulation"] == PAPER_SIMULATION_LINE == Line(0.089, -0.72)


def test_constants_of_a_fit(many):
    fit = po.fit_law(many)
    assert float(
        po.breakup_number(1e-3, normalized_area=20, symmetry=0.5, line=fit)
    ) == pytest.approx(1e-3 * 20 * (0.5 / fit.alpha.value) ** (-1 / fit.beta.value))


def test_wrong_lines_are_refused(refused):
    groups = {"normalized_area": 20, "symmetry": 0.5}
    error = refused("line", po.breakup_number, 1e-3, **groups, line="paper-experiments")
    assert "paper-experiment" in error.advice
    refused("line", po.breakup_number, 1e-3, **groups, line=(0.1, -1))


def test_not_measured_stays_so_and_s_0_never_breaks():
    bk = po.breakup_number(1e-3, normalized_area=20, symmetry=[np.nan, 0.0])
    assert np.isnan(bk[0])
    assert bk[1] == 0
    assert breakup_probability(bk[1], 0.1) == 0


def test_probability_is_x_over_1_plus_x():
    bk, w = np.array([0.5, 0.9, 1.0, 1.3, 4.0]), 0.2
    x = bk ** (1 / w)
    assert breakup_probability(bk, w) == pytest.approx(x / (1 + x))


def test_probability_far_from_the_line_neither_overflows_nor_warns():
    assert breakup_probability([1e-300, 1e300], 1e-3).tolist() == [0, 1]


def test_transition_of_the_paper():
    """From 5 to 95 %: 361^0.098 = 1.78; the paper says about 2."""
    assert transition_factor(0.098) == pytest.approx(1.781, abs=1e-3)
    bk = 1 / np.sqrt(1.781), np.sqrt(1.781)
    assert breakup_probability(bk, 0.098) == pytest.approx([0.05, 0.95], abs=1e-4)
