"""Results show themselves: figures that a display shows, pages in a notebook, films."""

from __future__ import annotations

import base64
import subprocess
import sys
import types

import numpy as np
import pytest

import pinchoff as po
from pinchoff.figures import style

EXPERIMENT = {
    "diameter": "481 um",
    "obstacle_radius": "85 um",
    "speed": "1 mm/s",
    "viscosity": "48 mPa s",
    "surface_tension": "20 mN/m",
    "thickness": "85 um",
}


@pytest.fixture(scope="module")
def collision():
    return po.simulate(po.Parameters.from_physical(**EXPERIMENT), outlines=True)


@pytest.fixture(scope="module")
def fit():
    return po.fit_law(po.virtual_experiment(seed=1, n=800, symmetry_noise=0))


def pictures(page: str) -> list[bytes]:
    parts = page.split("data:image/png;base64,")[1:]
    return [base64.b64decode(part.partition("'")[0]) for part in parts]


def assert_shows_itself(result, *said):
    page = result._repr_html_()
    for text in said:
        assert text in page
    (picture,) = pictures(page)
    assert picture.startswith(b"\x89PNG")


def test_collision_and_outlines(collision):
    assert_shows_itself(collision, "broke", "mm/s", "symmetry S")
    assert_shows_itself(collision.outlines, "frames")
    assert [axes.get_title("right") for axes in collision.plot()][1] == "contact"
    assert len(collision.plot(times=[2.0, 3.0])) == 2


def test_collision_without_outlines_says_what_to_do():
    bare = po.simulate(po.Parameters())
    assert not pictures(bare._repr_html_())
    assert "outlines=True" in bare._repr_html_()
    with pytest.raises(po.InputError, match="outlines=True"):
        bare.plot()


def test_law(fit):
    assert_shows_itself(fit, "β", "of which")
    assert fit.plot().get_xlabel() == "breakup number Bk"
    assert len(fit.plot(kind="outcomes")) == 3
    assert list(fit.summary().index) == ["alpha", "beta", "w"]
    assert fit.summary().loc["beta", "value"] == fit.beta.value
    with pytest.raises(po.InputError, match="kind must be"):
        fit.plot(kind="pie")


def test_prediction_is_the_law_at_bk(fit):
    table = po.simulate_many({"offset": [0.0, 0.1, 0.3]})
    x = fit.breakup_number(table) ** (1 / fit.w.value)
    assert fit.predict(table) == pytest.approx(x / (1 + x), nan_ok=True)
    with pytest.raises(po.InputError, match="symmetry"):
        fit.predict(table.drop(columns="symmetry"))


def test_tables_and_boundary():
    line = po.boundary(po.Parameters(), {"simulation_capillary_number": [20, 40, 80]}, width=0.05)
    assert_shows_itself(line, "simulation_capillary_number", "found")
    runs = line.runs
    for drawn in (po.figures.phase_diagram(runs), po.figures.separating_line(runs)):
        assert drawn.get_ylabel() == "symmetry $S$"
    assert_shows_itself(po.import_collisions(runs[runs["broke"].notna()]), "rows of the source")
    with pytest.raises(po.InputError, match="without capillary_number"):
        po.figures.phase_diagram(runs[["symmetry"]])


def test_films(collision, tmp_path):
    short = collision.outlines[::10]
    player = short.animate()
    assert "<script" in player._repr_html_()
    assert repr(player) == f"<Player of {player.frame_count} frames: a notebook shows it>"
    short.animate(tmp_path / "film.gif")
    short.animate(tmp_path / "film.html")
    from PIL import Image

    with Image.open(tmp_path / "film.gif") as film:
        assert film.n_frames == player.frame_count
    assert (tmp_path / "film.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    with pytest.raises(po.InputError, match=r"\.gif"):
        short.animate(tmp_path / "film.avi")


def test_some_frames_are_the_frames(collision):
    outlines = collision.outlines
    some = outlines[5:40:7]
    assert some.times.tolist() == outlines.times[5:40:7].tolist()
    for mine, other in zip(some[2], outlines[5 + 2 * 7], strict=True):
        assert mine.droplet_id == other.droplet_id
        np.testing.assert_array_equal(mine.vertices, other.vertices)
    assert len(outlines[3:3]) == 0
    with pytest.raises(po.InputError, match="step must be positive"):
        outlines[::-1]


def test_figures_are_pyplots_where_somebody_looks_on(monkeypatch):
    """In IPython a figure must be one of pyplot's to be shown; on its way to a file it is not."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    pyplot.close(pyplot.figure())  # its hooks are set before the shell is a stand-in

    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: object()))
    figure = style.new_figure(3.0, 2.0)
    assert pyplot.get_fignums() == [figure.number]
    pyplot.close(figure)
    with style.off_screen():
        style.new_figure(3.0, 2.0)
    assert pyplot.get_fignums() == []
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot")
    monkeypatch.delitem(sys.modules, "IPython")
    style.new_figure(3.0, 2.0)
    assert pyplot.get_fignums() == []


def test_importing_the_package_loads_no_figures():
    code = "import sys, pinchoff; print('matplotlib' in sys.modules, hasattr(pinchoff, 'Any'))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.split() == ["False", "False"]


def test_progress_in_a_notebook_is_html(monkeypatch):
    from pinchoff.support.progress import progress_bar, wanted_progress

    shown = []

    class Place:
        def update(self, page):
            shown.append(page)

    display = types.SimpleNamespace(HTML=str, display=lambda page, display_id: Place())
    shell = types.SimpleNamespace(kernel=object())
    ipython = types.SimpleNamespace(get_ipython=lambda: shell, display=display)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    assert wanted_progress(None)
    with progress_bar(True, "collisions", 4, unit="runs") as show:
        show(2)
        show(4)
    assert "4 of 4 runs" in shown[-2]
    assert "done" in shown[-1]
