"""Means of what is correlated in time, with errors from blocks left out one after the other.

Blocks are longer than the correlation time (jackknife). Where the record is too short for that many
blocks the error is not a number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pinchoff.support.numerals import numeral

Floats: TypeAlias = NDArray[np.float64]

FEWEST_BLOCKS = 5
"""Fewer give no error that could be believed."""

MOST_BLOCKS = 40
BLOCK = 4.0
"""Length of a block, in correlation times."""


class Measured(NamedTuple):
    """A mean and its standard error.

    Attributes
    ----------
    value, error : float
        The error is NaN where the record is too short for one.

    Examples
    --------
    >>> print(Measured(-0.00074, 0.0741))
    −0.001 ± 0.074
    """

    value: float
    error: float

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "not measured"
        if math.isnan(self.error):
            return f"{numeral(self.value, '.4g')}, error not measured"
        if not self.error > 0.0:
            return f"{numeral(self.value, '.4g')} ± {self.error:.2g}"
        # As many digits as the error has two of.
        digits = max(0, 1 - math.floor(math.log10(self.error)))
        return f"{numeral(self.value, f'.{digits}f')} ± {self.error:.{digits}f}"


def correlation_time(times: Floats, values: Floats) -> float:
    """Return the integrated correlation time of evenly sampled values.

    It is dt (1/2 + sum of the autocorrelation), summed over a window of five times itself (Sokal).

    Examples
    --------
    >>> noise = np.random.default_rng(0).normal(size=20_000)
    >>> round(correlation_time(np.arange(20_000.0), noise), 1)
    0.5
    """
    step = float(np.median(np.diff(times)))
    away = values - values.mean()
    variance = float(away @ away)
    if variance <= 1e-24 * float(values @ values):
        return 0.5 * step
    size = 1 << (2 * len(away) - 1).bit_length()
    power = np.abs(np.fft.rfft(away, size)) ** 2
    shared = np.fft.irfft(power, size)[: len(away)] / variance
    sums = 0.5 + np.concatenate([[0.0], np.cumsum(shared[1:])])
    window = np.flatnonzero(np.arange(len(sums)) >= 5.0 * sums)
    last = int(window[0]) if len(window) else len(sums) - 1
    return step * max(0.5, float(sums[last]))


def jackknife(blocks: Floats, of: Callable[[Floats], float]) -> Measured:
    """Return a function of sums over blocks, shape (b, m), with its error.

    Examples
    --------
    >>> jackknife(np.array([[1.0, 2.0], [1.0, 4.0]]), lambda sums: sums[1] / sums[0]).value
    3.0
    """
    whole = blocks.sum(axis=0)
    count = len(blocks)
    if count < FEWEST_BLOCKS:
        return Measured(float(of(whole)), math.nan)
    without = np.array([of(whole - block) for block in blocks])
    return Measured(float(of(whole)), float(math.sqrt((count - 1) * without.var())))
