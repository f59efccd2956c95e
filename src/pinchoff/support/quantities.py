"""Physical quantities in and out: what the dimensionless numbers stand for."""

from __future__ import annotations

import warnings
from collections.abc import Container, Mapping
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff.support.checked import Documented, Number, explained, unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.paper_constants import CA_PER_CA_SIM, MEDIAN_DIAMETER_UM, OBSTACLE_RADIUS_UM
from pinchoff.support.units import magnitude_of

if TYPE_CHECKING:
    from pinchoff.support.units import Physical

THICKNESS_TOLERANCE = 0.01
"""How far z/R may be off 1, the thickness of the two-dimensional model, without a warning."""


def capillary_number(
    viscosity_mPa_s: ArrayLike,  # noqa: N803
    speed_mm_s: ArrayLike,
    surface_tension_mN_m: ArrayLike,  # noqa: N803
) -> NDArray[np.float64]:
    """Return Ca = μv/γ [paper, eq. capillary], dimensionless.

    Parameters
    ----------
    viscosity_mPa_s, speed_mm_s, surface_tension_mN_m : array_like, shape (...)

    Examples
    --------
    >>> float(capillary_number(48, 1.0, 20).round(6))
    0.0024
    """
    viscosity, speed, tension = (
        np.asarray(values, dtype=np.float64)
        for values in (viscosity_mPa_s, speed_mm_s, surface_tension_mN_m)
    )
    return np.asarray(viscosity * speed / tension * 1e-3, dtype=np.float64)


def reynolds_number(
    density_kg_m3: float,
    speed_mm_s: float,
    length_um: float,
    viscosity_mPa_s: float,  # noqa: N803
) -> float:
    """Return Re = ρvL/μ, dimensionless.

    Examples
    --------
    >>> round(reynolds_number(960, 2.0, 120, 48), 6)
    0.0048
    """
    # 1 kg/m³ mm/s µm/(mPa s) is 1e-6.
    return density_kg_m3 * speed_mm_s * length_um / viscosity_mPa_s * 1e-6


def _positive(meaning: str) -> Any:
    return explained("a positive, finite number", meaning, gt=0.0)


class PhysicalScale(Documented):
    """The experiment that dimensionless parameters stand for.

    Parameters
    ----------
    **values
        Each as its entry says.

    Raises
    ------
    InputError
        A value is missing, not finite or not positive.

    Examples
    --------
    >>> scale = PhysicalScale(
    ...     diameter_um=481, speed_mm_s=1, obstacle_radius_um=85, thickness_um=85,
    ...     viscosity_mPa_s=48, surface_tension_mN_m=20)
    >>> round(scale.size_ratio, 3), scale.time_unit_s
    (5.659, 0.481)
    """

    diameter_um: Annotated[Number, _positive("the undeformed droplet's diameter D0 in µm")]
    speed_mm_s: Annotated[Number, _positive("the fluid's speed v_f∞ in mm/s")]
    obstacle_radius_um: Annotated[Number, _positive("the obstacle's radius R in µm")]
    thickness_um: Annotated[Number, _positive("the chamber's thickness z in µm")]
    viscosity_mPa_s: Annotated[  # noqa: N815
        Number, _positive("the fluid's dynamic viscosity μ in mPa s")
    ]
    surface_tension_mN_m: Annotated[  # noqa: N815
        Number, _positive("the surface tension γ in mN/m")
    ]

    @property
    def time_unit_s(self) -> float:
        """t0 = D0/v_f∞, seconds."""
        return self.diameter_um * 1e-3 / self.speed_mm_s

    @property
    def capillary_number(self) -> float:
        """Ca = μ v_f∞/γ, dimensionless."""
        return float(
            capillary_number(self.viscosity_mPa_s, self.speed_mm_s, self.surface_tension_mN_m)
        )

    @property
    def simulation_capillary_number(self) -> float:
        """Ca_sim = Ca/9.8e-5, dimensionless [paper, eq. conv]."""
        return self.capillary_number / CA_PER_CA_SIM

    @property
    def size_ratio(self) -> float:
        """D0/R, dimensionless."""
        return self.diameter_um / self.obstacle_radius_um


FIXED_FILM = "fixed-film"
"""The assumption that Ca per Ca_sim is (δ/D0)² with a film δ of one thickness."""


def ca_per_ca_sim(
    conversion: str, constant: float, size_ratio: float, scale: PhysicalScale | None = None
) -> float:
    """Return Ca/Ca_sim of a droplet under an assumption on it.

    Parameters
    ----------
    conversion : str
        "constant": the same for all [paper, eq. conv]. "fixed-film": (δ/D0)², as the paper argues
        for it, with one film thickness δ for all.
    constant : float
        Its value; with a fixed film that of the paper's median droplet, D0 = 481 µm.
    size_ratio : float
        D0/R, which stands for D0 at the paper's R = 85 µm where there is no scale.
    scale : PhysicalScale, optional

    Examples
    --------
    >>> ca_per_ca_sim("constant", 9.8e-5, 2.83)
    9.8e-05
    >>> round(ca_per_ca_sim("fixed-film", 1e-4, 481 / 85 / 2), 10)
    0.0004
    """
    if conversion != FIXED_FILM:
        return constant
    diameter_um = scale.diameter_um if scale else size_ratio * OBSTACLE_RADIUS_UM
    return constant * (MEDIAN_DIAMETER_UM / diameter_um) ** 2


class ScaleQuantity(NamedTuple):
    """A quantity with its unit that gives a field of `PhysicalScale`."""

    field: str
    unit: str
    example: str


SCALE_QUANTITIES = {
    "diameter": ScaleQuantity("diameter_um", "um", "481 um"),
    "obstacle_radius": ScaleQuantity("obstacle_radius_um", "um", "85 um"),
    "speed": ScaleQuantity("speed_mm_s", "mm/s", "1.0 mm/s"),
    "viscosity": ScaleQuantity("viscosity_mPa_s", "mPa*s", "48 mPa s"),
    "surface_tension": ScaleQuantity("surface_tension_mN_m", "mN/m", "20 mN/m"),
    "thickness": ScaleQuantity("thickness_um", "um", "85 um"),
}
"""The quantities of an experiment, by their names."""

PHYSICAL_NAMES = (*SCALE_QUANTITIES, "offset")
"""The physical arguments; all but the offset are required."""

GROUP_ORIGINS = {
    "size_ratio": "diameter / obstacle_radius",
    "simulation_capillary_number": "viscosity * speed / surface_tension",
}
"""What the groups follow from."""


def physical_groups(
    quantities: Mapping[str, Physical | None], *, thickness_acts: bool = False
) -> dict[str, Any]:
    """Read the `PHYSICAL_NAMES` with their units, and return what follows from them.

    That is ``size_ratio``, ``simulation_capillary_number``, ``scale`` and, where it is given,
    ``offset`` (D0). A chamber whose thickness is not R is warned of, unless the thickness acts.

    Raises
    ------
    InputError
        A name is unknown or missing; a value has no unit, the wrong unit, or is not finite; or
        something other than the offset is not positive.
    """
    groups = groups_of_magnitudes(physical_magnitudes(quantities))
    if not thickness_acts:
        warn_of_thickness(groups["scale"])
    return groups


def physical_magnitudes(
    quantities: Mapping[str, Physical | None], varied: Container[str] = ()
) -> dict[str, float]:
    """Read the `PHYSICAL_NAMES` that are not varied; all of them but the offset must be there.

    Raises
    ------
    InputError
        As `physical_groups`.
    """
    for name in quantities:
        if name not in PHYSICAL_NAMES:
            raise unknown_name(name, "the name of a physical quantity", name, PHYSICAL_NAMES)
    return {
        name: physical_magnitude(name, quantities.get(name))
        for name in PHYSICAL_NAMES
        if name not in varied and (name != "offset" or quantities.get(name) is not None)
    }


def physical_magnitude(name: str, value: Physical | None) -> float:
    """Read one of the `PHYSICAL_NAMES` and return its number in µm, mm/s, mPa s or mN/m.

    Raises
    ------
    InputError
        As `physical_groups`.
    """
    if name == "offset":
        return magnitude_of(name, value, "um", example="20 um")
    _, unit, example = SCALE_QUANTITIES[name]
    return magnitude_of(name, value, unit, example=example, positive=True)


def groups_of_magnitudes(magnitudes: Mapping[str, float]) -> dict[str, Any]:
    """Return what follows from all the `PHYSICAL_NAMES`, as numbers in µm, mm/s, mPa s, mN/m."""
    scale = PhysicalScale(
        **{quantity.field: magnitudes[name] for name, quantity in SCALE_QUANTITIES.items()}
    )
    return groups_of_scale(scale, magnitudes.get("offset"))


def groups_of_scale(scale: PhysicalScale, offset_um: float | None) -> dict[str, Any]:
    """Return what follows from an experiment and the droplet's start y, µm, if that is given."""
    offset = {} if offset_um is None else {"offset": offset_um / scale.diameter_um}
    return {
        **offset,
        "size_ratio": scale.size_ratio,
        "simulation_capillary_number": scale.simulation_capillary_number,
        "scale": scale,
    }


def refuse_physical_groups(constants: Mapping[str, Any]) -> None:
    """Refuse dimensionless numbers that follow from physical quantities given beside them.

    Raises
    ------
    InputError
        There is one.
    """
    for name in ("size_ratio", "simulation_capillary_number", "offset", "scale"):
        if constants.get(name) is not None:
            raise InputError.of(
                name,
                "left out beside physical quantities, from which it follows",
                constants[name],
                "give either the physical quantities or the dimensionless number",
            )


def blaming_quantities(error: InputError) -> InputError:
    """Return an error about a group as one about the quantities that it follows from."""
    if error.argument not in GROUP_ORIGINS:
        return error
    return InputError.of(
        GROUP_ORIGINS[error.argument],
        f"such that {error.argument} is {error.rule}",
        error.got,
        "check their units, as in um, mm/s, mPa s and mN/m",
    )


def warn_of_thickness(scale: PhysicalScale) -> None:
    """Warn of a chamber that is not as thick as the two-dimensional model's, z/R = 1."""
    normalized_thickness = scale.thickness_um / scale.obstacle_radius_um
    if abs(normalized_thickness - 1.0) > THICKNESS_TOLERANCE:
        warnings.warn(
            f"thickness/obstacle_radius is {normalized_thickness:.3g}, but the model is "
            "two-dimensional and simulates 1: the thickness does not act in the simulation",
            UserWarning,
            stacklevel=4,
        )
