"""``pinchoff explore``: the live model as a web page, with a user's own collisions in it."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from pinchoff.cli.options import OUTPUT
from pinchoff.cli.output import printed_warnings
from pinchoff.cli.table_options import ColumnMap, Constants, Units, table_pairs
from pinchoff.support.errors import InputError


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
        typer.Option(
            metavar="PAGE.html",
            help="The page; without it, it is opened in the browser.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", metavar="", help="Replace PAGE.", rich_help_panel=OUTPUT),
    ] = False,
) -> None:
    """Move a droplet, see it break, map the diagram: the model in one web page.

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
    options = table_pairs(columns, units, constants)
    if source is None and any(options.values()):
        raise InputError.of("DIR_OR_TABLE", "given beside options about it", "nothing", "name it")
    with printed_warnings():
        own = None if source is None else own_data(source, **options)
    if own is not None and not any(own["values"].values()):
        raise InputError.of("DIR_OR_TABLE", "a table with rows", "none", "check its name")
    for word in own["words"] if own else ():
        print(f"warning: {word}", file=sys.stderr)
    write_explorer(target, own)
    print(f"wrote {target}")
    if out is None and not webbrowser.open(target.resolve().as_uri()):
        print("open it in a browser: none could be started here", file=sys.stderr)


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
