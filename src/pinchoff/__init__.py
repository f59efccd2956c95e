"""Droplets that collide with an obstacle and pinch off, simulated and measured.

>>> import pinchoff as po
>>> collision = po.simulate(po.Parameters(simulation_capillary_number=30, offset=0.02))
>>> collision.outcome
'broke'

Names load on first use, so that importing the package costs next to nothing; `__init__.pyi` says
which there are.
"""

import importlib as _importlib
from typing import Any as _Any

import lazy_loader as _lazy_loader

from pinchoff.support.drawing import draw_with as _draw_with

_attribute, __dir__, _public_names = _lazy_loader.attach_stub(__name__, __file__)
__all__ = [*_public_names, "__version__"]

_draw_with("pinchoff.figures.displays")


def __getattr__(name: str) -> _Any:
    """Load a public name, or the compiled core, on first use."""
    if name == "__version__":
        return _importlib.import_module("importlib.metadata").version("pinchoff")
    if name == "_core":
        return _load_core()
    return _attribute(name)


def _load_core() -> _Any:
    # Every module writes `from pinchoff import _core`, which asks here first: one place that can
    # say what to do when the extension is missing.
    try:
        return _importlib.import_module(f"{__name__}._core")
    except ImportError as error:
        raise ImportError(
            "pinchoff._core, the compiled part of pinchoff, must be importable; got "
            f"'{error}'; install the package (pip install pinchoff, or pip install . in a "
            "source tree) and start Python outside its src folder"
        ) from error
