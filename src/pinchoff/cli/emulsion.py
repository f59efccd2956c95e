"""``pinchoff emulsion``: droplets through an array of pillars; after a stop it goes on."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pinchoff.cli.folders import going_on_with, results_folder, results_in
from pinchoff.cli.options import OUTPUT, AsJson, OutFolder, StartAnew, option, switch
from pinchoff.cli.output import announce, jsonable, print_table, write_json
from pinchoff.support.errors import InputError
from pinchoff.support.progress import progress_bar

if TYPE_CHECKING:
    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.periodic_flow import ArrayFlow
    from pinchoff.model.emulsion import Emulsion
    from pinchoff.studies.emulsion_sizes import SizeStudy

PAGE, RESULTS, MOVIE = "index.html", "emulsion.json", "movie.mp4"
CONTACTS = "collisions.parquet"
_PIECES = ("checkpoint.npz", "events-??????.parquet", "sizes-??????.parquet", "outlines-??????.gsd")


def emulsion(
    config: Annotated[
        Path, typer.Argument(metavar="CONFIG.toml", help="The array, the flow and the droplets.")
    ],
    out: OutFolder = "emulsion",
    workers: Annotated[
        int | None,
        option("INTEGER", "Threads", "--workers", "--threads", default="one a core"),
    ] = None,
    movie: Annotated[bool, switch("--movie", "Make movie.mp4 too", panel=OUTPUT)] = False,
    as_json: AsJson = False,
    overwrite: StartAnew = False,
) -> None:
    r"""Send droplets through an array of pillars, where they break.

    CONFIG.toml holds time, and the tables \[array], \[flow], \[parameters],
    and \[inlet] or \[droplets]; pinchoff examples writes one. Droplets do not
    merge.

    DIR gets

    - index.html: the page, with every figure inside
    - emulsion.json: the numbers
    - collisions.parquet: each contact with a pillar, as pinchoff fit takes it
    - explore.html: the contacts to play with, beside the live model
    - events, sizes and outlines in pieces, and a checkpoint
    - movie.mp4: the film, with --movie

    A run that was stopped, in any way, goes on with the same command.

    [bold]Examples[/bold]

    pinchoff emulsion examples/emulsion.toml --out emulsion
    """
    from pinchoff.chamber.emulsion_design import EmulsionDesign

    folder = results_folder(out)
    design = EmulsionDesign.from_toml(config)
    if movie:
        from pinchoff.video.writing import require_video_extra

        require_video_extra("--movie")
        if not design.settings["outlines"]:
            advice = "write outlines = true, which is the default, and run again"
            raise InputError.of("--movie", "left out where outlines are not kept", "it", advice)
    with results_in(folder):
        if overwrite:
            for pattern in _PIECES:  # the checkpoint first: it counts on the others
                for path in folder.glob(pattern):
                    path.unlink()
        shown = sys.stderr.isatty()
        with going_on_with(out):
            with progress_bar(shown, "flow", None, unit="iterations") as show:
                flow = design.flow(show)
            run = design.run(flow, folder, threads=workers, progress=shown)
        files = _write(design, flow, run, folder, workers)
        if movie:
            _write_movie(design, run, folder, shown)
            files.append(folder / MOVIE)
        study = design.study(run, flow)
        announce(_report(study, run), lambda: _print(study), files, as_json=as_json)


def _write(
    design: EmulsionDesign, flow: ArrayFlow, run: Emulsion, folder: Path, workers: int | None
) -> list[Path]:
    """Write the page, that to explore the contacts, and the tables."""
    from pinchoff.chamber.emulsion_trust import measure_trust
    from pinchoff.collisions.parquet import write_collisions
    from pinchoff.explorer.page import FOLDER_PAGE, NO_PAGE, write_folder_page
    from pinchoff.figures.pages.emulsion_page import EXPLORE, emulsion_page
    from pinchoff.studies.contact_table import contact_table
    from pinchoff.studies.emulsion_contacts import contact_outcomes

    study = design.study(run, flow)
    trust = None
    if design.settings["outlines"]:
        spacing = math.pi / run.parameters.vertex_count
        sampled = flow.sampled(pad=2.0)
        trust = measure_trust(run.outline_pieces(), design.array, sampled, study.start, spacing)
    array, events = design.array, run.events
    contacts = contact_outcomes(events, array.circles, run.parameters, run.time, array.width)
    isolated = design.isolated(contacts, flow, workers)
    table = contact_table(events, contacts, run.parameters)
    write_collisions(table, folder / CONTACTS)
    files = [folder / name for name in (PAGE, RESULTS, CONTACTS)]
    links = {}
    if len(table) and write_folder_page(folder):
        links[EXPLORE] = FOLDER_PAGE
        files.append(folder / FOLDER_PAGE)
    page = emulsion_page(design, run, study, trust, contacts, isolated, links)
    if len(table) and not links:
        page.paragraph(NO_PAGE)
    page.write(folder / PAGE)
    report = _report(study, run)
    report["trust"] = jsonable(vars(trust)) if trust else None
    report["isolated"] = None if isolated is None else jsonable(isolated.to_dict("list"))
    write_json(folder / RESULTS, report)
    return files


def _write_movie(design: EmulsionDesign, run: Emulsion, folder: Path, shown: bool) -> None:
    from pinchoff.figures.emulsion_film import write_emulsion_film

    largest = float(run.sizes["diameter"].max())
    with progress_bar(shown, "movie", run.time, unit="t0") as show:
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
    names = ("mean_diameter", "weighted_diameter", "mean_area", "dispersity", "growth", "trend")
    numbers = {name: dict(getattr(study, name)._asdict()) for name in names}
    rates = {kind: rate._asdict() for kind, rate in study.rates.items()}
    report: dict[str, Any] = {
        **numbers,
        "rates": rates,
        "steady": study.steady,
        "remarks": study.remarks,
    }
    report["correlation_time"] = study.correlation_time
    report["residence_time"] = study.residence_time
    report |= {"time": run.time, "balance": run.balance}
    found: dict[str, Any] = jsonable(report)
    return found


def _print(study: SizeStudy) -> None:
    rows = [("mean diameter", str(study.mean_diameter), "D0")]
    rows.append(("weighted by area", str(study.weighted_diameter), "D0"))
    rows += [
        (f"rate: {kind}", str(rate), "1/t0") for kind, rate in study.rates.items() if rate.value > 0
    ]
    print_table(("result", "value", "unit"), rows, left=(0, 2))
    for remark in study.remarks:
        print(remark)
