"""Options of the commands on films: what a camera does not see."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pinchoff.cli.options import flag_of, option

EXPERIMENT = "Experiment, with units"

_FIELDS = {
    "obstacle_radius": ("obstacle_radius_um", "um"),
    "thickness": ("thickness_um", "um"),
    "viscosity": ("viscosity_mPa_s", "mPa*s"),
    "surface_tension": ("surface_tension_mN_m", "mN/m"),
}
"""Field of `Laboratory` and unit of every quantity."""


def quantity(meaning: str, example: str, panel: str = EXPERIMENT, **more: str) -> Any:
    """Return an option that takes a number with its unit."""
    return option("QUANTITY", f"{meaning}, as '{example}'", panel=panel, **more)


@dataclass(frozen=True)
class LaboratoryOptions:
    """The obstacles, the chamber, the fluid and the interface."""

    obstacle_radius: Annotated[str | None, quantity("Obstacles, R", "85 um")] = None
    thickness: Annotated[str | None, quantity("Chamber, z", "85 um")] = None
    viscosity: Annotated[str | None, quantity("Fluid, μ", "48 mPa s")] = None
    surface_tension: Annotated[str | None, quantity("Interface, γ", "20 mN/m")] = None

    def values(self) -> dict[str, float]:
        """Return what is given, by the fields of `Laboratory` and in their units."""
        from pinchoff.support.units import magnitude_of

        given = {name: text for name, text in vars(self).items() if text is not None}
        return {
            _FIELDS[name][0]: magnitude_of(flag_of(name), text, _FIELDS[name][1], positive=True)
            for name, text in given.items()
        }
