"""Numbers with their units, read as text or as pint's quantities."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pint

    Physical = str | pint.Quantity[Any]


class QuantityKind(NamedTuple):
    """How a physical argument is read: its field in the scale, its unit and its kind."""

    field: str
    unit: str
    kind: str
    example: str


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


def magnitude_of(name: str, value: Physical, unit: str) -> float:
    """Read a quantity and return its number in one of `KINDS`' units.

    Raises
    ------
    InputError
        It has no unit or the wrong one, or is not finite.

    Examples
    --------
    >>> magnitude_of("width", "0.2 mm", "um")
    200.0
    """
    return magnitude_in(name, value, QuantityKind(name, unit, *KINDS[unit]))


def positive_magnitude_of(name: str, value: Physical, unit: str) -> float:
    """Read a quantity as `magnitude_of` does, and refuse one that is not positive."""
    magnitude = magnitude_of(name, value, unit)
    if not magnitude > 0:
        raise wrong_quantity(name, value, QuantityKind(name, unit, *KINDS[unit]), "a positive")
    return magnitude


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
    kind, example = KINDS[unit]
    try:
        return magnitude_in(name, f"1 {text}", QuantityKind(name, unit, kind, example))
    except InputError:
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


def magnitude_in(name: str, value: object, quantity: QuantityKind) -> float:
    """Read one quantity and return its number in `quantity.unit`."""
    import pint  # not needed for dimensionless work, and slow to import

    if isinstance(value, pint.Quantity):
        parsed = value
    elif isinstance(value, str):
        try:
            parsed = _parsed(value)
        except Exception:  # pint raises many kinds of errors, from TokenError to ZeroDivisionError
            raise wrong_quantity(name, value, quantity) from None
    else:
        raise wrong_quantity(name, "nothing" if value is None else value, quantity)
    try:
        magnitude = float(parsed.m_as(quantity.unit))
    except (pint.PintError, TypeError, ValueError, OverflowError):
        raise wrong_quantity(name, value, quantity) from None
    if not math.isfinite(magnitude):
        raise wrong_quantity(name, value, quantity, "a finite")
    return magnitude


def _parsed(text: str) -> pint.Quantity[Any]:
    """Read "<number> <unit>", and nothing that would have to be calculated."""
    import pint

    match = _QUANTITY.fullmatch(_POINT.sub("*", text))
    if match is None:
        raise ValueError
    quantity: pint.Quantity[Any]
    quantity = pint.application_registry.Quantity(float(match["number"]), match["unit"])
    return quantity


def wrong_quantity(
    name: str, value: object, quantity: QuantityKind, adjective: str = "a"
) -> InputError:
    """Return the error about a text that is not such a quantity."""
    got = value if isinstance(value, str) else str(value)
    rule = f"{adjective} {quantity.kind} with its unit"
    advice = f"write it like '{quantity.example}'"
    if _DECIMAL_COMMA.search(got):
        advice = f"write a decimal point in place of the comma: '{got.replace(',', '.')}'"
    return InputError.of(name, rule, f"'{got}'", advice)
