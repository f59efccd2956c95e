"""The examples in the docstrings run and give what they say; no public function is without one."""

import doctest
import importlib
import inspect
import pkgutil
from importlib.util import find_spec

import pytest

import pinchoff

MODULES = sorted(
    module.name for module in pkgutil.walk_packages(pinchoff.__path__, prefix="pinchoff.")
)
PUBLIC = ("pinchoff", "pinchoff.chamber", "pinchoff.model.flow", "pinchoff.video.microscope")


@pytest.fixture(scope="module")
def flows():
    """The flows through a device that examples have asked for: each takes seconds."""
    return {}


@pytest.fixture
def computed_once(flows, monkeypatch):
    """Let examples that ask for the same flow share it."""
    if find_spec("skfem") is None:
        return
    from pinchoff.chamber import flow_check

    compute = flow_check.check_flow

    def shared(design):
        text = repr(design)
        if text not in flows:
            flows[text] = compute(design)
        return flows[text]

    # Not in its own module: there its own example would not be found.
    monkeypatch.setattr(pinchoff.chamber, "check_flow", shared)


@pytest.mark.parametrize("name", ["pinchoff", *MODULES])
@pytest.mark.usefixtures("computed_once")
def test_examples(name, tmp_path, monkeypatch):
    if name == "pinchoff._core":
        pytest.skip("compiled: its docstrings hold no examples")
    monkeypatch.chdir(tmp_path)
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def functions_of(name):
    """Return the functions that a module offers: those it lists, or those it defines."""
    module = importlib.import_module(name)
    listed = getattr(module, "__all__", None)
    for each in listed if listed is not None else vars(module):
        value = getattr(module, each)
        own = listed is not None or getattr(value, "__module__", None) == name
        if own and inspect.isfunction(value) and not each.startswith("_"):
            yield value


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_function_has_an_example(name):
    functions = list(functions_of(name))
    assert functions
    without = [
        f"{function.__module__}.{function.__name__}"
        for function in functions
        if "\nExamples\n--------\n" not in (text := inspect.getdoc(function) or "")
        or not doctest.DocTestParser().get_examples(text)
    ]
    assert without == []
