"""Options of commands that read a user's table of collisions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.collisions.importing import ImportedCollisions

_TABLE = "Table"


def _pairs(flag: str, meaning: str) -> Any:
    return typer.Option(
        flag, metavar="NAME=TEXT", help=f"{meaning}; may be repeated.", rich_help_panel=_TABLE
    )


ColumnMap = Annotated[list[str] | None, _pairs("--map", "Column of a quantity, as symmetry=S_meas")]
Units = Annotated[list[str] | None, _pairs("--unit", "Unit of a quantity, as area=mm^2")]
Constants = Annotated[
    list[str] | None,
    _pairs("--constant", "What is the same in all rows, as viscosity='48 mPa s'"),
]


def imported(
    table: Path,
    columns: Sequence[str] | None,
    units: Sequence[str] | None,
    constants: Sequence[str] | None,
) -> ImportedCollisions:
    """Read a table as the options say; errors about what an option says name it.

    Raises
    ------
    InputError
        An option is wrong, or the table.
    """
    from pinchoff.collisions.importing import import_collisions

    given = {
        "--map": _read_pairs("--map", columns),
        "--unit": _read_pairs("--unit", units),
        "--constant": _read_pairs("--constant", constants),
    }
    how = dict(zip(("columns", "units", "constants"), given.values(), strict=True))
    try:
        return import_collisions(table, **how)
    except InputError as error:
        name = error.argument.removeprefix("unit of ")
        named = [flag for flag, pairs in given.items() if name in pairs]
        flag = "--unit" if name != error.argument or name in given["--unit"] else "".join(named[:1])
        if not flag:
            raise
        raise InputError.of(f"{flag} {name}", error.rule, error.got, error.advice) from None


def _read_pairs(flag: str, texts: Sequence[str] | None) -> dict[str, str]:
    pairs: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError.of(flag, "NAME=TEXT", text, "write it like symmetry=S_meas")
        if name in pairs:
            raise InputError.of(f"{flag} {name}", "given once", value, "drop one of them")
        pairs[name] = value
    return pairs
