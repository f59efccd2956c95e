"""Our own JSON: written strictly, and read back of the right shape, or refused in one line."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from pinchoff.support.errors import InputError
from pinchoff.support.files import bounded_bytes, write_text

_LARGEST = 200_000_000  # bytes


class Shape(BaseModel):
    """What a record must hold: numbers that are numbers, texts that are texts.

    What a later release adds is let through.
    """

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)


def json_text(content: Mapping[str, Any]) -> str:
    """Return JSON in the strict sense: no NaN.

    Examples
    --------
    >>> json_text({"S": 0.5}).split()
    ['{', '"S":', '0.5', '}']
    """
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def jsonable(value: Any) -> Any:
    """Return a value as JSON can hold it, with None where it is not a finite number.

    Examples
    --------
    >>> jsonable({"w": float("nan"), "n": (1, 2.5)})
    {'w': None, 'n': [1, 2.5]}
    """
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(name): jsonable(content) for name, content in value.items()}
    if isinstance(value, (list, tuple)):
        return [jsonable(content) for content in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON, complete or not at all."""
    write_text(path, json_text(content))


def read_record(path: Path, shape: type[Shape], rule: str, advice: str) -> dict[str, Any]:
    """Read a file of JSON; the rule, which completes "must be", and the advice are for errors.

    Raises
    ------
    InputError
        It is not there, is no JSON, or has another shape; says where.
    """
    try:
        text = bounded_bytes(path, _LARGEST)
    except OSError as error:
        raise InputError.of(str(path), rule, error.strerror or str(error), advice) from None
    return parsed_record(text, str(path), shape, rule, advice)


def parsed_record(
    text: bytes | str, place: str, shape: type[Shape], rule: str, advice: str
) -> dict[str, Any]:
    """Read a text of JSON, which stands at a place; all else as `read_record`."""
    try:
        shape.model_validate_json(text)
        content: dict[str, Any] = json.loads(text)
    except ValidationError as error:
        finding = error.errors(include_url=False)[0]
        where = "".join(f"{part}: " for part in [".".join(map(str, finding["loc"]))] if part)
        raise InputError.of(place, rule, f"{where}{finding['msg'].lower()}", advice) from None
    except (ValueError, RecursionError) as error:
        raise InputError.of(place, rule, str(error), advice) from None
    return content
