"""Parameters of many runs, in every form in which `simulate_many` takes them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from pinchoff.model.parameters import Parameters
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError

_LISTED = (list, tuple, range, np.ndarray)


def each_given(parameters: object) -> Iterable[Any]:
    """Yield the description of each run, Parameters or a mapping, of what `simulate_many` is given.

    Raises
    ------
    InputError
        They are neither an iterable nor a DataFrame nor a mapping.

    Examples
    --------
    >>> list(each_given({"offset": [0, 0.1], "line_tension": 60}))
    [{'offset': 0, 'line_tension': 60}, {'offset': 0.1, 'line_tension': 60}]
    """
    if isinstance(parameters, Mapping):
        return _grid(parameters)
    if hasattr(parameters, "to_dict") and hasattr(parameters, "columns"):  # a DataFrame
        rows: list[dict[str, Any]] = parameters.to_dict("records")
        return [{str(key): _present(value) for key, value in row.items()} for row in rows]
    # A model iterates over its fields, so a single one would pass for a collection.
    if isinstance(parameters, Parameters | str) or not isinstance(parameters, Iterable):
        rule = "an iterable of Parameters or dicts, a DataFrame, or a dict of lists"
        raise InputError.of("parameters", rule, parameters, "put them into a list")
    return parameters


def as_parameters(given: object, number: int) -> Parameters:
    """Return the parameters of one run; a refusal names its number."""
    name = f"parameters[{number}]"
    if isinstance(given, Parameters):
        return given
    if not isinstance(given, Mapping):
        advice = "build it with pinchoff.Parameters(...)"
        raise InputError.of(name, "a Parameters or a dict of their values", given, advice)
    try:
        return Parameters(**{str(key): _plain(value) for key, value in given.items()})
    except InputError as error:
        raise error.within(name) from None


def _grid(values: Mapping[Any, Any]) -> Iterator[dict[str, Any]]:
    """Return all combinations of values, the last name fastest."""
    for name in values:
        if name not in Parameters.model_fields:
            raise unknown_name("parameters", "a dict by names of parameters", name, _NAMES)
    axes = [list(value) if isinstance(value, _LISTED) else _one(value) for value in values.values()]
    names = [str(name) for name in values]
    return (dict(zip(names, point, strict=True)) for point in itertools.product(*axes))


def _one(value: Any) -> list[Any]:
    """Return the values of an axis that is no list: a Series has several, a number is one."""
    values = np.asarray(value, dtype=object)
    several: list[Any] = values.tolist() if values.ndim else [value]
    return several


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _present(value: Any) -> Any:
    """Turn NaN, which a table uses for "not given", into None."""
    return None if isinstance(value, float) and value != value else value


_NAMES = tuple(Parameters.model_fields)
