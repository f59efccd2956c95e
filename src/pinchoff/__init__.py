"""Droplets that collide with an obstacle and pinch off, simulated and measured.

>>> import pinchoff as po
>>> collision = po.simulate(po.Parameters(simulation_capillary_number=30, offset=0.02))
>>> collision.outcome
'broke'

Names load on first use, so that importing the package costs next to nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pinchoff import chamber as chamber
    from pinchoff import errors as errors
    from pinchoff import flow as flow
    from pinchoff import microscope as microscope
    from pinchoff.boundaries import Boundary as Boundary
    from pinchoff.boundaries import boundary as boundary
    from pinchoff.calibrations import Calibration as Calibration
    from pinchoff.calibrations import CollisionsTarget as CollisionsTarget
    from pinchoff.calibrations import LineTarget as LineTarget
    from pinchoff.calibrations import calibrate as calibrate
    from pinchoff.collisions_file import read_collisions as read_collisions
    from pinchoff.collisions_import import ImportedCollisions as ImportedCollisions
    from pinchoff.collisions_import import import_collisions as import_collisions
    from pinchoff.energy import term_forces as term_forces
    from pinchoff.energy import total_energy as total_energy
    from pinchoff.errors import InputError as InputError
    from pinchoff.errors import PinchoffError as PinchoffError
    from pinchoff.errors import SimulationError as SimulationError
    from pinchoff.fits import LawFit as LawFit
    from pinchoff.fits import fit_law as fit_law
    from pinchoff.law import Line as Line
    from pinchoff.law import breakup_number as breakup_number
    from pinchoff.outlines import Outlines as Outlines
    from pinchoff.parameters import Parameters as Parameters
    from pinchoff.parameters import PhysicalScale as PhysicalScale
    from pinchoff.reproduction import reproduce as reproduce
    from pinchoff.simulation import Collision as Collision
    from pinchoff.simulation import simulate as simulate
    from pinchoff.simulation import simulate_many as simulate_many
    from pinchoff.sweeps import SweepDesign as SweepDesign
    from pinchoff.sweeps import sweep as sweep
    from pinchoff.synthetic import virtual_experiment as virtual_experiment
    from pinchoff.video.batch import measure_videos as measure_videos
    from pinchoff.video.settings import VideoSettings as VideoSettings

    __version__: str

_HOME = {
    "Boundary": "boundaries",
    "Calibration": "calibrations",
    "Collision": "simulation",
    "CollisionsTarget": "calibrations",
    "ImportedCollisions": "collisions_import",
    "InputError": "errors",
    "LawFit": "fits",
    "Line": "law",
    "LineTarget": "calibrations",
    "Outlines": "outlines",
    "Parameters": "parameters",
    "PhysicalScale": "parameters",
    "PinchoffError": "errors",
    "SimulationError": "errors",
    "SweepDesign": "sweeps",
    "VideoSettings": "video.settings",
    "boundary": "boundaries",
    "breakup_number": "law",
    "calibrate": "calibrations",
    "fit_law": "fits",
    "import_collisions": "collisions_import",
    "measure_videos": "video.batch",
    "read_collisions": "collisions_file",
    "reproduce": "reproduction",
    "simulate": "simulation",
    "simulate_many": "simulation",
    "sweep": "sweeps",
    "term_forces": "energy",
    "total_energy": "energy",
    "virtual_experiment": "synthetic",
}
_MODULES = ("chamber", "errors", "flow", "microscope")

__all__ = [
    "Boundary",
    "Calibration",
    "Collision",
    "CollisionsTarget",
    "ImportedCollisions",
    "InputError",
    "LawFit",
    "Line",
    "LineTarget",
    "Outlines",
    "Parameters",
    "PhysicalScale",
    "PinchoffError",
    "SimulationError",
    "SweepDesign",
    "VideoSettings",
    "__version__",
    "boundary",
    "breakup_number",
    "calibrate",
    "chamber",
    "errors",
    "fit_law",
    "flow",
    "import_collisions",
    "measure_videos",
    "microscope",
    "read_collisions",
    "reproduce",
    "simulate",
    "simulate_many",
    "sweep",
    "term_forces",
    "total_energy",
    "virtual_experiment",
]


def __getattr__(name: str) -> Any:
    """Load a public name, or the compiled core, on first use."""
    if name == "__version__":
        value: Any = importlib.import_module("importlib.metadata").version("pinchoff")
    elif name == "_core":
        value = _load_core()
    elif name in _HOME:
        value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = importlib.import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


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
