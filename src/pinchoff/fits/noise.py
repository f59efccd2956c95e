r"""Errors in the symmetry: the likelihood of outcomes when S itself is known with noise only.

A measured S* is the true S plus a normal error, reflected at 0 and 1, which no measured S can pass.
The likelihood of an outcome is then a mean over the true S that S* may stand for,

.. math:: L_i = \sum_g P(S_g \mid S^*_i)\, P(\text{outcome}_i \mid S_g),
    \qquad P(S_g \mid S^*_i) \propto \pi_g\, K(S^*_i \mid S_g)

with the distribution π of true symmetries among the collisions, which is found first, from the
measured ones, by maximum likelihood. It is taken to be the same at every Ca Ã z̃.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.fits.likelihood import Floats, Slope

_SYMMETRY = 2  # the feature that is ln S
_PER_ERROR = 4  # true symmetries per standard error
_FEWEST, _MOST = 100, 1000  # true symmetries from 0 to 1
_CELLS = 2.0  # of the grid, in S: about one in ln Bk where droplets begin to break
_BINS = 400  # of measured symmetries, to find their distribution
_GAIN = 0.01  # of the log-likelihood: less is not worth a further step of the distribution
_PIECE = 4096  # collisions at a time, so that memory stays bounded
_KEPT = 4_000_000  # weights that are kept rather than computed anew at each evaluation


def reflected_normal(measured: Floats, true: Floats, noise: float) -> Floats:
    """Return the density, (n, g), of measured symmetries, (n,), given true ones, (g,).

    Their error is normal, of standard error `noise`, and reflected at 0 and 1.
    """
    rows = measured[:, None]
    distances = (rows - true, rows + true, 2.0 - rows - true)
    density = sum(np.exp(-0.5 * (distance / noise) ** 2) for distance in distances)
    return np.asarray(density / (noise * math.sqrt(2.0 * math.pi)), dtype=np.float64)


def true_distribution(measured: Floats, noise: float) -> tuple[Floats, Floats]:
    """Return true symmetries, (g,), and how frequent each is, (g,), from measured ones, (n,).

    Expectation maximisation from an even distribution, until a step gains next to nothing: that
    also keeps it smooth. The shares add up to 1.
    """
    count = int(np.clip(math.ceil(_PER_ERROR / noise), _FEWEST, _MOST))
    true = (np.arange(count) + 0.5) / count
    counted, edges = np.histogram(measured, bins=_BINS, range=(0.0, 1.0))
    middle = 0.5 * (edges[1:] + edges[:-1])
    occupied = counted > 0
    kernel = reflected_normal(middle[occupied], true, noise)
    share = np.full(count, 1.0 / count)
    before = -math.inf
    while True:
        expected = kernel @ share
        value = float(counted[occupied] @ np.log(expected))
        if value - before < _GAIN:
            return true, share
        before = value
        share = share * (kernel.T @ (counted[occupied] / expected)) / counted.sum()


class _Piece(NamedTuple):
    """Some of the collisions: features, the sign of the outcome, measured S, weights of true S."""

    features: Floats
    sign: Floats
    symmetry: Floats
    weights: Floats | None


class NoisyLikelihood:
    """ln L of n outcomes with a measured symmetry, (n,), whose standard error is `noise`.

    Features, (n, k), are as of `pinchoff.fits.form.Form`; the third is ln S as measured.
    """

    def __init__(
        self, features: Floats, symmetry: Floats, broke: NDArray[np.bool_], noise: float
    ) -> None:
        others = features.copy()
        others[:, _SYMMETRY] = 0.0
        self._noise = noise
        self._true, self._share = true_distribution(symmetry, noise)
        kept = len(symmetry) * len(self._true) <= _KEPT
        weights = self._weights(symmetry) if kept else None
        self._all = _Piece(others, np.where(broke, 1.0, -1.0), symmetry, weights)

    @property
    def narrowest(self) -> float:
        """The least w that the grid of true symmetries resolves."""
        return _CELLS * float(self._true[1] - self._true[0])

    @property
    def size(self) -> int:
        """Number of coefficients, k."""
        return int(self._all.features.shape[1])

    def subset(self, rows: NDArray[np.intp]) -> NoisyLikelihood:
        """Return the likelihood of some of the collisions, with the distribution of all."""
        part = object.__new__(NoisyLikelihood)
        part.__dict__.update(self.__dict__)
        part._all = self._piece(rows)
        return part

    def at(self, coefficients: Floats) -> Slope:
        """Return value and derivatives at coefficients, shape (k,)."""
        value = 0.0
        gradient = np.zeros(self.size)
        hessian = np.zeros((self.size, self.size))
        for first in range(0, len(self._all.sign), _PIECE):
            slope = self._at(coefficients, self._piece(slice(first, first + _PIECE)))
            value += slope.value
            gradient += slope.gradient
            hessian += slope.hessian
        return Slope(value, gradient, hessian)

    def _piece(self, rows: slice | NDArray[np.intp]) -> _Piece:
        features, sign, symmetry, weights = self._all
        part = None if weights is None else weights[rows]
        return _Piece(features[rows], sign[rows], symmetry[rows], part)

    def _weights(self, symmetry: Floats) -> Floats:
        """Return how likely each true symmetry is behind measured ones, shape (n, g)."""
        weights = reflected_normal(symmetry, self._true, self._noise) * self._share
        weights /= weights.sum(axis=1, keepdims=True)
        return weights

    def _at(self, coefficients: Floats, piece: _Piece) -> Slope:
        features, sign, symmetry, kept = piece
        log_true = np.log(self._true)
        weight = self._weights(symmetry) if kept is None else kept
        margin = sign[:, None] * (
            (features @ coefficients)[:, None] + coefficients[_SYMMETRY] * log_true
        )
        decay = np.exp(-np.abs(margin))
        against = np.where(margin > 0, decay, 1.0) / (1.0 + decay)  # 1 - P
        joint = weight * np.where(margin > 0, 1.0, decay) / (1.0 + decay)
        likely = np.maximum(joint.sum(axis=1), 1e-300)
        posterior = joint / likely[:, None]
        # First and second derivatives of ln P times 1, ln S and (ln S)², averaged over true S.
        first = posterior * against
        second = first * (2.0 * against - 1.0)
        plain, times_log = first.sum(axis=1) * sign, (first @ log_true) * sign
        slopes = plain[:, None] * features
        slopes[:, _SYMMETRY] = times_log
        hessian = (features * second.sum(axis=1)[:, None]).T @ features
        mixed = (second @ log_true) @ features
        hessian[_SYMMETRY] += mixed
        hessian[:, _SYMMETRY] += mixed
        hessian[_SYMMETRY, _SYMMETRY] += float(np.sum(second @ log_true**2))
        hessian -= slopes.T @ slopes
        return Slope(float(np.log(likely).sum()), slopes.sum(axis=0), hessian)
