"""Named sets of model constants, read from ``presets.toml``."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pinchoff.support.checked import unknown_name

with Path(__file__).with_name("presets.toml").open("rb") as _file:
    _PRESETS: dict[str, dict[str, Any]] = tomllib.load(_file)


def preset_names() -> tuple[str, ...]:
    """Names of the presets, ``default`` first."""
    return tuple(_PRESETS)


def preset_description(name: str) -> str:
    """What a preset is for, in a sentence or two."""
    return str(_preset(name)["description"])


def preset_constants(name: str) -> dict[str, Any]:
    """Return the constants in which a preset differs from ``default``."""
    if name == "default":
        return {}
    return {key: value for key, value in _preset(name).items() if key != "description"}


def _preset(name: object) -> dict[str, Any]:
    if not isinstance(name, str) or name not in _PRESETS:
        raise unknown_name("preset", "the name of a preset", name, _PRESETS)
    return _PRESETS[name]
