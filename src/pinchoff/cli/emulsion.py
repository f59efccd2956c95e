"""``pinchoff emulsion``: droplets through an array of pillars; after a stop it goes on."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from pinchoff.cli.cluster import Scheduler, cluster_client
from pinchoff.cli.folders import ResumableResults, remove_results
from pinchoff.cli.options import OUTPUT, Workers, argument, grouped, named_as_options, switch
from pinchoff.cli.output import bar, print_table, warn
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml, write_csv
from pinchoff.support.numerals import counted
from pinchoff.support.records import jsonable, write_json

if TYPE_CHECKING:
    from distributed import Client

    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.emulsion_sweep import SweepRun
    from pinchoff.chamber.periodic_flow import ArrayFlow
    from pinchoff.model.emulsion_result import Emulsion
    from pinchoff.studies.emulsion_sizes import SizeStudy

PAGE, RESULTS, MOVIE = "index.html", "emulsion.json", "movie.mp4"
CONTACTS, EVENTS, SIZES = "collisions.parquet", "events.parquet", "sizes.parquet"
SWEEP = "sweep.csv"
_MEASURED = (
    *("mean_diameter", "weighted_diameter", "mean_area", "dispersity"),
    *("growth", "exchange", "trend"),
)
# The checkpoint is removed first, because it refers to the others.
_PIECES = ("checkpoint.npz", "events-??????.parquet", "sizes-??????.parquet", "outlines-??????.gsd")


@grouped(out="emulsion")
def emulsion(
    config: Annotated[Path, argument("CONFIG.toml", "The array, the flow and the droplets")],
    *,
    workers: Workers = None,
    scheduler: Scheduler = None,
    movie: Annotated[bool, switch("--movie", "Make movie.mp4 too", panel=OUTPUT)] = False,
    results: ResumableResults,
) -> None:
    r"""Send droplets through an array of pillars, where they break and merge.

    CONFIG.toml holds time, and the tables \[array], \[flow], \[parameters],
    and \[inlet] or \[droplets]. With \[coalescence] droplets merge. pinchoff
    examples writes such a file.

    DIR gets

    - index.html: the page, with every figure inside
    - emulsion.json: the numbers
    - collisions.parquet: each contact with a pillar, as pinchoff fit takes it
    - explore.html: the contacts to play with, beside the live model
    - events, sizes and outlines in pieces, and a checkpoint
    - movie.mp4: the film, with --movie

    With a table \[sweep] every combination of the values it lists is run,
    each in a folder of its own, and DIR gets sweep.csv and a page of all.
    With --scheduler these runs are made on a Dask cluster, one a task.

    Where a guard ends a run, or it is too short for sizes, the page and a
    warning say so, with what could be measured.

    A run that was stopped, in any way, goes on with the same command.

    [bold]Examples[/bold]

    pinchoff emulsion examples/emulsion.toml --out emulsion
    """
    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.emulsion_sweep import TABLE, sweep_runs

    table = read_toml(config)
    varied = sweep_runs(table, config.parent) if TABLE in table else []
    designs = [one.design for one in varied] or [EmulsionDesign.from_toml(config)]
    if movie:
        _require_movie(designs)
    if scheduler is not None and not varied:
        advice = "one run goes on the threads of one machine"
        raise InputError.of("--scheduler", "left out without a table [sweep]", scheduler, advice)
    with named_as_options("scheduler", "threads"):
        cluster = cluster_client(scheduler, workers)
    with results.resumed() as folder:
        if results.overwrite:
            for place in [folder / one.folder for one in varied] or [folder]:
                remove_results(place, _PIECES)
        if varied:
            with named_as_options("scheduler"), cluster as client:
                report = _sweep(varied, folder, client, workers, movie, results.as_json)
            results.announce(report, lambda: None, [folder / PAGE, folder / SWEEP])
            return
        made = _make(designs[0], folder, workers, movie)
        for remark in made.study.remarks:
            warn(remark)
        results.announce(made.report, lambda: _print(made), made.files)


def _require_movie(designs: Sequence[EmulsionDesign]) -> None:
    from pinchoff.video.writing import require_video_extra

    require_video_extra("--movie")
    if not all(design.settings["outlines"] for design in designs):
        advice = "write outlines = true, which is the default, and run again"
        raise InputError.of("--movie", "left out where outlines are not kept", "it", advice)


class _Made(NamedTuple):
    run: Emulsion
    study: SizeStudy
    report: dict[str, Any]
    files: list[Path]


def _make(design: EmulsionDesign, folder: Path, workers: int | None, movie: bool) -> _Made:
    """Run a design, or go on with it, and write all that comes of it."""
    with bar("flow", unit="iterations") as show:
        flow = design.flow(show)
    run = design.run(flow, folder, threads=workers, progress=sys.stderr.isatty())
    study = design.study(run, flow)
    files, report = _write(design, flow, run, study, folder, workers)
    if movie:
        _write_movie(design, run, folder)
        files.append(folder / MOVIE)
    return _Made(run, study, report, files)


def _sweep(
    runs: Sequence[SweepRun],
    folder: Path,
    client: Client | None,
    workers: int | None,
    movie: bool,
    quiet: bool,
) -> dict[str, Any]:
    """Run the designs, on a cluster or each on all threads; write the table and its page."""
    import pandas as pd

    from pinchoff.chamber.emulsion_sweep import run_on_cluster, summary_row
    from pinchoff.figures.pages.emulsion_page import sweep_page

    rows = {}
    begun = runs if client is None else run_on_cluster(runs, folder, client)
    for number, one in enumerate(begun, start=1):
        made = _make(one.design, folder / one.folder, workers, movie)
        rows[one.folder] = summary_row(one, made.run, made.study)
        if not quiet:
            values = ", ".join(f"{name} = {value}" for name, value in one.values.items())
            print(f"{number} of {len(runs)}, {values}: mean diameter {made.study.mean_diameter} D0")
    table = pd.DataFrame([rows[one.folder] for one in runs])
    write_csv(folder / SWEEP, table)
    sweep_page(table, list(runs[0].values), PAGE).write(folder / PAGE)
    return {"runs": jsonable(table.to_dict("records"))}


def _write(
    design: EmulsionDesign,
    flow: ArrayFlow,
    run: Emulsion,
    study: SizeStudy,
    folder: Path,
    workers: int | None,
) -> tuple[list[Path], dict[str, Any]]:
    """Write the page, that to explore the contacts, and the tables; return the report too."""
    from pinchoff.collisions.parquet import write_collisions, write_table
    from pinchoff.explorer.page import FOLDER_PAGE, NO_PAGE, write_folder_page
    from pinchoff.figures.pages.emulsion_page import EXPLORE, emulsion_page
    from pinchoff.model.emulsion_result import EVENT_COLUMNS, SIZE_COLUMNS
    from pinchoff.studies.emulsion_contacts import contact_outcomes, contact_table

    trust = design.trust(run, flow, study.start)
    array, events = design.array, run.events
    contacts = contact_outcomes(events, array.circles, run.parameters, run.time, array.width)
    isolated = design.isolated(contacts, flow, workers)
    table = contact_table(events, contacts, run.parameters)
    write_collisions(table, folder / CONTACTS)
    write_table(events, folder / EVENTS, EVENT_COLUMNS)
    write_table(run.sizes, folder / SIZES, SIZE_COLUMNS)
    files = [folder / name for name in (PAGE, RESULTS, CONTACTS, EVENTS, SIZES)]
    links = {}
    if len(table) and write_folder_page(folder):
        links[EXPLORE] = FOLDER_PAGE
        files.append(folder / FOLDER_PAGE)
    page = emulsion_page(design, run, study, trust, contacts, isolated, links)
    if len(table) and not links:
        page.paragraph(NO_PAGE)
    page.write(folder / PAGE)
    report = _report(study, run)
    report["trust"] = vars(trust) if trust else None
    report["isolated"] = None if isolated is None else isolated.to_dict("list")
    report = jsonable(report)
    write_json(folder / RESULTS, report)
    return files, report


def _write_movie(design: EmulsionDesign, run: Emulsion, folder: Path) -> None:
    from pinchoff.figures.emulsion_film import write_emulsion_film

    largest = float(run.sizes["diameter"].max())
    with bar("movie", run.time, "t0") as show:
        write_emulsion_film(
            folder / MOVIE,
            run.outline_pieces(),
            design.array,
            largest,
            design.settings["interval"],
            design.periodic,
            show,
        )


def _report(study: SizeStudy, run: Emulsion) -> dict[str, Any]:
    report: dict[str, Any] = {name: getattr(study, name)._asdict() for name in _MEASURED}
    report["rates"] = {kind: rate._asdict() for kind, rate in study.rates.items()}
    for name in ("steady", "remarks", "correlation_time", "residence_time"):
        report[name] = getattr(study, name)
    for name in ("time", "balance", "stopped", "guard_report", "retired_share"):
        report[name] = getattr(run, name)
    return report


def _print(made: _Made) -> None:
    study, run = made.study, made.run
    rates = {kind: rate for kind, rate in study.rates.items() if rate.value > 0}
    rows = [
        ("mean diameter", str(study.mean_diameter), "D0"),
        ("weighted by area", str(study.weighted_diameter), "D0"),
        *((f"rate: {kind}", str(rate), "1/t0") for kind, rate in rates.items()),
    ]
    if run.balance["retired"]:
        gone = f"{counted(int(run.balance['retired']), 'droplet')}, {100 * run.retired_share:.2g} %"
        rows.append(("taken out by guards", gone, "of all area"))
    print_table(("result", "value", "unit"), rows, left=(0, 2))
