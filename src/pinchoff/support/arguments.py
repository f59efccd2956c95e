"""Numbers that functions are given, checked where they come in."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

from pinchoff.support.errors import InputError


def finite_or_nan(value: object) -> float:
    """Return a number as a float; NaN for one that is not finite and for what is no number.

    Examples
    --------
    >>> finite_or_nan(2), finite_or_nan("2"), finite_or_nan(True)
    (2.0, nan, nan)
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        converted = float(value)
    except OverflowError:
        return math.nan
    return converted if math.isfinite(converted) else math.nan


def number_rule(low: float = -math.inf, high: float = math.inf, *, above: bool = False) -> str:
    """Say what a number from `low` to `high`, or above `low`, must be; completes "must be".

    Examples
    --------
    >>> number_rule(0, above=True), number_rule(0.1, 2)
    ('a positive, finite number', 'a finite number from 0.1 to 2')
    """
    if math.isfinite(low) and math.isfinite(high):
        start = f"above {low:g} and at most" if above else f"from {low:g} to"
        return f"a finite number {start} {high:g}"
    if math.isinf(low):
        return "a finite number"
    if low == 0.0:
        return "a positive, finite number" if above else "a finite number, 0 or more"
    return f"a finite number {'above' if above else 'of at least'} {low:g}"


def checked_number(
    argument: str,
    value: object,
    advice: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    above: bool = False,
) -> float:
    """Return a number as a float; its limits are as of `number_rule`.

    Raises
    ------
    InputError
        It is no number, not finite or beyond the limits.

    Examples
    --------
    >>> checked_number("width", 1, "use 0.005", low=0, high=2)
    1.0
    """
    number = finite_or_nan(value)
    if (number > low if above else number >= low) and number <= high:
        return number
    raise InputError.of(argument, number_rule(low, high, above=above), value, advice)


def checked_positive(argument: str, value: object, advice: str) -> float:
    """Return a positive, finite number as a float.

    Raises
    ------
    InputError
        It is none.

    Examples
    --------
    >>> checked_positive("frame_rate", 60, "use 60")
    60.0
    """
    return checked_number(argument, value, advice, low=0.0, above=True)


def checked_whole(
    argument: str, value: object, advice: str, *, low: int, high: int | None = None
) -> int:
    """Return a whole number from `low` to `high`, which it may be.

    Raises
    ------
    InputError
        It is no whole number or beyond the limits.

    Examples
    --------
    >>> checked_whole("scan", 24, "use 24", low=4, high=100)
    24
    """
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    number = int(value) if whole else low - 1  # type: ignore[call-overload]
    if number >= low and (high is None or number <= high):
        return int(number)
    got = "nothing" if value is None else value
    limits = f", {low} or more" if high is None else f" from {low} to {high}"
    raise InputError.of(argument, f"a whole number{limits}", got, advice)


def checked_confidence(confidence: object) -> float:
    """Return the confidence of an interval, a number between 0 and 1.

    Raises
    ------
    InputError
        It is none.

    Examples
    --------
    >>> checked_confidence(0.95)
    0.95
    """
    number = finite_or_nan(confidence)
    if 0.0 < number < 1.0:
        return number
    raise InputError.of("confidence", "a number between 0 and 1", confidence, "use 0.95")
