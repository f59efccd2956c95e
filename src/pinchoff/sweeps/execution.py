"""Run a sweep: on the threads of this process, or on a Dask cluster, part by part."""

from __future__ import annotations

import itertools
import os
import sys
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pinchoff import _core
from pinchoff.collisions import PARAMETER_COLUMNS
from pinchoff.collisions_file import parquet_bytes
from pinchoff.errors import InputError
from pinchoff.outcomes import run_columns
from pinchoff.physical import warn_of_thickness
from pinchoff.simulation import thread_count
from pinchoff.sweeps.dataset import SweepDataset, opened, read_manifest, require_same
from pinchoff.sweeps.design import SweepDesign

if TYPE_CHECKING:
    from distributed import Client
    from numpy.typing import NDArray

    from pinchoff.parameters import Parameters

Show = Callable[[int], object]

_RUNS_A_THREAD = 32  # that one batch gives each thread, so that few wait for the slowest run


class SweepResult(NamedTuple):
    """What a sweep did.

    Attributes
    ----------
    path : Path
        The folder with the table; `pinchoff.read_collisions` reads it.
    rows : int
        How many it has.
    computed : int
        Those that this call computed; the others were there.
    failed : int
        Those of them that a guard stopped: rows with ``accepted`` False.
    """

    path: Path
    rows: int
    computed: int
    failed: int


class Part(NamedTuple):
    """A computed part: its number, its Parquet file, and how many of its runs guards stopped."""

    number: int
    content: bytes
    failed: int


def sweep(
    config: SweepDesign | Mapping[str, Any] | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    threads: int | None = None,
    client: Client | None = None,
    progress: bool | None = None,
) -> SweepResult:
    """Run the collisions of a design and write them as a Parquet dataset.

    Stopped at any moment, a sweep loses the parts that were being computed and nothing else; the
    same call goes on with it. The rows do not depend on where and in what order they are computed.

    Parameters
    ----------
    config : SweepDesign, mapping or path
        The design, or what `SweepDesign.from_config` or `SweepDesign.from_toml` reads.
    out : path
        The folder: new, or that of the same sweep.
    threads : int, optional
        How many threads; by default as many as there are cores for this process.
    client : distributed.Client, optional
        Runs the parts on its cluster instead; the workers need the same version of this package.
    progress : bool, optional
        Whether to show a bar on stderr; by default when that is a terminal.

    Returns
    -------
    SweepResult
        Where the table is, and how many rows there are.

    Raises
    ------
    InputError
        The design or an argument is wrong, or `out` holds something else: another sweep, this one
        with a changed configuration or by another version of the package.
    PinchoffError
        A part could not be written, or the cluster was lost. What was written stays.
    KeyboardInterrupt
        Ctrl-C. What was written stays.

    Warns
    -----
    RuntimeWarning
        Guards stopped some of the runs; says how many.

    Examples
    --------
    >>> done = sweep(
    ...     {"vary": {"offset": {"min": 0, "max": 0.4, "count": 100}}}, out="offsets"
    ... )  # doctest: +SKIP
    """
    design = _design(config)
    path = Path(out)
    workers = _workers(threads, client)
    shown = sys.stderr.isatty() if progress is None else progress
    _check(design, path, shown)
    failed = 0
    with opened(path, design) as dataset:
        missing = dataset.missing_parts()
        rows = sum(len(dataset.rows_of(part)) for part in missing)
        start = dataset.count - rows
        with _bar(shown, "collisions", dataset.count, start) as show:
            if client is None:
                parts = _on_threads(design, dataset, missing, workers, show)
            else:
                from pinchoff.sweeps.cluster import on_cluster

                parts = on_cluster(design, dataset, missing, client, show)
            with closing(parts):
                for part in parts:
                    dataset.write(part.number, part.content)
                    failed += part.failed
    _warn_of_failures(failed, rows)
    return SweepResult(path, dataset.count, rows, failed)


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
        parts.append(Part(part, parquet_bytes(columns, more), failed))
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


def _on_threads(
    design: SweepDesign,
    dataset: SweepDataset,
    missing: Sequence[int],
    threads: int,
    show: Show | None,
) -> Generator[Part, None, None]:
    """Compute parts in this process, several at once where they are small."""
    together = max(1, -(-_RUNS_A_THREAD * threads // dataset.part_size))
    done = 0
    for first in range(0, len(missing), together):
        ranges = {part: dataset.rows_of(part) for part in missing[first : first + together]}
        yield from compute_parts(design, ranges, threads, _shifted(show, done))
        done += sum(map(len, ranges.values()))


def _shifted(show: Show | None, done: int) -> Show | None:
    return None if show is None else lambda more: show(done + more)


def _design(config: object) -> SweepDesign:
    if isinstance(config, SweepDesign):
        return config
    if isinstance(config, Mapping):
        return SweepDesign.from_config(config)
    if isinstance(config, (str, os.PathLike)):
        return SweepDesign.from_toml(config)
    advice = "give the path of a TOML file, a dict or a SweepDesign"
    raise InputError.of("config", "a design", config, advice)


def _workers(threads: int | None, client: object) -> int:
    if client is None:
        return thread_count(threads)
    if threads is not None:
        raise InputError.of("threads", "left out on a cluster", threads, "its workers have theirs")
    if not hasattr(client, "submit"):
        raise InputError.of("client", "a Dask client", client, "build it with distributed.Client")
    return 1


def _check(design: SweepDesign, path: Path, progress: bool) -> None:
    """Refuse what is wrong before anything is written; what was begun has been checked."""
    scale = design.point(0).scale
    if scale is not None:
        warn_of_thickness(scale)
    manifest = read_manifest(path)
    if manifest is not None:
        require_same(manifest, design, path)
        return
    with _bar(progress, "checking", len(design), 0) as show:
        design.check(show)


def _warn_of_failures(failed: int, total: int) -> None:
    if failed:
        warnings.warn(
            f"guards stopped {failed} of {total} runs: their rows have accepted False and a "
            "reject_reason",
            RuntimeWarning,
            stacklevel=3,
        )


@contextmanager
def _bar(wanted: bool, label: str, total: int, start: int) -> Iterator[Show | None]:
    """Show a bar with the rate and the time left on stderr; give the function that moves it."""
    if not wanted:
        yield None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text("" if speed is None else f"{speed:.3g}/s")

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), Rate())
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task(label, total=total, completed=start)
        yield lambda done: bar.update(task, completed=start + done)
        bar.update(task, completed=total)
