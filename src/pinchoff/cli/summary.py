"""``pinchoff summary``: what a dataset of collisions holds, in tables and a picture."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pinchoff.cli.folders import require_new_file
from pinchoff.cli.options import OUTPUT, AsJson, argument, option, switch
from pinchoff.cli.output import announce, print_table
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    from pinchoff.studies.sweep.summary import Summary

_PICTURE = "_summary.png"


def summary(
    dataset: Annotated[Path, argument("DIR", "Folder of a sweep, or a Parquet file")],
    picture: Annotated[
        Path | None,
        option("FILE", "The picture, .png, .pdf or .svg", default=f"DIR/{_PICTURE}", panel=OUTPUT),
    ] = None,
    overwrite: Annotated[
        bool, switch("--overwrite", "Replace FILE where it exists", panel=OUTPUT)
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show counts and ranges of a collisions table, and draw it.

    The picture shows S against Ca Ã z̃, with the paper's separating lines.
    Its name in DIR begins with _ so that programs that open DIR as a table
    skip it.

    [bold]Example[/bold]

    pinchoff summary phase-diagram --picture phase-diagram.pdf
    """
    if picture is not None:
        require_new_file("--picture", picture, overwrite=overwrite)
    from pinchoff.figures import style
    from pinchoff.figures.phase_diagram import phase_diagram
    from pinchoff.studies.sweep.summary import summarize

    found = summarize(dataset)
    folder = dataset if dataset.is_dir() else dataset.parent
    path = folder / _PICTURE if picture is None else picture
    drawable = len(found.points.symmetry) > 0
    if drawable:
        style.save(path, phase_diagram(found.points))
    announce(found.to_dict(), lambda: _print(found), [path] if drawable else [], as_json=as_json)
    if not drawable:
        reason = "no picture: no accepted collision with a contact"
        print(reason, file=sys.stderr if as_json else sys.stdout)


def _print(found: Summary) -> None:
    state = "" if found.rows == found.expected else f" of {found.expected}: not finished"
    print(f"{counted(found.rows, 'collision')}{state}")
    counts = [(outcome, str(count)) for outcome, count in found.outcomes.most_common()]
    reasons = [(f"rejected: {name}", str(n)) for name, n in found.reasons.most_common()]
    print_table(("outcome", "rows"), [*counts, *reasons])
    ranges = []
    for name, (low, high, measured) in found.ranges.items():
        unit = found.units.get(name, "")
        where = "" if measured == found.rows else counted(measured, "row")
        ranges.append((name, f"{low:.5g}", f"{high:.5g}", "" if unit == "1" else unit, where))
    print_table(("column", "from", "to", "unit", "measured in"), ranges, left=(0, 3, 4))
