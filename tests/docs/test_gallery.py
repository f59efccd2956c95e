"""The gallery's examples and the notebooks run as they stand, and every figure has its place."""

import inspect
import json
import runpy
from pathlib import Path

import pytest

import pinchoff as po

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("plot_*.py"))
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
NEEDS = {"plot_chamber": "skfem", "plot_measured_film": "cv2"}
SLOW = ("plot_chamber", "plot_calibration", "plot_measured_film")
NOT_SHOWN = {"objective_landscape", "save", "write_snapshots"}  # a long search; writers of files


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in SLOW else ())
        for p in EXAMPLES
    ],
)
def test_examples_of_the_gallery_run(path, tmp_path, monkeypatch):
    pytest.importorskip(NEEDS.get(path.stem, "pinchoff"), reason="its extra is not installed")
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run_and_are_kept_without_outputs(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cells = [
        cell
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]
        if cell["cell_type"] == "code"
    ]
    assert cells
    session: dict[str, object] = {}
    for cell in cells:
        assert cell["outputs"] == []
        exec(compile("".join(cell["source"]), str(path), "exec"), session)


def test_every_figure_is_in_the_gallery():
    shown = "".join(path.read_text(encoding="utf-8") for path in EXAMPLES)
    functions = {n for n in po.figures.__all__ if inspect.isfunction(getattr(po.figures, n))}
    assert {name for name in functions - NOT_SHOWN if f"po.figures.{name}(" not in shown} == set()
