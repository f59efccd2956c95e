r"""Logistic regression: the log-likelihood, its derivatives, and its maximum under constraints.

P(break) = x/(1 + x) with ln x = c·f, where f holds 1 and logarithms of what was measured, is a
logistic regression. Newton's method maximises its likelihood in a few steps, also under the
constraints that profiles need, which here are of the form

.. math:: c = T d + t

statsmodels' ``GLM.fit_constrained`` gives the same maximum, as the tests check, in twelve times the
time. A profile makes hundreds of such fits and a bootstrap of profiles tens of thousands; and the
likelihood with a noisy symmetry (`pinchoff.fits.noise`), which goes through the same search, is no
generalised linear model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Equation: TypeAlias = tuple[Floats, float]
"""(a, b) of a condition a·c = b on the coefficients, a of shape (k,)."""

_MOST_ITERATIONS = 200
_USUAL_ITERATIONS = 25  # Newton's method takes about ten where a maximum exists
_TOLERANCE = 1e-13  # squared Newton decrement at the maximum: about 3e-7 standard errors
_ROUND_OFF = 1e-13  # of the log-likelihood, which is a long sum
_HALVINGS = 30
_LONGEST_STEP = 1e6


class Slope(NamedTuple):
    """A log-likelihood with its derivatives with respect to k coefficients.

    Attributes
    ----------
    value : float
    gradient : ndarray, shape (k,)
    hessian : ndarray, shape (k, k)
    """

    value: float
    gradient: Floats
    hessian: Floats


class Likelihood(Protocol):
    """A log-likelihood of k coefficients."""

    @property
    def size(self) -> int:
        """Number of coefficients, k."""

    def at(self, coefficients: Floats) -> Slope:
        """Return value and derivatives at coefficients, shape (k,)."""

    def subset(self, rows: NDArray[np.intp]) -> Likelihood:
        """Return the likelihood of some of the collisions."""


class Constraint(NamedTuple):
    """Coefficients c = matrix d + offset, with fewer free numbers d.

    Attributes
    ----------
    matrix : ndarray, shape (k, m)
    offset : ndarray, shape (k,)
    """

    matrix: Floats
    offset: Floats

    @classmethod
    def of(cls, equations: Sequence[Equation]) -> Constraint:
        """Return all coefficients that meet some equations."""
        rows = np.stack([row for row, _ in equations])
        values = np.array([value for _, value in equations])
        left, sizes, right = np.linalg.svd(rows)
        rank = len(equations)
        particular = right[:rank].T @ ((left.T @ values) / sizes)
        return cls(right[rank:].T, particular)

    def nearest(self, coefficients: Floats) -> Floats:
        """Return the free numbers, shape (m,), that come nearest to coefficients, shape (k,)."""
        found, *_ = np.linalg.lstsq(self.matrix, coefficients - self.offset, rcond=None)
        return np.asarray(found, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Maximum:
    """Where a log-likelihood is greatest.

    Attributes
    ----------
    coefficients : ndarray, shape (k,)
    value : float
        The log-likelihood.
    hessian : ndarray, shape (k, k)
        Of all k coefficients, also under a constraint.
    free : ndarray, shape (m,)
        d of the constraint, from which a nearby search may start.
    iterations : int
    converged : bool
        Whether the search came to an end.
    """

    coefficients: Floats
    value: float
    hessian: Floats
    free: Floats
    iterations: int
    converged: bool

    @property
    def doubtful(self) -> bool:
        """Whether the search took so long that there may be no maximum."""
        return not self.converged or self.iterations > _USUAL_ITERATIONS


class LogisticLikelihood:
    """ln L = Σ ln P(outcome), where P(break) = 1/(1 + exp(-f·c)) [paper, eq. likelihood3].

    The rows of `features`, (n, k), are f of each collision.
    """

    def __init__(self, features: Floats, broke: NDArray[np.bool_]) -> None:
        # With the sign of the outcome: then every collision has P = 1/(1 + exp(-margin)).
        self._signed = np.where(broke[:, None], features, -features)

    @property
    def size(self) -> int:
        """Number of coefficients, k."""
        return int(self._signed.shape[1])

    def subset(self, rows: NDArray[np.intp]) -> LogisticLikelihood:
        """Return the likelihood of some of the collisions."""
        part = object.__new__(LogisticLikelihood)
        part._signed = self._signed[rows]
        return part

    def margins(self, coefficients: Floats) -> Floats:
        """Return f·c of each collision, shape (n,), positive where the likelier thing happened."""
        return np.asarray(self._signed @ coefficients, dtype=np.float64)

    def at(self, coefficients: Floats) -> Slope:
        """Return value and derivatives at coefficients, shape (k,)."""
        margin = self.margins(coefficients)
        decay = np.exp(-np.abs(margin))
        against = np.where(margin > 0, decay, 1.0) / (1.0 + decay)  # 1 - P
        value = -float(np.sum(np.maximum(-margin, 0.0) + np.log1p(decay)))
        weighted = self._signed * (against * (1.0 - against))[:, None]
        return Slope(value, against @ self._signed, -(weighted.T @ self._signed))


def maximum(
    likelihood: Likelihood, constraint: Constraint | None = None, start: Floats | None = None
) -> Maximum:
    """Find the maximum by Newton's method, with steps halved until they ascend.

    It starts from the free numbers `start`, shape (m,); by default from zeros.
    """
    if constraint is None:
        constraint = Constraint(np.eye(likelihood.size), np.zeros(likelihood.size))
    matrix, offset = constraint
    free = np.zeros(matrix.shape[1]) if start is None else start
    slope = likelihood.at(matrix @ free + offset)
    for iteration in range(_MOST_ITERATIONS):
        gradient = matrix.T @ slope.gradient
        step = _ascent(matrix.T @ slope.hessian @ matrix, gradient)
        if gradient @ step < _TOLERANCE:
            return _end(constraint, free, slope, iteration, converged=True)
        for _ in range(_HALVINGS):
            trial = likelihood.at(matrix @ (free + step) + offset)
            if trial.value >= slope.value - _ROUND_OFF * abs(slope.value):
                break
            step = step / 2
        else:  # no step raises the likelihood any more: only round-off is left
            return _end(constraint, free, slope, iteration, converged=True)
        free, slope = free + step, trial
    return _end(constraint, free, slope, _MOST_ITERATIONS, converged=False)


def _ascent(hessian: Floats, gradient: Floats) -> Floats:
    """Return Newton's step; where the likelihood is not concave, along its curvature's size."""
    curvature, axes = np.linalg.eigh(-hessian)
    slope = axes.T @ gradient
    least = np.maximum(1e-12 * np.abs(curvature).max(), np.abs(slope) / _LONGEST_STEP)
    size = np.maximum(np.maximum(np.abs(curvature), least), np.finfo(float).tiny)
    return np.asarray(axes @ (slope / size), dtype=np.float64)


def _end(
    constraint: Constraint, free: Floats, slope: Slope, iterations: int, *, converged: bool
) -> Maximum:
    coefficients = constraint.matrix @ free + constraint.offset
    return Maximum(coefficients, slope.value, slope.hessian, free, iterations, converged)
