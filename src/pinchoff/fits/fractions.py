"""How large a share of the collisions broke, bin by bin, with binomial intervals."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Fractions(NamedTuple):
    """N_break/N_total in bins, those without a collision left out.

    Attributes
    ----------
    middle : ndarray, shape (b,)
        Geometric mean of Bk of the collisions in the bin.
    broke, total : ndarray of int, shape (b,)
    low, high : ndarray, shape (b,)
        Ends of the binomial interval.
    """

    middle: Floats
    broke: NDArray[np.intp]
    total: NDArray[np.intp]
    low: Floats
    high: Floats

    @property
    def fraction(self) -> Floats:
        """N_break/N_total, shape (b,)."""
        return np.asarray(self.broke / self.total)


def broken_fractions(
    breakup_number: Floats, broke: NDArray[np.bool_], edges: Floats, confidence: float = 0.95
) -> Fractions:
    """Count collisions, (n,), in bins of Bk; those beyond the edges, (b + 1,), are left out."""
    bins = np.digitize(breakup_number, edges) - 1
    inside = (bins >= 0) & (bins < len(edges) - 1)
    bins, broke = bins[inside], broke[inside]
    total = np.bincount(bins, minlength=len(edges) - 1)
    broken = np.bincount(bins[broke], minlength=len(edges) - 1)
    logs = np.bincount(bins, np.log(breakup_number[inside]), minlength=len(edges) - 1)
    filled = total > 0
    total, broken = total[filled], broken[filled]
    low, high = wilson_interval(broken, total, confidence)
    return Fractions(np.exp(logs[filled] / total), broken, total, low, high)


def wilson_interval(
    broke: NDArray[np.intp], total: NDArray[np.intp], confidence: float
) -> tuple[Floats, Floats]:
    """Return the ends, (b,), of Wilson's interval of a binomial share: within 0 and 1.

    Examples
    --------
    >>> low, high = wilson_interval(np.array([0, 5]), np.array([10, 10]), 0.95)
    >>> low.round(3).tolist(), high.round(3).tolist()
    ([0.0, 0.237], [0.278, 0.763])
    """
    from scipy.stats import binomtest  # slow to import

    shares = [binomtest(k, n) for k, n in zip(broke.tolist(), total.tolist(), strict=True)]
    ends = [share.proportion_ci(confidence, method="wilson") for share in shares]
    return np.array([end.low for end in ends]), np.array([end.high for end in ends])


def merged_edges(values: Floats, edges: Floats, fewest: int) -> Floats:
    """Leave out edges, from the lowest on, until every bin has so many values.

    Examples
    --------
    >>> merged_edges(np.array([0.5, 1.5, 2.5]), np.array([0.0, 1.0, 2.0, 3.0]), 2).tolist()
    [0.0, 3.0]
    """
    counts = np.histogram(values, edges)[0]
    kept, held = [edges[0]], 0
    for edge, count in zip(edges[1:], counts, strict=True):
        held += count
        if held >= fewest:
            kept.append(edge)
            held = 0
    if len(kept) == 1:
        return edges[[0, -1]]
    kept[-1] = edges[-1]  # the last bin takes what is left over
    return np.array(kept)


def logarithmic_edges(low: float, high: float, per_decade: float) -> Floats:
    """Return edges of bins that are even in the logarithm, with one edge on 1.

    Examples
    --------
    >>> logarithmic_edges(0.5, 20, 2).round(3).tolist()
    [0.316, 1.0, 3.162, 10.0, 31.623]
    """
    first = math.floor(math.log10(low) * per_decade)
    last = math.ceil(math.log10(high) * per_decade)
    return np.asarray(10.0 ** (np.arange(first, last + 1) / per_decade), dtype=np.float64)
