"""Which quantities the data need: nested laws side by side, by likelihood ratio and AIC."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinchoff.collisions.importing import ImportedCollisions, checked_collisions
from pinchoff.fits.form import EXPONENTS, Form
from pinchoff.fits.likelihood import Constraint, Equation, LogisticLikelihood, maximum
from pinchoff.fits.rows import rows_of
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = {
    "law": "",
    "claim": "",
    "parameters": "1",
    "log_likelihood": "1",
    "aic": "1",
    "delta_aic": "1",
    "likelihood_ratio": "1",
    "freedom": "1",
    "p_value": "1",
}
"""Columns of the comparison and their units."""


class _Law(NamedTuple):
    """A law that is the full one with some numbers fixed."""

    name: str
    claim: str
    equations: list[Equation]


def compare_laws(table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str]) -> pd.DataFrame:
    """Fit the law with every exponent free that the data can decide, and simpler laws.

    The table is as `pinchoff.fit_law` takes it.

    Returns
    -------
    DataFrame
        One row per law, the full one first: ``law``; ``claim``, in words; ``parameters``;
        ``log_likelihood``; ``aic`` and its distance ``delta_aic`` from the least;
        ``likelihood_ratio``, 2 ln of the full law's likelihood over this one's, which is χ²
        distributed with ``freedom`` if the law is true, and the ``p_value`` of that: a small one
        speaks against the law.

    Raises
    ------
    InputError
        As `pinchoff.fit_law`; or the outcomes do not overlap.

    Examples
    --------
    >>> import pinchoff as po
    >>> laws = compare_laws(po.virtual_experiment(seed=1, n=2000, symmetry_noise=0))
    >>> bool(laws.set_index("law").loc["without symmetry", "p_value"] < 1e-6)
    True
    """
    import pandas as pd
    from scipy.stats import chi2

    imported = checked_collisions(table)
    form = Form(_decided(imported.table))
    rows = rows_of(imported.table, form)
    likelihood = LogisticLikelihood(rows.features, rows.broke)
    best = maximum(likelihood)
    if best.doubtful:
        rule = "collisions whose outcomes overlap"
        advice = "laws cannot be compared where several fit without an exception"
        raise InputError.of("table", rule, "outcomes that a line separates", advice)
    found = []
    for law in _laws(form):
        constraint = Constraint.of(law.equations) if law.equations else None
        start = constraint.nearest(best.coefficients) if constraint else best.free
        value = maximum(likelihood, constraint, start).value
        freedom = len(law.equations)
        ratio = max(0.0, 2.0 * (best.value - value))
        p_value = float(chi2.sf(ratio, freedom)) if freedom else math.nan
        size = form.size - freedom
        aic = 2.0 * size - 2.0 * value
        found.append((law.name, law.claim, size, value, aic, 0.0, ratio, freedom, p_value))
    frame = pd.DataFrame(found, columns=list(COLUMNS))
    frame["delta_aic"] = frame["aic"] - frame["aic"].min()
    frame.attrs["units"] = dict(COLUMNS)
    return frame


def _decided(table: pd.DataFrame) -> tuple[str, ...]:
    """Return the quantities whose exponents the rows can tell from the others."""
    free: list[str] = []
    for name in ("area", "thickness", "viscosity", "radius"):
        if EXPONENTS[name].column not in table:
            continue
        values = table[EXPONENTS[name].column].to_numpy(dtype=np.float64, na_value=math.nan)
        if np.isfinite(values).all() and np.ptp(values) > 1e-9 * np.abs(values).max():
            try:
                rows_of(table, Form((*free, name)))
            except InputError:
                continue
            free.append(name)
    return tuple(free)


def _laws(form: Form) -> list[_Law]:
    """Return the full law, the paper's, and those in which one quantity does not matter."""
    exponents = [EXPONENTS[name] for name in form.free]
    symbols = [exponent.symbol for exponent in exponents]
    laws = [_Law("full", f"{', '.join(symbols) or 'no exponents'} free", [])]
    paper = [form.equation(exponent.key, exponent.held) for exponent in exponents]
    if paper:
        ones = " = ".join(e.symbol for e in exponents if e.held)
        zero = ", 2ε1 + ε2 + ε3 = 0" if "radius" in form.free else ""
        laws.append(_Law("paper", f"{ones} = 1{zero}", paper))
    for name, exponent, equation in zip(form.free, exponents, paper, strict=True):
        if len(paper) > 1:
            claim = f"{exponent.symbol} = {exponent.held:g}"
            laws.append(_Law(f"{name} as in the paper", claim, [equation]))
    for name, exponent in zip(form.free, exponents, strict=True):
        if name != "radius":
            equation = form.equation(exponent.key, 0.0)
            laws.append(_Law(f"without {name}", f"{exponent.symbol} = 0", [equation]))
    if {"area", "thickness"} <= {*form.free} or "radius" in form.free:
        laws.append(_Law("without radius", "ε2 = 0", [form.equation("epsilon_2", 0.0)]))
    laws.append(_Law("without symmetry", "S does not matter", [form.without_symmetry()]))
    return laws
