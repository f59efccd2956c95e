"""The examples in the docstrings run and give what they say."""

import doctest
import importlib
import inspect
import pkgutil

import pytest

import pinchoff

MODULES = sorted(
    module.name for module in pkgutil.walk_packages(pinchoff.__path__, prefix="pinchoff.")
)


FUNCTIONS = [name for name in pinchoff.__all__ if inspect.isfunction(getattr(pinchoff, name))]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_public_function_shows_its_use(name):
    documentation = inspect.getdoc(getattr(pinchoff, name))
    assert "Examples\n--------\n>>> " in documentation


@pytest.mark.parametrize("name", ["pinchoff", *MODULES])
def test_examples(name):
    if name == "pinchoff._core":
        pytest.skip("compiled: its docstrings hold no examples")
    assert doctest.testmod(importlib.import_module(name)).failed == 0
