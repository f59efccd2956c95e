"""``pinchoff emulsion``: droplets through an array of pillars; after a stop it goes on."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pinchoff.cli.folders import going_on_with, results_folder
from pinchoff.cli.options import OUTPUT, AsJson, OutFolder, StartAnew, option, switch
from pinchoff.cli.output import announce, jsonable, print_table, write_json
from pinchoff.support.progress import progress_bar

if TYPE_CHECKING:
    from pinchoff.studies.emulsion_sizes import SizeStudy

PAGE, RESULTS, MOVIE = "index.html", "emulsion.json", "movie.mp4"
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
    r"""Send droplets through an array of pillars, where they break and merge.

    CONFIG.toml holds time, and the tables \[array], \[flow], \[parameters], and \[inlet] or
    \[droplets]; pinchoff examples writes one. Droplets merge where it has \[coalescence].

    DIR gets

    - index.html: the page, with every figure inside
    - emulsion.json: the numbers
    - events, sizes and outlines in pieces, and a checkpoint
    - movie.mp4: the film, with --movie

    A run that was stopped, in any way, goes on with the same command.

    [bold]Examples[/bold]

    pinchoff emulsion examples/emulsion.toml --out emulsion
    """
    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.emulsion_trust import measure_trust
    from pinchoff.figures.pages.emulsion_page import emulsion_page
    from pinchoff.studies.emulsion_sizes import study_sizes

    folder = results_folder(out)
    design = EmulsionDesign.from_toml(config)
    if movie:
        from pinchoff.video.writing import require_video_extra

        require_video_extra("--movie")
    if overwrite:
        for pattern in _PIECES:  # the checkpoint first: it counts on the others
            for path in folder.glob(pattern):
                path.unlink()
    shown = sys.stderr.isatty()
    with going_on_with(out):
        with progress_bar(shown, "flow", None, unit="iterations") as show:
            flow = design.flow(show)
        run = design.run(flow, folder, threads=workers, progress=shown)
    residence = None if design.inlet else design.array.length / flow.mean_velocity[0]
    study = study_sizes(run.sizes, run.events, residence_time=residence)
    trust = None
    if design.settings["outlines"]:
        spacing = 3.1416 / run.parameters.vertex_count
        sampled = flow.sampled(pad=2.0)
        trust = measure_trust(run.outline_pieces(), design.array, sampled, study.start, spacing)
    emulsion_page(design, run, study, trust).write(folder / PAGE)
    report = _report(study) | {"time": run.time, "balance": run.balance}
    report["trust"] = jsonable(vars(trust)) if trust else None
    write_json(folder / RESULTS, report)
    if movie and run.outlines is not None:
        from pinchoff.figures.movie import write_movie

        write_movie(folder / MOVIE, run.outlines)
    files = [folder / name for name in (PAGE, RESULTS, MOVIE)]
    announce(report, lambda: _print(study), files, as_json=as_json)


def _report(study: SizeStudy) -> dict[str, Any]:
    names = ("mean_diameter", "weighted_diameter", "mean_area", "dispersity")
    names += ("growth", "exchange", "trend")
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
    found: dict[str, Any] = jsonable(report)
    return found


def _print(study: SizeStudy) -> None:
    rows = [("mean diameter", str(study.mean_diameter), "D0")]
    rows.append(("weighted by area", str(study.weighted_diameter), "D0"))
    rows += [(f"rate: {kind}", str(rate), "1/t0") for kind, rate in study.rates.items()]
    print_table(("result", "value", "unit"), rows, left=(0, 2))
    for remark in study.remarks:
        print(remark)
