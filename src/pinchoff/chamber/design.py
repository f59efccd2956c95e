"""The device as a whole: its regions' parameters, checked against each other."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

from pydantic import BeforeValidator, model_validator

from pinchoff.chamber.parameters import (
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
from pinchoff.support.files import read_toml

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.layout import Layout


def _part(model: type[Checked]) -> Any:
    """Return a field for the parameters of a part; a table is checked as the part's own."""

    def read(value: object) -> object:
        return model(**value) if isinstance(value, Mapping) else value

    return BeforeValidator(read)


def _default(model: type[Checked], meaning: str) -> Any:
    return explained(f"a table of {model.__name__}", meaning, default_factory=model)


class Chamber(Checked):
    """The microfluidic device, parametric; the defaults are the paper's device [appendix A].

    Parameters
    ----------
    thickness_um : float
        z, the height of the moulded channels [paper: 85; 45 as a variant].
    inlets, junction, oil_inputs, expansion, supports, imaging, exit
        Regions 1 to 7, each a model of `pinchoff.chamber` or a mapping of its parameters.
    mask, rules, operation
        The photomask, the design rules, and how the device is run.

    Raises
    ------
    InputError
        A value is out of its range, or parts do not fit each other; names the parameter, as in
        ``imaging.pitch_um``.

    Examples
    --------
    >>> import pinchoff as po
    >>> chamber = po.chamber.Chamber(imaging={"obstacle_radius_um": 60})
    >>> round(chamber.length_um), round(chamber.width_um)
    (22000, 6500)
    >>> len(chamber.obstacles.query("region == 'imaging'"))
    32
    """

    thickness_um: Number = number(1, 2000, "z in µm", default=85.0)
    inlets: Annotated[Inlets, _part(Inlets)] = _default(Inlets, "the inlets' parameters")
    junction: Annotated[Junction, _part(Junction)] = _default(Junction, "the junction's parameters")
    oil_inputs: Annotated[OilInputs, _part(OilInputs)] = _default(
        OilInputs, "the extra oil inlets' parameters"
    )
    expansion: Annotated[Expansion, _part(Expansion)] = _default(
        Expansion, "the expansion's parameters"
    )
    supports: Annotated[Supports, _part(Supports)] = _default(
        Supports, "the structural pillars' parameters"
    )
    imaging: Annotated[Imaging, _part(Imaging)] = _default(Imaging, "the imaging area's parameters")
    exit: Annotated[Exit, _part(Exit)] = _default(Exit, "the exit's parameters")
    mask: Annotated[Mask, _part(Mask)] = _default(Mask, "the photomask's parameters")
    rules: Annotated[DesignRules, _part(DesignRules)] = _default(DesignRules, "the design rules")
    operation: Annotated[Operation, _part(Operation)] = _default(Operation, "how the device is run")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        _require_fit(self)
        return self

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Read the device from a TOML file with a table for each part, as ``[imaging]``.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as the constructor, naming the key.
        """
        return cls(**read_toml(Path(path)))

    @cached_property
    def layout(self) -> Layout:
        """The geometry that all files, checks and flows follow from."""
        from pinchoff.chamber import load

        layout: Layout = load("layout").build_layout(self)
        return layout

    @property
    def width_um(self) -> float:
        """Width of the chamber between its side walls, µm."""
        return self.imaging.rows * self.imaging.pitch_um + 2 * self.supports.flank_um

    @property
    def length_um(self) -> float:
        """Length of the device, from the oil port's edge to the outlet's, µm."""
        return self.layout.stations.end

    @property
    def least_gap_um(self) -> float:
        """Narrowest fluid that the rules allow at this thickness, µm."""
        return max(self.rules.least_gap_um, self.thickness_um / self.rules.largest_aspect_ratio)

    @property
    def least_wall_um(self) -> float:
        """Thinnest solid that the rules allow at this thickness, µm."""
        return max(self.rules.least_wall_um, self.thickness_um / self.rules.largest_aspect_ratio)

    @property
    def obstacles(self) -> pd.DataFrame:
        """Every pillar: ``obstacle_x_um``, ``obstacle_y_um``, ``obstacle_radius_um``, ``region``.

        In the design's coordinates; `pinchoff.chamber.in_frame` has those of a picture. Regions
        are named as the parts: the obstacles of the imaging area are those of ``"imaging"``.
        """
        from pinchoff.chamber.positions import pillar_table

        return pillar_table(self.layout)


def _require_fit(chamber: Chamber) -> None:
    """Refuse parts that do not fit each other.

    Where rules only warn, what is too narrow is left to the design-rule check, which shows it.
    """
    strict = chamber.rules.on_violation == "refuse"
    _require_pillars_apart(chamber, chamber.least_gap_um if strict else 0.0)
    if strict:
        _require_channels(chamber)
    _require_chain(chamber)


def _require_pillars_apart(chamber: Chamber, least: float) -> None:
    for place, pitch, radius in (
        ("imaging", chamber.imaging.pitch_um, chamber.imaging.obstacle_radius_um),
        ("supports", chamber.supports.pitch_um, chamber.supports.radius_um),
    ):
        if pitch < 2 * radius + least:
            raise InputError.of(
                f"{place}.pitch_um",
                f"at least {2 * radius + least:g}, a diameter and the narrowest gap of {least:g}",
                pitch,
                "raise it, or lower the radius",
            )
    if chamber.inlets.post_gap_um < least:
        _narrow("inlets.post_gap_um", chamber.inlets.post_gap_um, least)
    strip = (chamber.supports.radius_um + least) / FLANK_SHARE
    if chamber.supports.flank_um < strip:
        raise InputError.of(
            "supports.flank_um",
            f"at least {strip:g}, room for a structural pillar and gaps beside it",
            chamber.supports.flank_um,
            "raise it, or lower supports.radius_um",
        )


def _require_channels(chamber: Chamber) -> None:
    """Refuse channels and walls that the rules would not pass."""
    least = chamber.least_gap_um
    for name, width in (
        ("inlets.arm_width_um", chamber.inlets.arm_width_um),
        ("junction.water_width_um", chamber.junction.water_width_um),
        ("junction.cross_width_um", chamber.junction.cross_width_um),
        ("junction.orifice_width_um", chamber.junction.orifice_width_um),
        ("junction.channel_width_um", chamber.junction.channel_width_um),
        ("oil_inputs.channel_width_um", chamber.oil_inputs.channel_width_um),
        ("exit.width_um", chamber.exit.width_um),
    ):
        if width < least:
            _narrow(name, width, least)
    for name, width in (
        ("inlets.wall_um", chamber.inlets.wall_um),
        ("inlets.post_diameter_um", chamber.inlets.post_diameter_um),
        ("expansion.divider_um", chamber.expansion.divider_um),
        ("imaging.obstacle_radius_um", 2 * chamber.imaging.obstacle_radius_um),
    ):
        if width < chamber.least_wall_um:
            advice = "raise it, or change the rules or the thickness"
            rule = f"such that the solid is at least {chamber.least_wall_um:g} µm wide"
            raise InputError.of(name, rule, f"{width:g} µm", advice)


def _narrow(name: str, width: float, least: float) -> None:
    raise InputError.of(
        name,
        f"at least {least:g}, the narrowest fluid that the rules allow at this thickness",
        width,
        "raise it, or change the rules or the thickness",
    )


class _Limit(NamedTuple):
    """What a parameter must be at least or at most for the parts to fit."""

    name: str
    value: float
    least: float
    most: float
    why: str


def _require_chain(chamber: Chamber) -> None:
    """Refuse parts that do not join: each limit is one of the parameter that is named."""
    for name, value, least, most, why in (*_inlet_limits(chamber), *_chamber_limits(chamber)):
        if not least <= value <= most:
            limit = f"at least {least:g}" if value < least else f"at most {most:g}"
            advice = "raise it" if value < least else "lower it"
            raise InputError.of(name, f"{limit}, {why}", value, f"{advice}, or change the other")


def _inlet_limits(chamber: Chamber) -> Iterator[_Limit]:
    inlets, junction, extra = chamber.inlets, chamber.junction, chamber.oil_inputs
    pitch = inlets.post_diameter_um + inlets.post_gap_um
    yield _Limit(
        "inlets.port_diameter_um",
        inlets.port_diameter_um,
        junction.water_width_um + pitch,
        math.inf,
        "the water channel and a post with its gap",
    )
    yield _Limit(
        "inlets.trap_length_um", inlets.trap_length_um, pitch, math.inf, "a post with its gap"
    )
    yield _Limit(
        "inlets.wall_um",
        inlets.wall_um,
        (junction.channel_width_um - inlets.port_diameter_um) / 2 + chamber.expansion.divider_um,
        math.inf,
        "so that the droplets' channel and its dividers fit between the oil channels",
    )
    yield _Limit(
        "oil_inputs.channel_width_um",
        extra.channel_width_um,
        0.0,
        extra.port_diameter_um,
        "the diameter of its port",
    )


def _chamber_limits(chamber: Chamber) -> Iterator[_Limit]:
    inlets, junction, extra = chamber.inlets, chamber.junction, chamber.oil_inputs
    expansion, imaging = chamber.expansion, chamber.imaging
    yield _Limit(
        "junction.channel_width_um",
        junction.channel_width_um,
        junction.orifice_width_um,
        math.inf,
        "the width of the orifice",
    )
    yield _Limit(
        "junction.taper_length_um",
        junction.taper_length_um,
        0.0,
        inlets.wall_um + expansion.length_um + expansion.straight_um - junction.orifice_length_um,
        "what is left from the orifice to the imaging area",
    )
    outer = inlets.port_diameter_um / 2 + 2 * inlets.wall_um + inlets.arm_width_um
    outer += (extra.port_diameter_um + extra.channel_width_um) / 2
    yield _Limit(
        "imaging.rows",
        imaging.rows,
        math.ceil(2 * (outer - chamber.supports.flank_um) / imaging.pitch_um),
        math.inf,
        "for a chamber, rows * pitch_um and two flanks, that the extra oil inlets can join",
    )
    yield _Limit(
        "exit.width_um",
        chamber.exit.width_um,
        0.0,
        min(chamber.width_um, chamber.exit.port_diameter_um),
        "the chamber's width and the diameter of the outlet",
    )
