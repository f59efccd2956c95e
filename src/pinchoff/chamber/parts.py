"""Parameters of the device: one model for each region of appendix A, and for how it is made.

Lengths are in µm. The x axis points downstream, the y axis is the other way across, and y = 0 is
the axis of symmetry. The paper gives the length of the device, the thickness, the radii and the
fluids; the other lengths are chosen here so that they come out.
"""

from __future__ import annotations

from typing import Any, Literal

from pinchoff.support import paper_constants as paper
from pinchoff.support.checked import Documented, Number, WholeNumber, explained, number

FLANK_SHARE = 0.33
"""Where in a flank its structural pillars stand, as a part of its width from the imaging area."""


def _length(default: float, meaning: str, low: float = 1.0, high: float = 50_000.0) -> Any:
    return number(low, high, f"{meaning} in µm", default=default)


class Inlets(Documented):
    """Region 1: the ports of oil and water, each with posts that catch debris."""

    port_diameter_um: Number = _length(1200.0, "the diameter of the punched holes")
    trap_length_um: Number = _length(700.0, "the length of the field of posts behind a port")
    post_diameter_um: Number = _length(90.0, "the diameter of a post")
    post_gap_um: Number = _length(60.0, "the gap between two posts")
    arm_width_um: Number = _length(400.0, "the width of an oil channel past the water inlet")
    wall_um: Number = _length(400.0, "the wall between two channels")


class Junction(Documented):
    """Region 2: where the oil pinches droplets off the water, and the droplets' channel."""

    water_width_um: Number = _length(100.0, "the width of the water channel")
    cross_width_um: Number = _length(150.0, "the width of a channel of oil to the junction")
    orifice_width_um: Number = _length(80.0, "the width of the orifice, where droplets pinch off")
    orifice_length_um: Number = _length(250.0, "the length of the orifice")
    channel_width_um: Number = _length(600.0, "the width of the droplets' channel")
    taper_length_um: Number = _length(400.0, "the length from orifice to channel")


class OilInputs(Documented):
    """Region 3: two more oil inlets beside the expansion, which make collisions asymmetric."""

    port_diameter_um: Number = _length(1200.0, "the diameter of the punched holes")
    channel_width_um: Number = _length(300.0, "the width of the channel")


class Expansion(Documented):
    """Region 4: the side channels widen, before the droplets' channel joins them."""

    length_um: Number = _length(2000.0, "the length along which the side channels widen")
    straight_um: Number = _length(1800.0, "the length from there to the imaging area")
    divider_um: Number = _length(200.0, "the wall between the droplets' channel and a side channel")


class Supports(Documented):
    """Region 5: structural pillars that keep the chamber from collapsing and the flow even."""

    radius_um: Number = _length(200.0, "the radius of a structural pillar")
    pitch_um: Number = _length(900.0, "the distance between structural pillars")
    flank_um: Number = _length(1000.0, "the width of the strip beside the imaging area")


class Imaging(Documented):
    """Region 6: the obstacles that droplets collide with, on a lattice."""

    obstacle_radius_um: Number = _length(paper.OBSTACLE_RADIUS_UM, "the obstacles' radius R")
    pitch_um: Number = _length(900.0, "the distance between obstacles, along and across,")
    rows: WholeNumber = explained(
        "a whole number from 1 to 200", "how many obstacles stand across", ge=1, le=200, default=5
    )
    columns: WholeNumber = explained(
        "a whole number from 1 to 200", "how many obstacles stand along", ge=1, le=200, default=7
    )
    stagger: Number = number(
        0, 1, "the shift of every second column as a part of the pitch", default=0.5
    )


class Exit(Documented):
    """Region 7: the walls converge, obstacles go on, and the outlet."""

    length_um: Number = _length(
        5095.0, "the length along which the walls converge, up to the middle of the outlet"
    )
    width_um: Number = _length(1000.0, "the width at the outlet")
    port_diameter_um: Number = _length(1500.0, "the diameter of the punched hole")


class Mask(Documented):
    """The photomask, and how curves are drawn on it."""

    polarity: Literal["dark-field", "bright-field"] = explained(
        "'dark-field' or 'bright-field'",
        "what is clear on the mask",
        default="dark-field",
        note="Dark field: the channels are clear in chrome, for a negative resist such as SU-8. "
        "Bright field: the channels are chrome, for a positive one.",
    )
    chord_tolerance_um: Number = number(
        0.001, 0.5, "how far a chord may stand off its curve in µm", default=0.1
    )
    margin_um: Number = _length(
        1500.0, "the margin from the channels to the edge of the chip", low=1000.0
    )
    label: str | None = explained(
        "a text of up to 60 plain letters",
        "what is written on the chip",
        note="None: the radius and the thickness.",
        max_length=60,
        pattern=r"^[ -~]*$",
        default=None,
    )


class DesignRules(Documented):
    """What photomask, SU-8 and PDMS can hold."""

    least_gap_um: Number = _length(15.0, "the narrowest fluid that the photomask resolves", low=0.1)
    least_wall_um: Number = _length(15.0, "the thinnest solid that the photomask resolves", low=0.1)
    largest_aspect_ratio: Number = number(
        0.1, 50, "the largest height over width of a trench or ridge of SU-8", default=4.0
    )
    largest_span_ratio: Number = number(
        1, 1000, "the largest unsupported width over height of the PDMS ceiling", default=25.0
    )
    on_violation: Literal["refuse", "warn"] = explained(
        "'refuse' or 'warn'", "what becomes of a design that breaks a rule", default="refuse"
    )


class Operation(Documented):
    """How the device is run, for the flow check."""

    oil_rate_uL_min: Number = number(  # noqa: N815
        0.001, 1e5, "the oil's flow rate (the paper's: 20 to 60) in µL/min", default=40.0
    )
    water_rate_uL_h: Number = number(  # noqa: N815
        0, 1e6, "the water's flow rate (the paper's: 15 to 120) in µL/h", default=60.0
    )
    extra_oil_rate_uL_min: Number = number(  # noqa: N815
        0, 1e5, "the flow rate through the extra inlet at y > 0 in µL/min", default=0.0
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
    droplet_diameter_um: Number = _length(
        paper.MEDIAN_DIAMETER_UM, "the diameter D0 of the droplet in the computed flow"
    )
    elements_across_gap: WholeNumber = explained(
        "a whole number from 4 to 60",
        "how many elements span the narrowest gap of the imaging area",
        ge=4,
        le=60,
        default=20,
    )
