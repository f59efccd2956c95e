"""The break-up law: a power law in the symmetry separates collisions that break from the rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Line(NamedTuple):
    """Separating line S_c = alpha (Ca Ã z̃)^beta [paper, eq. finalform].

    Attributes
    ----------
    alpha, beta : float
        Prefactor and exponent, both dimensionless.
    """

    alpha: float
    beta: float


PAPER_EXPERIMENT_LINE = Line(alpha=0.083, beta=-0.74)
"""The paper's fit to its experiments."""

PAPER_SIMULATION_LINE = Line(alpha=0.089, beta=-0.72)
"""The paper's fit to its simulations."""


def breakup_number(
    capillary_number: ArrayLike,
    normalized_area: ArrayLike,
    symmetry: ArrayLike,
    normalized_thickness: ArrayLike = 1.0,
    *,
    line: Line = PAPER_SIMULATION_LINE,
) -> NDArray[np.float64]:
    r"""Distance of a collision from the separating line; 1 on the line, larger where it breaks.

    .. math:: \mathrm{Bk} = \mathrm{Ca}\,\tilde A\,\tilde z \,(S/\alpha)^{-1/\beta}

    which is the paper's definition [paper, eq. bkeqn] with the exponents of its separating line.
    The rounded form that the paper prints later has the exponent of S with the wrong sign; this
    function is the exact form.

    Parameters
    ----------
    capillary_number : array_like, shape (...)
        Ca = μv/γ, dimensionless.
    normalized_area : array_like, shape (...)
        Ã = A/R², dimensionless.
    symmetry : array_like, shape (...)
        S at first contact, 0 to 1. Not measured is NaN, and so is the result.
    normalized_thickness : array_like, shape (...), optional
        z̃ = z/R, dimensionless; 1 in the two-dimensional model.
    line : Line, optional
        The separating line; that of the paper's simulations by default.

    Returns
    -------
    ndarray, shape (...)
        Bk, dimensionless; 0 where S = 0.
    """
    forcing = (
        np.asarray(capillary_number, dtype=np.float64)
        * np.asarray(normalized_area, dtype=np.float64)
        * np.asarray(normalized_thickness, dtype=np.float64)
    )
    relative_symmetry = np.asarray(symmetry, dtype=np.float64) / line.alpha
    return np.asarray(forcing * relative_symmetry ** (-1.0 / line.beta), dtype=np.float64)
