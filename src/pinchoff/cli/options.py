"""Options that several commands share, and how options become parameters."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.parameters import Parameters

OUTPUT = "Output"
"""Heading of the options that say what is written where."""

OutFolder = Annotated[
    str, typer.Option(metavar="DIR", help="Folder for the results.", rich_help_panel=OUTPUT)
]
Overwrite = Annotated[
    bool,
    typer.Option("--overwrite", metavar="", help="Replace results in DIR.", rich_help_panel=OUTPUT),
]

FLAGS = {
    "size_ratio": "--size-ratio",
    "simulation_capillary_number": "--capillary",
    "offset": "--offset",
    "diameter": "--diameter",
    "obstacle_radius": "--obstacle-radius",
    "speed": "--speed",
    "viscosity": "--viscosity",
    "surface_tension": "--surface-tension",
    "thickness": "--thickness",
}


def value_of(place: str, text: str) -> Any:
    """Read a value as TOML has it, or else as a bare word.

    Raises
    ------
    InputError
        Its brackets are nested beyond reason.
    """
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        return text
    except RecursionError:
        got, advice = "brackets nested too deeply", "give a number or a word"
        raise InputError.of(place, "a value", got, advice) from None


def configuration(config: Path | None, preset: str | None) -> tuple[Parameters, str]:
    """Return what a file or else a preset says, and the preset's name; the file is read once.

    Raises
    ------
    InputError
        Both are given, or either is wrong.
    """
    from pinchoff.model.parameters import Parameters
    from pinchoff.support.files import read_toml

    if config is None:
        name = preset or "default"
        return Parameters.preset(name), name
    if preset is not None:
        raise InputError.of(
            "--preset", "left out beside a file", preset, f"write the preset into {config}"
        )
    table = read_toml(config)
    return Parameters.from_config(table), str(table.get("preset", "default"))


def changed(
    base: Parameters,
    options: Mapping[str, str],
    assignments: Sequence[str],
    physical: Mapping[str, str],
) -> Parameters:
    """Return parameters with what the command line says in place of a configuration's.

    Parameters
    ----------
    base : Parameters
    options : mapping of str to str
        The dimensionless options that are given, by the names of their parameters.
    assignments : sequence of str
        What stands behind --set.
    physical : mapping of str to str
        The physical options that are given, by the names of `Parameters.from_physical`.

    Raises
    ------
    InputError
        A value is wrong; the message names the option.
    """
    assigned = _assigned(assignments)
    for name in options.keys() & assigned.keys():
        raise InputError.of(
            f"--set {name}", "given once", assigned[name], f"drop it or {FLAGS[name]}"
        )
    changes = {**assigned, **options}
    _require_one_description(base, changes, physical)
    try:
        parameters = _physical(base, physical, changes) if physical else base.replace(**changes)
        parameters.model_row()  # refuses an unstable time step before any file is touched
    except InputError as error:
        name = error.argument
        if name not in assigned and (physical or name in options):
            name = _as_options(name)
        raise InputError.of(name, error.rule, error.got, error.advice) from None
    return parameters


def _as_options(names: str) -> str:
    return " ".join(FLAGS.get(name, name) for name in names.split(" "))


def _require_one_description(
    base: Parameters, changes: Mapping[str, Any], physical: Mapping[str, str]
) -> None:
    """Refuse groups beside the quantities that they follow from, and a length without D0."""
    from pinchoff.support.quantities import GROUP_ORIGINS

    if base.scale is None and physical.keys() == {"offset"}:
        raise InputError.of(
            "--offset",
            "a number of D0, or a length beside physical quantities",
            physical["offset"],
            "give a number, or --diameter and the other quantities too",
        )
    if base.scale is None and not physical:
        return
    for name in GROUP_ORIGINS.keys() & changes.keys():
        raise InputError.of(
            FLAGS[name],
            "left out beside physical quantities, from which it follows",
            str(changes[name]),
            f"change {_as_options(GROUP_ORIGINS[name])}",
        )


def _physical(
    base: Parameters, physical: Mapping[str, str], changes: Mapping[str, Any]
) -> Parameters:
    """Build parameters from quantities; those not given are the configuration's."""
    from pinchoff.model.parameters import Parameters
    from pinchoff.support.quantities import PHYSICAL_NAMES

    groups = ("size_ratio", "simulation_capillary_number", "offset", "scale")
    constants = {name: getattr(base, name) for name in base.model_fields_set - {*groups}}
    quantities: dict[str, str | None] = dict.fromkeys(PHYSICAL_NAMES)
    if base.scale is not None:
        quantities = {
            "diameter": f"{base.scale.diameter_um!r} um",
            "obstacle_radius": f"{base.scale.obstacle_radius_um!r} um",
            "speed": f"{base.scale.speed_mm_s!r} mm/s",
            "viscosity": f"{base.scale.viscosity_mPa_s!r} mPa s",
            "surface_tension": f"{base.scale.surface_tension_mN_m!r} mN/m",
            "thickness": f"{base.scale.thickness_um!r} um",
            "offset": f"{base.offset * base.scale.diameter_um!r} um",
        }
    parameters = Parameters.from_physical(**{**constants, **quantities, **physical, **changes})
    if base.scale is None and not {*physical, *changes} & {"offset"}:
        return parameters.replace(offset=base.offset)  # in D0, which nothing else has changed
    return parameters


def _assigned(assignments: Sequence[str]) -> dict[str, Any]:
    """Read NAME=VALUE pairs."""
    values: dict[str, Any] = {}
    for assignment in assignments:
        name, equals, text = (part.strip() for part in assignment.partition("="))
        if not (name and equals and text):
            raise InputError.of("--set", "NAME=VALUE", assignment, "write it like line_tension=60")
        if name in values:
            raise InputError.of(f"--set {name}", "given once", text, "drop one of them")
        values[name] = value_of(f"--set {name}", text)
    return values
