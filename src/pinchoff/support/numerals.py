"""Numbers as a reader sees them: with a true minus sign, and powers of ten raised."""

from __future__ import annotations

import math

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def numeral(value: float, spec: str = ".2f") -> str:
    """Write a number as its format says, for a reader.

    The minus sign is a true one, a power of ten is raised, and what is infinite is ∞.

    Examples
    --------
    >>> numeral(-0.7235)
    '−0.72'
    >>> numeral(float("-inf"))
    '−∞'
    >>> numeral(0.0000871, ".3g")
    '8.71×10⁻⁵'
    """
    if math.isinf(value):
        return "∞" if value > 0 else "\N{MINUS SIGN}∞"
    digits, _, power = f"{value:{spec}}".partition("e")
    digits = digits.replace("-", "\N{MINUS SIGN}")
    return f"{digits}×10{str(int(power)).translate(_RAISED)}" if power else digits


def counted(count: int, noun: str) -> str:
    """Return how many there are of what has a plural in s.

    Examples
    --------
    >>> counted(1, "clip"), counted(1200, "collision")
    ('1 clip', '1,200 collisions')
    """
    return f"{count:,} {noun}" + ("" if count == 1 else "s")
