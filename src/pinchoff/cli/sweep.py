"""``pinchoff sweep``: very many collisions, written to a dataset; after a stop it goes on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pinchoff.cli.cluster import Scheduler, cluster_client
from pinchoff.cli.folders import ResumableResults
from pinchoff.cli.options import Workers, argument, grouped, named_as_options
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    from pinchoff.studies.sweep import SweepResult


@grouped(out="sweep")
def sweep(
    config: Annotated[Path, argument("CONFIG.toml", "What is fixed and what is varied")],
    *,
    workers: Workers = None,
    scheduler: Scheduler = None,
    results: ResumableResults,
) -> None:
    r"""Simulate every point of a design, into a table.

    CONFIG.toml holds fixed parameters as for [bold]pinchoff run[/bold], and
    under \[vary] a list or a range for every varied one:

    - offset = \[0.0, 0.1, 0.2]
    - offset = { min = 0.0, max = 0.4, count = 9 }
    - line_tension = { min = 5, max = 80, count = 9, scale = "log" }

    All combinations are run. With design = "sobol", "latin-hypercube" or
    "random", samples points are drawn instead, the same ones for the same
    seed; ranges then have no count.

    DIR gets the collisions table as Parquet parts and _sweep.json. If a
    sweep is stopped, the same command goes on with it.

    [bold]Examples[/bold]

    pinchoff sweep phase-diagram.toml --out phase-diagram

    pinchoff summary phase-diagram
    """
    from pinchoff.studies.sweep import SweepDesign
    from pinchoff.studies.sweep import sweep as run_sweep
    from pinchoff.studies.sweep.dataset import remove_sweep

    with named_as_options("out", "scheduler", "threads"):
        design = SweepDesign.from_toml(config)
        cluster = cluster_client(scheduler, workers)
        with results.resumed() as folder:
            if results.overwrite:
                remove_sweep(folder)
            with cluster as client:
                result = run_sweep(design, folder, threads=workers, client=client)
    report = {**result._asdict(), "path": str(result.path)}
    results.announce(report, lambda: _print(result), ())


def _print(result: SweepResult) -> None:
    earlier = result.rows - result.computed
    before = f", {earlier} of them from before" if earlier else ""
    print(f"wrote {result.path}: {counted(result.rows, 'collision')}{before}")
    print(f"see pinchoff summary {result.path}")
