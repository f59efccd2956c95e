"""The reference has a page for each public name."""

import inspect
from pathlib import Path

import pinchoff as po

REFERENCE = Path(__file__).parents[2] / "docs" / "reference" / "python.md"


def test_every_public_class_and_function_has_a_page():
    listed = {line.strip().removeprefix("~") for line in REFERENCE.read_text("utf-8").splitlines()}
    public = {
        n for n in po.__all__ if inspect.isclass(x := getattr(po, n)) or inspect.isfunction(x)
    }
    assert {name for name in public if f"pinchoff.{name}" not in listed} == set()


def test_every_figure_has_a_page():
    listed = REFERENCE.read_text(encoding="utf-8")
    assert {name for name in po.figures.__all__ if f".{name}\n" not in listed} == set()
