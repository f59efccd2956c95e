"""Convergence in vertices and time step, the overdamped collapse, and the separating line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

SIZE_RATIO = 5.66
AREA = math.pi / 4 * SIZE_RATIO**2
ABSCISSA = np.array([0.0395, 0.0493, 0.0616, 0.0789, 0.0986, 0.1233, 0.1578, 0.1973])
"""Ca Ã z̃ at which an independent prototype of the model found the line."""
PROTOTYPE = np.array([0.998, 0.843, 0.686, 0.562, 0.472, 0.408, 0.347, 0.309])
"""Its S_c at γ̃ = 80."""
COLUMN = _core.MODEL_FIELDS.index
SYMMETRY = _core.RESULT_FIELDS.index("symmetry")


@pytest.fixture
def separating_line(model):
    """Function (abscissa, **constants) -> S_c: bisection on the offset, to 6e-5 D0."""

    def find(abscissa, **constants):
        capillary = np.atleast_1d(abscissa) / (9.8e-5 * AREA)
        rows = np.array(
            [
                model(simulation_capillary_number=ca, follow_daughters=False, **constants)
                for ca in capillary
            ]
        )

        def run(offset):
            rows[:, COLUMN("offset")] = offset
            results = _core.run_many(rows, None, 1, None)
            assert (results[:, 0] != 3).all()
            return results[:, 0] == 1, results[:, SYMMETRY]

        inside, outside = np.zeros(len(rows)), np.full(len(rows), 0.25)
        breaks, s_inside = run(inside)
        assert breaks.all()
        breaks, s_outside = run(outside)
        assert not breaks.any()
        for _ in range(12):
            middle = (inside + outside) / 2
            breaks, s = run(middle)
            inside, outside = np.where(breaks, middle, inside), np.where(breaks, outside, middle)
            s_inside, s_outside = np.where(breaks, s, s_inside), np.where(breaks, s_outside, s)
        assert np.abs(s_inside - s_outside).max() < 1e-3
        return (s_inside + s_outside) / 2

    return find


def test_separating_line_is_the_prototypes(separating_line):
    """S_c at D0/R = 5.66 within 5 % of an independent program's at each of eight Ca Ã z̃."""
    got = separating_line(ABSCISSA)
    np.testing.assert_allclose(got, PROTOTYPE, rtol=0.05)
    exponent, logarithm = np.polyfit(np.log(ABSCISSA), np.log(got), 1)
    # The prototype's fit is 0.0881 x^-0.742. An error of 5 % at each point, independent of the
    # others, changes the slope by less than 0.05/√(Σ (ln x - mean)²), and α by that times |ln x|.
    spread = np.sqrt(((np.log(ABSCISSA) - np.log(ABSCISSA).mean()) ** 2).sum())
    assert exponent == pytest.approx(-0.742, abs=0.05 / spread)
    assert math.exp(logarithm) == pytest.approx(
        0.0881, rel=0.05 / spread * abs(np.log(ABSCISSA).mean())
    )
    assert (np.diff(got) < 0).all()


def test_overdamped_collapse(separating_line):
    """γ̃ = 20, 40 and 80 at equal Ca_sim: S_c within 2 %, for only μ̃/γ̃ matters."""
    some = ABSCISSA[[0, 2, 4, 7]]
    stiff = separating_line(some, line_tension=80.0)
    for line_tension in (20.0, 40.0):
        got = separating_line(some, line_tension=line_tension)
        np.testing.assert_allclose(got, stiff, rtol=0.02)


def test_separating_line_converges_in_the_number_of_vertices(separating_line):
    """S_c at N_v = 64 and at 128 agree to 5 %, "a few percent": the neck joins two vertices."""
    some = ABSCISSA[[1, 4, 7]]
    line = {n: separating_line(some, vertex_count=n) for n in (64, 128)}
    np.testing.assert_allclose(line[64], line[128], rtol=0.05)


def test_separating_line_converges_in_the_time_step(separating_line):
    """S_c with the automatic step and with the paper's 1e-4 t0 agree to 0.5 %."""
    some = ABSCISSA[[0, 1, 4, 7]]
    auto = separating_line(some)
    np.testing.assert_allclose(separating_line(some, time_step=1e-4), auto, rtol=0.005)


def test_automatic_step_agrees_with_the_papers_step(model):
    """S within 0.5 % and the same outcome, over a sample away from the line.

    Runs whose thinnest neck comes within 2 % of the threshold are on the line and left out.
    """
    rng = np.random.default_rng(1)
    auto = np.array(
        [
            model(
                size_ratio=rng.uniform(2, 8),
                simulation_capillary_number=rng.uniform(8, 90),
                offset=rng.uniform(-0.3, 0.3),
                follow_daughters=False,
            )
            for _ in range(60)
        ]
    )
    paper = auto.copy()
    paper[:, COLUMN("time_step")] = 1e-4
    got, expected = (
        {n: r[:, k] for k, n in enumerate(_core.RESULT_FIELDS)}
        for r in (_core.run_many(rows, None, 1, None) for rows in (auto, paper))
    )
    touched = np.isfinite(expected["symmetry"]) & np.isfinite(got["symmetry"])
    assert touched.sum() > 30
    near_line = (expected["outcome"] == 0) & (expected["minimum_neck"] < 1.02 * 0.167)
    clear = touched & ~near_line
    np.testing.assert_array_equal(got["outcome"][clear], expected["outcome"][clear])
    # A droplet that only grazes the obstacle has S near 0, where a fraction of S says nothing.
    full = touched & (expected["symmetry"] > 0.1)
    np.testing.assert_allclose(got["symmetry"][full], expected["symmetry"][full], rtol=0.005)
    np.testing.assert_allclose(
        got["symmetry"][touched], expected["symmetry"][touched], atol=0.005, rtol=0
    )


def test_symmetry_at_contact_converges_in_the_number_of_vertices(model, run):
    """S of collisions at N_v = 64 is within 0.01 of that at 128, and the outcome is the same."""
    for constants in (
        {"offset": 0.05},
        {"offset": 0.02, "simulation_capillary_number": 40.0},
        {"offset": 0.15, "simulation_capillary_number": 60.0},
    ):
        rows = [model(**constants, vertex_count=n, follow_daughters=False) for n in (64, 128)]
        coarse, fine = run(rows)
        assert coarse["symmetry"] == pytest.approx(fine["symmetry"], abs=0.01)
        assert coarse["outcome"] == fine["outcome"]
        assert coarse["contact_time"] == pytest.approx(fine["contact_time"], rel=0.01)
