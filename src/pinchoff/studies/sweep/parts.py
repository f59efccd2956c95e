"""The parts of a sweep: some of its points, run together into one Parquet file each."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pinchoff import _core
from pinchoff.collisions.parquet import parquet_bytes
from pinchoff.collisions.schema import COLUMNS, PARAMETER_COLUMNS
from pinchoff.model.outcomes import run_columns
from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.support.progress import Show

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.model.parameters import Parameters


class Part(NamedTuple):
    """A computed part: its number, its Parquet file, and how many of its runs guards stopped."""

    number: int
    content: bytes
    failed: int


def compute_parts(
    design: SweepDesign, ranges: Mapping[int, range], threads: int, show: Show | None = None
) -> list[Part]:
    """Run some parts, together.

    Parameters
    ----------
    design : SweepDesign
    ranges : mapping of int to range
        The numbers of the points of each part.
    threads : int
    show : callable, optional
        Called with the number of runs that are done.
    """
    chunks = {part: list(design.points(rows.start, rows.stop)) for part, rows in ranges.items()}
    models = np.array([point.model_row() for point in itertools.chain(*chunks.values())])
    results = _core.run_many(models, None, threads, show)
    ends = np.cumsum([len(chunk) for chunk in chunks.values()])[:-1]
    pieces = zip(np.split(models, ends), np.split(results, ends), strict=True)
    more = [PARAMETER_COLUMNS[axis.name] for axis in design.axes if axis.name in PARAMETER_COLUMNS]
    parts = []
    for (part, chunk), (model, result) in zip(chunks.items(), pieces, strict=True):
        columns = run_columns(chunk, result, first_id=ranges[part].start)
        columns |= _parameter_columns(design, chunk, model)
        failed = int((columns["outcome"] == "failed").sum())
        parts.append(Part(part, parquet_bytes(columns, (*COLUMNS, *more)), failed))
    return parts


def _parameter_columns(
    design: SweepDesign, points: Sequence[Parameters], models: NDArray[np.float64]
) -> dict[str, NDArray[Any]]:
    """Return the varied parameters that the table does not show anyway."""
    columns = {}
    for axis in design.axes:
        if axis.name == "time_step":  # "auto" stands for a number
            columns[axis.name] = models[:, _core.MODEL_FIELDS.index("time_step")]
        elif axis.name in PARAMETER_COLUMNS:
            values = [getattr(point, axis.name) for point in points]
            columns[PARAMETER_COLUMNS[axis.name].name] = np.array(values)
    return columns
