"""Options of commands that read a user's table of collisions."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.assignments import read_pairs
from pinchoff.cli.options import flag_of, option
from pinchoff.cli.output import warn
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.collisions.importing import ImportedCollisions

_TABLE = "Table"
_READING = ("sheet", "header_row", "encoding", "broke_is")
_ARGUMENT = re.compile(rf"\b({'|'.join(_READING)})= ?")


def _pairs(flag: str, meaning: str) -> Any:
    return option("NAME=TEXT", f"{meaning}; may be repeated", flag, panel=_TABLE)


@dataclass(frozen=True)
class ColumnOptions:
    """What the columns of a table are."""

    columns: Annotated[
        list[str] | None, _pairs("--map", "Column of a quantity, as symmetry=S_meas")
    ] = None
    units: Annotated[list[str] | None, _pairs("--unit", "Unit of a quantity, as area=mm^2")] = None
    constants: Annotated[
        list[str] | None,
        _pairs("--constant", "What is the same in all rows, as viscosity='48 mPa s'"),
    ] = None

    def pairs(self) -> dict[str, dict[str, str]]:
        """Return the columns, units and constants as `import_collisions` takes them."""
        return {
            "columns": read_pairs("--map", self.columns, "symmetry=S_meas"),
            "units": read_pairs("--unit", self.units, "area=mm^2"),
            "constants": read_pairs("--constant", self.constants, "viscosity='48 mPa s'"),
        }


@dataclass(frozen=True)
class TableOptions(ColumnOptions):
    """What the columns of a table are, and how its file is read."""

    broke_is: Annotated[
        list[str] | None,
        option(
            "VALUE",
            "Outcome that means that the droplet broke, as 2; all others then mean that it did "
            "not; may be repeated",
            default="words of several languages, 1 and 0",
            panel=_TABLE,
        ),
    ] = None
    sheet: Annotated[
        str | None,
        option("NAME", "Sheet of a spreadsheet", default="first with a table", panel=_TABLE),
    ] = None
    header_row: Annotated[
        int | None,
        option(
            "INTEGER", "Row of the file with the names of columns", default="found", panel=_TABLE
        ),
    ] = None
    encoding: Annotated[
        str | None,
        option("NAME", "Encoding of a text table, as latin-1", default="found", panel=_TABLE),
    ] = None

    def read(self, table: Path) -> ImportedCollisions:
        """Read a table as the options say; errors about what an option says name it."""
        from pinchoff.collisions.importing import import_collisions

        pairs = self.pairs()
        reading: dict[str, Any] = {name: getattr(self, name) for name in _READING}
        reading |= {**pairs, "broke_is": self.broke_is or ()}
        with named_as_table_options(pairs):
            return import_collisions(table, **reading)


@contextmanager
def named_as_table_options(how: Mapping[str, Mapping[str, str]]) -> Iterator[None]:
    """Let errors and warnings about what an option says name the option."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield
        except InputError as error:
            raise _about_options(error, how) from None
        finally:
            for warning in caught:
                warn(_with_flags(str(warning.message)))


def _about_options(error: InputError, how: Mapping[str, Mapping[str, str]]) -> InputError:
    """Name the option that was wrong, and in the advice the one to use."""
    name = error.argument.removeprefix("unit of ")
    flags = {"columns": "--map", "units": "--unit", "constants": "--constant"}
    named = [flags[keyword] for keyword, pairs in how.items() if name in pairs]
    flag = "--unit" if name != error.argument or name in how["units"] else "".join(named[:1])
    argument = f"{flag} {name}" if flag else error.argument
    if argument in _READING:
        argument = flag_of(argument)
    return InputError.of(argument, error.rule, error.got, _with_flags(error.advice))


def _with_flags(text: str) -> str:
    return _ARGUMENT.sub(lambda found: f"{flag_of(found[1])} ", text)
