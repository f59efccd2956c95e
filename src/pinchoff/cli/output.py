"""What commands report: tables, JSON, the names of files, warnings."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, TypeVar

from pinchoff.support.progress import Bar, progress_bar
from pinchoff.support.records import json_text, jsonable

Item = TypeVar("Item")

_TABLE = (
    "outcome",
    "symmetry",
    "impact_parameter",
    "breakup_number",
    "contact_time",
    "contact_time_s",
    "contact_speed",
    "speed_mm_s",
    "maximum_shape_parameter",
    "spring_tension_ratio",
    "minimum_neck",
    "neck_um",
    "breakup_time",
    "daughter_area_ratio",
    "droplet_count",
    "end_time",
)


def print_collision(row: Mapping[str, Any]) -> None:
    """Print the results that a collision has, with their units."""
    from pinchoff.collisions.schema import units

    rows = []
    for name in _TABLE:
        value, unit = row[name], units()[name]
        if not isinstance(value, float):
            missed = name == "outcome" and math.isnan(row["contact_time"])
            rows.append((name, f"{value}, without a contact" if missed else str(value), ""))
        elif math.isfinite(value):
            rows.append((name, f"{value:.4g}", "" if unit == "1" else unit))
    print_table(("result", "value", "unit"), rows, left=(0, 2))


def versioned(report: Mapping[str, Any]) -> dict[str, Any]:
    """Return a report as JSON can hold it, with the version of the package."""
    from pinchoff import __version__

    return {"pinchoff_version": __version__, **jsonable(report)}


def warn(message: object) -> None:
    """Print a warning, as one line on stderr."""
    print(f"warning: {message}", file=sys.stderr)


def bar(
    label: str, total: float | None = None, unit: str = ""
) -> AbstractContextManager[Bar | None]:
    """Return a bar of progress on stderr; it shows nothing where that is no terminal."""
    return progress_bar(sys.stderr.isatty(), label, total, unit=unit)


def counted_off(label: str, items: Sequence[Item], unit: str) -> Iterator[Item]:
    """Yield items one by one, and move a bar as each is done."""
    with bar(label, len(items), unit) as show:
        for done, item in enumerate(items, start=1):
            yield item
            if show is not None:
                show(done)


def announce(
    report: Mapping[str, Any], tell: Callable[[], object], files: Iterable[Path], *, as_json: bool
) -> None:
    """Say what came of a command, as JSON or in the words that `tell` prints.

    Then those of the files that exist are named: on stdout, beside JSON on stderr.
    """
    if as_json:
        print(json_text(report), end="")
    else:
        tell()
    for path in files:
        if path.exists():
            print(f"wrote {path}", file=sys.stderr if as_json else sys.stdout)


def print_table(
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    left: Collection[int] = (0,),
    title: str | None = None,
) -> None:
    """Print a table; columns in `left` are words, aligned to the left, all others numbers."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, title=title, title_justify="right", title_style="")
    for k, heading in enumerate(headings):
        table.add_column(heading, justify="left" if k in left else "right", no_wrap=k in left)
    for row in rows:
        table.add_row(*row)
    Console().print(table)


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print each warning once, as one line on stderr, when it is given."""
    printed: set[str] = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in printed:
            printed.add(str(message))
            warn(message)

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.simplefilter("always", RuntimeWarning)
        warnings.showwarning = show
        yield
