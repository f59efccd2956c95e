"""Figures of many droplets: what is drawn of known droplets and contacts."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from matplotlib.patches import Circle

from pinchoff.collisions.law import breakup_probability
from pinchoff.figures import emulsion_figures as figures
from pinchoff.figures.emulsion_film import film_rate
from pinchoff.model import arrays
from pinchoff.model.outlines import Outline

ARRAY = arrays.square(rows=2, columns=2, radius=0.3, gap=1.4)  # a cell of 4 by 4 D0


def droplet(x, y, diameter=1.0, generation=0):
    angle = 2 * math.pi * np.arange(48) / 48
    circle = 0.5 * diameter * np.column_stack([np.cos(angle), np.sin(angle)]) + [x, y]
    return Outline(0, generation, circle, np.zeros((48, 2)))


def shapes(x, y, periodic):
    axes = figures.droplets_in_array([droplet(x, y)], ARRAY, 0.0, "size", periodic)
    return axes.collections[0].get_paths()


@pytest.mark.parametrize(
    ("x", "y", "periodic", "count"),
    [
        (2.0, 2.0, "xy", 1),
        (2.0, 3.8, "y", 2),
        (3.8, 2.0, "y", 1),
        (3.8, 2.0, "xy", 2),
        (3.9, 3.9, "xy", 4),
    ],
)
def test_what_crosses_an_edge_is_drawn_on_both_sides(x, y, periodic, count):
    found = shapes(x, y, periodic)
    assert len(found) == count
    middles = np.array([path.vertices.mean(axis=0) for path in found])
    away = np.abs(middles - [x, y])
    assert np.isclose(np.minimum(away, np.abs(away - 4.0)), 0.0, atol=0.02).all()


def test_every_pillar_of_the_cell_is_drawn():
    axes = figures.droplets_in_array([], ARRAY, 0.0)
    circles = [patch for patch in axes.patches if isinstance(patch, Circle)]
    inside = [c for c in circles if 0 <= c.center[0] < 4 and 0 <= c.center[1] < 4]
    assert len(inside) == len(ARRAY.circles)


def known_contacts(shift, seed=0, count=4000):
    """Return contacts that break at Bk = shift, with the paper's width."""
    rng = np.random.default_rng(seed)
    number = np.exp(rng.uniform(math.log(0.02), math.log(5.0), count))
    broke = rng.random(count) < breakup_probability(number / shift, 0.098)
    columns = {"breakup_number": number, "broke": broke, "diameter": np.ones(count)}
    return pd.DataFrame({**columns, "settled": np.ones(count, dtype=bool)})


def test_contacts_fall_on_the_line_of_the_pillar_alone():
    alone = pd.DataFrame({"diameter": [0.9, 1.1], "breakup_number": [0.25, 0.25]})
    axes = figures.contact_breakups(known_contacts(0.25), alone)
    first, second = axes.figure.axes
    for panel, matches in ((first, False), (second, True)):
        points = panel.containers[0].lines[0]
        x, y = np.asarray(points.get_xdata()), np.asarray(points.get_ydata())
        assert np.allclose(y, breakup_probability(x, 0.098), atol=0.12) is matches


def test_contacts_of_which_none_has_ended_are_drawn():
    none = pd.DataFrame({"kind": [], "time": [], "since": [], "clock": []}, dtype=float)
    axes = figures.pair_contacts(none)
    axes.figure.draw_without_rendering()
    assert min(*axes.get_xlim(), *axes.get_ylim()) > 0


def test_a_sweep_has_a_line_for_each_combination_of_the_others():
    table = pd.DataFrame(
        {
            "array.gap": [0.5, 1.0, 0.5, 1.0],
            "seed": [1, 1, 2, 2],
            **{f"{name}_diameter": [0.5, 0.7, 0.6, 0.8] for name in ("mean", "weighted")},
            **{f"{name}_diameter_error": [math.nan] * 4 for name in ("mean", "weighted")},
        }
    )
    axes = figures.sizes_over_sweep(table, ["array.gap", "seed"])
    for panel in axes.figure.axes:
        lines = [container.lines[0] for container in panel.containers]
        assert [line.get_ydata().tolist() for line in lines] == [[0.5, 0.7], [0.6, 0.8]]
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    assert texts == ["seed = 1", "seed = 2"]


def test_a_film_runs_at_five_t0_a_second_within_reason():
    assert [film_rate(interval) for interval in (0.5, 0.1, 5.0, 0.01)] == [10, 50, 5, 50]
