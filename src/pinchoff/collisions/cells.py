"""Cells of anybody's table, however they are written, and the rows that they rule out."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.collisions.columns import LARGEST, QUANTITIES, Place
from pinchoff.collisions.reasons import OUTCOME_UNKNOWN, general_reason, not_measured
from pinchoff.support.errors import InputError
from pinchoff.support.units import magnitude_of

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_BROKE = (
    *("true", "yes", "y", "t", "1", "1.0", "broke", "breaks", "broken", "break", "breakup"),
    *("break-up", "did break", "wahr", "ja", "j", "vrai", "oui", "verdadero", "sí", "vero", "sì"),
)
_UNBROKEN = (
    *("false", "no", "n", "f", "0", "0.0", "slipped", "captured", "intact", "unbroken", "slips"),
    *("no break", "no break-up", "no breakup", "not broken", "did not break", "does not break"),
    *("falsch", "nein", "faux", "non", "falso"),
)
_UNKNOWN = ("", "nan", "none", "na", "n/a", "failed", "<na>", "-", "--", "?", "unknown", "n.d.")

_NO_NUMBER = {*_UNKNOWN, "#n/a", "#div/0!", "#value!", "#ref!", "#num!", "#name?", "#null!", "–"}

_WRITTEN_OTHERWISE = (
    (re.compile(r"[-+]?\d{1,3}([,' \u00a0\u202f]\d{3})+(\.\d*)?"), "without thousands separators"),
    (re.compile(r"[-+]?\d{1,3}(\.\d{3})+(,\d*)?"), "without thousands separators"),
    (re.compile(r".*\d\s*%"), "as a fraction of 1 instead of percent"),
    (re.compile(r".*\d\s*(±|\+/?-)\s*\d.*"), "without its error, which may have its own column"),
    (re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?"), "with a point for the decimals"),
    (re.compile(r"[-+]?\d[\d.]*\s*[a-zA-Zµμ][^\d]*\d?"), "without its unit"),
)
"""Numbers that are written for people, and how to write them instead."""


def numbers_of(frame: pd.DataFrame, name: str, place: Place) -> Floats:
    """Return the numbers of a column in our unit, NaN where there is none."""
    import pandas as pd

    column = frame[place.column]
    if not pd.api.types.is_numeric_dtype(column):
        numbers = pd.to_numeric(column, errors="coerce")
        strange = _strange_cells(column, numbers)
        _refuse_written_otherwise(name, place.column, strange)
        if numbers.isna().all() and strange:
            got = f"{next(iter(strange.values()))!r} in the column {place.column!r}"
            raise InputError.of(name, "numbers", got, "choose another column")
        column = numbers
    return column.to_numpy(dtype=np.float64, na_value=math.nan) * place.factor


def _strange_cells(column: pd.Series, numbers: pd.Series) -> dict[int, str]:
    """Return, by row from 1, cells that are neither a number nor a sign for "no value"."""
    rows = np.flatnonzero(numbers.isna().to_numpy() & column.notna().to_numpy()).tolist()
    texts = {row + 1: str(column.iloc[row]).strip() for row in rows}
    return {row: text for row, text in texts.items() if text.lower() not in _NO_NUMBER}


def _refuse_written_otherwise(name: str, column: str, cells: Mapping[int, str]) -> None:
    """Refuse numbers written for people, as 1,000 or 5 ± 1; dropping them would lose data."""
    for row, text in cells.items():
        for pattern, how in _WRITTEN_OTHERWISE:
            if pattern.fullmatch(text):
                got = f"{text!r} in the column {column!r}"
                place = f"{name} in row {row}"
                raise InputError.of(place, "a plain number", got, f"write it {how}")


def constant_of(name: str, text: str) -> float:
    """Return a quantity that is the same in all rows, as a number in our unit."""
    quantity = QUANTITIES[name]
    if quantity.unit:
        value = magnitude_of(name, text, quantity.unit)
    else:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
    if not quantity.possible(np.array([value])).all():
        raise InputError.of(name, quantity.rule(), text, "correct it")
    return value


def _outcomes_of(column: pd.Series, broke_is: Sequence[str]) -> tuple[Floats, NDArray[np.bool_]]:
    """Read true and false; return 1, 0 or NaN for unknown, and where it is none of these."""
    import pandas as pd

    words = column.astype(object).where(column.notna(), "").astype(str).str.strip().str.lower()
    words = words.str.removesuffix(".0")
    if broke_is:
        named = [word.strip().lower().removesuffix(".0") for word in broke_is]
        broke = np.where(words.isin(named), 1.0, np.where(words.isin(_UNKNOWN), math.nan, 0.0))
        return broke, np.zeros(len(column), dtype=bool)
    if pd.api.types.is_bool_dtype(column):
        return column.to_numpy(dtype=np.float64, na_value=math.nan), np.zeros(len(column), bool)
    broke = np.where(words.isin(_BROKE), 1.0, np.where(words.isin(_UNBROKEN), 0.0, math.nan))
    return broke, np.isnan(broke) & ~words.isin(_UNKNOWN).to_numpy()


def _require_both_understood(
    shown: NDArray[Any], broke: Floats, strange: NDArray[np.bool_]
) -> None:
    """Refuse outcomes if some are not understood and the others are all of one kind.

    Of 1 and 2, for instance, 1 may mean either.
    """
    if strange.any() and not ((broke == 1).any() and (broke == 0).any()):
        counts = Counter(map(str, shown)).most_common()
        got = ", ".join(f"{value!r} ({count})" for value, count in counts[:6])
        more = ", ..." if len(counts) > 6 else ""
        rule = "true or false, yes or no, or 1 or 0"
        raise InputError.of("broke", rule, got + more, "say broke_is=VALUE of those that broke")


class RowChecks:
    """Which rows are kept so far, and what is wrong with the others."""

    def __init__(self, frame: pd.DataFrame, places: Mapping[str, Place]) -> None:
        self._frame, self._places = frame, places
        self.kept = np.ones(len(frame), dtype=bool)
        self._found: list[tuple[NDArray[np.intp], str, Sequence[object], str]] = []

    def outcomes(self, broke_is: Sequence[str]) -> Floats:
        """Return 1 where a droplet broke, 0 where it did not."""
        column = self._places["broke"].column
        broke, strange = _outcomes_of(self._frame[column], broke_is)
        entries = self._entries(column)
        _require_both_understood(entries, broke, strange)
        for value in dict.fromkeys(map(str, entries[strange])):
            words = f"broke is {value!r}, neither true or false, yes or no, nor 1 or 0"
            self._set_aside(strange & (entries.astype(str) == value), column, entries, words)
        self._set_aside(np.isnan(broke), column, entries, OUTCOME_UNKNOWN)
        return broke

    def accepted(self) -> None:
        """Set aside what was rejected when it was measured."""
        if "accepted" not in self._places:
            return
        column = self._places["accepted"].column
        accepted, _ = _outcomes_of(self._frame[column], ())
        reasons: Any = self._entries(column)
        if "reject_reason" in self._places:
            reasons = self._entries(self._places["reject_reason"].column)
        for reason in dict.fromkeys(general_reason(str(text)) for text in reasons[accepted == 0]):
            same = [general_reason(str(text)) == reason for text in reasons]
            where = (accepted == 0) & np.array(same)
            self._set_aside(where, column, reasons, f"rejected: {reason}".rstrip(": "))

    def possible(self, name: str, values: Floats) -> None:
        """Set aside impossible values; one that is missing is possible."""
        quantity = QUANTITIES[name]
        column = self._places[name].column if name in self._places else name
        impossible = ~np.isnan(values) & ~quantity.possible(values)
        self._set_aside(impossible, column, values, f"{name} is not {quantity.rule()}")
        size = np.abs(values)
        extreme = (size > LARGEST) | ((size > 0) & (size < 1.0 / LARGEST))
        self._set_aside(extreme, column, values, f"{name} is no size that can be computed with")

    def known(self, name: str, values: Floats) -> None:
        """Set aside rows without a number that is needed."""
        self._set_aside(np.isnan(values), name, values, not_measured(name))

    def lacking(self, name: str, part: str, values: Mapping[str, Floats]) -> None:
        """Set aside rows without a number that could follow from others, if one were there."""
        if part in values:
            which = np.isnan(values[name]) & np.isnan(values[part])
            self._set_aside(which, part, values[part], f"{name} needs {part}, which is not given")

    def set_aside(self) -> pd.DataFrame:
        """Return the rows that are not kept, in their order."""
        import pandas as pd

        lines = [
            (int(row) + 1, column, values[row], reason)
            for rows, column, values, reason in self._found
            for row in rows
        ]
        frame = pd.DataFrame(lines, columns=["row", "column", "value", "reason"])
        return frame.sort_values("row", ignore_index=True)

    def _entries(self, column: str) -> NDArray[Any]:
        return self._frame[column].to_numpy(dtype=object, na_value="")

    def _set_aside(self, which: NDArray[np.bool_], column: str, values: Any, reason: str) -> None:
        fresh = np.flatnonzero(self.kept & which)
        if len(fresh):
            self.kept[fresh] = False
            self._found.append((fresh, column, values, reason))
