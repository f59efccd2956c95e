"""Run a sweep: on the threads of this process, or on a Dask cluster, part by part."""

from __future__ import annotations

import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pinchoff.model.guards import warn_of_failures
from pinchoff.model.simulation import thread_count
from pinchoff.studies.sweep.cluster import on_cluster
from pinchoff.studies.sweep.dataset import SweepDataset, opened, read_manifest, require_same
from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.studies.sweep.parts import Part, compute_parts
from pinchoff.support.errors import InputError
from pinchoff.support.progress import Show, progress_bar, shifted, wanted_progress
from pinchoff.support.quantities import warn_of_thickness

if TYPE_CHECKING:
    from distributed import Client


_RUNS_A_THREAD = 32  # runs for each thread in a batch: enough that few threads stand idle


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
        Whether to show a bar on stderr; by default in terminals and notebooks.

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
    with_bar = wanted_progress(progress)
    _check(design, path, with_bar)
    failed = 0
    with opened(path, design) as dataset:
        dataset.settle()  # a line that a kill cut short would spoil the next one
        missing = dataset.missing_parts()
        rows = sum(len(dataset.rows_of(part)) for part in missing)
        start = dataset.count - rows
        with progress_bar(with_bar, "collisions", dataset.count, start=start, unit="runs") as show:
            if client is None:
                parts = _on_threads(design, dataset, missing, workers, show)
            else:
                parts = on_cluster(design, dataset, missing, client, show)
            with closing(parts):
                for part in parts:
                    dataset.write(part.number, part.content)
                    failed += part.failed
        dataset.settle()
    warn_of_failures(failed, rows)
    return SweepResult(path, dataset.count, rows, failed)


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
        yield from compute_parts(design, ranges, threads, shifted(show, done))
        done += sum(map(len, ranges.values()))


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
    """Refuse a wrong design before anything is written; one that was begun has been checked."""
    scale = design.point(0).scale
    if scale is not None:
        warn_of_thickness(scale)
    manifest = read_manifest(path)
    if manifest is not None:
        require_same(manifest, design, path)
        return
    with progress_bar(progress, "checking", len(design), unit="points") as show:
        design.check(show)
