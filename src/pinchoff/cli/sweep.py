"""``pinchoff sweep``: very many collisions into a dataset that survives any interruption."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pinchoff.cli.folders import results_folder
from pinchoff.cli.output import printed_warnings
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

    from pinchoff.studies.sweep import SweepResult

_FLAGS = {"out": "--out", "threads": "--threads", "scheduler": "--scheduler"}


def sweep(
    config: Annotated[
        Path, typer.Argument(metavar="CONFIG.toml", help="What is fixed and what is varied.")
    ],
    out: Annotated[str, typer.Option(metavar="DIR", help="Folder for the dataset.")],
    threads: Annotated[
        int | None, typer.Option(metavar="NUMBER", help="Threads; all cores by default.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler to run on, as tcp://10.0.0.1:8786."),
    ] = None,
) -> None:
    r"""Simulate every point of a design, into a table.

    CONFIG.toml holds fixed parameters as for [bold]pinchoff run[/bold],
    and under \[vary] a list or a range for every varied one:

    - offset = \[0.0, 0.1, 0.2]
    - offset = { min = 0.0, max = 0.4, count = 9 }
    - line_tension = { min = 5, max = 80, count = 9, scale = "log" }

    All combinations are run. With design = "sobol", "latin-hypercube"
    or "random", samples points are drawn instead, the same ones for
    the same seed; ranges then have no count.

    DIR gets the collisions table as Parquet parts and _sweep.json.
    A sweep that was stopped, in any way, goes on with the same command.

    [bold]Examples[/bold]

    pinchoff sweep phase-diagram.toml --out phase-diagram

    pinchoff summary phase-diagram
    """
    from pinchoff.studies.sweep import SweepDesign
    from pinchoff.studies.sweep import sweep as run_sweep

    with _named_as_options(), printed_warnings():
        folder = results_folder(out)
        design = SweepDesign.from_toml(config)
        if threads is not None and scheduler is not None:
            advice = "a cluster's workers have their own"
            raise InputError.of("threads", "left out beside --scheduler", threads, advice)
        try:
            with _client(scheduler) as client:
                result = run_sweep(design, folder, threads=threads, client=client)
        except KeyboardInterrupt:
            print(f"stopped; the same command goes on with {out}", file=sys.stderr)
            raise
    _announce(result)


@contextmanager
def _named_as_options() -> Iterator[None]:
    """Give arguments of the library the names that they have on the command line."""
    try:
        yield
    except InputError as error:
        name = _FLAGS.get(error.argument, error.argument)
        raise InputError.of(name, error.rule, error.got, error.advice) from error


def _client(scheduler: str | None) -> AbstractContextManager[Client | None]:
    if scheduler is None:
        return nullcontext()
    from pinchoff.studies.sweep.cluster import connected

    return connected(scheduler)


def _announce(result: SweepResult) -> None:
    there = result.rows - result.computed
    before = f", {there} of them were there" if there else ""
    print(f"wrote {result.path}: {result.rows} collisions{before}")
    print(f"see pinchoff summary {result.path}")
