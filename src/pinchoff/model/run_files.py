"""The files of one run, read back: its report and its outlines."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, NamedTuple

from pinchoff.collisions.schema import COLUMNS
from pinchoff.model.outlines import Outlines
from pinchoff.model.parameters import Parameters
from pinchoff.support.errors import InputError
from pinchoff.support.records import Shape, read_record

REPORT = "collision.json"
OUTLINES = "outlines.gsd"
"""Names of the files."""

_EVENTS = ("contacts", "breakups")


class _Results(Shape):
    contacts: list[dict[str, Any]]
    breakups: list[dict[str, Any]]


class _Report(Shape):
    parameters: dict[str, Any]
    row: dict[str, str | float | bool | None]
    results: _Results


class StoredRun(NamedTuple):
    """What the files of one run hold; the row is that of the collisions table."""

    parameters: Parameters
    row: dict[str, Any]
    contacts: list[dict[str, Any]]
    breakups: list[dict[str, Any]]
    outlines: Outlines | None


def read_run(path: str | os.PathLike[str]) -> StoredRun:
    """Read a run from its report, or from the folder in which that lies.

    If ``outlines.gsd`` lies beside the ``collision.json``, that is read too.

    Raises
    ------
    InputError
        There is no such file, or it holds no collision.
    """
    source = Path(path) / REPORT if Path(path).is_dir() else Path(path)
    rule, advice = "a report of one collision", "give the collision.json of `pinchoff run`"
    report = read_record(source, _Report, rule, advice)
    try:
        parameters = Parameters(**report["parameters"])
        row = {column.name: _measured(report["row"][column.name]) for column in COLUMNS}
    except (InputError, KeyError) as error:
        raise InputError.of(str(source), rule, str(error), advice) from None
    contacts, breakups = (_measured(report["results"][name]) for name in _EVENTS)
    beside = source.with_name(OUTLINES)
    outlines = Outlines.load(beside) if beside.is_file() else None
    return StoredRun(parameters, row, contacts, breakups, outlines)


def _measured(value: Any) -> Any:
    """Turn None, which stands for what was not measured, into NaN."""
    if isinstance(value, dict):
        return {key: _measured(content) for key, content in value.items()}
    if isinstance(value, list):
        return [_measured(content) for content in value]
    return math.nan if value is None else value
