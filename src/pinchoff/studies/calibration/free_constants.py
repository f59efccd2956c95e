"""Constants of the model that a calibration may change, and their bounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from pinchoff.model.parameters import FRONT, SPRINGS, Parameters
from pinchoff.studies.calibration.evaluation import CONVERSION
from pinchoff.studies.calibration.sensitivity import has_meaning
from pinchoff.studies.calibration.targets import Floats, checked_ends
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.paper_constants import CA_PER_CA_SIM

Bounds: TypeAlias = dict[str, tuple[float, float]]

FREE: Mapping[str, tuple[float, float]] = {
    "edge_stiffness": (1.0, 6.0),
    "neck_separation": (0.15, 0.42),
    "neck_thickness": (0.08, 0.3),
    "line_tension": (20.0, 2000.0),
    CONVERSION: (3e-5, 3e-4),
}
"""Constants that may be free, and their bounds unless others are given."""

_IN_DIAMETERS = (0.15, 1.5)  # bounds of neck_separation in D0; half a circle is 1.57

DEFAULT_FREE = {
    SPRINGS: ("edge_stiffness", "neck_thickness"),
    FRONT: ("neck_separation", "neck_thickness"),
}
"""Those that are free unless others are named, by the model."""


def bounds_of(free: object, model: Parameters) -> Bounds:
    """Check the names and bounds of the free constants."""
    if isinstance(free, str) or not isinstance(free, Iterable):
        raise InputError.of("free", "names of constants", free, f"write [{free!r}]")
    given = dict(free) if isinstance(free, Mapping) else dict.fromkeys(free)
    if not given:
        raise InputError.of(
            "free", "one constant or more", "none", f"choose from {', '.join(FREE)}"
        )
    bounds: Bounds = {}
    for name, ends in given.items():
        if name not in FREE:
            if name in ("vertex_count", "follow_daughters", "neck_separation_unit"):
                advice = "set it in base, and compare calibrations"
                raise InputError.of("free", "a continuous constant", repr(name), advice)
            raise unknown_name("free", "a constant that may be free", name, FREE)
        if not has_meaning((name,), model):
            advice = "choose neck_separation, neck_thickness or conversion"
            rule = f"a constant of the {model.model} model"
            raise InputError.of("free", rule, repr(name), advice)
        given_ends = _default_bounds(name, model) if ends is None else ends
        advice = "write them as (low, high)"
        bounds[name] = checked_ends(f"free[{name!r}]", given_ends, "bounds", advice)
        _require_inside(name, bounds[name], model)
    return bounds


def _default_bounds(name: str, model: Parameters) -> tuple[float, float]:
    diameters = name == "neck_separation" and model.neck_separation_unit == "diameter"
    return _IN_DIAMETERS if diameters else FREE[name]


def _require_inside(name: str, ends: tuple[float, float], model: Parameters) -> None:
    value = CA_PER_CA_SIM if name == CONVERSION else getattr(model, name)
    if not ends[0] <= value <= ends[1]:
        advice = "widen the bounds, or start from another base"
        rule = f"bounds that hold the base's {value:g}"
        raise InputError.of(f"free[{name!r}]", rule, list(ends), advice)
    if name == CONVERSION:
        return
    # Each end is checked alone. Whether it agrees with other constants shows in the search.
    others: dict[str, Any] = {"neck_thickness": 0.0}
    if name == "neck_thickness":
        others = {"neck_separation_unit": "perimeter", "neck_separation": 0.49}
    for end in ends:
        try:
            model.replace(**{**others, name: end})
        except InputError as error:
            raise error.within("free") from None


def values_of(bounds: Bounds, model: Parameters) -> dict[str, float]:
    """Return what the free constants are in a model."""
    return {
        name: CA_PER_CA_SIM if name == CONVERSION else float(getattr(model, name))
        for name in bounds
    }


def grid_of(
    names: tuple[str, str], bounds: Bounds, model: Parameters, count: int
) -> tuple[Floats, Floats]:
    """Return the values of two constants, evenly spaced in their logarithms, for a landscape."""
    ends = [bounds.get(name) or _default_bounds(name, model) for name in names]
    first, second = (np.clip(np.geomspace(*pair, count), *pair) for pair in ends)
    return first, second
