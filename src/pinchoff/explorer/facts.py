"""What the page has to know of the model: nothing in it is written down a second time there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any, get_args

from pinchoff.collisions.law import LINES
from pinchoff.collisions.reasons import general_reason
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import (
    AREA_STIFFNESS_PER_LINE_TENSION,
    CA_PER_CA_SIM,
    DEFAULTS,
    PARAMETERS,
    WALL_STIFFNESS_PER_LINE_TENSION,
    Model,
    Parameters,
    preset_description,
    preset_names,
)
from pinchoff.model.presets import preset_constants
from pinchoff.support.quantities import physical_magnitude

LABORATORY = {
    "diameter": "481 um",
    "obstacle_radius": "85 um",
    "thickness": "85 um",
    "speed": "1.0 mm/s",
    "viscosity": "48 mPa s",
    "surface_tension": "20 mN/m",
    "offset": "24 um",
}
"""The experiment that physical units begin with: the paper's median breaking droplet."""

FOLLOWING = {
    "area_stiffness": AREA_STIFFNESS_PER_LINE_TENSION,
    "wall_stiffness": WALL_STIFFNESS_PER_LINE_TENSION,
}
"""Parameters whose default follows the line tension, and their ratio to it."""

_MODELS: tuple[Model, ...] = get_args(Model)

_LINE_LABELS = {
    "paper-simulation": "paper, simulations",
    "paper-experiment": "paper, experiments",
    "paper-rounded": "paper, rounded: Bk = 28 Ca Ã z̃ S^(4/3) = 1",
}


def facts() -> dict[str, Any]:
    """Return the data of the page, ready for JSON.

    Returns
    -------
    dict
        The engine's fields, the parameters with limits and defaults, presets of the constants, the
        paper's lines, what the guards say, examples and the tour.
    """
    from pinchoff import __version__, _core

    examples, tour = _scenes()
    return {
        "version": __version__,
        "fields": list(_core.MODEL_FIELDS),
        "parameters": list(_parameters()),
        "ratios": FOLLOWING,
        "defaults": {m: Parameters(model=m).model_dump(mode="json") for m in _MODELS},
        "constants": _constants(),
        "ca_per_ca_sim": CA_PER_CA_SIM,
        "presets": [
            {"name": n, "description": preset_description(n), "constants": preset_constants(n)}
            for n in preset_names()
            if all(PARAMETERS[c].in_core for c in preset_constants(n))
        ],
        "lines": [
            {"name": name, "label": _LINE_LABELS.get(name, name), **line._asdict()}
            for name, line in LINES.items()
        ],
        "guards": {g: general_reason(guard_message(g, 0.0, 0.0)) for g in _core.GUARDS if g},
        "laboratory": {name: physical_magnitude(name, q) for name, q in LABORATORY.items()},
        "examples": examples,
        "tour": tour,
    }


def _parameters() -> Iterator[dict[str, Any]]:
    schemas = Parameters.model_json_schema()["properties"]
    for name, entry in PARAMETERS.items():
        if not entry.in_core:  # the page reads Ca as by default
            continue
        yield {
            "name": name,
            "default": DEFAULTS.get(name),
            "follows": "line_tension" if name in FOLLOWING else "model" if entry.follows else "",
            "scope": entry.model,
            **_limits(schemas[name]),
            "rule": entry.rule,
            "meaning": entry.phrase,
            "advice": entry.advice,
            "place": entry.place,
            "column": entry.as_column().name,
        }


def _limits(schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the limits, the choices and whether only whole numbers will do."""
    kinds = [schema, *schema.get("anyOf", ())]
    numbers = [kind for kind in kinds if kind.get("type") in ("number", "integer")]
    number: dict[str, Any] = numbers[0] if numbers else {}
    choices = None if number else schema.get("enum")
    return {
        # Beside None, pydantic leaves the limits as it was given them.
        "low": number.get("minimum", number.get("ge")),
        "high": number.get("maximum", number.get("le")),
        "whole": number.get("type") == "integer",
        "choices": choices,
    }


def _constants() -> dict[str, float]:
    """Return the numbers of the row that no parameter decides."""
    from pinchoff import _core

    decided = {entry.place for entry in PARAMETERS.values() if entry.in_core}
    row = dict(zip(_core.MODEL_FIELDS, Parameters().model_row().tolist(), strict=True))
    return {name: value for name, value in row.items() if name not in decided}


def _scenes() -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Read the examples and the stops of the tour."""
    import tomllib

    text = resources.files(__package__).joinpath("scenes.toml").read_text(encoding="utf-8")
    scenes = tomllib.loads(text)
    return scenes["example"], scenes["tour"]
