"""Tables that others wrote, from the files that laboratories keep them in."""

from __future__ import annotations

import codecs
import csv
import io
import os
import re
import warnings
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import BadZipFile

from pinchoff.collisions.header import (
    LOOKED_AT,
    announce_header,
    column_names,
    find_header,
    is_number,
    require_row,
    units_of,
)
from pinchoff.collisions.spreadsheet import read_spreadsheet
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

TEXT = (".csv", ".tsv", ".txt")
SPREADSHEETS = (".xlsx", ".xlsm")

MOST_BYTES = 256_000_000
"""Size of a text table."""

_MOST_REMARKS = 1000  # lines above the header
_DECIMAL_COMMA = re.compile(r"(?:^|[;\t])\s*-?\d+,\d+\s*(?:[;\t]|$)", re.M)
_MARKS = (  # the longer first: that of UTF-32 begins like that of UTF-16
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_ADVICE = (
    "check its name; a Parquet file or a folder of them, a text table (.csv, .tsv) or a "
    "spreadsheet (.xlsx) will do"
)


def read_table(
    path: str | os.PathLike[str],
    *,
    sheet: str | None = None,
    header_row: int | None = None,
    encoding: str | None = None,
) -> pd.DataFrame:
    """Read a table as it stands.

    Parameters
    ----------
    path : path
        A Parquet file or a folder of them; a text table, whose separator and decimal sign are
        found out, with remarks behind # above its header; or a spreadsheet.
    sheet : str, optional
        Of a spreadsheet; by default the first that holds a table.
    header_row : int, optional
        Row or line of the file that names the columns, from 1; by default the first that is about
        as full as most are. Units in the row below it are in ``attrs["unit_row"]``.
    encoding : str, optional
        Of a text table, such as "latin-1"; by default UTF-8, UTF-16 or, if it is neither, that of
        Windows in western Europe, with a warning.

    Raises
    ------
    InputError
        It cannot be read, or has no rows.

    Warns
    -----
    UserWarning
        A guess was made: of the sheet, the header, units or the encoding.
    """
    import pandas as pd

    source = Path(path)
    suffix = source.suffix.lower()
    if not source.exists():
        raise InputError.of(str(path), "a readable table", "nothing there", _ADVICE)
    if not (source.is_file() or source.is_dir()):
        raise InputError.of(str(path), "a readable table", "neither file nor folder", _ADVICE)
    _require_of_kind("sheet", sheet, "a spreadsheet", suffix in SPREADSHEETS)
    _require_of_kind("header_row", header_row, "text or sheets", suffix in (*TEXT, *SPREADSHEETS))
    _require_of_kind("encoding", encoding, "a text table", suffix in TEXT)
    try:
        if suffix in TEXT:
            frame = _read_text(source, header_row, encoding)
        elif suffix in SPREADSHEETS:
            frame = read_spreadsheet(source, sheet, header_row)
        else:
            frame = pd.read_parquet(source)
    except InputError:
        raise
    except _damage(suffix) as error:
        reason = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise InputError.of(str(path), "a readable table", reason or "damage", _ADVICE) from None
    if frame.empty:
        raise InputError.of(str(path), "a table with rows", "none", "check its name")
    return frame


def _damage(suffix: str) -> tuple[type[Exception], ...]:
    """Return the errors that reading a damaged file raises."""
    # Readers of spreadsheets raise any error over damage: a part or an attribute is missing.
    if suffix in SPREADSHEETS:
        return (Exception,)
    # The errors of pandas and pyarrow derive from the first two.
    return (OSError, ValueError, csv.Error, KeyError, BadZipFile, zlib.error, NotImplementedError)


def _require_of_kind(name: str, value: object, kind: str, fits: bool) -> None:
    if value is not None and not fits:
        raise InputError.of(name, f"left out unless the table is {kind}", value, "leave it out")


def _read_text(source: Path, header_row: int | None, encoding: str | None) -> pd.DataFrame:
    text = _decoded(source, encoding)
    require_row(header_row, text.count("\n") + 1)
    top = _remarks(text) if header_row is None else header_row - 1
    lines = text.split("\n", top + LOOKED_AT)[: top + LOOKED_AT]
    separator, rows, start = _separated(lines[top:], None if header_row is None else 0)
    names, above = rows[start] if rows else [], start > 0
    if header_row is None and top and start == 0 and any(map(is_number, names)):
        (remark,) = csv.reader([lines[top - 1].lstrip("# ")], delimiter=separator)
        if len(remark) == len(names):  # the header is a remark, as some programs write it
            names, start = remark, -1
    return _text_frame(text, top + start, separator, column_names(names), above)


def _text_frame(
    text: str, header: int, separator: str, names: list[str], above: bool
) -> pd.DataFrame:
    """Read what stands below the header's line, counted from 0."""
    import pandas as pd

    body = text.split("\n", header + 1)[-1] if text.count("\n") > header else ""
    second = next(csv.reader([body.partition("\n")[0]], delimiter=separator), [])
    units = units_of(names, second)
    announce_header(header + 1, units is not None, above=above)
    if units:
        body = body.partition("\n")[2]
    if not body.strip():
        return pd.DataFrame(columns=names)
    longest = _require_fields(body, separator, len(names), header + 2 + bool(units))
    more = [f"\0{k}" for k in range(len(names), longest)]
    comma = separator != "," and _DECIMAL_COMMA.search(body[: 64 * 1024])
    frame = pd.read_csv(
        io.StringIO(body),
        sep=separator,
        decimal="," if comma else ".",
        header=None,
        names=[*names, *more],
        index_col=False,
        skipinitialspace=True,
    ).drop(columns=more)
    frame.attrs["unit_row"] = units or {}
    return frame


def _decoded(source: Path, encoding: str | None) -> str:
    size = source.stat().st_size
    if size > MOST_BYTES:
        rule = f"at most {MOST_BYTES / 1e6:g} MB as text"
        raise InputError.of(str(source), rule, f"{size / 1e6:.0f} MB", "save it as Parquet")
    data = source.read_bytes()
    if encoding is not None:
        try:
            text = data.decode(encoding)
        except LookupError:
            advice = "write it like utf-8, utf-16 or latin-1"
            raise InputError.of("encoding", "the name of one", encoding, advice) from None
        except UnicodeDecodeError as error:
            reason = f"{encoding}, which it is not: {error.reason}"
            advice = "try utf-8, utf-16 or latin-1"
            raise InputError.of("encoding", f"that of {source.name}", reason, advice) from None
    else:
        text = _guessed(data, source.name)
    if "\0" in text:
        raise ValueError("it is no text")
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _guessed(data: bytes, name: str) -> str:
    for mark, known in _MARKS:
        if data.startswith(mark):
            return data.decode(known)
    for known, zeros in (("utf-16-le", data[1:200:2]), ("utf-16-be", data[:200:2])):
        if len(zeros) > 4 and not any(zeros):
            return data.decode(known)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        if b"\0" in data:
            raise ValueError("it is no text") from None
        text = data.decode("cp1252", errors="strict")
        first = text[: error.start].count("\n") + 1
        warnings.warn(
            f"{name} is not UTF-8 (line {first}): it is read as Windows-1252; say encoding= if its "
            "letters come out wrong",
            UserWarning,
            stacklevel=2,
        )
        return text


def _remarks(text: str) -> int:
    """Return how many lines at the top are empty or remarks."""
    lines = text.split("\n", _MOST_REMARKS)[:_MOST_REMARKS]
    remarks = (not line.strip() or line.startswith("#") for line in lines)
    return next((k for k, remark in enumerate(remarks) if not remark), len(lines))


def _separated(lines: Sequence[str], header: int | None) -> tuple[str, list[list[str]], int]:
    """Return the separator that gives the header the most names, the rows, and which it is."""
    best: tuple[float, str, list[list[str]], int] = (-1, ",", [], 0)
    for separator in ",;\t":
        rows = [next(csv.reader([line], delimiter=separator), []) for line in lines]
        start = find_header(rows) if header is None else header
        names = rows[start] if rows else []
        # Names come before numbers: there a comma may stand for the decimals.
        score = (len(names) - 1) * (0.001 if any(map(is_number, names)) else 1.0)
        best = max(best, (score, separator, rows, start), key=lambda found: found[0])
    return best[1:]


def _require_fields(body: str, separator: str, count: int, first_line: int) -> int:
    """Return the largest number of fields in a row; fields beyond the header must be empty."""
    longest = count
    rows = csv.reader(io.StringIO(body), delimiter=separator)
    for row in rows:
        if len(row) > count:
            longest = max(longest, len(row))
            if any(cell.strip() for cell in row[count:]):
                line = first_line + rows.line_num - 1
                raise ValueError(f"line {line} has {len(row)} fields, the header {count}")
    return longest
