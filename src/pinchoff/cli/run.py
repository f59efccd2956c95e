"""``pinchoff run``: one collision, its results, its outlines and its pictures."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.folders import Results, remove_results
from pinchoff.cli.laboratory import LaboratoryOptions, quantity
from pinchoff.cli.model_options import ModelFileOptions, changed, set_option
from pinchoff.cli.options import MODEL, OUTPUT, grouped, option, switch
from pinchoff.cli.output import bar, print_collision
from pinchoff.model.parameters import Parameters
from pinchoff.model.run_files import OUTLINES
from pinchoff.model.run_files import REPORT as RESULTS
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.quantities import SCALE_QUANTITIES
from pinchoff.support.records import write_json

if TYPE_CHECKING:
    from pinchoff.model.results import Collision

FORMATS = ("png", "pdf", "svg")
SNAPSHOTS = tuple(f"snapshots.{name}" for name in FORMATS)
MOVIE, GIF = "movie.mp4", "movie.gif"
_FILES = (RESULTS, OUTLINES, *SNAPSHOTS, MOVIE, GIF)


def _number(meaning: str, default: str, takes: str = "NUMBER") -> Any:
    return option(takes, meaning, default=default, panel=MODEL)


@dataclass(frozen=True)
class CollisionOptions(LaboratoryOptions, ModelFileOptions):
    """The parameters of a collision: a preset or a file, and what is changed of it."""

    size_ratio: Annotated[str | None, _number("D0/R, droplet over obstacle", "5.66")] = None
    capillary: Annotated[str | None, _number("Ca_sim, viscous drag over line tension", "25")] = None
    offset: Annotated[
        str | None,
        _number(
            "Start off the axis: a number of D0, or a length as '20 um'", "0.05", "NUMBER|QUANTITY"
        ),
    ] = None
    constants: Annotated[
        list[str] | None, set_option("NAME=VALUE", "Any other parameter, as line_tension=60")
    ] = None
    diameter: Annotated[str | None, quantity("Droplet, D0", "481 um")] = None
    speed: Annotated[str | None, quantity("Fluid, v", "1 mm/s")] = None

    def parameters(self) -> tuple[Parameters, str]:
        """Return what the file and the options say, and the preset's name."""
        base, preset = super().parameters()
        quantities = {name: getattr(self, name) for name in SCALE_QUANTITIES}
        numbers = {"size_ratio": self.size_ratio, "simulation_capillary_number": self.capillary}
        (quantities if _has_unit(self.offset) else numbers)["offset"] = self.offset
        return changed(base, _given(numbers), self.constants or [], _given(quantities)), preset


@dataclass(frozen=True)
class PictureOptions:
    """What is recorded and drawn of a collision."""

    frames_every: Annotated[
        float, option("NUMBER", "Time between stored outlines, in t0", panel=OUTPUT)
    ] = 0.02
    formats: Annotated[
        str,
        option("LIST", f"Formats of the snapshots: {', '.join(FORMATS)}", "--format", panel=OUTPUT),
    ] = "png"
    streamlines: Annotated[
        bool, switch("--streamlines", "Draw the flow into the snapshots", panel=OUTPUT)
    ] = False
    movie: Annotated[bool, switch("--movie", "Make movie.mp4 too", panel=OUTPUT)] = False
    gif: Annotated[bool, switch("--gif", "Make movie.gif too", panel=OUTPUT)] = False

    def checked(self) -> list[str]:
        """Return the names of the snapshots; refuse what cannot be drawn."""
        if not 0.0 < self.frames_every < math.inf:
            rule, advice = "a positive, finite number", "give a time in t0, as 0.02"
            raise InputError.of("--frames-every", rule, self.frames_every, advice)
        wanted = [name.strip().lower().removeprefix(".") for name in self.formats.split(",")]
        for name in wanted:
            if name not in FORMATS:
                rule = f"of {', '.join(FORMATS)}, separated by commas"
                raise InputError.of("--format", rule, f"'{self.formats}'", "write --format png,pdf")
        if self.movie:
            from pinchoff.video.writing import require_video_extra

            require_video_extra("--movie")
        return [f"snapshots.{name}" for name in dict.fromkeys(wanted)]


@grouped(out="collision")
def run(
    chosen: CollisionOptions,
    pictures: PictureOptions,
    results: Results,
) -> None:
    r"""Simulate one droplet that meets one obstacle.

    Without options it is the paper's median breaking collision. DIR gets

    - collision.json: parameters and results
    - outlines.gsd: every outline, written as the run goes on; OVITO opens it
    - snapshots.png: six moments of the collision (.pdf, .svg: see --format)
    - movie.mp4, movie.gif: the film, with --movie and --gif

    [bold]Examples[/bold]

    pinchoff run --capillary 30 --offset 0.1 --out off-centre --format pdf --gif

    pinchoff run --diameter '481 um' --obstacle-radius '85 um' \
    --speed '1 mm/s' --viscosity '48 mPa s' --surface-tension '20 mN/m' \
    --thickness '85 um'
    """
    names = pictures.checked()
    parameters, preset = chosen.parameters()
    about = partial(_description, parameters=parameters)
    with results.held_for(_FILES, about) as folder:
        remove_results(folder, _FILES)  # first, because the outlines are written during the run
        from pinchoff.model.collision_report import collision_report

        collision = _simulated(parameters, folder / OUTLINES, pictures.frames_every)
        _draw(collision, folder, names, pictures)
        report = collision_report(collision, preset)
        write_json(folder / RESULTS, report)
        results.announce(
            report, lambda: print_collision(collision.to_row()), (folder / name for name in _FILES)
        )


def _given(options: Mapping[str, str | None]) -> dict[str, str]:
    return {name: text for name, text in options.items() if text is not None}


def _has_unit(text: str | None) -> bool:
    try:
        float(text or "0")
    except ValueError:
        return True
    return False


def _description(out: Path, parameters: Parameters) -> str:
    """Say how the results in a folder relate to the run that is asked for."""
    from pinchoff import __version__

    try:
        report = json.loads((out / RESULTS).read_text(encoding="utf-8"))
        same = report["parameters"] == parameters.model_dump(mode="json")
        version = report["pinchoff_version"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return "it holds an unfinished run"
    if not same:
        return "it holds a run with other parameters"
    return "it holds this very run" + ("" if version == __version__ else f", by pinchoff {version}")


def _simulated(parameters: Parameters, path: Path, interval: float) -> Collision:
    from pinchoff.model.gsd import OutlineWriter
    from pinchoff.model.simulation import simulate

    obstacles = [[0.0, 0.0, parameters.obstacle_radius]]
    try:
        about = parameters.model_dump(mode="json")
        with OutlineWriter(path, obstacles, about, flush_every=50) as writer:
            return simulate(
                parameters, outlines=interval, on_frame=writer.append, progress=sys.stderr.isatty()
            )
    except (SimulationError, KeyboardInterrupt):
        print(f"stopped; {path} holds the run until then", file=sys.stderr)
        raise


def _draw(
    collision: Collision, folder: Path, names: Iterable[str], pictures: PictureOptions
) -> None:
    """Draw the snapshots, and the films that are wanted."""
    from pinchoff.figures.movie import animate
    from pinchoff.figures.snapshots import write_snapshots
    from pinchoff.model.flow import stokes

    outlines = collision.recorded()
    flow = stokes(collision.parameters.obstacle_radius) if pictures.streamlines else None
    for name in names:
        write_snapshots(folder / name, outlines, flow)
    for name, wanted in ((MOVIE, pictures.movie), (GIF, pictures.gif)):
        if wanted:
            with bar(name, unit="frames") as show:
                animate(outlines, folder / name, progress=show)
