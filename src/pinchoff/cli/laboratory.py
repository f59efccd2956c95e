"""The laboratory's quantities as options: numbers with their units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pinchoff.cli.options import named_as_options, option
from pinchoff.support.quantities import SCALE_QUANTITIES, physical_magnitude

EXPERIMENT = "Experiment, with units"


def quantity(meaning: str, example: str, panel: str = EXPERIMENT, **more: str) -> Any:
    """Return an option that takes a number with its unit."""
    return option("QUANTITY", f"{meaning}, as '{example}'", panel=panel, **more)


@dataclass(frozen=True)
class LaboratoryOptions:
    """The obstacles, the chamber, the fluid and the interface."""

    obstacle_radius: Annotated[str | None, quantity("Obstacle, R", "85 um")] = None
    thickness: Annotated[str | None, quantity("Chamber, z", "85 um")] = None
    viscosity: Annotated[str | None, quantity("Fluid, μ", "48 mPa s")] = None
    surface_tension: Annotated[str | None, quantity("Interface, γ", "20 mN/m")] = None

    def values(self) -> dict[str, float]:
        """Return what is given, by the fields of `Laboratory` and in their units."""
        given = {name: text for name, text in vars(self).items() if text is not None}
        with named_as_options(*given):
            return {
                SCALE_QUANTITIES[name].field: physical_magnitude(name, text)
                for name, text in given.items()
            }
