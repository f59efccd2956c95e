"""The figures of the law: what is drawn where, and the numbers written on them."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po
from pinchoff.collisions.circle_segments import (
    area_ratio_bound,
    height_of_symmetry,
    symmetry_of_height,
)
from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.constant_height import constant_height
from pinchoff.figures.daughters import daughter_areas
from pinchoff.figures.neck_histograms import FRAME_RATES, neck_histograms
from pinchoff.figures.phase_diagram import separated_outcomes
from pinchoff.fits.fractions import (
    broken_fractions,
    logarithmic_edges,
    merged_edges,
    wilson_interval,
)
from pinchoff.studies.necks import ThinningHistory


@pytest.fixture(scope="module")
def virtual():
    return po.import_collisions(po.virtual_experiment(1, 2000, symmetry_noise=0))


@pytest.fixture(scope="module")
def fit(virtual):
    return po.fit_law(virtual)


@pytest.fixture(scope="module")
def simulated():
    table = po.virtual_experiment(2, 80, outcomes="engine", symmetry_noise=0, progress=False)
    return po.import_collisions(table).table


def written(axes):
    return " ".join(text.get_text() for text in axes.texts)


def test_split_shows_each_collision_where_it_belongs(virtual, fit):
    broke, both, unbroken = separated_outcomes(virtual.table, fit)
    counts = [len(panel.collections[0].get_offsets()) for panel in (broke, both, unbroken)]
    assert counts == [fit.broke_count, 2000, 2000 - fit.broke_count]
    shown = np.sort(np.asarray(broke.collections[0].get_offsets())[:, 0])
    table = virtual.table[virtual.table["broke"].astype(bool)]
    forcing = table["capillary_number"] * table["normalized_area"] * table["normalized_thickness"]
    assert shown == pytest.approx(np.sort(forcing.to_numpy()))
    assert "synthetic" in written(broke)


def test_split_draws_the_line_up_to_s_1(virtual, fit):
    panel = separated_outcomes(virtual.table, fit)[1]
    (ours,) = (line for line in panel.lines if str(line.get_label()).startswith("fit"))
    x, y = ours.get_data()
    assert y == pytest.approx(fit.alpha.value * x**fit.beta.value)
    assert y.max() <= 1


def test_split_with_free_exponents_scales_the_axis(virtual):
    free = po.fit_law(virtual, free="area")
    panel = separated_outcomes(virtual.table, free)[1]
    power = free.estimates["epsilon_1"].value
    table = virtual.table
    scaled = table["capillary_number"] * table["normalized_area"] ** power
    scaled *= table["normalized_thickness"]
    shown = np.sort(np.asarray(panel.collections[0].get_offsets())[:, 0])
    assert shown == pytest.approx(np.sort(scaled.to_numpy()))
    assert f"{power:.2f}" in panel.get_xlabel()


def test_probability_is_counted_in_bins(virtual, fit):
    axes = breakup_probability(virtual.table, fit)
    bk = fit.breakup_number(virtual.table)
    data = axes.containers[0].lines[0]
    assert len(data.get_xdata()) > 8
    assert data.get_ydata()[-1] == 1
    inset = axes.child_axes[0]
    assert inset.get_xlim() == (0.3, 3.0)
    x, y = inset.lines[1].get_data()
    assert y == pytest.approx(1 / (1 + x ** (-1 / fit.w.value)))
    near = (bk > 0.3) & (bk < 3)
    assert len(inset.containers[0].lines[0].get_xdata()) <= np.count_nonzero(near)
    assert f"factor {361**fit.w.value:.2f}" in axes.get_title("right")


def test_probability_of_a_step_says_the_bound():
    table = po.import_collisions(po.virtual_experiment(3, 400, width=0.0, symmetry_noise=0))
    fit = po.fit_law(table)
    assert "at most" in breakup_probability(table.table, fit).get_title("right")


def test_counts_by_hand():
    bk = np.array([0.11, 0.15, 0.5, 2.0, 3.0, 30.0])
    broke = np.array([False, True, False, True, True, True])
    found = broken_fractions(bk, broke, np.array([0.1, 1.0, 10.0]))
    assert found.total.tolist() == [3, 2]
    assert found.broke.tolist() == [1, 2]
    assert found.middle == pytest.approx([(0.11 * 0.15 * 0.5) ** (1 / 3), 6**0.5])


def test_binomial_intervals_of_wilson():
    low, high = wilson_interval(np.array([0, 5, 10]), np.array([10, 10, 10]), 0.95)
    # the roots of (p - k/n)² = z² p (1 - p)/n
    assert low == pytest.approx([0, 0.2366, 0.7225], abs=1e-4)
    assert high == pytest.approx([0.2775, 0.7634, 1], abs=1e-4)


def test_bins_have_an_edge_on_the_line_and_enough_in_them():
    edges = logarithmic_edges(2e-3, 40, 5)
    assert 1.0 in edges
    assert edges[0] <= 2e-3
    assert edges[-1] >= 40
    values = np.geomspace(2e-3, 40, 500)
    merged = merged_edges(values, edges, 60)
    counts = np.histogram(values, merged)[0]
    assert counts.sum() == 500
    assert counts.min() >= 60
    assert {*merged} <= {*edges}


def test_daughters_lie_below_the_bound_in_simulations(simulated):
    axes = daughter_areas(simulated)
    points = axes.collections[0].get_offsets()
    assert len(points) == simulated["broke"].sum()
    assert (points[:, 1] <= area_ratio_bound(points[:, 0])).all()
    assert "0 above the bound" in axes.get_title("right")
    assert area_ratio_bound([0.0, 0.5, 1.0]) == pytest.approx([0, 1 / 3, 1])


def test_necks_of_both_kinds(simulated):
    history = ThinningHistory(np.array([0.0, 1.0]), np.array([500.0, 0.0]), 1.0)
    left, right = neck_histograms(simulated, history)
    counts = [sum(bar.get_height() for bar in container) for container in left.containers]
    measured = simulated[simulated["neck_um"].notna()]
    broke = int(measured["broke"].sum())
    assert counts == [broke, len(measured) - broke]
    for line, rate in zip(right.lines, FRAME_RATES, strict=True):
        assert line.get_xdata().max() == pytest.approx(500 / rate, rel=0.01)


def test_one_panel_without_a_history(simulated):
    assert len(neck_histograms(simulated)) == 1


def test_what_was_not_measured_is_refused(virtual, refused):
    refused("table", daughter_areas, virtual.table)
    refused("table", neck_histograms, virtual.table)


def test_construction_of_one_height():
    """Smaller parts 1 : 4^(1 + β), by the areas of the segments that are drawn."""
    left, right = constant_height("paper-rounded", small_symmetry=0.5)
    heights = [d * height_of_symmetry(0.5 * (d**2) ** -0.75) for d in (1.0, 2.0)]
    assert heights[0] == pytest.approx(heights[1], rel=0.05)
    assert f"{heights[0]:.3f} and {heights[1]:.3f}" in left.get_title("left")
    assert f"1 : {4**0.25:.2f}" in left.get_title("left")
    exact = right.lines[0].get_ydata()
    assert exact[0] == pytest.approx(-0.75, abs=1e-3)
    assert float(symmetry_of_height(height_of_symmetry(0.37))) == pytest.approx(0.37)
