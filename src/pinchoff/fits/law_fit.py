"""The break-up law fitted to collisions by maximum likelihood."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pinchoff.collisions.importing import ImportedCollisions, checked_collisions
from pinchoff.collisions.reasons import NO_SYMMETRY
from pinchoff.fits.fitted_law import LawFit
from pinchoff.fits.form import Form, free_names
from pinchoff.fits.intervals import Optimum
from pinchoff.fits.likelihood import Constraint, Floats, LogisticLikelihood, maximum
from pinchoff.fits.noise import NoisyLikelihood
from pinchoff.fits.rows import Rows, rows_of
from pinchoff.fits.separation import Gap, widest_gap
from pinchoff.support.arguments import checked_confidence, checked_number
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    import pandas as pd


FEW_ROWS = 20
"""Fewer collisions than this come with a warning."""

_FEW_PER_COEFFICIENT = 10  # rarer outcomes for each coefficient, below which a fit warns
_NARROWEST = 1e-3  # w at which the search for its upper bound begins


def fit_law(
    table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str],
    *,
    free: str | Sequence[str] = (),
    symmetry_noise: float = 0.0,
    confidence: float = 0.95,
) -> LawFit:
    """Fit the break-up law to collisions by maximum likelihood [paper, section 4.2].

    Parameters
    ----------
    table : DataFrame, ImportedCollisions or path
        Collisions, from simulations, videos or anywhere; checked by
        `pinchoff.import_collisions` unless that returned them.
    free : str or sequence of str, optional
        Quantities whose exponents are fitted instead of 1: "area", "thickness" (the radius's
        follows from 2ε1 + ε2 + ε3 = 0), "viscosity", "surface_tension", "speed". "radius" drops
        that condition, and frees area and thickness too; a thickness that the rows cannot tell
        from the radius keeps the exponent 1. It shows whether a hidden length is at work.
    symmetry_noise : float, optional
        Standard error of S, such as the paper's 0.088, for which the fit then accounts; 0: none.
    confidence : float, optional
        Of the intervals.

    Returns
    -------
    LawFit

    Raises
    ------
    InputError
        An argument is wrong; all outcomes are the same; the rows do not decide an exponent; or
        break-up does not get likelier with both Ca Ã z̃ and S, so that there is no such law.

    Warns
    -----
    UserWarning
        Rows were set aside or left out, or there are so few that the intervals are wide.

    Examples
    --------
    >>> import pinchoff as po
    >>> fit = po.fit_law(po.virtual_experiment(seed=1, n=2000, symmetry_noise=0))
    >>> print(f"{fit.alpha.value:.3f} {fit.beta.value:.2f} {fit.w.value:.2f}")
    0.086 -0.73 0.08
    """
    confidence = checked_confidence(confidence)
    advice = "use 0.088, or 0 for none"
    symmetry_noise = checked_number("symmetry_noise", symmetry_noise, advice, low=0.0, high=0.5)
    imported = checked_collisions(table)
    form = Form(_freed(imported.table, free_names(free)))
    rows = rows_of(imported.table, form)
    found = _found_noisy(rows, form, symmetry_noise) if symmetry_noise else _found_plain(rows, form)
    fit = LawFit(
        free=form.free,
        confidence=confidence,
        count=len(rows),
        broke_count=int(rows.broke.sum()),
        left_out=rows.left_out,
        log_likelihood=found.best.value,
        symmetry_noise=float(symmetry_noise),
        step=found.step,
        gap=found.gap,
        synthetic=imported.synthetic,
        used=imported.table.iloc[np.sort(rows.places)],
        _found=found,
    )
    _warn_of_few(fit)
    _warn_of_left_out(fit)
    return fit


def _freed(table: pd.DataFrame, free: tuple[str, ...]) -> tuple[str, ...]:
    """Return the free quantities; the radius frees area and, if rows decide it, thickness."""
    if "radius" not in free:
        return free
    everything = free_names((*free, "area", "thickness"))
    try:
        rows_of(table, Form(everything))
    except InputError:
        return free_names((*free, "area"))
    return everything


def _found_plain(rows: Rows, form: Form) -> Optimum:
    likelihood = LogisticLikelihood(rows.features, rows.broke)
    best = maximum(likelihood)
    gap = Gap(best.coefficients, -1.0)
    if best.doubtful:
        gap = widest_gap(rows.features, rows.broke, best.coefficients)
    if gap.half_width < 0:
        values = _require_law(form.scaled(best.coefficients), best.coefficients)
        return Optimum(form, likelihood, best, values)
    values = _require_law(form.scaled(gap.coefficients), gap.coefficients)
    del values["w"]
    step = (
        "a line separates the collisions that broke from the others without exception; "
        f"the nearest to it are a factor {math.exp(min(gap.half_width, 100.0)):.4g} in Bk away"
    )
    return Optimum(form, likelihood, best, values, step, gap.half_width, (), _NARROWEST)


def _found_noisy(rows: Rows, form: Form, symmetry_noise: float) -> Optimum:
    plain = maximum(LogisticLikelihood(rows.features, rows.broke))
    likelihood = NoisyLikelihood(rows.features, rows.symmetry, rows.broke, symmetry_noise)
    best = maximum(likelihood, start=None if plain.doubtful else plain.free)
    narrowest = likelihood.narrowest
    values = _require_law(form.scaled(best.coefficients), best.coefficients)
    if not best.doubtful and values["w"] > math.log(narrowest):
        return Optimum(form, likelihood, best, values, narrowest=narrowest)
    held = (form.equation("w", math.log(narrowest)),)
    constraint = Constraint.of(held)
    near = best.coefficients / (narrowest * best.coefficients[1])
    best = maximum(likelihood, constraint, constraint.nearest(near))
    values = _require_law(form.scaled(best.coefficients), best.coefficients)
    del values["w"]
    step = f"noise of {symmetry_noise:g} in S explains all of the overlap"
    return Optimum(form, likelihood, best, values, step, math.nan, held, narrowest)


def _require_law(values: dict[str, float], coefficients: Floats) -> dict[str, float]:
    if all(map(math.isfinite, values.values())):
        return values
    _, forcing, symmetry = coefficients[:3].tolist()
    raise InputError.of(
        "table",
        "collisions that break more often at larger Ca Ã z̃ and at larger S",
        f"slopes {forcing:.3g} with ln(Ca Ã z̃) and {symmetry:.3g} with ln S",
        "check the columns and their units, or add collisions",
    )


def _warn_of_left_out(fit: LawFit) -> None:
    """Warn of collisions with S = 0, which have no logarithm."""
    count = fit.left_out.get(NO_SYMMETRY, 0)
    if count:
        rows = counted(count, "collision") + (" is" if count == 1 else " are")
        warnings.warn(f"{rows} left out: {NO_SYMMETRY}", UserWarning, stacklevel=3)


def _warn_of_few(fit: LawFit) -> None:
    rarer = min(fit.broke_count, fit.count - fit.broke_count)
    if fit.count >= FEW_ROWS and (fit.step or rarer >= _FEW_PER_COEFFICIENT * fit._found.form.size):
        return
    beta = fit.beta
    wide = f"{beta.high - beta.low:.3g} wide" if math.isfinite(beta.low) else "without an end"
    many = f"{fit.count} collisions, {fit.broke_count} of which broke, are few"
    warnings.warn(
        f"{many}: the {fit.confidence:.0%} interval of β is {beta.low:.3g} to {beta.high:.3g}, "
        f"{wide}",
        UserWarning,
        stacklevel=3,
    )
