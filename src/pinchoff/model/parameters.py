"""Parameters of a collision: the dimensionless groups, their defaults and their limits.

Lengths are in D0, the diameter of the undeformed droplet; speeds in v_f∞, the speed of the fluid;
masses in M, the droplet's. So the unit of time is t0 = D0/v_f∞.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pinchoff.model.consistency import require_consistent
from pinchoff.model.entry import CoreNumber, Entry, documented, entries_of, parameter
from pinchoff.model.presets import preset_constants, preset_description, preset_names
from pinchoff.support.checked import Checked, Number, WholeNumber, explained, unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml
from pinchoff.support.paper_constants import CA_PER_CA_SIM, NECK_SEPARATION, NECK_THICKNESS
from pinchoff.support.quantities import (
    PhysicalScale,
    blaming_quantities,
    ca_per_ca_sim,
    groups_of_scale,
    physical_groups,
    refuse_physical_groups,
)

if TYPE_CHECKING:
    import os

    from pinchoff.support.units import Physical

__all__ = [
    "CA_PER_CA_SIM",
    "DEFAULTS",
    "PARAMETERS",
    "SAMPLE_INTERVAL",
    "Parameters",
    "PhysicalScale",
    "preset_description",
    "preset_names",
]

AREA_STIFFNESS_PER_LINE_TENSION = 5000.0
"""Default of k̃_a/γ̃: a droplet round an obstacle loses 0.4 % of its area, a small one 0.55 %."""

WALL_STIFFNESS_PER_LINE_TENSION = 1.25
"""Default of ε̃_w/γ̃: a stiffer wall forces a smaller time step."""

EVENING_RATE = 50.0
"""Front tracking: rate at which edges return to one length, 1/t0; results do not depend on it."""

SAMPLE_INTERVAL = 0.01
"""Time between two measurements of a run, t0. Recording happens at multiples of it."""

Model = Literal["deformable-particle", "front-tracking"]
CaConversion = Literal["constant", "fixed-film"]
CaSpeed = Literal["far", "contact"]
TimeStep = Literal["auto"] | Annotated[Number, Field(ge=1e-7, le=0.1)]


SPRINGS: Model = "deformable-particle"
"""The paper's model: vertices with mass, held by springs, line tension and a stiff area."""

FRONT: Model = "front-tracking"
"""Its limit without springs: an outline that is line tension alone."""

_VERTICES: dict[object, int] = {SPRINGS: 64, FRONT: 128}


def _line_tension(given: dict[str, Any]) -> float:
    # Missing when it was refused itself, which is then the error that the user gets to see.
    return float(given.get("line_tension", math.nan))


class Parameters(Checked):
    """Everything that decides a collision: dimensionless, checked and immutable.

    Every parameter is a keyword; one that is missing or None has the value of the preset
    ``default``. Equal parameters give equal collisions.

    Parameters
    ----------
    **values
        Each as its entry in the class body says.
    scale : PhysicalScale, optional
        The experiment that the numbers stand for; `from_physical` fills it in.

    Raises
    ------
    InputError
        A value is out of its range, not finite or of the wrong type; a name is unknown; or the
        scale disagrees with the dimensionless numbers.

    Examples
    --------
    >>> p = Parameters(size_ratio=5.66, simulation_capillary_number=20, offset=0.05)
    >>> round(p.capillary_number, 5)
    0.00196
    >>> p.replace(line_tension=20).area_stiffness
    100000.0
    """

    # One entry each: whatever else is said of a parameter follows from here. What a number of the
    # core follows from several parameters is in the entry of the one that it changes with.
    model: Model = parameter(
        SPRINGS,
        "what the outline is made of",
        rule=f"'{SPRINGS}' or '{FRONT}'",
        note="The paper's springs, or their limit: line tension alone.",
        core_name="front_tracking",
        core=lambda p: p.model == FRONT,
    )
    size_ratio: Number = parameter(
        5.66,
        "the undeformed droplet's diameter over the obstacle's radius",
        symbol="D0/R",
        unit="1",
        low=0.01,
        high=100,
        core_name="obstacle_radius",
    )
    simulation_capillary_number: Number = parameter(
        25.0,
        "drag over line tension, μ̃/γ̃ = Ca/9.8e-5",
        symbol="Ca_sim",
        unit="1",
        low=1e-3,
        high=1e5,
        core_name="drag",
    )
    offset: Number = parameter(
        0.05,
        "the droplet's start y",
        symbol="y0",
        unit="D0",
        low=-5,
        high=5,
        note="The obstacle's centre is at y = 0.",
    )
    vertex_count: WholeNumber = parameter(
        lambda given: _VERTICES.get(given.get("model"), 64),
        "how many vertices the outline has",
        symbol="N_v",
        unit="1",
        rule="a whole number from 16 to 1024",
        low=16,
        high=1024,
        follows=f"{_VERTICES[SPRINGS]}, or {_VERTICES[FRONT]} with {FRONT}",
    )
    line_tension: Number | None = parameter(
        80.0,
        "the line tension, γ_2D t0/(M v_f∞)",
        symbol="γ̃",
        unit="M v_f∞²/D0",
        low=1e-3,
        high=1e5,
        note="From about 20 on the motion is overdamped.",
        model=SPRINGS,
        core=lambda p: p.line_tension or 1.0,  # front tracking knows no other force: the unit
    )
    edge_stiffness: Number | None = parameter(
        3.0,
        "the stiffness of edges, k_l D0/γ_2D",
        symbol="k̃_l",
        unit="1",
        low=1e-6,
        high=1e4,
        model=SPRINGS,
        core=lambda p: (p.edge_stiffness or 0.0) * (p.line_tension or 0.0),
    )
    area_stiffness: Number | None = parameter(
        lambda given: AREA_STIFFNESS_PER_LINE_TENSION * _line_tension(given),
        "the stiffness of the area, k_a D0⁴/(M v_f∞²)",
        symbol="k̃_a",
        unit="M v_f∞²/D0⁴",
        low=1e-3,
        high=1e9,
        follows=f"{AREA_STIFFNESS_PER_LINE_TENSION:g} γ̃",
        model=SPRINGS,
    )
    wall_stiffness: Number | None = parameter(
        lambda given: WALL_STIFFNESS_PER_LINE_TENSION * _line_tension(given),
        "the stiffness of the wall, ε_w/(M v_f∞²)",
        symbol="ε̃_w",
        unit="M v_f∞²",
        low=1e-3,
        high=1e9,
        follows=f"{WALL_STIFFNESS_PER_LINE_TENSION:g} γ̃",
        model=SPRINGS,
    )
    contact_angle: Number = parameter(
        180.0,
        "the angle at which a droplet meets a pillar, measured in the droplet",
        symbol="θ",
        unit="°",
        low=30,
        high=180,
        note="180: the pillars are not wet. Springs make the angle larger.",
        core_name="adhesion",
        core=lambda p: (p.line_tension or 1.0) * (1.0 + math.cos(math.radians(p.contact_angle))),
    )
    start_distance: Number = parameter(
        5.0,
        "how far upstream of the obstacle's centre the droplet starts",
        unit="D0",
        low=0.75,
        high=1000,
    )
    time_step: TimeStep = parameter(
        "auto",
        "the time step",
        symbol="Δt",
        unit="t0",
        rule="'auto' or a finite number from 1e-07 to 0.1",
        note="'auto' takes the largest step whose results agree with the paper's step.",
        core=lambda p: math.nan if p.time_step == "auto" else p.time_step,
    )
    time_limit: Number = parameter(
        30.0,
        "when the run ends at the latest",
        unit="t0",
        low=0.01,
        high=1e4,
        note="A droplet that has not left the obstacle behind by then counts as captured.",
    )
    neck_thickness: Number = parameter(
        NECK_THICKNESS,
        "the thickness below which a neck breaks",
        symbol="d_min-neck",
        unit="D0 or z",
        low=0,
        high=10,
        note="Zero: nothing ever breaks.",
        column="neck_thickness_limit",  # neck_thickness is what is measured
        core=lambda p: p.neck_threshold,
    )
    neck_thickness_unit: Literal["diameter", "thickness"] = parameter(
        "diameter",
        "what neck_thickness is measured in",
        rule="'diameter' or 'thickness'",
        note="D0, for daughters their own diameter; or the thickness z of the chamber, one length "
        "for all: that of the scale, or R where there is none.",
        core_name="neck_thickness_is_fixed",
        core=lambda p: p.neck_thickness_unit == "thickness",
    )
    neck_separation: Number = parameter(
        NECK_SEPARATION,
        "the shortest arc between the two sides of a neck",
        symbol="d_min-sep",
        unit="1 or D0",
        low=0.01,
        high=1.5,
    )
    neck_separation_unit: Literal["perimeter", "diameter"] = parameter(
        "perimeter",
        "what neck_separation is measured in",
        rule="'perimeter' or 'diameter'",
        note="A fraction of the current perimeter, or a length in D0.",
        core_name="neck_separation_in_diameters",
        core=lambda p: p.neck_separation_unit == "diameter",
    )
    follow_daughters: bool = parameter(
        True,
        "whether the run goes on after a break-up",
        rule="true or false",
        note="It then lasts until every droplet has left.",
        core_name="stop_at_breakup",
        core=lambda p: not p.follow_daughters,
    )
    ca_conversion: CaConversion = parameter(
        "constant",
        "the assumption that turns Ca_sim into Ca",
        rule="'constant' or 'fixed-film'",
        note="One conversion_constant for all sizes; or (δ/D0)² with one film thickness δ, which "
        "is conversion_constant at D0 = 481 µm. The motion does not depend on it.",
        in_core=False,
    )
    conversion_constant: Number = parameter(
        CA_PER_CA_SIM,
        "Ca per Ca_sim, at D0 = 481 µm with a fixed film",
        symbol="c",
        unit="1",
        low=1e-8,
        high=1,
        in_core=False,
    )
    ca_speed: CaSpeed = parameter(
        "far",
        "the speed in the Ca of tables",
        rule="'far' or 'contact'",
        note="v_f∞, as in the paper's simulations; or the droplet's own at first contact, as in "
        "its experiments.",
        in_core=False,
    )
    scale: PhysicalScale | None = explained(
        "a PhysicalScale", "the experiment behind the numbers, or use from_physical", default=None
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        require_consistent(self)
        return self

    @classmethod
    def preset(cls, name: str, **changes: Any) -> Self:
        """Return the constants of a named preset, with some of them changed.

        Parameters
        ----------
        name : str
            One of `preset_names`.
        **changes
            Parameters that differ from the preset.

        Raises
        ------
        InputError
            There is no such preset, or as the constructor.

        Examples
        --------
        >>> Parameters.preset("literal-separation", offset=0).neck_separation_unit
        'diameter'
        """
        return cls(**{**preset_constants(name), **changes})

    @classmethod
    def from_physical(
        cls,
        *,
        diameter: Physical,
        obstacle_radius: Physical,
        speed: Physical,
        viscosity: Physical,
        surface_tension: Physical,
        thickness: Physical,
        offset: Physical | None = None,
        **constants: Any,
    ) -> Self:
        """Return the parameters of an experiment.

        Ca = μ v/γ, Ca_sim = Ca/9.8e-5 [paper, eq. conv] and D0/R follow from the quantities, and
        `scale` keeps them, so that results come back in physical units too.

        Parameters
        ----------
        diameter, obstacle_radius : str or pint.Quantity
            D0 of the undeformed droplet, and R; lengths, such as ``"481 um"``.
        speed : str or pint.Quantity
            v_f∞, the speed of the fluid, such as ``"1.0 mm/s"``.
        viscosity : str or pint.Quantity
            μ, the fluid's dynamic viscosity, such as ``"48 mPa s"``.
        surface_tension : str or pint.Quantity
            γ, such as ``"20 mN/m"``.
        thickness : str or pint.Quantity
            z of the chamber, a length. The model is two-dimensional with z/R = 1; a chamber that
            is off by more than 1 % is warned of.
        offset : str or pint.Quantity, optional
            Start y of the droplet, a length; by default that of the constructor, 0.05 D0.
        **constants
            Constants of the model, dimensionless, such as ``vertex_count``.

        Raises
        ------
        InputError
            A quantity lacks its unit, has the wrong one, is not finite or (all but the offset)
            not positive; a constant is refused by the constructor, or follows from the physical
            quantities and must not be given as well.

        Warns
        -----
        UserWarning
            The thickness is not the one that the model stands for.

        Examples
        --------
        >>> p = Parameters.from_physical(
        ...     diameter="481 um", obstacle_radius="85 um", thickness="85 um", speed="1.0 mm/s",
        ...     viscosity="48 mPa s", surface_tension="20 mN/m", offset="20 um")
        >>> round(p.size_ratio, 3), round(p.simulation_capillary_number, 2), round(p.offset, 4)
        (5.659, 24.49, 0.0416)
        """
        refuse_physical_groups(constants)
        groups = physical_groups(
            {
                "diameter": diameter,
                "obstacle_radius": obstacle_radius,
                "speed": speed,
                "viscosity": viscosity,
                "surface_tension": surface_tension,
                "thickness": thickness,
                "offset": offset,
            },
            thickness_acts=constants.get("neck_thickness_unit") == "thickness",
        )
        return cls._of_groups(constants, groups)

    @classmethod
    def of_scale(
        cls, scale: PhysicalScale, *, offset_um: float | None = None, **constants: Any
    ) -> Self:
        """Return the parameters of an experiment that is known in numbers, as `from_physical`.

        Parameters
        ----------
        scale : PhysicalScale
        offset_um : float, optional
            Start y of the droplet, µm; by default that of the constructor, 0.05 D0.
        **constants
            Constants of the model, dimensionless.

        Raises
        ------
        InputError
            As `from_physical`.

        Examples
        --------
        >>> scale = PhysicalScale(
        ...     diameter_um=481, speed_mm_s=1, obstacle_radius_um=85, thickness_um=85,
        ...     viscosity_mPa_s=48, surface_tension_mN_m=20)
        >>> round(Parameters.of_scale(scale, offset_um=20).offset, 4)
        0.0416
        """
        refuse_physical_groups(constants)
        return cls._of_groups(constants, groups_of_scale(scale, offset_um))

    @classmethod
    def _of_groups(cls, constants: Mapping[str, Any], groups: Mapping[str, Any]) -> Self:
        """Join constants with what follows from physical quantities."""
        try:
            return cls(**{**constants, **groups, **_converted(constants, groups["scale"])})
        except InputError as error:
            raise blaming_quantities(error) from None

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Read the parameters from a TOML file.

        Its keys are the parameters' names, or ``preset``, or a table ``[physical]`` with the
        quantities of `from_physical` beside dimensionless constants.

        Parameters
        ----------
        path : str or path-like
            The file.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as `from_physical` and the constructor,
            naming the key.

        Examples
        --------
        >>> import pinchoff as po
        >>> from pathlib import Path
        >>> _ = Path("run.toml").write_text("size_ratio = 4")
        >>> po.Parameters.from_toml("run.toml").size_ratio
        4.0
        """
        return cls.from_config(read_toml(Path(path)))

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> Self:
        """Read the parameters from a table, as a TOML file holds it.

        Parameters
        ----------
        config : mapping
            The keys of `from_toml`.

        Raises
        ------
        InputError
            As `from_toml`.

        Examples
        --------
        >>> Parameters.from_config({"preset": "paper-step", "offset": 0.1}).time_step
        0.0001
        """
        table = dict(config)
        physical = table.pop("physical", None)
        known = {*cls.model_fields, "preset", "physical"}
        for name in table:
            if name not in known:
                raise unknown_name(name, "the name of a parameter", name, known)
        constants = {**preset_constants(table.pop("preset", "default")), **table}
        if physical is None:
            return cls(**constants)
        if not isinstance(physical, dict):
            raise InputError.of("physical", "a table", physical, "write it as [physical]")
        refuse_physical_groups(constants)
        try:
            acts = constants.get("neck_thickness_unit") == "thickness"
            groups = physical_groups(physical, thickness_acts=acts)
        except InputError as error:
            raise error.within("physical") from None
        return cls._of_groups(constants, groups)

    @property
    def obstacle_radius(self) -> float:
        """R, D0."""
        return 1.0 / self.size_ratio

    @property
    def ca_per_ca_sim(self) -> float:
        """Ca/Ca_sim as `ca_conversion` assumes it, dimensionless [paper, eq. conv]."""
        return ca_per_ca_sim(
            self.ca_conversion, self.conversion_constant, self.size_ratio, self.scale
        )

    @property
    def capillary_number(self) -> float:
        """Ca of the far flow, v_f∞, dimensionless [paper, eq. conv]."""
        return self.ca_per_ca_sim * self.simulation_capillary_number

    @property
    def normalized_area(self) -> float:
        """Ã = A/R² of the undeformed droplet, dimensionless."""
        return math.pi / 4.0 * self.size_ratio**2

    @property
    def normalized_thickness(self) -> float:
        """z̃ = z/R, dimensionless: 1 in the two-dimensional model, unless necks know z."""
        if self.neck_thickness_unit == "thickness" and self.scale is not None:
            return self.scale.thickness_um / self.scale.obstacle_radius_um
        return 1.0

    @property
    def neck_threshold(self) -> float:
        """The thickness below which the neck of the undeformed droplet breaks, D0."""
        if self.neck_thickness_unit == "thickness":
            return self.neck_thickness * self.normalized_thickness * self.obstacle_radius
        return self.neck_thickness

    @property
    def drag(self) -> float:
        """μ̃ = Ca_sim γ̃, in M/t0 [paper, eq. drag_force]; with front tracking in units of γ̃."""
        return self.simulation_capillary_number * (self.line_tension or 1.0)

    @property
    def effective_time_step(self) -> float:
        """Δt that a run takes, t0: the given one, or the automatic one.

        Raises
        ------
        InputError
            The given one is unstable.
        """
        from pinchoff import _core

        return float(self.model_row()[_core.MODEL_FIELDS.index("time_step")])

    def model_row(self) -> NDArray[np.float64]:
        """Return the model as one row of numbers, as the compiled core takes it.

        Returns
        -------
        ndarray, shape (len(_core.MODEL_FIELDS),)
            In units of D0, v_f∞ and M.

        Raises
        ------
        InputError
            The given time step is unstable.

        Examples
        --------
        >>> from pinchoff import _core
        >>> row = Parameters(size_ratio=4).model_row()
        >>> float(row[_core.MODEL_FIELDS.index("obstacle_radius")])
        0.25
        """
        from pinchoff import _core

        row = np.array([number(self) for number in core_numbers()], dtype=np.float64)
        position = _core.MODEL_FIELDS.index("time_step")
        if self.time_step == "auto":
            # A whole number of steps a sample, so that samples fall on round times.
            steps = math.ceil(SAMPLE_INTERVAL / _core.auto_time_step(row))
            row[position] = SAMPLE_INTERVAL / steps
        elif self.time_step > (limit := _core.stable_time_step(row)):
            raise InputError.of(
                "time_step",
                f"at most {limit:.3g}, the largest stable step of this model",
                self.time_step,
                "lower it, or use 'auto'",
            )
        return row


def require_parameters(argument: str, value: object) -> None:
    """Refuse anything that is not `Parameters`."""
    if not isinstance(value, Parameters):
        advice = "build it with pinchoff.Parameters(...)"
        raise InputError.of(argument, "a Parameters", value, advice)


def _converted(constants: Mapping[str, Any], scale: PhysicalScale) -> dict[str, float]:
    """Return Ca_sim of a scale under the conversion that constants ask for.

    Constants that are wrong are left for `Parameters` to refuse.
    """
    given = constants.get("conversion_constant")
    constant = given if isinstance(given, (int, float)) and given > 0 else CA_PER_CA_SIM
    conversion = constants.get("ca_conversion") or "constant"
    per = ca_per_ca_sim(conversion, constant, scale.size_ratio, scale)
    return {"simulation_capillary_number": scale.capillary_number / per}


PARAMETERS: dict[str, Entry] = entries_of(Parameters)
"""The entry of every parameter, in their order."""

DEFAULTS: dict[str, Any] = {
    name: getattr(Parameters(), name) for name, entry in PARAMETERS.items() if not entry.follows
}
"""The default of every parameter that does not follow from another."""

CORE_CONSTANTS = {"sample_interval": SAMPLE_INTERVAL, "evening_rate": EVENING_RATE}
"""Numbers of the core's row that are no parameters."""

Parameters.__doc__ = documented(Parameters.__doc__, PARAMETERS)


@functools.cache
def core_numbers() -> tuple[CoreNumber, ...]:
    """Return what fills each place of the core's row."""
    from pinchoff import _core

    numbers = {name: _always(value) for name, value in CORE_CONSTANTS.items()}
    numbers |= {entry.place: entry.core_value for entry in PARAMETERS.values() if entry.in_core}
    if unmatched := numbers.keys() ^ {*_core.MODEL_FIELDS}:
        raise RuntimeError(
            "the entries of Parameters and PINCHOFF_MODEL_FIELDS in model.hpp must name the same "
            f"numbers; got {', '.join(sorted(unmatched))} in one of them alone; correct the other"
        )
    return tuple(numbers[name] for name in _core.MODEL_FIELDS)


def _always(value: float) -> CoreNumber:
    return lambda _: value
