"""Sheets of .xlsx files as tables; sizes are bounded before anything is parsed."""

from __future__ import annotations

import warnings
import zipfile
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.collisions.header import (
    LOOKED_AT,
    Row,
    announce_header,
    column_names,
    find_header,
    is_empty,
    require_row,
    units_of,
)
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

MOST_BYTES = 400_000_000
"""Size of a spreadsheet, unpacked: what more would take GB of memory to parse."""

MOST_CELLS = 5_000_000
"""Cells of a sheet."""


def read_spreadsheet(source: Path, sheet: str | None, header_row: int | None) -> pd.DataFrame:
    """Read a sheet, with the units of a row below the header in ``attrs["unit_row"]``.

    By default it is the first sheet that holds a table, and the row that names its columns, counted
    from 1, is found out.

    Raises
    ------
    InputError
        The file is too large or damaged; there is no such sheet or row; a formula has no value.
    """
    _require_size(source)
    book = _opened(source, with_values=True)
    try:
        chosen = _chosen(book, source, sheet)
        rows = _rows(book[chosen], source)
    finally:
        book.close()
    while rows and all(map(is_empty, rows[-1])):
        rows.pop()
    require_row(header_row, len(rows))
    start = find_header(rows[:LOOKED_AT]) if header_row is None else header_row - 1
    _require_values(source, chosen, rows, start)
    return _frame(rows, start, announced=header_row is None)


def _require_size(source: Path) -> None:
    with zipfile.ZipFile(source) as packed:
        size = sum(member.file_size for member in packed.infolist())
    if size > MOST_BYTES:
        rule = f"a spreadsheet of at most {MOST_BYTES / 1e6:g} MB unpacked"
        raise InputError.of(str(source), rule, f"{size / 1e6:.0f} MB", "save it as CSV or Parquet")


def _opened(source: Path, *, with_values: bool) -> Any:
    from openpyxl import load_workbook

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about styles and the like, which are not read
        return load_workbook(source, read_only=True, data_only=with_values)


def _chosen(book: Any, source: Path, sheet: str | None) -> str:
    """Return the name of the sheet that is meant; say which, where there is a choice."""
    names = [page.title for page in book.worksheets]
    if sheet is not None:
        if sheet not in names:
            raise unknown_name("sheet", f"a sheet of {source.name}", sheet, names)
        return sheet
    tables = [page.title for page in book.worksheets if _holds_table(page)]
    chosen = (tables or names)[0]
    if len(names) > 1:
        others = ", ".join(repr(name) for name in names if name != chosen)
        warnings.warn(
            f"{source.name}: the sheet {chosen!r} is read, not {others}; say sheet= for another",
            UserWarning,
            stacklevel=2,
        )
    return str(chosen)


def _holds_table(sheet: Any) -> bool:
    sheet.reset_dimensions()  # what a file says of them may be wrong
    rows = list(islice(sheet.iter_rows(values_only=True), LOOKED_AT))
    return sum(sum(not is_empty(cell) for cell in row) > 1 for row in rows) > 1


def _rows(sheet: Any, source: Path) -> list[Row]:
    sheet.reset_dimensions()
    rows: list[Row] = []
    cells = 0
    for row in sheet.iter_rows(values_only=True):
        cells += len(row) or 1
        if cells > MOST_CELLS:
            rule = f"a sheet of at most {MOST_CELLS:,} cells"
            raise InputError.of(str(source), rule, "more", "save it as CSV or Parquet")
        rows.append(row)
    return rows


def _require_values(source: Path, sheet: str, rows: list[Row], start: int) -> None:
    """Refuse formulas whose values the file does not hold, as programs that only write it do."""
    width = len(rows[start]) if rows else 0
    if not any(None in row[:width] or len(row) < width for row in rows[start:]):
        return
    book = _opened(source, with_values=False)
    try:
        written = _rows(book[sheet], source)
    finally:
        book.close()
    for number, (values, cells) in enumerate(zip(rows, written, strict=False), 1):
        for column, (value, cell) in enumerate(zip_longest(values, cells)):
            if value is None and isinstance(cell, str) and cell.startswith("="):
                place = f"cell {_letters(column)}{number} of {source.name}"
                advice = "open the file in a spreadsheet program and save it, or save it as CSV"
                got = f"the formula {cell[:40]} without its value"
                raise InputError.of(place, "a value", got, advice)


def _letters(column: int) -> str:
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(column + 1))


def _frame(rows: list[Row], start: int, *, announced: bool) -> pd.DataFrame:
    import pandas as pd

    if not rows:
        return pd.DataFrame()
    width = max((k + 1 for k, cell in enumerate(rows[start]) if not is_empty(cell)), default=0)
    names = column_names(rows[start][:width])
    below = rows[start + 1 :]
    units = units_of(names, below[0]) if below else None
    if announced:
        announce_header(start + 1, units is not None, above=any(map(_filled, rows[:start])))
    body = below[1:] if units else below
    cells = [
        [None if is_empty(cell) else cell for cell, _ in zip_longest(row[:width], names)]
        for row in body
        if _filled(row)
    ]
    frame = pd.DataFrame(cells, columns=names)
    frame.attrs["unit_row"] = units or {}
    return frame


def _filled(row: Row) -> bool:
    return not all(map(is_empty, row))
