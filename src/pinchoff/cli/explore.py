"""``pinchoff explore``: the live model as a web page, with a user's own collisions in it."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated, Any

import typer

from pinchoff.cli.options import OUTPUT, AsJson, option, switch
from pinchoff.cli.output import announce
from pinchoff.cli.table_options import (
    ColumnMap,
    Constants,
    Units,
    named_as_table_options,
    table_pairs,
)
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted


def explore(
    source: Annotated[
        Path | None,
        typer.Argument(
            metavar="DIR_OR_TABLE",
            help="Folder of a sweep, of video, fit or run; or a table of collisions.",
        ),
    ] = None,
    columns: ColumnMap = None,
    units: Units = None,
    constants: Constants = None,
    out: Annotated[
        str | None,
        option("FILE", "The page", default="a temporary file, opened in a browser", panel=OUTPUT),
    ] = None,
    as_json: AsJson = False,
    overwrite: Annotated[bool, switch("--overwrite", "Replace FILE", panel=OUTPUT)] = False,
) -> None:
    r"""Move a droplet, see it break, map the diagram: the model in one web page.

    The page works from a file, offline, in any browser of today. With
    DIR_OR_TABLE it shows your own collisions in the same diagram, with
    filters, and simulates any of them beside its filmed outlines.

    [bold]Examples[/bold]

    pinchoff explore

    pinchoff explore measured --out measured.html

    pinchoff explore mine.csv --map symmetry=S_meas --out mine.html
    """
    from pinchoff.explorer.own_data import own_data
    from pinchoff.explorer.page import write_explorer

    target = _target(out, overwrite)
    how = table_pairs(columns, units, constants)
    if source is None and any(how.values()):
        raise InputError.of("DIR_OR_TABLE", "given beside options about it", "nothing", "name it")
    with named_as_table_options(how):
        own = None if source is None else own_data(source, **how)
    if own is not None and not any(own["values"].values()):
        raise InputError.of("DIR_OR_TABLE", "a table with rows", "none", "check its name")
    for word in own["words"] if own else ():
        print(f"warning: {word}", file=sys.stderr)
    write_explorer(target, own)
    report = {
        "collisions": len(next(iter(own["values"].values()))) if own else 0,
        "films": len(own["films"]) if own else 0,
        "words": own["words"] if own else [],
    }
    announce(report, lambda: _print(report), [target], as_json=as_json)
    if out is None and not webbrowser.open(target.resolve().as_uri()):
        print("open it in a browser: none could be started here", file=sys.stderr)


def _print(report: dict[str, Any]) -> None:
    if report["collisions"]:
        print(
            f"{counted(report['collisions'], 'collision')}, {report['films']} with their outlines"
        )


def _target(out: str | None, overwrite: bool) -> Path:
    """Return the file to write: the named one, or one among the system's temporary files."""
    if out is None:
        return Path(tempfile.mkdtemp(prefix="pinchoff-")) / "explorer.html"
    target = Path(out)
    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError.of("--out", "a name ending in .html", out, "choose another")
    if target.exists() and not overwrite:
        raise InputError.of("--out", "a new file", f"{out}, which exists", "add --overwrite")
    if not target.parent.is_dir():
        got = f"{out}, whose folder does not exist"
        raise InputError.of("--out", "a file in an existing folder", got, "make it first")
    return target
