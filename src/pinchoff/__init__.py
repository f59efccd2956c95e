"""Droplets that collide with an obstacle and pinch off, simulated and measured.

>>> import pinchoff as po
>>> collision = po.simulate(po.Parameters(simulation_capillary_number=30, offset=0.02))
>>> collision.outcome
'broke'

Names load on first use, so that importing the package costs next to nothing; `__init__.pyi` says
which there are.
"""

import importlib
from typing import Any

import lazy_loader

_attribute, __dir__, _public_names = lazy_loader.attach_stub(__name__, __file__)
__all__ = [*_public_names, "__version__"]


def __getattr__(name: str) -> Any:
    """Load a public name, or the compiled core, on first use."""
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version("pinchoff")
    if name == "_core":
        return _load_core()
    return _attribute(name)


def _load_core() -> Any:
    # Every module writes `from pinchoff import _core`, which asks here first: one place that can
    # say what to do when the extension is missing.
    try:
        return importlib.import_module(f"{__name__}._core")
    except ImportError as error:
        raise ImportError(
            "pinchoff._core, the compiled part of pinchoff, must be importable; got "
            f"'{error}'; install the package (pip install pinchoff, or pip install . in a "
            "source tree) and start Python outside its src folder"
        ) from error
