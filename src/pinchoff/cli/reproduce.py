"""``pinchoff reproduce``: the figures and numbers of the paper, remade."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pinchoff.cli.folders import ResumableResults
from pinchoff.cli.options import Seed, grouped, named_as_options, option, switch
from pinchoff.cli.output import bar, warn
from pinchoff.cli.table_options import TableOptions

if TYPE_CHECKING:
    from pinchoff.paper import Reproduction

PAGE = "report.html"


@grouped(out="reproduction")
def reproduce(
    reading: TableOptions,
    *,
    only: Annotated[
        list[str] | None,
        option(
            "FIG",
            "A figure, as 4 or C, or numbers; may be repeated, or several between commas",
            default="all",
        ),
    ] = None,
    quick: Annotated[bool, switch("--quick", "Fewer and coarser simulations")] = False,
    seed: Seed = 1,
    experiment: Annotated[
        Path | None,
        option("TABLE", "Real collisions in place of the synthetic ones", default="none"),
    ] = None,
    results: ResumableResults,
) -> None:
    r"""Remake the figures and numbers of the paper, ours beside its own.

    What is in DIR already is not made again: the same command goes on where
    an earlier one was stopped. DIR gets

    - report.html: everything on one page, with verdicts
    - figure_1.png, figure_1.pdf, …: the figures
    - numbers.csv, numbers.json: every number, with the paper's

    [bold]Examples[/bold]

    pinchoff reproduce --quick --out reproduction

    pinchoff reproduce --only 4,7,numbers --experiment mine.csv \
    --map symmetry=S_meas --unit area=mm^2 --out mine
    """
    from pinchoff.paper import reproduce as remake
    from pinchoff.paper.make import remove_reproduction
    from pinchoff.paper.reproduction_page import reproduction_page

    names = None if only is None else [name for text in only for name in text.split(",")]
    table = None if experiment is None else reading.read(experiment)
    with results.resumed() as folder:
        if results.overwrite:
            remove_reproduction(folder)
        with named_as_options("out", "only", "seed"), bar("", unit="items") as show:
            made = remake(
                folder,
                only=names,
                quick=quick,
                seed=seed,
                experiment=table,
                progress=None
                if show is None
                else lambda name, done, total: show(done, total, _title(name)),
            )
        reproduction_page(made).write(folder / PAGE)
    results.announce(made.to_dict(), lambda: _print(made), [folder / PAGE])


def _title(name: str) -> str:
    return name if name == "numbers" else f"figure {name}"


def _print(made: Reproduction) -> None:
    from pinchoff.paper.reproduction_page import verdicts

    for line in verdicts(made):
        print(line)
    for number in made.numbers:
        if number.verdict in ("differs", "not recovered", "does not follow"):
            print(f"{number.verdict}: {number.name}: paper {number.paper}, ours {number.ours}")
    for name, reason in made.left_out.items():
        warn(f"figure {name} is left out: {reason}")
    print(f"{len(made.figures)} figures; {made.seconds:.0f} s")
