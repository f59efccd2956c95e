"""Tables that others wrote, from the files that laboratories keep them in."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING
from zipfile import BadZipFile

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

TEXT = (".csv", ".tsv", ".txt")
SPREADSHEETS = (".xlsx", ".xlsm")

_SAMPLE = 64 * 1024  # bytes from which the separator of a text table is guessed
_DECIMAL_COMMA = re.compile(r"(?:^|[;\t])\s*-?\d+,\d+\s*(?:[;\t]|$)", re.M)
_ADVICE = (
    "check its name; a Parquet file or a folder of them, a text table (.csv, .tsv) or a "
    "spreadsheet (.xlsx) will do"
)


def read_table(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a table as it stands.

    Parameters
    ----------
    path : path
        A Parquet file or a folder of them; a text table, whose separator and decimal sign are
        found out and in which lines that begin with # are remarks; or a spreadsheet, of which the
        first sheet is read.

    Raises
    ------
    InputError
        It cannot be read, or has no rows.
    """
    import pandas as pd

    source = Path(path)
    if not source.exists():
        raise InputError.of(str(path), "a readable table", "nothing there", _ADVICE)
    try:
        if source.suffix.lower() in TEXT:
            frame = _read_text(source)
        elif source.suffix.lower() in SPREADSHEETS:
            frame = pd.read_excel(source)
        else:
            frame = pd.read_parquet(source)
    except (OSError, ValueError, csv.Error, KeyError, BadZipFile) as error:
        # The errors of pandas and pyarrow derive from these.
        reason = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise InputError.of(str(path), "a readable table", reason, _ADVICE) from None
    if frame.empty:
        raise InputError.of(str(path), "a table with rows", "none", "check its name")
    return frame


def _read_text(source: Path) -> pd.DataFrame:
    import pandas as pd

    with source.open(encoding="utf-8-sig", newline="") as file:
        sample = file.read(_SAMPLE)
    lines = [line for line in sample.splitlines() if line.strip() and not line.startswith("#")]
    head = lines[0] if lines else ""
    separator = max(",;\t", key=head.count) if lines else ","
    comma = separator != "," and _DECIMAL_COMMA.search("\n".join(lines[1:]))
    return pd.read_csv(
        source,
        sep=separator,
        decimal="," if comma else ".",
        comment="#",
        encoding="utf-8-sig",
        skipinitialspace=True,
    )
