"""The collisions that a fit can use, as logarithms, in an order of their own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pinchoff.collisions.reasons import NO_SYMMETRY, OUTCOME_UNKNOWN, REJECTED, not_measured
from pinchoff.fits.form import EXPONENTS, Form
from pinchoff.fits.likelihood import Floats
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

GROUPS = ("capillary_number", "normalized_area", "normalized_thickness")
"""Columns whose product is Ca Ã z̃."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Collisions for a fit.

    Attributes
    ----------
    features : ndarray, shape (n, k)
        1, ln(Ca Ã z̃), ln S and those of the free exponents, as of `pinchoff.fits.form.Form`.
    broke : ndarray of bool, shape (n,)
    symmetry : ndarray, shape (n,)
        S.
    places : ndarray of int, shape (n,)
        Their rows in the table, from 0.
    left_out : dict of str to int
        How many collisions are not used, by the reason.
    """

    features: Floats
    broke: NDArray[np.bool_]
    symmetry: Floats
    places: NDArray[np.intp]
    left_out: dict[str, int]

    def __len__(self) -> int:
        return len(self.broke)


def rows_of(table: pd.DataFrame, form: Form) -> Rows:
    """Gather what a fit needs from a table that `pinchoff.import_collisions` returned.

    The rows are sorted by their numbers, so that their order in the table does not show in any
    digit of a result. Refused are a table that lacks a column, outcomes that are all the same, and
    rows that do not decide the exponents.
    """
    exponents = [EXPONENTS[name] for name in form.free]
    columns = [*GROUPS, "symmetry", *(exponent.column for exponent in exponents)]
    values = {name: _column(table, name) for name in dict.fromkeys(columns)}
    broke = table["broke"].to_numpy(dtype=np.float64, na_value=math.nan)
    used, left_out = _used(table, values, broke)
    logs = {name: np.log(column[used]) for name, column in values.items()}
    forcing = logs[GROUPS[0]] + logs[GROUPS[1]] + logs[GROUPS[2]]
    free = [
        exponent.sign * (logs[exponent.column] - math.log(exponent.reference))
        for exponent in exponents
    ]
    features = np.stack([np.ones_like(forcing), forcing, logs["symmetry"], *free], axis=1)
    outcome = broke[used] > 0
    order = np.lexsort((outcome, *features.T))
    symmetry, places = values["symmetry"][used], np.flatnonzero(used)
    rows = Rows(features[order], outcome[order], symmetry[order], places[order], left_out)
    _require_both_outcomes(rows)
    _require_rank(rows, form)
    return rows


def _column(table: pd.DataFrame, name: str) -> Floats:
    if name not in table.columns:
        raise InputError.of("table", f"one with the column {name}", "a table without it", "add it")
    return table[name].to_numpy(dtype=np.float64, na_value=math.nan)


def _used(
    table: pd.DataFrame, values: dict[str, Floats], broke: Floats
) -> tuple[NDArray[np.bool_], dict[str, int]]:
    """Return which rows can be used, and a count of the others by reason."""
    used = np.ones(len(table), dtype=bool)
    left_out: dict[str, int] = {}

    def leave_out(which: NDArray[np.bool_], reason: str) -> None:
        fresh = used & which
        if fresh.any():
            left_out[reason] = int(fresh.sum())
            used[fresh] = False

    leave_out(~table["accepted"].to_numpy(dtype=bool), REJECTED)
    leave_out(np.isnan(broke), OUTCOME_UNKNOWN)
    for name, column in values.items():
        leave_out(np.isnan(column), not_measured(name))
    leave_out(values["symmetry"] == 0, NO_SYMMETRY)
    return used, left_out


def _require_both_outcomes(rows: Rows) -> None:
    count, broke = len(rows), int(rows.broke.sum())
    if 0 < broke < count:
        return
    rule = "collisions of which some broke and some did not"
    if not count:
        reasons = "; ".join(f"{number}: {reason}" for reason, number in rows.left_out.items())
        got = f"none that can be used ({reasons})" if reasons else "none"
    else:
        got = f"{count} that all {'broke' if broke else 'did not break'}"
    raise InputError.of("table", rule, got, "add others: one outcome has no boundary")


def _require_rank(rows: Rows, form: Form) -> None:
    """Refuse collisions that do not differ enough to decide every coefficient."""
    spread = rows.features[:, 1:] - rows.features[:, 1:].mean(axis=0)
    names = ["Ca Ã z̃", "S", *(EXPONENTS[name].column for name in form.free)]
    for k, name in enumerate(names):
        if np.ptp(spread[:, k]) < 1e-9:
            rule = f"collisions that differ in {name}"
            advice = "add others" if k < 2 else f"leave {form.free[k - 2]} out of free"
            raise InputError.of("table", rule, "one value in all rows", advice)
    if np.linalg.matrix_rank(spread / spread.std(axis=0), tol=1e-6 * math.sqrt(len(rows))) < len(
        names
    ):
        rule = f"collisions that differ in {', '.join(names)} independently of each other"
        raise InputError.of("table", rule, "a relation between them", "leave more exponents at 1")
