"""``pinchoff reproduce``: the figures and numbers of the paper, remade."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pinchoff.cli.folders import prepare_folder, results_folder
from pinchoff.cli.options import OutFolder
from pinchoff.cli.output import printed_warnings
from pinchoff.cli.table import ColumnMap, Constants, Units, imported
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from pinchoff.paper import Reproduction

PAGE = "report.html"

_FLAGS = {"out": "--out", "only": "--only", "seed": "--seed"}


def reproduce(
    out: OutFolder = "reproduction",
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIG",
            help="A figure, as 4 or C, or numbers; may be repeated, or several between commas.",
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", metavar="", help="Fewer and coarser simulations.")
    ] = False,
    seed: Annotated[int, typer.Option(help="The same seed gives the same numbers.")] = 1,
    experiment: Annotated[
        Path | None,
        typer.Option(metavar="TABLE", help="Real collisions in place of the synthetic ones."),
    ] = None,
    columns: ColumnMap = None,
    units: Units = None,
    constants: Constants = None,
) -> None:
    """Remake the figures and numbers of the paper, ours beside its own.

    What is in DIR already is not made again: the same command goes on
    where an earlier one was stopped. DIR gets

    - report.html: everything on one page, with verdicts
    - figure_1.png, figure_1.pdf, …: the figures
    - numbers.csv, numbers.json: every number, with the paper's

    [bold]Examples[/bold]

    pinchoff reproduce --quick --out reproduction

    pinchoff reproduce --only 4,7,numbers --experiment mine.csv
    --map symmetry=S_meas --unit area=mm^2 --out mine
    """
    from pinchoff.paper import reproduce as remake
    from pinchoff.paper.page import reproduction_page

    folder = results_folder(out)
    names = None if only is None else [name for text in only for name in text.split(",")]
    with printed_warnings():
        table = None if experiment is None else imported(experiment, columns, units, constants)
        prepare_folder(folder)
        try:
            with _shown() as show:
                made = remake(
                    folder, only=names, quick=quick, seed=seed, experiment=table, progress=show
                )
        except InputError as error:
            name = _FLAGS.get(error.argument, error.argument)
            raise InputError.of(name, error.rule, error.got, error.advice) from None
        except KeyboardInterrupt:
            print(f"stopped; the same command goes on with {out}", file=sys.stderr)
            raise
    reproduction_page(made).write(folder / PAGE)
    _announce(made, folder / PAGE)


@contextmanager
def _shown() -> Iterator[Callable[[str, int, int], object] | None]:
    """Show what is being made on stderr, where that is a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:12}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task("", total=None)

        def show(name: str, done: int, total: int) -> None:
            text = name if name == "numbers" else f"figure {name}"
            bar.update(task, description=text, completed=done, total=total)

        yield show


def _announce(made: Reproduction, page: Path) -> None:
    from pinchoff.paper.page import verdicts

    if made.numbers:
        print(verdicts(made))
    for number in made.numbers:
        if number.verdict == "differs":
            print(f"differs: {number.name}: paper {number.paper}, ours {number.ours}")
    for name, reason in made.left_out.items():
        print(f"warning: figure {name} is left out: {reason}", file=sys.stderr)
    print(f"{len(made.figures)} figures; {made.seconds:.0f} s")
    print(f"wrote {page}")
