"""Anybody's table of collisions: columns and units brought to ours, every value checked.

Rows with an impossible value, without an outcome or without what the break-up law needs are set
aside, each with its reason; nothing is dropped in silence.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.collisions.cells import RowChecks, constant_of, numbers_of
from pinchoff.collisions.columns import QUANTITIES, Place, find_columns
from pinchoff.collisions.law import breakup_number_of
from pinchoff.collisions.reading import read_table
from pinchoff.collisions.schema import measured_table, synthetic
from pinchoff.support.checked import unknown_name
from pinchoff.support.drawing import Drawable
from pinchoff.support.errors import InputError
from pinchoff.support.quantities import capillary_number

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_REQUIRED = ("capillary_number", "normalized_area", "normalized_thickness", "symmetry")

_DERIVED: dict[str, tuple[tuple[str, ...], Callable[..., Floats]]] = {
    "capillary_number": (("viscosity", "speed", "surface_tension"), capillary_number),
    "normalized_area": (("area", "obstacle_radius"), lambda area, radius: area / radius**2),
    "normalized_thickness": (("thickness", "obstacle_radius"), np.divide),
}
"""What follows from other quantities, with how."""


@dataclass(frozen=True, eq=False)
class ImportedCollisions(Drawable):
    """A checked table of collisions.

    Attributes
    ----------
    table : DataFrame
        With `pinchoff.collisions.schema.SHARED_COLUMNS`: rows whose outcome, symmetry, Ca, Ã and
        z̃ are known and possible. S is folded: S above 1 is 2 - S.
    set_aside : DataFrame
        The other rows, one line each: ``row`` in the source, counted from 1; ``column``; ``value``;
        ``reason``. Of several reasons the first.
    count : int
        Rows of the source.
    duplicates : int
        Rows of the table that repeat another one in every digit. They count like others.
    """

    table: pd.DataFrame
    set_aside: pd.DataFrame
    count: int
    duplicates: int

    @property
    def synthetic(self) -> bool:
        """Whether rows were drawn rather than simulated or measured."""
        return synthetic(self.table)

    def reasons(self) -> dict[str, int]:
        """Return how many rows were set aside, by the reason."""
        counts = self.set_aside["reason"].value_counts()
        return {str(reason): int(number) for reason, number in counts.items()}

    def messages(self) -> list[str]:
        """Say what was set aside and what was noticed, a line each."""
        lines = []
        if len(self.set_aside):
            several = "; ".join(f"{reason} ({n})" for reason, n in self.reasons().items())
            lines.append(f"{len(self.set_aside)} of {self.count} rows are set aside: {several}")
        if self.duplicates:
            number = self.duplicates
            lines.append(f"{number} rows repeat others in every digit, and count all the same")
        return lines

    def warn(self, stacklevel: int = 2) -> None:
        """Warn of what `messages` says."""
        for message in self.messages():
            warnings.warn(message, UserWarning, stacklevel=stacklevel + 1)


def import_collisions(
    source: pd.DataFrame | str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
    broke_is: Sequence[str] = (),
    sheet: str | None = None,
    header_row: int | None = None,
    encoding: str | None = None,
) -> ImportedCollisions:
    """Bring a table of collisions into our form, and check every value.

    A column is found by the name of its quantity (in
    `pinchoff.collisions.columns`), with its unit at the end
    where it has one: ``area_mm2``, ``speed_um_s``; or by what `columns` says. Ca, Ã and z̃ are
    computed from the physical columns where they are not given, Ã from the diameter too.

    Parameters
    ----------
    source : DataFrame or path
        As of `pinchoff.collisions.reading.read_table`.
    columns : mapping of str to str, optional
        Column of the source by quantity, such as ``{"symmetry": "S_meas"}``.
    units : mapping of str to str, optional
        Unit by quantity, such as ``{"area": "mm^2"}``, for columns whose names do not tell it.
    constants : mapping of str to str, optional
        What is the same in all rows and has no column, such as ``{"viscosity": "48 mPa s"}``; a
        pure number without a unit.
    broke_is : sequence of str, optional
        Values of the outcome that mean that the droplet broke; all others that are given then
        mean that it did not. By default words of several languages, and 1 and 0, are understood.
    sheet, header_row, encoding
        As of `pinchoff.collisions.reading.read_table`, for a file.

    Raises
    ------
    InputError
        The source cannot be read; a name or unit is wrong; there is no outcome, no symmetry, or
        nothing that gives Ca, Ã or z̃.

    Examples
    --------
    >>> import pandas as pd
    >>> table = pd.DataFrame({
    ...     "S": [0.9, 0.3, 0.5], "broke": ["yes", "no", ""], "capillary_number": 0.0024,
    ...     "area_mm2": 0.18, "radius": 85.0, "normalized_thickness": 1.0})
    >>> found = import_collisions(
    ...     table, columns={"symmetry": "S", "obstacle_radius": "radius"},
    ...     units={"obstacle_radius": "um"})
    >>> found.table["normalized_area"].round(1).tolist(), found.reasons()
    ([24.9, 24.9], {'outcome not known': 1})
    """
    frame, name = _frame(source, sheet=sheet, header_row=header_row, encoding=encoding)
    places = find_columns(frame, columns or {}, units or {})
    values = _values(frame, places, constants or {})
    checks = RowChecks(frame, places)
    broke = checks.outcomes(broke_is)
    checks.accepted()
    for quantity, column in values.items():
        checks.possible(quantity, column)
    _derive(values)
    for quantity, (needed, _) in _DERIVED.items():
        for part in needed:
            checks.lacking(quantity, part, values)
    for quantity in _REQUIRED:
        checks.known(quantity, values[quantity])
    table = _table(frame, places, values, broke, name, checks.kept)
    repeated = table.duplicated([*_REQUIRED, "broke", "source", "area_um2", "contact_time_s"])
    return ImportedCollisions(table, checks.set_aside(), len(frame), int(repeated.sum()))


def checked_collisions(
    table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str], stacklevel: int = 3
) -> ImportedCollisions:
    """Return collisions as they were imported, or import them and warn of what is set aside."""
    if isinstance(table, ImportedCollisions):
        imported = table
    else:
        imported = import_collisions(table)
        imported.warn(stacklevel=stacklevel)
    if not len(imported.table):
        reasons = "; ".join(f"{reason} ({n})" for reason, n in imported.reasons().items())
        got = f"none of {imported.count}: {reasons}"
        advice = "correct the values, or give what is missing, as a column or for all rows"
        raise InputError.of("table", "a table with rows that can be used", got, advice)
    return imported


def _frame(
    source: pd.DataFrame | str | os.PathLike[str], **how: str | int | None
) -> tuple[pd.DataFrame, str]:
    if isinstance(source, (str, os.PathLike)):
        return read_table(source, **how), Path(source).name  # type: ignore[arg-type]
    import pandas as pd

    if not isinstance(source, pd.DataFrame):
        advice = "give a DataFrame or the name of a file"
        raise InputError.of("table", "a table of collisions", source, advice)
    if source.empty:
        raise InputError.of("table", "a table with rows", "none", "give collisions")
    return source, "table"


def _values(
    frame: pd.DataFrame, places: Mapping[str, Place], constants: Mapping[str, str]
) -> dict[str, Floats]:
    values = {
        name: numbers_of(frame, name, place) for name, place in places.items() if name in QUANTITIES
    }
    for name, text in constants.items():
        if name not in QUANTITIES:
            raise unknown_name(name, "a quantity that can be imported", name, QUANTITIES)
        if name in places and np.isfinite(values[name]).any():
            got = f"{text} beside the column {places[name].column!r}"
            raise InputError.of(name, "given once", got, "drop one of them")
        values[name] = np.full(len(frame), constant_of(name, text))
    return values


def _derive(values: dict[str, Floats]) -> None:
    """Fold S, and fill in what follows from other columns where it is not given.

    Raises
    ------
    InputError
        There is nothing that gives Ca, Ã or z̃.
    """
    if "diameter" in values:
        _fill(values, "area", math.pi / 4.0 * values["diameter"] ** 2)
    if "first_daughter_area" in values and "second_daughter_area" in values:
        both = np.stack([values["first_daughter_area"], values["second_daughter_area"]])
        _fill(values, "daughter_area_ratio", both.min(axis=0) / both.max(axis=0))
    for name, (needed, formula) in _DERIVED.items():
        if all(column in values for column in needed):
            _fill(values, name, formula(*(values[column] for column in needed)))
        elif name not in values:
            missing = [column for column in needed if column not in values]
            rule = f"a column, or follow from {', '.join(needed)}"
            advice = "say which columns they are, or give what is the same in all rows"
            raise InputError.of(name, rule, f"no {' and no '.join(missing)}", advice)
    symmetry = values["symmetry"]
    values["symmetry"] = np.where(symmetry > 1.0, 2.0 - symmetry, symmetry)


def _fill(values: dict[str, Floats], name: str, derived: Floats) -> None:
    given = values.get(name)
    values[name] = derived if given is None else np.where(np.isnan(given), derived, given)


def _table(
    frame: pd.DataFrame,
    places: Mapping[str, Place],
    values: Mapping[str, Floats],
    broke: Floats,
    name: str,
    kept: NDArray[np.bool_],
) -> pd.DataFrame:
    """Return the rows that are kept, in our form."""
    columns: dict[str, NDArray[Any]] = {
        QUANTITIES[quantity].column: column[kept] for quantity, column in values.items()
    }
    columns["broke"] = broke[kept] > 0
    columns["source"] = np.full(int(kept.sum()), name, dtype=object)
    if "source" in places:
        columns["source"] = frame[places["source"].column].to_numpy(dtype=object)[kept]
    columns["collision_id"] = np.flatnonzero(kept)
    columns["breakup_number"] = breakup_number_of(columns)
    return measured_table(columns)
