"""Parameters of the device: one model for each region of appendix A, and for how it is made.

Lengths are in µm. The x axis points downstream, the y axis is the other way across, and y = 0 is
the axis of symmetry. The paper gives the length of the device, the thickness, the radii and the
fluids; the other lengths are chosen here so that they come out.
"""

from __future__ import annotations

from typing import Any, Literal

from pinchoff.support import paper_constants as paper
from pinchoff.support.checked import Checked, Number, WholeNumber, explained, number

__all__ = [
    "DesignRules",
    "Exit",
    "Expansion",
    "Imaging",
    "Inlets",
    "Junction",
    "Mask",
    "OilInputs",
    "Operation",
    "Supports",
]

FLANK_SHARE = 0.33
"""Where in a flank its structural pillars stand, as a part of its width from the imaging area."""


def _length(default: float, meaning: str, low: float = 1.0, high: float = 50_000.0) -> Any:
    return number(low, high, f"{meaning} in µm", default=default)


class Inlets(Checked):
    """Region 1: the ports of oil and water, each with posts that catch debris.

    Parameters
    ----------
    port_diameter_um : float
        Diameter of the punched holes.
    trap_length_um : float
        Length of the field of posts behind a port.
    post_diameter_um, post_gap_um : float
        The posts, and the gap between two of them: narrower than the channels behind.
    arm_width_um : float
        Width of the two oil channels round the water inlet.
    wall_um : float
        Solid between two neighbouring channels.
    """

    port_diameter_um: Number = _length(1200.0, "the diameter of the punched holes")
    trap_length_um: Number = _length(700.0, "the length of the field of posts")
    post_diameter_um: Number = _length(90.0, "the diameter of a post")
    post_gap_um: Number = _length(60.0, "the gap between two posts")
    arm_width_um: Number = _length(400.0, "the width of an oil channel")
    wall_um: Number = _length(400.0, "the wall between two channels")


class Junction(Checked):
    """Region 2: where the oil pinches droplets off the water, and the droplets' channel.

    Parameters
    ----------
    water_width_um : float
        Width of the water channel.
    cross_width_um : float
        Width of the two channels that bring oil to the junction.
    orifice_width_um, orifice_length_um : float
        The narrowing behind the junction, in which droplets pinch off.
    channel_width_um : float
        Width of the central channel, along which the droplets travel.
    taper_length_um : float
        Length from the orifice to the central channel.
    """

    water_width_um: Number = _length(100.0, "the width of the water channel")
    cross_width_um: Number = _length(150.0, "the width of a channel of oil to the junction")
    orifice_width_um: Number = _length(80.0, "the width of the orifice")
    orifice_length_um: Number = _length(250.0, "the length of the orifice")
    channel_width_um: Number = _length(600.0, "the width of the droplets' channel")
    taper_length_um: Number = _length(400.0, "the length from orifice to channel")


class OilInputs(Checked):
    """Region 3: two more oil inlets beside the expansion, which make collisions asymmetric.

    Parameters
    ----------
    port_diameter_um : float
        Diameter of the punched holes.
    channel_width_um : float
        Width of the channels into the expansion.
    """

    port_diameter_um: Number = _length(1200.0, "the diameter of the punched holes")
    channel_width_um: Number = _length(300.0, "the width of the channel")


class Expansion(Checked):
    """Region 4: the side channels widen, before the droplets' channel joins them.

    Parameters
    ----------
    length_um : float
        Along which the side channels widen.
    straight_um : float
        Length from there to where the three channels join.
    divider_um : float
        Wall between the droplets' channel and a side channel.
    """

    length_um: Number = _length(2000.0, "the length along which the side channels widen")
    straight_um: Number = _length(1800.0, "the length from there to the imaging area")
    divider_um: Number = _length(200.0, "the wall beside the droplets' channel")


class Supports(Checked):
    """Region 5: structural pillars that keep the chamber from collapsing and the flow even.

    Parameters
    ----------
    radius_um : float
        Radius of a structural pillar.
    pitch_um : float
        Distance between neighbours, along and across.
    flank_um : float
        Width of the strip with structural pillars on either side of the imaging area.
    """

    radius_um: Number = _length(200.0, "the radius of a structural pillar")
    pitch_um: Number = _length(900.0, "the distance between structural pillars")
    flank_um: Number = _length(1000.0, "the width of the strip beside the imaging area")


class Imaging(Checked):
    """Region 6: the obstacles that droplets collide with, on a lattice.

    Parameters
    ----------
    obstacle_radius_um : float
        R [paper: 85; 60 and 120 as variants].
    pitch_um : float
        Distance between neighbours, along and across. The chamber is ``rows * pitch_um`` and two
        flanks wide.
    rows : int
        Obstacles across the imaging area.
    columns : int
        Obstacles along it.
    stagger : float
        By what part of the pitch every second column is shifted sideways.
    """

    obstacle_radius_um: Number = _length(paper.OBSTACLE_RADIUS_UM, "the obstacles' radius R")
    pitch_um: Number = _length(900.0, "the distance between obstacles")
    rows: WholeNumber = explained(
        "a whole number from 1 to 200", "how many obstacles stand across", ge=1, le=200, default=5
    )
    columns: WholeNumber = explained(
        "a whole number from 1 to 200", "how many obstacles stand along", ge=1, le=200, default=7
    )
    stagger: Number = number(
        0, 1, "the shift of every second column as a part of the pitch", default=0.5
    )


class Exit(Checked):
    """Region 7: the walls converge, obstacles go on, and the outlet.

    Parameters
    ----------
    length_um : float
        Along which the walls converge, up to the middle of the outlet.
    width_um : float
        Width to which they converge there.
    port_diameter_um : float
        Diameter of the punched hole.
    """

    length_um: Number = _length(5095.0, "the length along which the walls converge")
    width_um: Number = _length(1000.0, "the width at the outlet")
    port_diameter_um: Number = _length(1500.0, "the diameter of the punched hole")


class Mask(Checked):
    """The photomask, and how curves are drawn on it.

    Parameters
    ----------
    polarity : "dark-field" or "bright-field"
        Dark field: the channels are clear in chrome, for a negative resist such as SU-8. Bright
        field: the channels are chrome, for a positive one.
    chord_tolerance_um : float
        How far a chord may stand off the curve that it replaces.
    margin_um : float
        Distance from the channels to the edge of the chip.
    label : str
        Text on the chip; by default the radius and the thickness.
    """

    polarity: Literal["dark-field", "bright-field"] = explained(
        "'dark-field' or 'bright-field'", "what is clear on the mask", default="dark-field"
    )
    chord_tolerance_um: Number = number(
        0.001, 0.5, "how far a chord may stand off its curve in µm", default=0.1
    )
    margin_um: Number = _length(1500.0, "the margin round the channels", low=1000.0)
    label: str | None = explained(
        "a text of up to 60 plain letters",
        "what is written on the chip",
        max_length=60,
        pattern=r"^[ -~]*$",
        default=None,
    )


class DesignRules(Checked):
    """What photomask, SU-8 and PDMS can hold.

    Parameters
    ----------
    least_gap_um, least_wall_um : float
        Narrowest fluid and thinnest solid that the photomask resolves.
    largest_aspect_ratio : float
        Height over width of the narrowest trench or ridge of SU-8.
    largest_span_ratio : float
        Unsupported width over height, beyond which the PDMS ceiling sags.
    on_violation : "refuse" or "warn"
        What becomes of a design that breaks a rule.
    """

    least_gap_um: Number = _length(15.0, "the narrowest fluid", low=0.1)
    least_wall_um: Number = _length(15.0, "the thinnest solid", low=0.1)
    largest_aspect_ratio: Number = number(
        0.1, 50, "the largest height over width of SU-8", default=4.0
    )
    largest_span_ratio: Number = number(
        1, 1000, "the largest unsupported width over height", default=25.0
    )
    on_violation: Literal["refuse", "warn"] = explained(
        "'refuse' or 'warn'", "what becomes of a design that breaks a rule", default="refuse"
    )


class Operation(Checked):
    """How the device is run, for the flow check.

    Parameters
    ----------
    oil_rate_uL_min : float
        Oil through the oil inlet [paper: 20 to 60].
    water_rate_uL_h : float
        Water through the water inlet [paper: 15 to 120].
    extra_oil_rate_uL_min : float
        Oil through the extra inlet at y > 0, and drawn from no other [paper: none].
    viscosity_mPa_s, density_kg_m3 : float
        Viscosity of the oil [paper: 50 cSt × 960 kg/m³].
    surface_tension_mN_m : float
        Between oil and water [paper: about 20].
    droplet_diameter_um : float
        D0 of the droplet that collides in the computed flow [paper: median 481].
    elements_across_gap : int
        Finite elements across the narrowest gap of the imaging area.
    """

    oil_rate_uL_min: Number = number(  # noqa: N815
        0.001, 1e5, "the oil's flow rate in µL/min", default=40.0
    )
    water_rate_uL_h: Number = number(  # noqa: N815
        0, 1e6, "the water's flow rate in µL/h", default=60.0
    )
    extra_oil_rate_uL_min: Number = number(  # noqa: N815
        0, 1e5, "the extra oil's flow rate in µL/min", default=0.0
    )
    viscosity_mPa_s: Number = number(  # noqa: N815
        1e-3, 1e7, "the oil's viscosity in mPa s", default=paper.VISCOSITY_MPA_S
    )
    density_kg_m3: Number = number(
        1, 1e5, "the oil's density in kg/m³", default=paper.OIL_DENSITY_KG_M3
    )
    surface_tension_mN_m: Number = number(  # noqa: N815
        1e-3, 1e4, "the surface tension in mN/m", default=paper.SURFACE_TENSION_MN_M
    )
    droplet_diameter_um: Number = _length(paper.MEDIAN_DIAMETER_UM, "the droplet's diameter D0")
    elements_across_gap: WholeNumber = explained(
        "a whole number from 4 to 60",
        "how many elements span the narrowest gap",
        ge=4,
        le=60,
        default=20,
    )
