"""The reproduction: what is made, that it goes on where it stopped, and that it says what it is."""

from __future__ import annotations

import importlib
import json
import re

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.cli import main
from pinchoff.paper import make
from pinchoff.paper.catalogue import FIGURES
from pinchoff.paper.make import ITEMS
from pinchoff.paper.numbers import data_name, numbers
from pinchoff.paper.reproduction_page import reproduction_page
from pinchoff.paper.study import Study, droplet, offset_of_symmetry, paper_breakup_number
from pinchoff.paper.verdicts import KINDS, Number, estimated, plain

CHEAP = ["2", "3"]


def reproduce(*arguments):
    return main(["reproduce", *map(str, arguments)])


@pytest.fixture(scope="module")
def study():
    """A study of half the points of each line and a third of the simulated collisions."""

    def fewer(seed, *count, **more):
        return po.virtual_experiment(seed, *(n // 3 for n in count), **more)

    module = importlib.import_module("pinchoff.paper.study")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "CAPILLARY", module.CAPILLARY[::2])
        patch.setattr(module, "virtual_experiment", fewer)
        yield Study(seed=1, quick=True)


@pytest.fixture(scope="module")
def found(study):
    return {number.name: number for number in numbers(study)}


def test_every_figure_of_the_paper_has_its_place():
    assert [figure.name for figure in FIGURES] == [*map(str, range(1, 11)), "A", "B1", "B2", "C"]
    assert all(figure.caption.endswith(".") for figure in FIGURES)


def test_figures_are_written_once_and_taken_up(tmp_path, monkeypatch):
    made = po.reproduce(tmp_path, only=CHEAP, quick=True)
    assert [each.figure.name for each in made.figures] == CHEAP
    for each in made.figures:
        assert each.png.read_bytes().startswith(b"\x89PNG")
        assert each.pdf.read_bytes().startswith(b"%PDF")
    before = {path: path.stat().st_mtime_ns for path in tmp_path.glob("figure_*")}
    (tmp_path / "figure_3.json").unlink()  # as if it had been stopped there
    drawn = []
    monkeypatch.setattr(make.style, "save", lambda path, axes: drawn.append(path.name))
    po.reproduce(tmp_path, only=CHEAP, quick=True)
    assert drawn == ["figure_3.png", "figure_3.pdf"]
    assert (tmp_path / "figure_2.png").stat().st_mtime_ns == before[tmp_path / "figure_2.png"]


@pytest.mark.usefixtures("unrendered")
def test_what_is_not_installed_is_left_out_and_said(tmp_path, monkeypatch):
    monkeypatch.setattr(make, "find_spec", lambda name: None)
    made = po.reproduce(tmp_path, only=["3", "A"], quick=True)
    assert [each.figure.name for each in made.figures] == ["3"]
    assert "pinchoff[chamber]" in made.left_out["A"]
    assert "Figures that were left out" in reproduction_page(made).html()


@pytest.mark.usefixtures("unrendered")
def test_the_device_and_a_film_that_is_measured(tmp_path):
    made = po.reproduce(tmp_path, only=["A", "B2"], quick=True)
    assert [each.figure.name for each in made.figures] == ["A", "B2"]
    assert (tmp_path / "film_B2.mp4").exists()


@pytest.mark.usefixtures("unrendered")
def test_other_settings_are_refused(tmp_path, refused):
    po.reproduce(tmp_path, only=["3"], quick=True)
    error = refused("out", po.reproduce, tmp_path, only=["3"], quick=True, seed=2)
    assert "seed differ" in error.got
    error = refused("only", po.reproduce, tmp_path, only=["11"], quick=True)
    assert "choose from" in error.advice or "did you mean" in error.advice


@pytest.mark.usefixtures("unrendered")
def test_progress_names_what_comes_next(tmp_path):
    seen = []
    po.reproduce(tmp_path, only=CHEAP, quick=True, progress=lambda *now: seen.append(now))
    assert seen == [("2", 0, 2), ("3", 1, 2)]


def test_numbers_that_the_paper_and_arithmetic_give(found):
    assert found["prefactor of Bk"].value == pytest.approx(28.89, abs=0.01)
    assert found["exponent of S in Bk"].verdict == "misprint"
    assert found["exponent of S in Bk"].value > 0
    assert found["growth of P from 5 to 95 %, factor in Bk"].value == pytest.approx(1.781, abs=1e-3)
    assert found["β of one height h ≪ D0"].value == pytest.approx(-0.75, abs=1e-3)
    assert found["d_min-neck"].value == pytest.approx(80.3, abs=0.05)
    assert found["viscosity of the oils"].value == pytest.approx(48)
    assert found["Re"].value == pytest.approx(960 * 2e-3 * 120e-6 / 0.048)
    assert found["Ca"].low == pytest.approx(1.2e-3)
    assert found["Ca"].high == pytest.approx(9.6e-3)
    assert found["δ/z = Ca^(2/3)"].low == pytest.approx(1.2e-3 ** (2 / 3))
    assert paper_breakup_number(0.2, 1.0, 0.62) == pytest.approx(1, abs=0.01)


def test_numbers_of_engine_and_law(found):
    for name, verdict in (
        ("prefactor α, simulations", "agrees"),
        ("exponent β, simulations", "agrees"),
        ("exponent ε1 of A", "recovered"),
    ):
        assert found[name].verdict == verdict
        assert found[name].low < found[name].value < found[name].high
    assert found["simulated A1/A2 below S/(2 − S)"].value == 1
    assert found["collapse of S_c with μ̃/γ̃"].value < 0.02
    assert 8e-5 < found["Ca per Ca_sim"].value < 1e-4


def test_front_tracking_stands_beside_what_both_models_simulate(found):
    """Its own numbers, with verdicts of their own; the springs' constants have none there."""
    beside = {name for name, number in found.items() if number.front}
    assert beside == {
        "prefactor α, simulations",
        "exponent β, simulations",
        "Ca per Ca_sim",
        "simulated A1/A2 below S/(2 − S)",
    }
    for name in beside:
        assert found[name].front_verdict in ("agrees", "differs")
        assert re.search("front tracking: engine|both models: engine", found[name].how)
    alpha = found["prefactor α, simulations"]
    assert alpha.front != alpha.ours
    assert float(alpha.front) == pytest.approx(0.086, abs=0.006)
    assert found["exponent β, simulations"].front_verdict == "agrees"
    assert found["slope of ln S_c against ln μ̃"].front == ""


def test_what_rests_on_synthetic_data_says_so(found):
    for name in ("prefactor α, experiments", "exponent ε2 of R", "orders of magnitude of Bk"):
        assert "synthetic data" in found[name].how
        assert found[name].kind == "recovered"
    assert found["uncertainty of S"].kind == "needs the authors' data"
    assert found["uncertainty of S"].ours == ""


def test_a_wrong_number_would_differ():
    """The verdict depends on the numbers: an interval that misses the paper's value differs."""
    from pinchoff.support.interval import Estimate

    known = ("n", "p", "1", (1.0, 0.05))
    near = estimated(*known, Estimate(1.2, 1.05, 1.3), "h", "simulated")
    far = estimated(*known, Estimate(1.2, 1.15, 1.3), "h", "simulated")
    assert (near.verdict, far.verdict) == ("agrees", "differs")
    far = estimated(*known, Estimate(1.2, 1.15, 1.3), "h", "recovered")
    assert far.verdict == "not recovered"
    assert plain("n", "p", "28", 28.0, 28.9, "h", factor=1.05).verdict == "follows"
    assert plain("n", "p", "28", 28.0, -28.9, "h", factor=1.05).verdict == "does not follow"


def test_only_what_was_simulated_agrees_or_differs(found):
    for number in found.values():
        assert number.kind in KINDS
        assert (number.verdict in ("agrees", "differs")) == (number.kind == "simulated")
        assert ("synthetic data" in number.how) == (number.kind == "recovered")
    assert not any("engine" in n.how for n in found.values() if n.kind == "arithmetic")


def test_a_start_that_gives_a_symmetry():
    offset = offset_of_symmetry(540.0, 1.4, 0.5)
    collision = po.simulate(droplet(540.0, 1.4, offset))
    assert collision.symmetry == pytest.approx(0.5, abs=0.01)


@pytest.mark.usefixtures("unrendered")
def test_real_collisions_take_the_place_of_synthetic_ones(tmp_path, capsys):
    table = po.virtual_experiment(9, 1500, symmetry_noise=0).assign(source="laboratory")
    table.to_csv(tmp_path / "mine.csv", index=False)
    out = tmp_path / "mine"
    assert reproduce("--only", "4,7", "--experiment", tmp_path / "mine.csv", "--out", out) == 0
    assert json.loads((out / "figure_4.json").read_text())["how"] == "law; your collisions"
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "synthetic" not in page
    study = Study(quick=True, experiment=po.import_collisions(tmp_path / "mine.csv"))
    assert study.measured
    assert data_name(study) == "your collisions"
    assert "2 figures" in capsys.readouterr().out


def test_the_page_has_everything_inside(tmp_path):
    made = po.reproduce(tmp_path, only=CHEAP, quick=True)
    known = ("a number", "sec. 1", "1", "2", "", "by hand")
    numbers = [
        Number(*known, "simulated", "differs", 2.0),
        Number(*known, "recovered", "recovered"),
    ]
    object.__setattr__(made, "numbers", numbers)
    page = reproduction_page(made).html()
    assert page.count("data:image/png;base64,") == 2
    assert "There are no real collisions" in page
    assert "1 simulated: 1 differs. 1 recovered: 1 recovered." in page
    assert "is no evidence" in page
    assert not re.search(r'(?:src|href)="(?!data:|#)', page)


@pytest.mark.parametrize(
    ("options", "argument"),
    [(["--only", "11"], "--only"), (["--experiment", "no.csv"], "no.csv")],
)
def test_wrong_options_are_refused(tmp_path, capsys, options, argument):
    assert reproduce(*options, "--out", tmp_path / "out") == 2
    assert capsys.readouterr().err.startswith(f"error: {argument} must be ")


@pytest.mark.slow
def test_the_same_seed_gives_the_same_numbers(tmp_path):
    for name in ("one", "two"):
        assert reproduce("--quick", "--out", tmp_path / name) == 0
    tables = [pd.read_csv(tmp_path / name / "numbers.csv") for name in ("one", "two")]
    pd.testing.assert_frame_equal(*tables)
    for name in ITEMS[:-1]:
        pictures = [
            (tmp_path / each / f"figure_{name}.png").read_bytes() for each in ("one", "two")
        ]
        assert pictures[0] == pictures[1]
    assert np.isfinite(tables[0]["value"]).sum() > 25
