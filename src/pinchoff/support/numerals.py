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


def counted(count: int, noun: str) -> str:
    """Return how many there are of what has a plural in s.

    Examples
    --------
    >>> counted(1, "clip"), counted(1200, "collision")
    ('1 clip', '1,200 collisions')
    """
    return f"{count:,} {noun}" + ("" if count == 1 else "s")
