"""The microfluidic device: one geometry, from which masks, checks, flow and positions follow.

Names load on first use: the geometry needs shapely and gdstk, the flow scikit-fem, all of them in
``pip install 'pinchoff[chamber]'``.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from pinchoff.chamber.extra import chamber_extra

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber as Chamber
    from pinchoff.chamber.flow_check import FlowCheck as FlowCheck
    from pinchoff.chamber.flow_check import check_flow as check_flow
    from pinchoff.chamber.masks import write_dxf as write_dxf
    from pinchoff.chamber.masks import write_gds as write_gds
    from pinchoff.chamber.masks import write_oasis as write_oasis
    from pinchoff.chamber.obstacle_flow import compare_with_stokes as compare_with_stokes
    from pinchoff.chamber.obstacle_flow import flow_around as flow_around
    from pinchoff.chamber.periodic_flow import ArrayFlow as ArrayFlow
    from pinchoff.chamber.periodic_flow import array_flow as array_flow
    from pinchoff.chamber.periodic_flow import imaging_array as imaging_array
    from pinchoff.chamber.positions import in_frame as in_frame
    from pinchoff.chamber.record import read_design as read_design
    from pinchoff.chamber.rules import Violation as Violation
    from pinchoff.chamber.rules import check_rules as check_rules
    from pinchoff.chamber.solids import write_scad as write_scad
    from pinchoff.chamber.solids import write_stl as write_stl

_HOME = {
    "ArrayFlow": "periodic_flow",
    "Chamber": "design",
    "FlowCheck": "flow_check",
    "Violation": "rules",
    "array_flow": "periodic_flow",
    "check_flow": "flow_check",
    "check_rules": "rules",
    "compare_with_stokes": "obstacle_flow",
    "flow_around": "obstacle_flow",
    "imaging_array": "periodic_flow",
    "in_frame": "positions",
    "read_design": "record",
    "write_dxf": "masks",
    "write_gds": "masks",
    "write_oasis": "masks",
    "write_scad": "solids",
    "write_stl": "solids",
}

__all__ = [
    "ArrayFlow",
    "Chamber",
    "FlowCheck",
    "Violation",
    "array_flow",
    "check_flow",
    "check_rules",
    "compare_with_stokes",
    "flow_around",
    "imaging_array",
    "in_frame",
    "read_design",
    "write_dxf",
    "write_gds",
    "write_oasis",
    "write_scad",
    "write_stl",
]


def __getattr__(name: str) -> Any:
    """Load a public name on first use."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with chamber_extra():
        value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
