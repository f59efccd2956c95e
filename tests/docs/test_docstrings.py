"""The examples in the docstrings run and give what they say."""

import doctest
import importlib
import pkgutil

import pytest

import pinchoff

MODULES = sorted(
    module.name for module in pkgutil.walk_packages(pinchoff.__path__, prefix="pinchoff.")
)


@pytest.mark.parametrize("name", ["pinchoff", *MODULES])
def test_examples(name):
    if name == "pinchoff._core":
        pytest.skip("compiled: its docstrings hold no examples")
    assert doctest.testmod(importlib.import_module(name)).failed == 0
