"""JSON that the package wrote, read back: of the right shape, or refused in one line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from pinchoff.support.errors import InputError
from pinchoff.support.files import bounded_bytes

_LARGEST = 200_000_000  # bytes


class Shape(BaseModel):
    """What a record must hold: numbers that are numbers, texts that are texts.

    What a later release adds is let through.
    """

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)


def read_record(path: Path, shape: type[Shape], rule: str, advice: str) -> dict[str, Any]:
    """Read a file of JSON.

    Parameters
    ----------
    path : Path
    shape : type of Shape
    rule : str
        What the file is; completes "must be".
    advice : str
        What to do with one that is damaged.

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
