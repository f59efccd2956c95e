"""What the device is asked to be: the parameters of its parts, checked against each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from operator import attrgetter
from typing import Any, NamedTuple, Self

from pydantic import ValidationInfo, field_validator, model_validator

from pinchoff.chamber.parts import (
    FLANK_SHARE,
    DesignRules,
    Exit,
    Expansion,
    Imaging,
    Inlets,
    Junction,
    Mask,
    OilInputs,
    Operation,
    Supports,
)
from pinchoff.support.checked import Checked, Number, explained, number
from pinchoff.support.errors import InputError
from pinchoff.support.paper_constants import THICKNESS_UM


def _part(model: type[Checked], meaning: str) -> Any:
    """Return a field for a part; `Device` reads it from a table too."""
    return explained(f"a table of {model.__name__}", meaning, default_factory=model)


class Device(Checked):
    """The parameters of `pinchoff.chamber.Chamber`, without the geometry that follows from them."""

    thickness_um: Number = number(1, 2000, "z in µm", default=THICKNESS_UM)
    inlets: Inlets = _part(Inlets, "the inlets' parameters")
    junction: Junction = _part(Junction, "the junction's parameters")
    oil_inputs: OilInputs = _part(OilInputs, "the extra oil inlets' parameters")
    expansion: Expansion = _part(Expansion, "the expansion's parameters")
    supports: Supports = _part(Supports, "the structural pillars' parameters")
    imaging: Imaging = _part(Imaging, "the imaging area's parameters")
    exit: Exit = _part(Exit, "the exit's parameters")
    mask: Mask = _part(Mask, "the photomask's parameters")
    rules: DesignRules = _part(DesignRules, "the design rules")
    operation: Operation = _part(Operation, "how the device is run")

    @field_validator("*", mode="before")
    @classmethod
    def _read(cls, value: object, about: ValidationInfo) -> object:
        """Check a table as the constructor of its part does, whose refusals name the key."""
        part = cls.model_fields[about.field_name or ""].annotation
        if isinstance(value, Mapping) and isinstance(part, type) and issubclass(part, Checked):
            return part(**value)
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _require_fit(self)
        return self

    @property
    def width_um(self) -> float:
        """Width of the chamber between its side walls, µm."""
        return self.imaging.rows * self.imaging.pitch_um + 2 * self.supports.flank_um

    @property
    def least_gap_um(self) -> float:
        """Narrowest fluid that the rules allow at this thickness, µm."""
        return max(self.rules.least_gap_um, self.thickness_um / self.rules.largest_aspect_ratio)

    @property
    def least_wall_um(self) -> float:
        """Thinnest solid that the rules allow at this thickness, µm."""
        return max(self.rules.least_wall_um, self.thickness_um / self.rules.largest_aspect_ratio)


def _require_fit(device: Device) -> None:
    """Refuse parts that do not fit each other.

    Where rules only warn, what is too narrow is left to the design-rule check, which shows it.
    """
    strict = device.rules.on_violation == "refuse"
    _require_pillars_apart(device, device.least_gap_um if strict else 0.0)
    if strict:
        _require_channels(device)
    _require_chain(device)


def _require_pillars_apart(device: Device, least: float) -> None:
    for place, pitch, radius in (
        ("imaging", device.imaging.pitch_um, device.imaging.obstacle_radius_um),
        ("supports", device.supports.pitch_um, device.supports.radius_um),
    ):
        if pitch < 2 * radius + least:
            raise InputError.of(
                f"{place}.pitch_um",
                f"at least {2 * radius + least:g}, a diameter and the narrowest gap of {least:g}",
                pitch,
                "raise it, or lower the radius",
            )
    _require_wide(device, "inlets.post_gap_um", least)
    strip = (device.supports.radius_um + least) / FLANK_SHARE
    if device.supports.flank_um < strip:
        raise InputError.of(
            "supports.flank_um",
            f"at least {strip:g}, room for a structural pillar and gaps beside it",
            device.supports.flank_um,
            "raise it, or lower supports.radius_um",
        )


def _require_channels(device: Device) -> None:
    """Refuse channels and walls that the rules would not pass."""
    for name in (
        "inlets.arm_width_um",
        "junction.water_width_um",
        "junction.cross_width_um",
        "junction.orifice_width_um",
        "junction.channel_width_um",
        "oil_inputs.channel_width_um",
        "exit.width_um",
    ):
        _require_wide(device, name, device.least_gap_um)
    for name, width in (
        ("inlets.wall_um", device.inlets.wall_um),
        ("inlets.post_diameter_um", device.inlets.post_diameter_um),
        ("expansion.divider_um", device.expansion.divider_um),
        ("imaging.obstacle_radius_um", 2 * device.imaging.obstacle_radius_um),
    ):
        if width < device.least_wall_um:
            advice = "raise it, or change the rules or the thickness"
            rule = f"such that the solid is at least {device.least_wall_um:g} µm wide"
            raise InputError.of(name, rule, f"{width:g} µm", advice)


def _require_wide(device: Device, name: str, least: float) -> None:
    width = attrgetter(name)(device)
    if width < least:
        rule = f"at least {least:g}, the narrowest fluid that the rules allow at this thickness"
        advice = "raise it, or change the rules or the thickness"
        raise InputError.of(name, rule, width, advice)


class _Limit(NamedTuple):
    """What a parameter must be at least or at most for the parts to fit."""

    name: str
    why: str
    least: float = -math.inf
    most: float = math.inf


def _require_chain(device: Device) -> None:
    """Refuse parts that do not join; each limit names its parameter."""
    for name, why, least, most in _limits(device):
        value = attrgetter(name)(device)
        if not least <= value <= most:
            limit = f"at least {least:g}" if value < least else f"at most {most:g}"
            advice = "raise it" if value < least else "lower it"
            raise InputError.of(name, f"{limit}, {why}", value, f"{advice}, or change the other")


def _limits(device: Device) -> Iterator[_Limit]:
    inlets, junction, extra = device.inlets, device.junction, device.oil_inputs
    expansion, imaging = device.expansion, device.imaging
    pitch = inlets.post_diameter_um + inlets.post_gap_um
    yield _Limit(
        "inlets.port_diameter_um",
        "the water channel and a post with its gap",
        least=junction.water_width_um + pitch,
    )
    yield _Limit("inlets.trap_length_um", "a post with its gap", least=pitch)
    yield _Limit(
        "inlets.wall_um",
        "so that the droplets' channel and its dividers fit between the oil channels",
        least=(junction.channel_width_um - inlets.port_diameter_um) / 2 + expansion.divider_um,
    )
    yield _Limit(
        "oil_inputs.channel_width_um", "the diameter of its port", most=extra.port_diameter_um
    )
    yield _Limit(
        "junction.channel_width_um", "the width of the orifice", least=junction.orifice_width_um
    )
    left = inlets.wall_um + expansion.length_um + expansion.straight_um
    yield _Limit(
        "junction.taper_length_um",
        "what is left from the orifice to the imaging area",
        most=left - junction.orifice_length_um,
    )
    outer = inlets.port_diameter_um / 2 + 2 * inlets.wall_um + inlets.arm_width_um
    outer += (extra.port_diameter_um + extra.channel_width_um) / 2
    yield _Limit(
        "imaging.rows",
        "for a chamber, rows * pitch_um and two flanks, that the extra oil inlets can join",
        least=math.ceil(2 * (outer - device.supports.flank_um) / imaging.pitch_um),
    )
    yield _Limit(
        "exit.width_um",
        "the chamber's width and the diameter of the outlet",
        most=min(device.width_um, device.exit.port_diameter_um),
    )
