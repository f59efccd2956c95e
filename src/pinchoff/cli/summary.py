"""``pinchoff summary``: what a dataset of collisions holds, in tables and a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pinchoff.cli.folders import refuse_files

if TYPE_CHECKING:
    from rich.table import Table

    from pinchoff.studies.sweep.summary import Summary

_PICTURE = "_summary.png"


def summary(
    dataset: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a sweep, or a Parquet file.")
    ],
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="The picture, .png or .pdf; DIR/_summary.png by default."
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", metavar="", help="Replace FILE where it exists.")
    ] = False,
) -> None:
    """Show counts and ranges of a collisions table, and draw it.

    The picture shows S against Ca Ã z̃, with the paper's separating lines. Its name in DIR begins
    with _ so that what opens DIR as a table passes over it.

    [bold]Example[/bold]

    pinchoff summary phase-diagram --picture phase-diagram.pdf
    """
    if picture is not None:
        refuse_files("--picture", [picture], overwrite=overwrite)
    from pinchoff.figures import style
    from pinchoff.figures.phase_diagram import phase_diagram
    from pinchoff.studies.sweep.summary import summarize

    found = summarize(dataset)
    _print(found)
    folder = dataset if dataset.is_dir() else dataset.parent
    path = folder / _PICTURE if picture is None else picture
    if len(found.points.symmetry):
        style.save(path, phase_diagram(found.points))
        print(f"wrote {path}")
    else:
        print("no picture: there is no accepted collision")


def _print(found: Summary) -> None:
    from rich.console import Console

    console = Console()
    state = "" if found.rows == found.expected else f" of {found.expected}: not finished"
    console.print(f"{found.rows} collisions{state}")
    console.print(_counts(found))
    console.print(_ranges(found))


def _counts(found: Summary) -> Table:
    table = _table("outcome", "rows")
    for outcome, count in found.outcomes.most_common():
        table.add_row(outcome, str(count))
    for reason, count in found.reasons.most_common():
        table.add_row(f"rejected: {reason}", str(count))
    return table


def _ranges(found: Summary) -> Table:
    table = _table("column", "from", "to", "unit", "measured in")
    for name, (low, high, measured) in found.ranges.items():
        unit = found.units.get(name, "")
        shown = (f"{low:.5g}", f"{high:.5g}", "" if unit == "1" else unit)
        table.add_row(name, *shown, "" if measured == found.rows else f"{measured} rows")
    return table


def _table(*columns: str) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD)
    for column in columns:
        table.add_column(column, justify="right" if column in ("rows", "from", "to") else "left")
    return table
