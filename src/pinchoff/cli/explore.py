"""``pinchoff explore``: the live model as a web page, with a user's own collisions in it."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated

from pinchoff.cli.folders import require_new_file
from pinchoff.cli.options import OUTPUT, AsJson, argument, grouped, option, switch
from pinchoff.cli.output import announce, warn
from pinchoff.cli.table_options import ColumnOptions, named_as_table_options
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted


@grouped()
def explore(
    reading: ColumnOptions,
    source: Annotated[
        Path | None,
        argument(
            "DIR_OR_TABLE", "Folder of a sweep, of video, fit or run; or a table of collisions"
        ),
    ] = None,
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
    pairs = reading.pairs()
    if source is None and any(pairs.values()):
        raise InputError.of("DIR_OR_TABLE", "given beside options about it", "nothing", "name it")
    with named_as_table_options(pairs):
        own = None if source is None else own_data(source, **pairs)
    if own is not None and not any(own["values"].values()):
        raise InputError.of("DIR_OR_TABLE", "a table with rows", "none", "check its name")
    for message in own["words"] if own else ():
        warn(message)
    write_explorer(target, own)
    report = {
        "collisions": len(next(iter(own["values"].values()))) if own else 0,
        "films": len(own["films"]) if own else 0,
        "words": own["words"] if own else [],
    }
    words = f"{counted(report['collisions'], 'collision')}, {report['films']} with their outlines"
    announce(report, lambda: print(words) if own else None, [target], as_json=as_json)
    if out is None and not webbrowser.open(target.resolve().as_uri()):
        print("open it in a browser: none could be started here", file=sys.stderr)


def _target(out: str | None, overwrite: bool) -> Path:
    """Return the file to write: the named one, or one among the system's temporary files."""
    if out is None:
        return Path(tempfile.mkdtemp(prefix="pinchoff-")) / "explorer.html"
    target = Path(out)
    if target.suffix.lower() not in (".html", ".htm"):
        raise InputError.of("--out", "a name ending in .html", out, "choose another")
    require_new_file("--out", target, overwrite=overwrite)
    return target
