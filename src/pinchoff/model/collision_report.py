"""A collision as data: its parameters, what follows from them, and its results, with units."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff import _core
from pinchoff.collisions.schema import OUTCOMES, units
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.results import Collision

REPORT = "collision.json"
OUTLINES = "outlines.gsd"
"""Names of the files of one run."""

_PHYSICAL_RESULTS = ("contact_time_s", "area_um2", "speed_mm_s", "neck_um")


def collision_report(collision: Collision, preset: str) -> dict[str, Any]:
    """Return what goes into collision.json.

    Parameters
    ----------
    collision : Collision
    preset : str
        Name of the preset from which its parameters come.

    Examples
    --------
    >>> import pinchoff as po
    >>> report = collision_report(po.simulate(po.Parameters()), "default")
    >>> report["results"]["outcome"], report["derived"]["normalized_thickness"]
    ('broke', 1.0)
    """
    from pinchoff import __version__

    parameters, row = collision.parameters, collision.to_row()
    results = collision.to_dict()
    given = results.pop("parameters")
    results["vertex_updates"] = row["vertex_updates"]
    if parameters.scale is not None:
        results.update({name: _finite(row[name]) for name in _PHYSICAL_RESULTS})
    return {
        "pinchoff_version": __version__,
        "preset": preset,
        "parameters": given,
        "derived": {
            "capillary_number": parameters.capillary_number,
            "normalized_area": parameters.normalized_area,
            "normalized_thickness": parameters.normalized_thickness,
            "breakup_number": _finite(row["breakup_number"]),
            "effective_time_step": parameters.effective_time_step,
        },
        "results": results,
        "units": {
            **{name: unit for name, unit in units().items() if unit and name in results},
            "daughter_areas": "D0²",
            "contacts": "D0, t0, v_f∞",
            "breakups": "D0, t0, v_f∞",
        },
    }


def read_collision(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return what makes a `Collision`, from a report or the folder in which it lies.

    Parameters
    ----------
    path : path
        What `collision_report` gave, as JSON. If ``outlines.gsd`` lies beside it, that is read.

    Raises
    ------
    InputError
        There is no such file, or it holds no collision.
    """
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.parameters import Parameters
    from pinchoff.model.results import collision_fields

    source = Path(path) / REPORT if Path(path).is_dir() else Path(path)
    try:
        report = json.loads(source.read_text(encoding="utf-8"))
        parameters = Parameters(**report["parameters"])
        found = _measured(report["results"])
        found["small_daughter_area"], found["large_daughter_area"] = found["daughter_areas"]
        found["outcome"] = OUTCOMES.index(found["outcome"])
        numbers = [float(found.get(name, 0.0)) for name in _core.RESULT_FIELDS]
        events = tuple(found["contacts"]), tuple(found["breakups"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        rule, advice = "a report of one collision", "give the collision.json of `pinchoff run`"
        got = error.strerror or error if isinstance(error, OSError) else repr(error)
        raise InputError.of(str(source), rule, got, advice) from None
    beside = source.with_name(OUTLINES)
    outlines = Outlines.load(beside) if beside.is_file() else None
    return collision_fields(parameters, np.array(numbers), *events, outlines, {})


def _measured(value: Any) -> Any:
    """Turn None, which stands for what was not measured, into NaN."""
    if isinstance(value, dict):
        return {key: _measured(content) for key, content in value.items()}
    if isinstance(value, list):
        return [_measured(content) for content in value]
    return math.nan if value is None else value


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
