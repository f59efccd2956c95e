"""A number with its confidence interval."""

from __future__ import annotations

from typing import NamedTuple


class Estimate(NamedTuple):
    """A fitted number and the ends of its confidence interval.

    Attributes
    ----------
    value, low, high : float
        An infinite end: the data do not bound the number on that side.
    method : str
        How the interval was obtained.

    Examples
    --------
    >>> print(Estimate(-0.74, -0.77, -0.71))
    -0.74 (-0.77 to -0.71)
    """

    value: float
    low: float
    high: float
    method: str = ""

    def __str__(self) -> str:
        return f"{self.value:.4g} ({self.low:.4g} to {self.high:.4g})"
