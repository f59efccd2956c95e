"""Numbers as a reader sees them: with a true minus sign."""

from __future__ import annotations

import math


def numeral(value: float, spec: str = ".2f") -> str:
    """Write a number as its format says, with a true minus sign; ∞ where it is infinite.

    Examples
    --------
    >>> numeral(-0.7235)
    '−0.72'
    >>> numeral(float("-inf"))
    '−∞'
    """
    if math.isinf(value):
        return "∞" if value > 0 else "\N{MINUS SIGN}∞"
    return f"{value:{spec}}".replace("-", "\N{MINUS SIGN}")
