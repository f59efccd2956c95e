"""NAME=VALUE pairs and lists of values, as the command line takes them.

What is read stands behind an option that may be repeated; errors name that option and show a pair.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from typing import Any

from pinchoff.support.errors import InputError


def read_pairs(
    flag: str, texts: Iterable[str] | None, example: str, form: str = "NAME=VALUE"
) -> dict[str, str]:
    """Read pairs; a text that is none is refused, and so is a name that is given twice.

    Examples
    --------
    >>> read_pairs("--set", ["line_tension=60", "seed = 3"], "line_tension=60")
    {'line_tension': '60', 'seed': '3'}
    """
    pairs: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError.of(flag, form, text, f"write it like {example}")
        if name in pairs:
            raise InputError.of(f"{flag} {name}", "given once", value, "drop one of them")
        pairs[name] = value
    return pairs


def read_values(flag: str, texts: Iterable[str] | None, example: str) -> dict[str, Any]:
    """Read pairs whose values are as `read_value` takes them.

    Examples
    --------
    >>> read_values("--set", ["line_tension=60"], "line_tension=60")
    {'line_tension': 60}
    """
    pairs = read_pairs(flag, texts, example)
    return {name: read_value(f"{flag} {name}", text) for name, text in pairs.items()}


def read_value(place: str, text: str) -> Any:
    """Read a value that is written as in TOML, or else is a bare word.

    Examples
    --------
    >>> [read_value("--set", text) for text in ("60", "true", "sobol")]
    [60, True, 'sobol']
    """
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        return text
    except RecursionError:
        got, advice = "brackets nested too deeply", "give a number or a word"
        raise InputError.of(place, "a value", got, advice) from None


def read_list(place: str, text: str) -> list[Any]:
    """Read values between commas.

    Examples
    --------
    >>> read_list("--size-ratio", "4, 5.66, 8")
    [4, 5.66, 8]
    """
    parts = [part.strip() for part in text.strip().removeprefix("[").removesuffix("]").split(",")]
    if not all(parts):
        raise InputError.of(place, "a list of values", repr(text), "write it like 16,20,25")
    return [read_value(place, part) for part in parts]
