"""The break-up law: a power law in the symmetry separates collisions that break from the rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff.support import paper_constants as paper
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError


class Line(NamedTuple):
    """Separating line S_c = alpha (Ca Ã z̃)^beta [paper, eq. finalform].

    Attributes
    ----------
    alpha, beta : float
        Prefactor and exponent, both dimensionless.

    Examples
    --------
    >>> import pinchoff as po
    >>> line = po.Line(0.083, -0.74)
    >>> round(line(0.0024 * 25), 3)
    0.666
    >>> round(po.breakup_number(0.0024, normalized_area=25, symmetry=1, line=line), 2)
    1.73
    """

    alpha: float
    beta: float

    def __call__(self, control: ArrayLike) -> Any:
        """Return S_c at x = Ca Ã z̃, a float for one x and an array, shape (...), for many.

        Examples
        --------
        >>> round(Line(0.083, -0.74)(0.06), 3)
        0.666
        """
        return as_given(self.alpha * np.asarray(control, dtype=np.float64) ** self.beta)


def as_given(values: NDArray[np.float64]) -> Any:
    """Return a float where a scalar was given, else an array."""
    return values.item() if values.ndim == 0 else values


class HasLine(Protocol):
    """What has a separating line, such as a fitted law."""

    @property
    def line(self) -> Line:
        """The line."""


LineLike: TypeAlias = Line | HasLine | str

PAPER_EXPERIMENT_LINE = Line(paper.EXPERIMENT_ALPHA, paper.EXPERIMENT_BETA)
"""The paper's fit to its experiments."""

PAPER_SIMULATION_LINE = Line(paper.SIMULATION_ALPHA, paper.SIMULATION_BETA)
"""The paper's fit to its simulations."""

PAPER_ROUNDED_LINE = Line(alpha=28.0**-0.75, beta=-0.75)
"""The line of the paper's rounded Bk = 28 Ca Ã z̃ S^(4/3) [paper, eq. Bkequation].

As printed, the exponent of S is -4/3. That contradicts the definition (eq. bkeqn, with β < 0) and
the abstract: head-on collisions would be the least likely to break.
"""

LINES = {
    "paper-simulation": PAPER_SIMULATION_LINE,
    "paper-experiment": PAPER_EXPERIMENT_LINE,
    "paper-rounded": PAPER_ROUNDED_LINE,
}
"""Separating lines by name."""


ARGUMENTS = ("capillary_number", "normalized_area", "symmetry", "normalized_thickness")
"""Columns that decide Bk, as arguments of `breakup_number`."""


def breakup_number(
    capillary_number: ArrayLike,
    *,
    normalized_area: ArrayLike,
    symmetry: ArrayLike,
    normalized_thickness: ArrayLike = 1.0,
    line: LineLike = PAPER_SIMULATION_LINE,
) -> Any:
    r"""Distance of a collision from the separating line; 1 on the line, larger where it breaks.

    .. math:: \mathrm{Bk} = \mathrm{Ca}\,\tilde A\,\tilde z \,(S/\alpha)^{-1/\beta}

    which is the paper's definition [paper, eq. bkeqn] with the exponents of its separating line.

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
    line : Line, fitted law or str, optional
        The separating line: one of `LINES` by name, a `Line`, or what `pinchoff.fit_law` returned.
        ``"paper-rounded"`` is Bk = 28 Ca Ã z̃ S^(4/3). By default that of the paper's simulations.

    Returns
    -------
    float or ndarray, shape (...)
        Bk, dimensionless; 0 where S = 0. Of numbers alone a float.

    Raises
    ------
    InputError
        There is no line of that name.

    Examples
    --------
    >>> import pinchoff as po
    >>> bk = po.breakup_number(
    ...     2.4e-3, normalized_area=25, symmetry=0.8, line="paper-rounded")
    >>> round(bk, 3)
    1.248
    """
    known = as_line(line)
    forcing = (
        np.asarray(capillary_number, dtype=np.float64)
        * np.asarray(normalized_area, dtype=np.float64)
        * np.asarray(normalized_thickness, dtype=np.float64)
    )
    relative_symmetry = np.asarray(symmetry, dtype=np.float64) / known.alpha
    number = forcing * relative_symmetry ** (-1.0 / known.beta)
    return as_given(np.asarray(number, dtype=np.float64))


def breakup_number_of(
    columns: Mapping[str, ArrayLike], *, line: LineLike = PAPER_SIMULATION_LINE
) -> Any:
    """Return Bk of collisions from their columns, those of `ARGUMENTS`.

    Examples
    --------
    >>> row = dict(zip(ARGUMENTS, (2.4e-3, 25, 0.8, 1.0), strict=True))
    >>> round(breakup_number_of(row, line="paper-rounded"), 3)
    1.248
    """
    capillary, area, symmetry, thickness = (columns[name] for name in ARGUMENTS)
    return breakup_number(
        capillary,
        normalized_area=area,
        symmetry=symmetry,
        normalized_thickness=thickness,
        line=line,
    )


def as_line(line: LineLike) -> Line:
    """Return the separating line that is named, or that something has.

    Raises
    ------
    InputError
        It is none of these.

    Examples
    --------
    >>> as_line("paper-experiment")
    Line(alpha=0.083, beta=-0.74)
    """
    if isinstance(line, str):
        if line not in LINES:
            raise unknown_name("line", "the name of a separating line", line, LINES)
        return LINES[line]
    found = line if isinstance(line, Line) else getattr(line, "line", None)
    if not isinstance(found, Line):
        raise InputError.of("line", "a separating line", line, "use pinchoff.Line(0.083, -0.74)")
    return found


def breakup_probability(breakup_number: ArrayLike, width: float) -> NDArray[np.float64]:
    """Return P = x/(1 + x) with x = Bk^(1/w) [paper, eq. likelihood2].

    Parameters
    ----------
    breakup_number : array_like, shape (...)
        Bk, dimensionless.
    width : float
        w, dimensionless and positive.

    Examples
    --------
    >>> breakup_probability([0.9, 1.0, 1.1], 0.098).round(2).tolist()
    [0.25, 0.5, 0.73]
    """
    with np.errstate(divide="ignore"):
        log_x = np.log(np.asarray(breakup_number, dtype=np.float64)) / width
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * log_x)), dtype=np.float64)


def transition_factor(width: float, low: float = 0.05, high: float = 0.95) -> float:
    """Return by what factor Bk must grow for the probability of break-up to grow from low to high.

    It is (high/(1 - high) (1 - low)/low)^w; 1.78 for the paper's w = 0.098, from 5 % to 95 %.

    Examples
    --------
    >>> round(transition_factor(0.098), 2)
    1.78
    """
    odds = high / (1.0 - high) * (1.0 - low) / low
    return float(odds**width)
