"""Everything that can be said about a table of collisions and the law: one call for commands."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pinchoff.collisions.importing import ImportedCollisions, checked_collisions
from pinchoff.fits.fitted_law import LawFit
from pinchoff.fits.intervals import BOOTSTRAP, DELTA, PROFILE, require_parts
from pinchoff.fits.law_comparison import compare_laws
from pinchoff.fits.law_fit import fit_law
from pinchoff.support.errors import InputError
from pinchoff.support.interval import Estimate
from pinchoff.support.progress import Show

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class LawStudy:
    """A fit, its intervals in every way, and how it compares with other laws.

    Attributes
    ----------
    collisions : ImportedCollisions
    fit : LawFit
    intervals : dict of str to dict of str to Estimate
        By method, then by number; a method that the data do not allow is not there.
    spread : dict of str to float
        Of the bootstrap's parts, as the paper quotes it; empty without a bootstrap.
    samples, fraction, seed
        Of the bootstrap.
    comparison : DataFrame or None
        What `compare_laws` returns.
    missing : dict of str to str
        Why a method or the comparison is not there.
    """

    collisions: ImportedCollisions
    fit: LawFit
    intervals: dict[str, dict[str, Estimate]]
    spread: dict[str, float]
    samples: int
    fraction: float
    seed: int
    comparison: pd.DataFrame | None
    missing: dict[str, str]

    @property
    def estimates(self) -> dict[str, Estimate]:
        """The numbers of the law with the intervals of the profile likelihood."""
        return self.intervals[PROFILE]

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold; an end of an interval may be infinite."""
        return {
            **{name: estimate._asdict() for name, estimate in self.estimates.items()},
            **{k: v for k, v in self.fit.to_dict().items() if k not in self.estimates},
            "set_aside": self.collisions.reasons(),
            "intervals": {
                method: {name: list(estimate[:3]) for name, estimate in numbers.items()}
                for method, numbers in self.intervals.items()
            },
            "bootstrap": {
                "samples": self.samples,
                "fraction": self.fraction,
                "seed": self.seed,
                "spread": self.spread,
            },
            "missing": self.missing,
        }


def study_law(
    table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str],
    *,
    free: str | Sequence[str] = (),
    symmetry_noise: float = 0.0,
    confidence: float = 0.95,
    samples: int = 100,
    fraction: float = 0.5,
    seed: int = 0,
    progress: Show | None = None,
) -> LawStudy:
    """Fit the law, find its intervals in three ways, and compare it with other laws.

    Arguments and refusals are those of `pinchoff.fit_law` and of `LawFit.bootstrap`.
    """
    collisions = checked_collisions(table)
    fit = fit_law(collisions, free=free, symmetry_noise=symmetry_noise, confidence=confidence)
    require_parts(samples, fraction, fit.count)
    intervals = {PROFILE: fit.profile()}
    missing: dict[str, str] = {}
    spread: dict[str, float] = {}
    comparison = None
    if fit.step:
        missing[DELTA] = missing[BOOTSTRAP] = f"w = 0: {fit.step}"
    else:
        intervals[DELTA] = fit.delta()
        try:
            found = fit.bootstrap(samples=samples, fraction=fraction, seed=seed, progress=progress)
            intervals[BOOTSTRAP], spread = found.estimates, found.spread
        except InputError as error:  # too few collisions to draw parts from
            missing[BOOTSTRAP] = str(error)
    try:
        comparison = compare_laws(collisions)
    except InputError as error:
        missing["comparison"] = str(error)
    return LawStudy(
        collisions, fit, intervals, spread, samples, fraction, seed, comparison, missing
    )
