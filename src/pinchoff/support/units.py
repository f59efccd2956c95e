"""Numbers with their units, read as text or as pint's quantities."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pint

    Physical = str | pint.Quantity[Any]


KINDS = {
    "um": ("length", "85 um"),
    "um^2": ("area", "0.18 mm^2"),
    "mm/s": ("speed", "1.0 mm/s"),
    "mPa*s": ("dynamic viscosity", "48 mPa s"),
    "mN/m": ("surface tension", "20 mN/m"),
    "s": ("time", "0.5 s"),
}
"""What is measured in each of our units, and an example of it."""

# pint would evaluate its input, even 9**9**9. So a power of a unit is one digit.
_LETTERS = r"[^\W\d_⁰¹²³⁴⁵⁶⁷⁸⁹]+"
_FACTOR = rf"{_LETTERS}(?:\^-?[1-9]|⁻?[¹²³⁴])?"
_DECIMAL_COMMA = re.compile(r"^\s*[+-]?\d+,\d+")
_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*"
    rf"(?P<unit>{_FACTOR}(?:(?:(?!\*\*)[\s*/·()])+{_FACTOR})*[\s)]*)"
)
_POINT = re.compile(r"(?<=[^\W\d_])\.(?=[^\W\d_])")  # of a product, as in mPa.s


def magnitude_of(
    name: str, value: object, unit: str, *, example: str = "", positive: bool = False
) -> float:
    """Read a text or a pint.Quantity and return its number in one of `KINDS`' units.

    The example is for the error; by default it is that of the unit.

    Raises
    ------
    InputError
        It has no unit or the wrong one, is not finite, or not positive.

    Examples
    --------
    >>> magnitude_of("width", "0.2 mm", "um")
    200.0
    """
    import pint  # not needed for dimensionless work, and slow to import

    def wrong(adjective: str = "a") -> InputError:
        got = "nothing" if value is None else f"'{value}'"
        advice = f"write it like '{example or KINDS[unit][1]}'"
        if _DECIMAL_COMMA.search(str(value)):
            advice = f"write a decimal point in place of the comma: {got.replace(',', '.')}"
        return InputError.of(name, f"{adjective} {KINDS[unit][0]} with its unit", got, advice)

    try:
        quantity = value if isinstance(value, pint.Quantity) else _parsed(value)
        magnitude = float(quantity.m_as(unit))
    except Exception:  # pint raises many kinds of errors, from TokenError to ZeroDivisionError
        raise wrong() from None
    if not math.isfinite(magnitude):
        raise wrong("a finite")
    if positive and not magnitude > 0:
        raise wrong("a positive")
    return magnitude


def _parsed(text: object) -> pint.Quantity[Any]:
    """Read "<number> <unit>", and nothing that would have to be calculated."""
    import pint

    match = _QUANTITY.fullmatch(_POINT.sub("*", text)) if isinstance(text, str) else None
    if match is None:
        raise ValueError
    quantity: pint.Quantity[Any]
    quantity = pint.application_registry.Quantity(float(match["number"]), match["unit"])
    return quantity


def unit_factor(name: str, text: str, unit: str) -> float:
    """Return how many of one of `KINDS`' units a unit, such as "mm^2", is.

    Raises
    ------
    InputError
        It is no unit, or one of something else.

    Examples
    --------
    >>> unit_factor("speed", "m/s", "mm/s")
    1000.0
    """
    try:
        return magnitude_of(name, f"1 {text}", unit)
    except InputError:
        kind, example = KINDS[unit]
        advice = f"write it like {example.partition(' ')[2]}"
        raise InputError.of(name, f"a unit of {kind}", f"'{text}'", advice) from None


def is_unit(text: str) -> bool:
    """Return whether a short text is one of the units that `unit_factor` takes."""
    if not 0 < len(text) <= 16 or text[0].isdigit():
        return False
    for unit in KINDS:
        try:
            unit_factor("unit", text, unit)
        except InputError:
            continue
        return True
    return False
