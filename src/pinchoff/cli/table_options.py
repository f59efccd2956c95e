"""Options of commands that read a user's table of collisions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.assignments import read_pairs
from pinchoff.cli.options import option
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.collisions.importing import ImportedCollisions

_TABLE = "Table"


def _pairs(flag: str, meaning: str) -> Any:
    return option("NAME=TEXT", f"{meaning}; may be repeated", flag, panel=_TABLE)


ColumnMap = Annotated[list[str] | None, _pairs("--map", "Column of a quantity, as symmetry=S_meas")]
Units = Annotated[list[str] | None, _pairs("--unit", "Unit of a quantity, as area=mm^2")]
Constants = Annotated[
    list[str] | None,
    _pairs("--constant", "What is the same in all rows, as viscosity='48 mPa s'"),
]


def table_pairs(
    columns: Sequence[str] | None, units: Sequence[str] | None, constants: Sequence[str] | None
) -> dict[str, dict[str, str]]:
    """Return what the options about a table say, as `import_collisions` takes it.

    Raises
    ------
    InputError
        What stands behind an option is no pair, or a name is given twice.
    """
    return {
        "columns": read_pairs("--map", columns, "symmetry=S_meas"),
        "units": read_pairs("--unit", units, "area=mm^2"),
        "constants": read_pairs("--constant", constants, "viscosity='48 mPa s'"),
    }


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

    how = table_pairs(columns, units, constants)
    with named_as_table_options(how):
        return import_collisions(table, **how)


@contextmanager
def named_as_table_options(how: Mapping[str, Mapping[str, str]]) -> Iterator[None]:
    """Let errors about what an option says name the option."""
    try:
        yield
    except InputError as error:
        name = error.argument.removeprefix("unit of ")
        flags = {"columns": "--map", "units": "--unit", "constants": "--constant"}
        named = [flags[keyword] for keyword, pairs in how.items() if name in pairs]
        flag = "--unit" if name != error.argument or name in how["units"] else "".join(named[:1])
        if not flag:
            raise
        raise error.renamed(f"{flag} {name}") from None
