"""The files of one run, read back: its report and its outlines."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.collisions.schema import OUTCOMES
from pinchoff.model.outlines import Outlines
from pinchoff.model.parameters import Parameters
from pinchoff.support.errors import InputError

REPORT = "collision.json"
OUTLINES = "outlines.gsd"
"""Names of the files."""


class StoredRun(NamedTuple):
    """What the files of one run hold; the results are the core's numbers, in its order."""

    parameters: Parameters
    results: NDArray[np.float64]
    contacts: tuple[dict[str, Any], ...]
    breakups: tuple[dict[str, Any], ...]
    outlines: Outlines | None


def read_run(path: str | os.PathLike[str]) -> StoredRun:
    """Read a run from its report, or from the folder in which that lies.

    Parameters
    ----------
    path : path
        The ``collision.json`` of a run. If ``outlines.gsd`` lies beside it, that is read.

    Raises
    ------
    InputError
        There is no such file, or it holds no collision.
    """
    source = Path(path) / REPORT if Path(path).is_dir() else Path(path)
    try:
        report = json.loads(source.read_text(encoding="utf-8"))
        parameters = Parameters(**report["parameters"])
        found = _measured(report["results"])
        found["small_daughter_area"], found["large_daughter_area"] = found["daughter_areas"]
        found["outcome"] = OUTCOMES.index(found["outcome"])
        numbers = [float(found.get(name, 0.0)) for name in _core.RESULT_FIELDS]
        contacts, breakups = tuple(found["contacts"]), tuple(found["breakups"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        rule, advice = "a report of one collision", "give the collision.json of `pinchoff run`"
        got = error.strerror or error if isinstance(error, OSError) else repr(error)
        raise InputError.of(str(source), rule, got, advice) from None
    beside = source.with_name(OUTLINES)
    outlines = Outlines.load(beside) if beside.is_file() else None
    return StoredRun(parameters, np.array(numbers), contacts, breakups, outlines)


def _measured(value: Any) -> Any:
    """Turn None, which stands for what was not measured, into NaN."""
    if isinstance(value, dict):
        return {key: _measured(content) for key, content in value.items()}
    if isinstance(value, list):
        return [_measured(content) for content in value]
    return math.nan if value is None else value
