"""The parts of a sweep: some of its points, run together into one Parquet file each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pinchoff.collisions.parquet import parquet_bytes
from pinchoff.collisions.schema import COLUMNS
from pinchoff.model.run_table import run_batch, varied_columns
from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.support.progress import Show


class Part(NamedTuple):
    """A computed part: its number, its Parquet file, and how many of its runs guards stopped."""

    number: int
    content: bytes
    failed: int


def compute_parts(
    design: SweepDesign, ranges: Mapping[int, range], threads: int, show: Show | None = None
) -> list[Part]:
    """Run some parts together; `ranges` holds the numbers of the points of each.

    `show` is called with the number of runs that are done.
    """
    points = [p for rows in ranges.values() for p in design.points(rows.start, rows.stop)]
    ids = [number for rows in ranges.values() for number in rows]
    varied = [axis.name for axis in design.axes]
    columns = run_batch(points, ids, threads=threads, varied=varied, show=show)
    schema = (*COLUMNS, *varied_columns(varied).values())
    parts, start = [], 0
    for part, rows in ranges.items():
        stop = start + len(rows)
        own = {name: values[start:stop] for name, values in columns.items()}
        failed = int((own["outcome"] == "failed").sum())
        parts.append(Part(part, parquet_bytes(own, schema), failed))
        start = stop
    return parts
