"""Rows of a table that are set aside, each with its reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.collisions.cells import outcomes_of, require_both_understood
from pinchoff.collisions.columns import LARGEST, QUANTITIES, Place
from pinchoff.collisions.reasons import OUTCOME_UNKNOWN, general_reason, not_measured

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


class RowChecks:
    """Which rows are kept so far, and what is wrong with the others."""

    def __init__(self, frame: pd.DataFrame, places: Mapping[str, Place]) -> None:
        self._frame, self._places = frame, places
        self.kept = np.ones(len(frame), dtype=bool)
        self._found: list[tuple[NDArray[np.intp], str, Sequence[object], str]] = []

    def outcomes(self, broke_is: Sequence[str]) -> Floats:
        """Return 1 where a droplet broke, 0 where it did not."""
        column = self._places["broke"].column
        broke, strange = outcomes_of(self._frame[column], broke_is)
        entries = self._entries(column)
        require_both_understood(entries, broke, strange)
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
        accepted, _ = outcomes_of(self._frame[column], ())
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
