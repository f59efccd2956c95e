"""Parameters of a collision: the dimensionless groups, their defaults and their limits.

Lengths are in D0, the diameter of the undeformed droplet; speeds in v_f∞, the speed of the fluid;
masses in M, the droplet's. So the unit of time is t0 = D0/v_f∞.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pinchoff.model.consistency import require_consistent
from pinchoff.model.presets import DEFAULTS, preset_constants, preset_description, preset_names
from pinchoff.support.checked import Checked, Number, WholeNumber, explained, number, unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml
from pinchoff.support.quantities import (
    CA_PER_CA_SIM,
    PhysicalScale,
    blaming_quantities,
    groups_of_scale,
    physical_groups,
    refuse_physical_groups,
)

if TYPE_CHECKING:
    import os

    from pinchoff.support.quantities import Physical

__all__ = [
    "CA_PER_CA_SIM",
    "SAMPLE_INTERVAL",
    "Parameters",
    "PhysicalScale",
    "preset_description",
    "preset_names",
]

AREA_STIFFNESS_PER_LINE_TENSION = 5000.0
"""Default of k̃_a/γ̃: keeps the area to 0.3 %."""

WALL_STIFFNESS_PER_LINE_TENSION = 1.25
"""Default of ε̃_w/γ̃: a stiffer wall forces a smaller time step."""

SAMPLE_INTERVAL = 0.01
"""Time between two measurements of a run, t0. Recording happens at multiples of it."""

TimeStep = Literal["auto"] | Annotated[Number, Field(ge=1e-7, le=0.1)]


def _line_tension(given: dict[str, Any]) -> float:
    # Missing when it was refused itself, which is then the error that the user gets to see.
    return float(given.get("line_tension", math.nan))


class Parameters(Checked):
    """Everything that decides a collision: dimensionless, checked and immutable.

    Every parameter is a keyword; one that is missing or None has the value of the preset
    ``default``. Equal parameters give equal collisions.

    Parameters
    ----------
    size_ratio : float
        D0/R, diameter of the undeformed droplet over the obstacle's radius.
    simulation_capillary_number : float
        Ca_sim = μ̃/γ̃; the experiment's Ca is 9.8e-5 times as large [paper, eq. conv].
    offset : float
        Start y of the droplet, D0; the obstacle's centre is at y = 0.
    vertex_count : int
        N_v, vertices of the outline.
    line_tension : float
        γ̃, in M v_f∞²/D0. From about 20 on the motion is overdamped.
    edge_stiffness : float
        k̃_l = k_l D0/γ_2D, dimensionless [paper, eq. shape].
    area_stiffness : float
        k̃_a = k_a D0⁴/(M v_f∞²), dimensionless; by default 5000 γ̃.
    wall_stiffness : float
        ε̃_w = ε_w/(M v_f∞²), dimensionless; by default 1.25 γ̃.
    start_distance : float
        How far upstream of the obstacle's centre the droplet starts, D0.
    time_step : float or "auto"
        Δt, t0; "auto" takes the largest step whose results agree with the paper's step.
    time_limit : float
        When the run ends at the latest, t0: a droplet that has not left the obstacle behind by then
        counts as captured.
    neck_thickness : float
        A neck thinner than this breaks, D0. Zero: nothing ever breaks.
    neck_separation : float
        Shortest arc that counts as a neck's two sides, in `neck_separation_unit`.
    neck_separation_unit : "perimeter" or "diameter"
        Whether `neck_separation` is a fraction of the current perimeter or a length in D0.
    follow_daughters : bool
        Whether the run goes on after a break-up, until every droplet has left.
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

    size_ratio: Number = number(
        0.01, 100, "D0/R, the diameter over the obstacle's radius", default=DEFAULTS["size_ratio"]
    )
    simulation_capillary_number: Number = number(
        1e-3, 1e5, "Ca_sim, that is Ca/9.8e-5", default=DEFAULTS["simulation_capillary_number"]
    )
    offset: Number = number(-5, 5, "the droplet's start y in D0", default=DEFAULTS["offset"])
    vertex_count: WholeNumber = explained(
        "a whole number from 16 to 1024",
        "how many vertices the outline has",
        ge=16,
        le=1024,
        default=DEFAULTS["vertex_count"],
    )
    line_tension: Number = number(1e-3, 1e5, "γ̃ in M v_f∞²/D0", default=DEFAULTS["line_tension"])
    edge_stiffness: Number = number(1e-6, 1e4, "k̃_l", default=DEFAULTS["edge_stiffness"])
    area_stiffness: Number = number(
        1e-3,
        1e9,
        "k̃_a, or leave it out for 5000 γ̃",
        default_factory=lambda given: AREA_STIFFNESS_PER_LINE_TENSION * _line_tension(given),
    )
    wall_stiffness: Number = number(
        1e-3,
        1e9,
        "ε̃_w, or leave it out for 1.25 γ̃",
        default_factory=lambda given: WALL_STIFFNESS_PER_LINE_TENSION * _line_tension(given),
    )
    start_distance: Number = number(
        0.75, 1000, "how far upstream the droplet starts in D0", default=DEFAULTS["start_distance"]
    )
    time_step: TimeStep = explained(
        "'auto' or a finite number from 1e-07 to 0.1",
        "Δt in t0, or leave it to 'auto'",
        default=DEFAULTS["time_step"],
    )
    time_limit: Number = number(
        0.01, 1e4, "the latest end of the run in t0", default=DEFAULTS["time_limit"]
    )
    neck_thickness: Number = number(
        0, 1, "the thickness in D0 below which a neck breaks", default=DEFAULTS["neck_thickness"]
    )
    neck_separation: Number = number(
        0.01,
        1.5,
        "the shortest arc between the two sides of a neck",
        default=DEFAULTS["neck_separation"],
    )
    neck_separation_unit: Literal["perimeter", "diameter"] = explained(
        "'perimeter' or 'diameter'",
        "what neck_separation is measured in",
        default=DEFAULTS["neck_separation_unit"],
    )
    follow_daughters: bool = explained(
        "true or false",
        "whether the run goes on after a break-up",
        default=DEFAULTS["follow_daughters"],
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
        offset: Physical = "0 um",
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
            Start y of the droplet, a length.
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
            }
        )
        return cls._of_groups(constants, groups)

    @classmethod
    def of_scale(cls, scale: PhysicalScale, *, offset_um: float = 0.0, **constants: Any) -> Self:
        """Return the parameters of an experiment that is known in numbers, as `from_physical`.

        Parameters
        ----------
        scale : PhysicalScale
        offset_um : float, optional
            Start y of the droplet, µm.
        **constants
            Constants of the model, dimensionless.

        Raises
        ------
        InputError
            As `from_physical`.
        """
        refuse_physical_groups(constants)
        return cls._of_groups(constants, groups_of_scale(scale, offset_um))

    @classmethod
    def _of_groups(cls, constants: Mapping[str, Any], groups: Mapping[str, Any]) -> Self:
        """Join constants with what follows from physical quantities."""
        try:
            return cls(**{**constants, **groups})
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
            groups = physical_groups(physical)
        except InputError as error:
            raise error.within("physical") from None
        return cls._of_groups(constants, groups)

    @property
    def obstacle_radius(self) -> float:
        """R, D0."""
        return 1.0 / self.size_ratio

    @property
    def capillary_number(self) -> float:
        """Ca = 9.8e-5 Ca_sim, dimensionless [paper, eq. conv]."""
        return CA_PER_CA_SIM * self.simulation_capillary_number

    @property
    def normalized_area(self) -> float:
        """Ã = A/R² of the undeformed droplet, dimensionless."""
        return math.pi / 4.0 * self.size_ratio**2

    @property
    def normalized_thickness(self) -> float:
        """z̃ = z/R, dimensionless: 1, because the model is two-dimensional."""
        return 1.0

    @property
    def drag(self) -> float:
        """μ̃ = Ca_sim γ̃, in M/t0 [paper, eq. drag_force]."""
        return self.simulation_capillary_number * self.line_tension

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
        """
        from pinchoff import _core

        constants = self._core_constants()
        row = np.array([constants[name] for name in _core.MODEL_FIELDS], dtype=np.float64)
        position = _core.MODEL_FIELDS.index("time_step")
        if self.time_step == "auto":
            # A whole number of steps a sample, so that samples fall on round times.
            steps = math.ceil(SAMPLE_INTERVAL / _core.auto_time_step(row))
            row[position] = SAMPLE_INTERVAL / steps
        elif self.time_step > (limit := _core.stable_time_step(row)):
            raise InputError.of(
                "time_step",
                f"at most {limit:.3g}, the largest stable step of these stiffnesses",
                self.time_step,
                "lower it, or use 'auto'",
            )
        return row

    def _core_constants(self) -> dict[str, float]:
        return {
            "obstacle_radius": self.obstacle_radius,
            "drag": self.drag,
            "line_tension": self.line_tension,
            "edge_stiffness": self.edge_stiffness * self.line_tension,
            "area_stiffness": self.area_stiffness,
            "wall_stiffness": self.wall_stiffness,
            "offset": self.offset,
            "start_distance": self.start_distance,
            "vertex_count": self.vertex_count,
            "time_step": math.nan if self.time_step == "auto" else self.time_step,
            "time_limit": self.time_limit,
            "neck_thickness": self.neck_thickness,
            "neck_separation": self.neck_separation,
            "neck_separation_in_diameters": self.neck_separation_unit == "diameter",
            "sample_interval": SAMPLE_INTERVAL,
            "stop_at_breakup": not self.follow_daughters,
        }
