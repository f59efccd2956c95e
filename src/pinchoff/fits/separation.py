"""Collisions that a line separates without exception: the line with the widest gap.

The likelihood then has no maximum: it grows to 1 as w → 0, whatever line separates the outcomes.
The line of the greatest likelihood as w → 0 is the one whose nearest collisions are as far away
as possible in ln Bk; finding it is a linear programme. Where no line separates them, the same
programme says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.fits.likelihood import Floats

_BATCH = 500  # collisions that are added to the programme at a time
_BOUND = 100.0  # largest exponent in Bk: beyond, one quantity alone separates the outcomes
_TOLERANCE = 1e-7  # of the linear programme, in ln Bk
_FORCING = 1  # the feature whose coefficient in ln Bk is 1


class Gap(NamedTuple):
    """The line with the widest gap in ln Bk.

    Attributes
    ----------
    coefficients : ndarray, shape (k,)
        ln Bk of a collision with features f is f·coefficients.
    half_width : float
        Distance in ln Bk of the line from the nearest collision on either side. Negative: no line
        separates the outcomes.
    """

    coefficients: Floats
    half_width: float


def widest_gap(features: Floats, broke: NDArray[np.bool_], near: Floats) -> Gap:
    """Find the line with the widest gap between broken and unbroken collisions.

    Features, (n, k), are as of `pinchoff.fits.form.Form`: the coefficient of the second one is 1.
    `near` holds the coefficients, (k,), of a line near it.
    """
    signed = np.where(broke[:, None], features, -features)
    margins = signed @ near
    chosen = np.zeros(len(signed), dtype=bool)
    while True:
        # Few collisions decide the gap: those nearest to the line, and then those that it misses.
        chosen[np.argpartition(margins, min(_BATCH, len(margins) - 1))[:_BATCH]] = True
        gap = _solved(signed[chosen])
        margins = signed @ gap.coefficients - gap.half_width
        if margins[~chosen].min(initial=0.0) >= -_TOLERANCE:
            return gap


def _solved(signed: Floats) -> Gap:
    """Maximise t subject to signed·coefficients ≥ t."""
    from scipy.optimize import linprog  # slow to import, and most fits do without

    others = np.delete(signed, _FORCING, axis=1)
    count = others.shape[1]
    solution = linprog(
        c=np.append(np.zeros(count), -1.0),
        A_ub=np.column_stack([-others, np.ones(len(others))]),
        b_ub=signed[:, _FORCING],
        bounds=[(None, None)] + [(-_BOUND, _BOUND)] * (count - 1) + [(None, None)],
        method="highs",
    )
    return Gap(np.insert(solution.x[:-1], _FORCING, 1.0), float(solution.x[-1]))
