"""What a collisions table holds, read little by little: counts, ranges and points to draw."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from pinchoff.collisions.parquet import collision_batches, open_collisions, units_of
from pinchoff.collisions.reasons import NO_CONTACT, general_reason
from pinchoff.studies.sweep.dataset import read_manifest

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_DRAWN = 100_000
"""Collisions that a picture shows; of more, a random sample."""

_DRAWN = ("capillary_number", "normalized_area", "normalized_thickness", "symmetry", "broke")


class ColumnRange(NamedTuple):
    """Smallest and largest value of a column, and in how many rows it was measured."""

    low: float
    high: float
    measured: int


class Points(NamedTuple):
    """Accepted collisions in the plane of the break-up law, or a sample of them."""

    forcing: NDArray[np.float64]  # Ca Ã z̃
    symmetry: NDArray[np.float64]  # S at first contact
    broke: NDArray[np.bool_]
    population: int  # how many there are


@dataclass
class Summary:
    """What a collisions table holds.

    Attributes
    ----------
    rows, expected : int
        Rows that are there, and that a finished sweep has.
    outcomes, reasons : Counter
        Rows by outcome, "no contact" among them; other rejected ones by reason, without the numbers
        of the single case. Every row is counted once.
    ranges : dict of str to ColumnRange
        Every numeric column with at least one value.
    units : dict of str to str
    points : Points
    """

    rows: int
    expected: int
    outcomes: Counter[str]
    reasons: Counter[str]
    ranges: dict[str, ColumnRange]
    units: Mapping[str, str]
    points: Points

    def to_dict(self) -> dict[str, Any]:
        """Return the counts and ranges, fit for JSON."""
        return {
            "rows": self.rows,
            "expected": self.expected,
            "outcomes": dict(self.outcomes),
            "rejected": dict(self.reasons),
            "ranges": {name: found._asdict() for name, found in self.ranges.items()},
            "units": {name: self.units[name] for name in self.ranges if name in self.units},
        }


def summarize(path: str | os.PathLike[str]) -> Summary:
    """Read a collisions table through, holding a piece of it at a time.

    Parameters
    ----------
    path : path
        The folder of a sweep, finished or not, or a Parquet file.

    Raises
    ------
    InputError
        There is no collisions table.
    """
    dataset = open_collisions(path)
    rows = sum(pq.read_metadata(path).num_rows for path in dataset.files)
    manifest = read_manifest(Path(path)) or {"count": rows}
    outcomes: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    ranges: dict[str, ColumnRange] = {}
    sample = _Sample(rows)
    for batch in collision_batches(dataset):
        outcomes.update(_counted(_outcomes(batch)))
        for reason, count in _counted(batch["reject_reason"]).items():
            if reason and reason != NO_CONTACT:
                reasons[general_reason(reason)] += count
        _widen(ranges, batch)
        sample.add(batch)
    return Summary(
        rows,
        manifest["count"],
        outcomes,
        reasons,
        ranges,
        units_of(dataset.schema),
        sample.points(),
    )


def _outcomes(batch: pa.RecordBatch) -> pa.Array:
    """Return the outcome of each row that counts: broke or not where nothing was simulated.

    A droplet that never met the obstacle did not "pass" it: its outcome is "no contact". Other
    rejected rows have none; they are counted by their reasons.
    """
    if "outcome" in batch.schema.names:
        known = batch["outcome"].cast(pa.string())
    else:
        known = pc.coalesce(pc.if_else(batch["broke"], "broke", "did not break"), "unknown")
    missed = pc.equal(batch["reject_reason"].cast(pa.string()), NO_CONTACT)
    counted = pc.or_(pc.fill_null(batch["accepted"], False), pc.fill_null(missed, False))
    return pc.if_else(pc.fill_null(missed, False), "no contact", known).filter(counted)


def _counted(values: pa.Array) -> dict[str, int]:
    return {str(pair["values"]): pair["counts"] for pair in pc.value_counts(values).to_pylist()}


def _widen(ranges: dict[str, ColumnRange], batch: pa.RecordBatch) -> None:
    for column in batch.schema:
        if not (pa.types.is_floating(column.type) or pa.types.is_integer(column.type)):
            continue
        values = batch[column.name].to_numpy(zero_copy_only=False)
        values = values[np.isfinite(values)]
        if values.size:
            known = ranges.get(column.name, ColumnRange(math.inf, -math.inf, 0))
            ranges[column.name] = ColumnRange(
                min(known.low, float(values.min())),
                max(known.high, float(values.max())),
                known.measured + values.size,
            )


@dataclass
class _Sample:
    """Draws about `MOST_DRAWN` of the rows, the same ones every time."""

    rows: int
    population: int = 0
    pieces: list[dict[str, NDArray[Any]]] = field(default_factory=list)
    generator: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def add(self, batch: pa.RecordBatch) -> None:
        """Draw from some further rows, among those that have a place in the plane."""
        accepted = batch["accepted"].to_numpy(zero_copy_only=False)
        measured = np.isfinite(batch["symmetry"].to_numpy(zero_copy_only=False))
        fit = accepted.astype(bool) & measured & batch["broke"].is_valid().to_numpy(False)
        self.population += int(fit.sum())
        if self.rows > MOST_DRAWN:
            fit &= self.generator.random(len(fit)) < MOST_DRAWN / self.rows
        drawn = batch.select(list(_DRAWN)).filter(pa.array(fit))
        self.pieces.append({n: drawn[n].to_numpy(zero_copy_only=False) for n in _DRAWN})

    def points(self) -> Points:
        joined = {n: np.concatenate([piece[n] for piece in self.pieces]) for n in _DRAWN}
        ca, area, thickness, symmetry, broke = (joined[n] for n in _DRAWN)
        return Points(ca * area * thickness, symmetry, broke.astype(bool), self.population)
