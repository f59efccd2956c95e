"""The values that a sweep gives to one parameter: a list, or a range."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pinchoff.support.arguments import checked_number, checked_whole
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError

MOST_LEVELS = 1_000_000

_KEYS = ("min", "max", "count", "scale")
_FORM = "write a list, or { min = …, max = …, count = …, scale = 'linear' or 'log' }"

Reader = Callable[[str, Any], float]
"""Reads a number, ``read(argument, value)``; raises InputError."""


@dataclass(frozen=True)
class Levels:
    """A parameter that takes some values, one after the other or at random."""

    name: str
    values: tuple[Any, ...]
    configuration: Any

    def at(self, u: float) -> Any:
        """Return the value at `u` in [0, 1): every value has the same share of it."""
        return self.values[min(int(u * len(self.values)), len(self.values) - 1)]

    def ends(self) -> Iterator[tuple[str, Any]]:
        """Yield the values to check, and how the user knows each."""
        if isinstance(self.configuration, Mapping):
            yield f"vary.{self.name}.min", self.values[0]
            yield f"vary.{self.name}.max", self.values[-1]
        else:
            yield from ((f"vary.{self.name}[{k}]", value) for k, value in enumerate(self.values))


@dataclass(frozen=True)
class Range:
    """A parameter that takes any value between two ends, uniformly, or so in its logarithm."""

    name: str
    low: float
    high: float
    logarithmic: bool
    whole: bool
    configuration: Any

    def at(self, u: float) -> float:
        """Return the value at `u` in [0, 1)."""
        if self.whole:
            # Each end has a full share, which rounding alone would halve.
            low, high = self.low - 0.5, self.high + 0.5
            return min(max(round(self._between(low, high, u)), round(self.low)), round(self.high))
        return min(max(self._between(self.low, self.high, u), self.low), self.high)

    def _between(self, low: float, high: float, u: float) -> float:
        return low * math.pow(high / low, u) if self.logarithmic else low + (high - low) * u

    def ends(self) -> Iterator[tuple[str, Any]]:
        """Yield the values to check, and how the user knows each."""
        yield f"vary.{self.name}.min", self.low
        yield f"vary.{self.name}.max", self.high


Axis = Levels | Range


def read_axis(
    name: str, given: object, *, sampled: bool, whole: bool, read: Reader | None = None
) -> Axis:
    """Read what a configuration says about one varied parameter: a list, or a range as a table.

    The range of a sample has no count. Where the parameter is whole, the values of a range are
    rounded; `read` reads a physical quantity as a number.

    Raises
    ------
    InputError
        It is anything else, empty, reversed or holds a value twice.
    """
    argument = f"vary.{name}"
    if isinstance(given, Mapping):
        return _read_range(argument, name, given, sampled, whole, read or _number)
    if isinstance(given, np.ndarray):
        given = given.tolist()
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InputError.of(argument, "a list or a range", given, _FORM)
    values = [read(f"{argument}[{k}]", v) if read else _plain(v) for k, v in enumerate(given)]
    return _levels(argument, name, values, list(values))


def _plain(value: Any) -> Any:
    """Return numbers as floats, so that 20 and 20.0 are the same, and all else unchanged."""
    number = isinstance(value, (int, float, np.integer, np.floating))
    return float(value) if number and not isinstance(value, bool) else value


def _levels(argument: str, name: str, values: list[Any], configuration: Any) -> Levels:
    if not values:
        raise InputError.of(argument, "a list of one value or more", "an empty one", _FORM)
    seen: set[str] = set()
    for value in values:
        if repr(value) in seen:
            advice = "give each once, or lower count"
            raise InputError.of(argument, "without repetitions", f"{value!r} twice", advice)
        seen.add(repr(value))
    return Levels(name, tuple(values), configuration)


def _read_range(
    argument: str, name: str, given: Mapping[str, Any], sampled: bool, whole: bool, read: Reader
) -> Axis:
    for key in given:
        if key not in _KEYS:
            raise unknown_name(f"{argument}.{key}", "a key of a range", key, _KEYS)
    for key in ("min", "max"):
        if given.get(key) is None:
            raise InputError.of(f"{argument}.{key}", "given", "nothing", _FORM)
    low, high = read(f"{argument}.min", given["min"]), read(f"{argument}.max", given["max"])
    if not low < high:
        raise InputError.of(
            f"{argument}.max", f"larger than min = {given['min']}", given["max"], "swap or widen"
        )
    logarithmic = _read_scale(argument, given.get("scale", "linear"), low)
    configuration = {"min": low, "max": high, "scale": "log" if logarithmic else "linear"}
    count = given.get("count")
    if sampled:
        if count is not None:
            advice = "drop it: samples says how many points there are"
            raise InputError.of(f"{argument}.count", "left out of a sample", count, advice)
        return Range(name, low, high, logarithmic, whole, configuration)
    spaced = np.geomspace if logarithmic else np.linspace
    values = spaced(low, high, _read_count(argument, count)).tolist()
    if whole:
        values = [round(value) for value in values]
    return _levels(argument, name, values, {**configuration, "count": count})


def _read_scale(argument: str, scale: object, low: float) -> bool:
    if scale not in ("linear", "log"):
        raise unknown_name(f"{argument}.scale", "'linear' or 'log'", scale, ("linear", "log"))
    if scale == "log" and not low > 0:
        advice = "raise it, or use scale = 'linear'"
        raise InputError.of(f"{argument}.min", "positive when the scale is 'log'", low, advice)
    return scale == "log"


def _read_count(argument: str, count: object) -> int:
    advice = "say how many values the range has"
    return checked_whole(f"{argument}.count", count, advice, low=2, high=MOST_LEVELS)


def _number(argument: str, value: object) -> float:
    return checked_number(argument, value, _FORM)
