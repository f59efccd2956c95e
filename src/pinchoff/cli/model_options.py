"""Options about the model, and how they become parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pinchoff.cli.assignments import read_values
from pinchoff.cli.options import MODEL, argument, flag_of, named_as_options, option
from pinchoff.model.parameters import FRONT, SPRINGS, Parameters, preset_names
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml
from pinchoff.support.quantities import GROUP_ORIGINS, PHYSICAL_NAMES, SCALE_QUANTITIES

_OPTIONS = ("model", "size_ratio", "simulation_capillary_number", *PHYSICAL_NAMES)
_CONSTANTS = [name for name in Parameters.model_fields if name not in (*_OPTIONS, "scale")]


def set_option(takes: str, meaning: str, panel: str = MODEL) -> Any:
    """Return --set, which takes the parameters that have no option of their own."""
    meaning = f"{meaning}; may be repeated. NAME is {', '.join(_CONSTANTS)}"
    return option(takes, meaning, "--set", panel=panel)


@dataclass(frozen=True)
class ModelOptions:
    """The constants of the model by name, and what the outline is made of."""

    preset: Annotated[
        str | None,
        option(
            "NAME",
            f"Model constants by name: {', '.join(preset_names())}",
            default="default",
            panel=MODEL,
        ),
    ] = None
    model: Annotated[
        str | None,
        option(
            "NAME",
            f"What the outline is made of: {SPRINGS} or {FRONT}",
            default=SPRINGS,
            panel=MODEL,
        ),
    ] = None

    def parameters(self) -> tuple[Parameters, str]:
        """Return what the options say, and the preset's name."""
        preset = self.preset or "default"
        with named_as_options("preset"):
            return self.with_model(Parameters.preset(preset)), preset

    def with_model(self, base: Parameters) -> Parameters:
        """Return parameters with the model that is given in place of their own."""
        try:
            return base if self.model is None else base.replace(model=self.model)
        except InputError as error:
            raise error.renamed(_as_options(error.argument)) from None


@dataclass(frozen=True)
class ModelFileOptions(ModelOptions):
    """A preset and a model, or all parameters from a file."""

    config: Annotated[
        Path | None, argument("CONFIG.toml", "Parameters from a TOML file", show_default=False)
    ] = None

    def parameters(self) -> tuple[Parameters, str]:
        """Return what the file and the options say, and the preset's name."""
        if self.config is None:
            return super().parameters()
        if self.preset is not None:
            advice = f"write the preset into {self.config}"
            raise InputError.of("--preset", "left out beside a file", self.preset, advice)
        table = read_toml(self.config)
        base = self.with_model(Parameters.from_config(table))
        return base, str(table.get("preset", "default"))


def changed(
    base: Parameters,
    options: Mapping[str, str],
    assignments: Sequence[str],
    physical: Mapping[str, str],
) -> Parameters:
    """Return parameters in which the command line overrides the configuration.

    `options` are the dimensionless options that are given, `physical` those with a unit, both by
    the names of the library; `assignments` stand behind --set. A refusal names the option.
    """
    assigned = read_values("--set", assignments, "line_tension=60")
    for name in options:
        if name in assigned:
            advice = f"drop it or {flag_of(name)}"
            raise InputError.of(f"--set {name}", "given once", assigned[name], advice)
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
    if base.scale is None and physical.keys() == {"offset"}:
        raise InputError.of(
            "--offset",
            "a number of D0, or a length beside physical quantities",
            physical["offset"],
            "give a number, or --diameter and the other quantities too",
        )
    if base.scale is None and not physical:
        return
    for name, origins in GROUP_ORIGINS.items():
        if name in changes:
            rule = "left out beside physical quantities, from which it follows"
            advice = f"change {_as_options(origins)}"
            raise InputError.of(flag_of(name), rule, str(changes[name]), advice)


def _physical(
    base: Parameters, physical: Mapping[str, str], changes: Mapping[str, Any]
) -> Parameters:
    """Build parameters from quantities; those not given are the configuration's."""
    groups = {*GROUP_ORIGINS, "offset", "scale"}
    constants = {name: getattr(base, name) for name in base.model_fields_set - groups}
    quantities: dict[str, str | None] = dict.fromkeys(PHYSICAL_NAMES)
    if base.scale is not None:
        for name, (field, unit, _) in SCALE_QUANTITIES.items():
            quantities[name] = f"{getattr(base.scale, field)!r} {unit}"
        quantities["offset"] = f"{base.offset * base.scale.diameter_um!r} um"
    parameters = Parameters.from_physical(**{**constants, **quantities, **physical, **changes})
    if base.scale is None and not {*physical, *changes} & {"offset"}:
        return parameters.replace(offset=base.offset)  # in D0, as the configuration has it
    return parameters
