"""The fitted break-up law: its numbers with their intervals, and what it predicts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.collisions.law import ARGUMENTS, Line, breakup_number_of, breakup_probability
from pinchoff.fits.form import EXPONENTS, LOGARITHMIC, MEANINGS
from pinchoff.fits.intervals import (
    PROFILE,
    Bootstrap,
    Optimum,
    bootstrap,
    delta_intervals,
    profile_intervals,
    scaled_errors,
    upper_bound_of_width,
)
from pinchoff.support.drawing import Drawable
from pinchoff.support.errors import InputError
from pinchoff.support.interval import Estimate
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    from pinchoff.support.progress import Show

_MOST_OF_FIRST_ORDER = 0.5  # largest standard error of a logarithm for which first order is enough


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LawFit(Drawable):
    """The break-up law, P(break) = x/(1 + x) with x = Bk^(1/w), fitted to collisions.

    Attributes
    ----------
    free : tuple of str
        Quantities whose exponents were free.
    confidence : float
        Of the intervals.
    count, broke_count : int
        Collisions that were used, and those of them that broke.
    left_out : dict of str to int
        Collisions that were not, by the reason.
    log_likelihood : float
        At its greatest; 0 where a line separates the outcomes.
    symmetry_noise : float
        Standard error of S that the fit accounts for.
    step : str
        Empty, or why w = 0: the data do not tell the transition from a step.
    gap : float
        Where a line separates the outcomes, its distance in ln Bk from the nearest collision on
        either side; else NaN.
    synthetic : bool
        Whether there are rows that were drawn rather than simulated or measured.
    used : DataFrame
        The collisions that it was fitted to.
    """

    free: tuple[str, ...]
    confidence: float
    count: int
    broke_count: int
    left_out: dict[str, int]
    log_likelihood: float
    symmetry_noise: float
    step: str
    gap: float
    synthetic: bool
    used: pd.DataFrame
    _found: Optimum

    @cached_property
    def estimates(self) -> dict[str, Estimate]:
        """``alpha``, ``beta``, ``w`` and the free exponents (``epsilon_1``, …).

        The intervals are by the delta method; by the profile likelihood where w = 0, or where a
        logarithm is too uncertain for first order.
        """
        if self.step:
            return self.profile()
        errors = scaled_errors(self._found.form, self._found.best)
        uncertain = max(errors[name] for name in LOGARITHMIC) > _MOST_OF_FIRST_ORDER
        return self.profile() if uncertain else self.delta()

    @property
    def alpha(self) -> Estimate:
        """α, prefactor of the separating line."""
        return self.estimates["alpha"]

    @property
    def beta(self) -> Estimate:
        """β, its exponent."""
        return self.estimates["beta"]

    @property
    def w(self) -> Estimate:
        """w, the width of the transition in ln Bk."""
        return self.estimates["w"]

    @property
    def line(self) -> Line:
        """The separating line; with free exponents, Ã and z̃ in it carry theirs."""
        return Line(self.alpha.value, self.beta.value)

    @property
    def aic(self) -> float:
        """Akaike's information criterion, 2k - 2 ln L."""
        return 2.0 * self._found.form.size - 2.0 * self.log_likelihood

    def breakup_number(self, table: pd.DataFrame) -> NDArray[np.float64]:
        """Return Bk of collisions, shape (n,), with the exponents that were fitted."""
        bk: NDArray[np.float64] = breakup_number_of(
            {name: table[name].to_numpy(dtype=np.float64) for name in ARGUMENTS}, line=self.line
        )
        for name in self.free:
            exponent = EXPONENTS[name]
            relative = table[exponent.column].to_numpy(dtype=np.float64) / exponent.reference
            power = self.estimates[exponent.key].value - exponent.held
            bk = bk * relative ** (exponent.sign * power)
        return bk

    def probability(self, breakup_number: ArrayLike) -> NDArray[np.float64]:
        """Return the probability of break-up at Bk, shape (...); a step where w = 0.

        Examples
        --------
        >>> import pinchoff as po
        >>> fit = po.fit_law(po.virtual_experiment(1, 2000, symmetry_noise=0))
        >>> float(fit.probability(1.0))
        0.5
        """
        return breakup_probability(breakup_number, max(self.w.value, 1e-12))

    def predict(self, table: pd.DataFrame) -> NDArray[np.float64]:
        """Return the probability that collisions break, shape (n,); NaN where S is not known.

        Parameters
        ----------
        table : DataFrame
            With the columns of Ca, Ã, S and z̃, as of `breakup_number`, and those of free
            exponents.

        Raises
        ------
        InputError
            A column is missing.

        Examples
        --------
        >>> import pinchoff as po
        >>> fit = po.fit_law(po.virtual_experiment(seed=1, n=2000, symmetry_noise=0))
        >>> fit.predict(po.simulate_many([po.Parameters(offset=y) for y in (0, 0.2)])).round(2)
        array([1., 0.])
        """
        needed = [*ARGUMENTS, *(EXPONENTS[name].column for name in self.free)]
        for name in needed:
            if name not in table:
                rule = f"one with the columns {', '.join(needed)}"
                raise InputError.of("table", rule, f"a table without {name}", "add it")
        return self.probability(self.breakup_number(table))

    def summary(self) -> pd.DataFrame:
        """Return a table of the fitted numbers: a row each, with its interval.

        Returns
        -------
        DataFrame
            Columns ``value``, ``low``, ``high``, ``interval`` (the method) and ``meaning``; the
            index is the names of `estimates`.

        Examples
        --------
        >>> import pinchoff as po
        >>> fit = po.fit_law(po.virtual_experiment(1, 2000, symmetry_noise=0))
        >>> print(fit.summary())  # doctest: +SKIP
        """
        import pandas as pd

        rows = [
            {**estimate._asdict(), "meaning": MEANINGS[name]}
            for name, estimate in self.estimates.items()
        ]
        table = pd.DataFrame(rows, index=list(self.estimates))
        return table.rename(columns={"method": "interval"})

    def plot(self, axes: Any = None, *, kind: str = "probability") -> Any:
        """Draw the law and the collisions that it was fitted to.

        Parameters
        ----------
        axes : Axes, or 3 Axes for outcomes, optional
            Where to draw; by default a new figure, which a notebook shows.
        kind : {"probability", "outcomes"}, optional
            The share of broken collisions against Bk, or S against Ca Ã z̃ by outcome.

        Returns
        -------
        Axes or list of Axes
        """
        return self._drawn(axes, kind=kind)

    def delta(self) -> dict[str, Estimate]:
        """Return intervals by the delta method.

        Raises
        ------
        InputError
            The outcomes do not overlap: the likelihood has no curvature.
        """
        self._require_maximum("delta")
        return delta_intervals(self._found.form, self._found.best, self.confidence)

    def profile(self) -> dict[str, Estimate]:
        """Return intervals by the profile likelihood; where w = 0, an upper bound of it.

        Examples
        --------
        >>> import pinchoff as po
        >>> fit = po.fit_law(po.virtual_experiment(1, 2000, symmetry_noise=0))
        >>> fit.profile()["beta"].low < -0.74 < fit.profile()["beta"].high
        True
        """
        if self.step:
            steps = dict.fromkeys(self._found.values, max(0.01, self.gap if self.gap > 0 else 0.0))
        else:
            steps = scaled_errors(self._found.form, self._found.best)
        found = profile_intervals(self._found, steps, self.confidence)
        if self.step:
            found["w"] = self._bound()
        return {name: found[name] for name in self._found.form.names}

    def bootstrap(
        self,
        *,
        samples: int = 100,
        fraction: float = 0.5,
        seed: int = 0,
        progress: Show | None = None,
    ) -> Bootstrap:
        """Fit random parts of the collisions [paper, section 4.2].

        Parameters
        ----------
        samples : int, optional
            Parts; the paper takes 100.
        fraction : float, optional
            Of the collisions in a part; the paper takes half.
        seed : int, optional
        progress : callable, optional
            Called with the number of parts that are done.

        Raises
        ------
        InputError
            An argument is wrong, the outcomes do not overlap, or most parts have no fit.

        Examples
        --------
        >>> import pinchoff as po
        >>> fit = po.fit_law(po.virtual_experiment(1, 2000, symmetry_noise=0))
        >>> parts = fit.bootstrap(samples=10)
        >>> parts.samples, parts.failed
        (10, 0)
        """
        self._require_maximum("bootstrap")
        return bootstrap(
            self._found,
            self.count,
            samples=samples,
            fraction=fraction,
            seed=seed,
            confidence=self.confidence,
            show=progress,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold, but for infinite ends of intervals."""
        return {
            **{name: estimate._asdict() for name, estimate in self.estimates.items()},
            "free": list(self.free),
            "confidence": self.confidence,
            "count": self.count,
            "broke_count": self.broke_count,
            "left_out": self.left_out,
            "log_likelihood": self.log_likelihood,
            "aic": self.aic,
            "symmetry_noise": self.symmetry_noise,
            "why_w_is_0": self.step,
            "synthetic": self.synthetic,
        }

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name} = {estimate}" for name, estimate in self.estimates.items())
        return f"<LawFit to {counted(self.count, 'collision')}: {numbers}>"

    def _bound(self) -> Estimate:
        guess = math.log(max(self._found.narrowest, self.gap / 5.0 if self.gap > 0 else 0.0))
        high = upper_bound_of_width(self._found, guess, self.confidence)
        return Estimate(0.0, 0.0, high, f"{PROFILE}, upper bound")

    def _require_maximum(self, method: str) -> None:
        if self.step:
            rule = "left out where the data do not tell the transition from a step"
            raise InputError.of(method, rule, self.step, "use the profile likelihood")
