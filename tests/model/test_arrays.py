"""Arrays of pillars: their geometry against plain arithmetic, and what is refused."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.model.arrays import PillarArray

arrays = po.arrays


def brute_force_gaps(array):
    """Every pillar against every image of every other, and of itself."""
    gaps = []
    for k, (x, y, radius) in enumerate(array.circles):
        least = math.inf
        for (m, (a, b, other)), i, j in itertools.product(
            enumerate(array.circles), (-1, 0, 1), (-1, 0, 1)
        ):
            if (m, i, j) != (k, 0, 0):
                away = math.hypot(a + i * array.length - x, b + j * array.width - y)
                least = min(least, away - radius - other)
        gaps.append(least)
    return np.array(gaps)


@pytest.mark.parametrize("build", [arrays.square, arrays.staggered, arrays.hexagonal])
def test_neighbours_of_a_lattice_are_the_gap_apart(build):
    array = build(rows=2, columns=4, radius=0.3, gap=0.45)
    np.testing.assert_allclose(array.gaps, 0.45, rtol=1e-12)
    np.testing.assert_allclose(array.gaps, brute_force_gaps(array), rtol=1e-12)
    assert len(array.circles) == 8


def test_six_neighbours_in_a_hexagonal_lattice():
    array = arrays.hexagonal(rows=4, columns=4, radius=0.3, gap=0.4)
    x, y, _ = array.circles[5]
    away = np.array([array.length, array.width])
    to = array.circles[:, :2] - [x, y]
    to -= away * np.round(to / away)
    assert np.isclose(np.hypot(*to.T), 1.0).sum() == 6


@pytest.mark.parametrize(("porosity", "gap"), [(0.85, 0.3), (0.6, 0.1)])
def test_disordered_arrays_have_the_porosity_and_keep_the_gap(porosity, gap):
    array = arrays.disordered(
        length=8, width=5, radius=0.25, porosity=porosity, least_gap=gap, seed=3
    )
    one = math.pi * 0.25**2 / 40
    assert array.porosity == pytest.approx(porosity, abs=0.51 * one)
    assert array.least_gap >= gap * (1 - 1e-9)
    np.testing.assert_allclose(array.gaps, brute_force_gaps(array), rtol=1e-9)


def test_the_seed_alone_decides_a_disordered_array():
    def build(seed):
        return arrays.disordered(
            length=5, width=4, radius=0.25, porosity=0.7, least_gap=0.1, seed=seed
        ).circles

    np.testing.assert_array_equal(build(5), build(5))
    assert not np.array_equal(build(5), build(6))


def test_margins_and_scale_keep_the_pillars_apart():
    array = arrays.staggered(rows=2, columns=2, radius=0.2, gap=0.5)
    wide = array.with_margins(1.0, 2.0)
    assert wide.length == pytest.approx(array.length + 3.0)
    np.testing.assert_allclose(wide.circles[:, 0], array.circles[:, 0] + 1.0)
    assert array.scaled(3.0).porosity == pytest.approx(array.porosity)
    assert array.scaled(3.0).least_gap == pytest.approx(1.5)


def test_an_array_comes_from_a_table(tmp_path):
    path = tmp_path / "pillars.csv"
    path.write_text("X,Y,Radius\n0.5,0.5,0.2\n1.5,0.5,0.25\n")
    array = arrays.read(path, length=2, width=1)
    np.testing.assert_array_equal(array.circles, [[0.5, 0.5, 0.2], [1.5, 0.5, 0.25]])
    with pytest.raises(po.InputError, match="length must be"):
        arrays.read(path, length="long", width=1)
    for text, words in (
        ("x,y,r\n0.5,0.5,0.2\n", "columns x, y and radius"),
        ("x,y,radius\n0.5,a,0.2\n", "numbers"),
    ):
        path.write_text(text)
        with pytest.raises(po.InputError, match=words):
            arrays.read(path, length=2, width=1)


@pytest.mark.parametrize(
    ("circles", "words"),
    [
        ([], "of shape"),
        ([[0.5, 0.5, 0.0]], r"circles\[0\] must be finite"),
        ([[0.5, 0.5, 0.1], [0.2, math.nan, 0.1]], r"circles\[1\] must be finite"),
        ([[2.0, 0.5, 0.1]], "in the cell"),
        ([[0.5, 0.5, 0.2], [0.8, 0.5, 0.2]], "free of overlap"),
        ([[0.1, 0.5, 0.2], [1.8, 0.5, 0.2]], "free of overlap"),  # across the edge
        ([[1.0, 0.5, 0.5]], "free of overlap"),  # with its own image
    ],
)
def test_what_is_no_array_is_refused(circles, words):
    with pytest.raises(po.InputError, match=words):
        PillarArray(np.array(circles, dtype=float), 2.0, 1.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"porosity": 1.2}, "porosity must be between"),
        ({"porosity": 0.3}, "pillars fit"),
        ({"porosity": 0.999}, "from 1 to"),
        ({"radius": -1}, "radius must be"),
        ({"seed": 1.5}, "seed must be"),
        ({"least_gap": 5}, "length and width must be"),
    ],
)
def test_impossible_disordered_arrays_are_refused(change, words):
    good = {"length": 4, "width": 4, "radius": 0.25, "porosity": 0.7, "least_gap": 0.1, "seed": 0}
    with pytest.raises(po.InputError, match=words):
        arrays.disordered(**{**good, **change})


@pytest.mark.parametrize(("columns", "words"), [(3, "even"), (2.5, "a whole number")])
def test_a_staggered_lattice_needs_an_even_number_of_columns(columns, words):
    with pytest.raises(po.InputError, match=f"columns must be {words}"):
        arrays.staggered(rows=1, columns=columns, radius=0.2, gap=0.2)
