"""Options about the model, and how they become parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.assignments import read_values
from pinchoff.cli.options import MODEL, argument, flag_of, named_as_options, option
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.parameters import Parameters

MODELS = ("deformable-particle", "front-tracking")
"""What --model takes."""

PRESETS = ("default", "paper-step", "front-tracking", "literal-separation", "soft-edges")
"""What --preset takes."""

CONSTANTS = (
    "vertex_count",
    "line_tension",
    "edge_stiffness",
    "area_stiffness",
    "wall_stiffness",
    "contact_angle",
    "start_distance",
    "time_step",
    "time_limit",
    "neck_thickness",
    "neck_separation",
    "neck_separation_unit",
    "neck_thickness_unit",
    "ca_conversion",
    "conversion_constant",
    "ca_speed",
    "follow_daughters",
)
"""What --set takes: the parameters that have no option of their own."""

_OPTIONS = (
    "model",
    "size_ratio",
    "simulation_capillary_number",
    "offset",
    "diameter",
    "obstacle_radius",
    "speed",
    "viscosity",
    "surface_tension",
    "thickness",
)


def set_option(takes: str, meaning: str, panel: str = MODEL) -> Any:
    """Return --set, which takes the `CONSTANTS`."""
    meaning = f"{meaning}; may be repeated. NAME is {', '.join(CONSTANTS)}"
    return option(takes, meaning, "--set", panel=panel)


@dataclass(frozen=True)
class ModelOptions:
    """The constants of the model by name, and what the outline is made of."""

    preset: Annotated[
        str | None,
        option(
            "NAME", f"Model constants by name: {', '.join(PRESETS)}", default="default", panel=MODEL
        ),
    ] = None
    model: Annotated[
        str | None,
        option(
            "NAME",
            f"What the outline is made of: {' or '.join(MODELS)}",
            default=MODELS[0],
            panel=MODEL,
        ),
    ] = None

    def parameters(self) -> tuple[Parameters, str]:
        """Return what the options say, and the preset's name."""
        return _configuration(None, self.preset, self.model)


@dataclass(frozen=True)
class ModelFileOptions(ModelOptions):
    """A preset and a model, or all parameters from a file."""

    config: Annotated[
        Path | None, argument("CONFIG.toml", "Parameters from a TOML file", show_default=False)
    ] = None

    def parameters(self) -> tuple[Parameters, str]:
        """Return what the file and the options say, and the preset's name."""
        return _configuration(self.config, self.preset, self.model)


def _configuration(
    config: Path | None, preset: str | None, model: str | None
) -> tuple[Parameters, str]:
    """Return what a file or else a preset says; a model that is given stands in place of theirs."""
    from pinchoff.model.parameters import Parameters
    from pinchoff.support.files import read_toml

    if config is None:
        preset = preset or "default"
        with named_as_options("preset"):
            base = Parameters.preset(preset)
    elif preset is not None:
        advice = f"write the preset into {config}"
        raise InputError.of("--preset", "left out beside a file", preset, advice)
    else:
        table = read_toml(config)
        base, preset = Parameters.from_config(table), str(table.get("preset", "default"))
    if model is None:
        return base, preset
    try:
        return base.replace(model=model), preset
    except InputError as error:
        raise error.renamed(_as_options(error.argument)) from None


def changed(
    base: Parameters,
    options: Mapping[str, str],
    assignments: Sequence[str],
    physical: Mapping[str, str],
) -> Parameters:
    """Return parameters in which the command line overrides the configuration.

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
    assigned = read_values("--set", assignments, "line_tension=60")
    for name in options.keys() & assigned.keys():
        raise InputError.of(
            f"--set {name}", "given once", assigned[name], f"drop it or {flag_of(name)}"
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
        raise error.renamed(name) from None
    return parameters


def _as_options(names: str) -> str:
    return " ".join(flag_of(name) if name in _OPTIONS else name for name in names.split(" "))


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
            flag_of(name),
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
        return parameters.replace(offset=base.offset)  # in D0, as the configuration has it
    return parameters
