"""The figures of the separating line: what is drawn where, and the numbers written on them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb

import pinchoff as po
from pinchoff.figures import style
from pinchoff.figures.appendix_c import appendix_c
from pinchoff.figures.area_collapse import area_collapse
from pinchoff.figures.phase_diagram import separating_line
from pinchoff.figures.plane import logarithmic_axes
from pinchoff.studies.boundary.collapse import collapse_spread, slopes
from pinchoff.support import palette


@pytest.fixture(scope="module")
def grid():
    vary = {
        "line_tension": [60, 190],
        "size_ratio": [5.66, 8],
        "simulation_capillary_number": [25, 40],
    }
    return po.boundary(po.Parameters(), vary, width=0.02)


@pytest.fixture
def tensions():
    """Two line tensions, the critical symmetry of one 2 % above that of the other."""
    ca = np.array([10.0, 20.0, 40.0])
    symmetry = 3 * ca**-0.7
    return pd.DataFrame(
        {
            "line_tension": np.repeat([20.0, 200.0], 3),
            "simulation_capillary_number": np.tile(ca, 2),
            "drag": np.concatenate([20 * ca, 200 * ca]),
            "critical_symmetry": np.concatenate([0.99 * symmetry, 1.01 * symmetry]),
            "width": 0.002,
        }
    )


def test_every_run_that_touched_is_a_star(grid):
    axes = separating_line(grid, grid.fit())
    stars = axes.collections[0]
    filled = np.all(stars.get_facecolors()[:, :3] == to_rgb(palette.BROKE), axis=1)
    touched = grid.runs[grid.runs["symmetry"].notna()]
    assert filled.sum() == touched["broke"].sum()
    assert (~filled).sum() == (~touched["broke"].astype(bool)).sum()
    labels = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert sum("paper" in label for label in labels) == 2
    assert "its 95% interval" in labels


def test_the_papers_lines_lie_where_the_paper_has_them(grid):
    axes = separating_line(grid)
    for line in axes.lines:
        if "simulations" in str(line.get_label()):
            assert line.get_ydata() == pytest.approx(0.089 * line.get_xdata() ** -0.72)
        if "experiments" in str(line.get_label()):
            assert line.get_ydata() == pytest.approx(0.083 * line.get_xdata() ** -0.74)


def test_the_collapse_says_its_exponent(grid):
    _, free = area_collapse(grid)
    p = grid.fit(free_area=True).area_exponent
    (text,) = free.texts
    assert f"{p.value:.2f} ({p.low:.2f} to {p.high:.2f})" in text.get_text()


def test_spread_and_slopes_of_known_points(tensions):
    spread = collapse_spread(tensions)
    assert spread.typical == pytest.approx(0.01)
    assert spread.largest == pytest.approx(0.01)
    assert spread.bracket == pytest.approx(0.001 / tensions["critical_symmetry"].min())
    assert slopes(tensions) == pytest.approx({20: -0.7, 200: -0.7})


def test_appendix_c_shows_the_spread(grid):
    one_size = po.Boundary(
        grid.table[grid.table["size_ratio"] == 8], grid.runs, grid.base, grid.varied
    )
    _, below = appendix_c(one_size)
    spread = collapse_spread(one_size.found)
    assert f"largest {spread.largest:.2%}" in below.texts[0].get_text()


def test_one_line_tension_has_no_collapse(refused, tensions):
    refused("boundary", collapse_spread, tensions[tensions["line_tension"] == 20])


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_written_whole(grid, tmp_path, suffix):
    style.save(tmp_path / f"line{suffix}", separating_line(grid))
    assert [path.name for path in tmp_path.iterdir()] == [f"line{suffix}"]


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [
        (0.04, 0.25, [0.05, 0.1, 0.2]),
        (0.0075, 0.018, [0.008, 0.01, 0.015]),
        (1e-4, 0.5, [1e-4, 1e-3, 1e-2, 0.1]),
    ],
)
def test_an_axis_has_several_numbers_and_not_many(low, high, shown):
    axes = style.one_panel(2.0)
    logarithmic_axes(axes, np.array([low, high]))
    assert axes.get_xticks().tolist() == shown
