"""Which row of a table names its columns, and whether the row below it gives their units."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

from pinchoff.support.errors import InputError
from pinchoff.support.units import is_unit

LOOKED_AT = 30
"""Rows at the top of a file among which the header is looked for."""

Row = Sequence[object]


def find_header(rows: Sequence[Row]) -> int:
    """Return the row that names the columns, from 0: no numbers, about as full as the others.

    Titles and merged cells above it fill fewer cells; one name may be missing, as that of an index.
    """
    filled = [sum(not is_empty(cell) for cell in row) for row in rows]
    usual = max(filter(None, filled), key=lambda count: (filled.count(count), count), default=0)
    least = usual - 1 if usual > 3 else usual
    for k, count in enumerate(filled):
        if count and count >= least and not any(map(is_number, rows[k])):
            return k
    return next((k for k, count in enumerate(filled) if count), 0)


def column_names(header: Row) -> list[str]:
    """Return a name for each column; a missing or repeated name gets the column's number."""
    names: list[str] = []
    for number, cell in enumerate(header, 1):
        name = "" if is_empty(cell) else str(cell).strip()
        names.append(name if name and name not in names else f"{name or 'column'}.{number}")
    return names


def units_of(names: Sequence[str], row: Row) -> dict[str, str] | None:
    """Return the units of columns from the row below the header; None where it is none of units."""
    texts = ["" if is_empty(cell) else str(cell).strip(" []()") for cell in row]
    if any(is_number(text) for text in texts):
        return None
    units = {name: text for name, text in zip(names, texts, strict=False) if is_unit(text)}
    return units or None


def is_empty(cell: object) -> bool:
    """Return whether nothing is written in a cell."""
    return cell is None or (isinstance(cell, str) and not cell.strip())


def is_number(cell: object) -> bool:
    """Return whether a cell holds a finite number, with a point or a comma."""
    try:
        return math.isfinite(float(str(cell).replace(",", ".")))
    except ValueError:
        return False


def require_row(header_row: int | None, count: int) -> None:
    """Refuse a number of the header's row, from 1, that the file does not have.

    Raises
    ------
    InputError
        It is less than 1 or there are not that many.
    """
    if header_row is not None and not 1 <= header_row <= count:
        raise InputError.of(
            "header_row", f"from 1 to {count}, the rows of the file", header_row, "count from 1"
        )


def announce_header(number: int, has_units: bool, *, above: bool) -> None:
    """Warn that a row, from 1, was taken for the header, and the one below it for units."""
    if above:
        text = f"row {number} names the columns, what is above it is left out"
        warnings.warn(f"{text}; say header_row= for another", UserWarning, stacklevel=2)
    if has_units:
        text = f"row {number + 1} is read as the units of the columns"
        warnings.warn(text, UserWarning, stacklevel=2)
