"""Confidence intervals of the numbers of the law: delta method, profile likelihood, bootstrap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from pinchoff.fits.form import Form, unscaled
from pinchoff.fits.likelihood import Constraint, Equation, Floats, Likelihood, Maximum, maximum
from pinchoff.support.arguments import checked_whole
from pinchoff.support.errors import InputError
from pinchoff.support.interval import Estimate
from pinchoff.support.progress import Show

DELTA = "delta method"
PROFILE = "profile likelihood"
BOOTSTRAP = "bootstrap"

_FARTHEST = 40.0  # from the value, in logarithms and exponents: ends are not sought farther away
_PRECISION = 1e-4  # of the ends of a profile's interval, relative to its half width


class Optimum(NamedTuple):
    """The maximum of the likelihood, or a substitute where there is none.

    The numbers in ``values`` are on the scale of `Form.scaled`, w among them unless there is a
    step. The equations in ``held`` hold of the coefficients throughout. ``narrowest`` is the least
    w that the likelihood resolves; an interval that goes on below ends at 0.
    """

    form: Form
    likelihood: Likelihood
    best: Maximum
    values: dict[str, float]
    step: str = ""
    gap: float = math.nan
    held: tuple[Equation, ...] = ()
    narrowest: float = 0.0


def normal_quantile(confidence: float) -> float:
    """Return z of a two-sided normal interval: 1.96 for 0.95.

    Examples
    --------
    >>> round(normal_quantile(0.95), 4)
    1.96
    """
    return NormalDist().inv_cdf(0.5 + confidence / 2)


def inverse_curvature(best: Maximum) -> Floats:
    """Return the covariance of the coefficients, shape (k, k): the inverse of the curvature."""
    return np.asarray(np.linalg.inv(-best.hessian), dtype=np.float64)


def scaled_errors(form: Form, best: Maximum) -> dict[str, float]:
    """Return the standard error of every number on the scale of `Form.scaled`, to first order."""
    spread = inverse_curvature(best)
    gradients = form.gradients(best.coefficients)
    return {name: math.sqrt(row @ spread @ row) for name, row in gradients.items()}


def delta_intervals(form: Form, best: Maximum, confidence: float) -> dict[str, Estimate]:
    """Carry the covariance of the coefficients over to the numbers of the law, to first order."""
    reach = normal_quantile(confidence)
    errors = {name: reach * error for name, error in scaled_errors(form, best).items()}
    return {
        name: _estimate(name, value, errors[name], errors[name], DELTA)
        for name, value in form.scaled(best.coefficients).items()
    }


def profile_intervals(
    found: Optimum, steps: dict[str, float], confidence: float
) -> dict[str, Estimate]:
    """Return where the likelihood, at its greatest over all other numbers, is not too small.

    Twice the difference of the log-likelihoods is at most the quantile of χ² with one degree of
    freedom. The steps are a first guess of the standard errors.
    """
    reach = normal_quantile(confidence)
    intervals = {}
    for name, value in found.values.items():
        root = _DevianceRoot(found, name, found.held)
        bounded = name == "w" and found.narrowest
        below = value - math.log(found.narrowest) if bounded else _FARTHEST
        down = _distance(root, value, -steps[name], reach, below)
        up = _distance(root, value, steps[name], reach, _FARTHEST)
        intervals[name] = _estimate(name, value, down, up, PROFILE)
    return intervals


class _DevianceRoot:
    """The root of the deviance along one number; nearly proportional to the distance."""

    def __init__(self, found: Optimum, name: str, held: Sequence[Equation] = ()) -> None:
        self._found, self._name, self._held = found, name, held
        self._near = found.best.coefficients  # of the last place: the next one is not far

    def at(self, scaled: float) -> float:
        equation = self._found.form.equation(self._name, scaled)
        constraint = Constraint.of([equation, *self._held])
        near = self._near
        if self._name == "w":  # the width never turns a line around
            near = near * (math.exp(-scaled) / near[1])
        start = constraint.nearest(near)
        highest = maximum(self._found.likelihood, constraint, start)
        self._near = highest.coefficients
        return math.sqrt(max(0.0, 2.0 * (self._found.best.value - highest.value)))


def _distance(
    root: _DevianceRoot, value: float, step: float, reach: float, farthest: float
) -> float:
    """Return how far from `value`, towards `step`, the root of the deviance is `reach`.

    Infinite where it stays below that, up to `farthest`.
    """
    from scipy.optimize import brentq  # slow to import

    def above(distance: float) -> float:
        return root.at(value + math.copysign(distance, step)) - reach

    inside, outside = 0.0, min(reach * abs(step), farthest)
    while (height := above(outside)) < 0:
        if outside >= farthest:
            return math.inf
        # In proportion, or by doubling where it is flat since the likelihood has no maximum.
        grown = 1.05 * outside * min(reach / max(height + reach, 0.5 * reach), 2.0)
        inside, outside = outside, min(grown, farthest)
    try:
        return float(brentq(above, inside, outside, xtol=_PRECISION * abs(step), rtol=_PRECISION))
    except ValueError:  # no change of sign: the likelihood has no maximum to follow
        rule = "collisions that decide the law's constants"
        advice = "add others, or use no symmetry_noise"
        raise InputError.of("table", rule, "a likelihood without a clear maximum", advice) from None


def upper_bound_of_width(found: Optimum, guess: float, confidence: float) -> float:
    """Return the largest w that the collisions allow, for fits that give w = 0.

    One-sided: the deviance is at most the square of the normal quantile of `confidence`. At least
    exp(guess).
    """
    from scipy.optimize import brentq

    reach = normal_quantile(2.0 * confidence - 1.0)
    root = _DevianceRoot(found, "w")
    low, high = guess, guess
    if root.at(low) > reach:
        return math.exp(guess)
    while root.at(high) < reach:
        if high > guess + _FARTHEST:
            return math.inf
        high += 1.0
    return math.exp(brentq(lambda scaled: root.at(scaled) - reach, low, high, xtol=1e-5))


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """Fits to random parts of the collisions.

    Attributes
    ----------
    estimates : dict of str to Estimate
        Intervals for all collisions: the spread of the parts, scaled to the size of the whole.
    spread : dict of str to float
        Standard deviation of each number over the parts, which the paper quotes.
    samples, failed : int
        Parts drawn, and those among them without a fit.
    size : int
        Collisions in a part.
    """

    estimates: dict[str, Estimate]
    spread: dict[str, float]
    samples: int
    failed: int
    size: int


def bootstrap(
    found: Optimum,
    count: int,
    *,
    samples: int,
    fraction: float,
    seed: int,
    confidence: float,
    show: Show | None = None,
) -> Bootstrap:
    """Fit random parts of n collisions, each drawn without replacement.

    The variance of fits to m of n collisions about the fit to all is (n - m)/m times that of the
    fit to all: for half of them, the paper's choice, the two are equal. Here n is `count`, and m/n
    the `fraction`. Refused if more than half of the parts have no fit.
    """
    require_parts(samples, fraction, count)
    generator = np.random.default_rng(seed)
    size = max(1, round(fraction * count))
    fitted: list[list[float]] = []
    for k in range(samples):
        rows = np.sort(generator.choice(count, size, replace=False))
        part = maximum(found.likelihood.subset(rows), start=found.best.coefficients)
        numbers = list(found.form.scaled(part.coefficients).values())
        if not part.doubtful and all(map(math.isfinite, numbers)):
            fitted.append(numbers)
        if show is not None:
            show(k + 1)
    if len(fitted) <= samples / 2:
        rule = "such that most parts of the collisions can be fitted"
        advice = "raise it, or use the profile likelihood"
        raise InputError.of(
            "fraction", rule, f"{len(fitted)} of {samples} parts with a fit", advice
        )
    parts = np.array(fitted)
    errors = (parts.std(axis=0, ddof=1) * math.sqrt(size / (count - size))).tolist()
    reach = normal_quantile(confidence)
    estimates, spread = {}, {}
    for k, (name, value) in enumerate(found.form.scaled(found.best.coefficients).items()):
        estimates[name] = _estimate(name, value, reach * errors[k], reach * errors[k], BOOTSTRAP)
        spread[name] = float(np.std([unscaled(name, x) for x in parts[:, k].tolist()], ddof=1))
    return Bootstrap(estimates, spread, samples, samples - len(parts), size)


def require_parts(samples: int, fraction: float, count: int) -> None:
    """Refuse a number or a size of a bootstrap's parts that makes none, as `bootstrap` does."""
    checked_whole("samples", samples, "use 100", low=2, high=100_000)
    if not 0.0 < fraction < 1.0 or not 0 < round(fraction * count) < count:
        rule = "between 0 and 1, and a number of collisions less than all"
        raise InputError.of("fraction", rule, fraction, "use 0.5")


def _estimate(name: str, scaled: float, down: float, up: float, method: str) -> Estimate:
    low, high = sorted(unscaled(name, end) for end in (scaled - down, scaled + up))
    return Estimate(unscaled(name, scaled), low, high, method)
