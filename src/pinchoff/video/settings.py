"""What a measurement of videos can be told; all of it has a default or follows from the image."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self, TypeAlias, get_args

from pydantic import Field, model_validator

from pinchoff.support.checked import Checked, Number, WholeNumber, explained, number
from pinchoff.support.errors import InputError
from pinchoff.video.encounters import CONTACT_DISTANCE_UM, Laboratory
from pinchoff.video.formats.selection import frame_range
from pinchoff.video.formats.source import SMALLEST_SIDE

SMALLEST_RIM_PX = 8.0
"""Smallest diameter of droplets that are told by their rims alone, pixels."""

SMALLEST_DROPLET_PX = 11.0
"""Smallest diameter that is looked for unless one is given, pixels: a rim and an inside show."""

SMALLEST_LENGTH_PX = 2.0
"""Least radius of a pillar that can be seen, pixels."""

Method: TypeAlias = Literal["rings", "enclosed", "spots", "packed"]
METHOD_NAMES: tuple[str, ...] = get_args(Method)
"""Segmentations, by name."""

_Even: TypeAlias = Annotated[WholeNumber, Field(ge=0, multiple_of=2)]
_Side: TypeAlias = Annotated[WholeNumber, Field(ge=SMALLEST_SIDE)]
_Level: TypeAlias = Annotated[Number, Field(ge=0, le=255)]


def _derived(low: float, high: float, meaning: str) -> Any:
    rule = f"a finite number from {low:g} to {high:g}"
    advice = f"{meaning}, or leave it out: it follows from the image"
    return explained(rule, advice, ge=low, le=high, default=None)


class Lattice(Checked):
    """A regular array of obstacles.

    Parameters
    ----------
    pitch_um : float
        Distance between neighbours, µm.
    radius_um : float
        Of each, µm.
    x_px, y_px : float
        Centre of one of them in the image, pixels.
    angle_deg : float, optional
        Direction of a row, degrees from x towards y.
    hexagonal : bool, optional
        Whether rows are shifted by half a pitch; by default the array is square.

    Raises
    ------
    InputError
        A value is missing, out of its range or of the wrong type.
    """

    pitch_um: Number = number(1e-3, 1e6, "the distance between neighbours in µm")
    radius_um: Number = number(1e-3, 1e6, "their radius in µm")
    x_px: Number = number(-1e5, 1e5, "x of one of their centres in pixels")
    y_px: Number = number(-1e5, 1e5, "y of one of their centres in pixels")
    angle_deg: Number = number(-360.0, 360.0, "the direction of a row", default=0.0)
    hexagonal: bool = explained("true or false", "whether rows are shifted", default=False)


class VideoSettings(Checked):
    """How clips are read, segmented and tracked. Thresholds are fractions, whatever the input.

    Parameters
    ----------
    pixel_size_um : float, optional
        Side of a pixel in the chamber, µm; by default what the file's tags say.
    fps : float, optional
        Frames a second; by default the times that the clip gives, or 60 for images.
    frames : str, optional
        Which frames are measured, ``START:STOP`` or ``START:STOP:STEP``; they keep their numbers.
    crop : (left, top, width, height), optional
        Part of the picture that is measured, pixels; left and top are even. All places are then
        counted from its corner.
    channel : str, optional
        Which of several channels, by its name or number, or red, green or blue of a colour film.
    edge_level : float, optional
        Where the outline lies, as a fraction of the ring's darkness from the fluid's 0 to the
        ring's 1; by default the darkness at the outer edge of a blurred ring that is fitted to it.
    pale_edge_level : float, optional
        The same where a ring is too pale to be closed, because its droplet moves fast or is out of
        focus; by default halfway to the darkness of the interior.
    inner_edge_level : float, optional
        The same on the ring's inner side; by default that of the outline, or halfway from the
        interior's darkness to the ring's where the interior is dark.
    ring_darkness : float, optional
        How much darker than the fluid the ring is, grey levels of 255 at average light; by default
        nearly that of the darkest there is.
    ring_width_um : float, optional
        Width over which the ring is darker than its edge, µm; by default from its profile.
    interior_level : float
        How similar to the droplets' interior a region within a ring must be, from the fluid's 0
        to the interior's 1, to be a droplet.
    interior : (float, float, float), optional
        Red, green and blue of the droplets' interior; by default learned from the regions that
        dark rings enclose.
    clicks : tuple of (frame, x, y)
        Places inside droplets from which to learn that colour instead.
    minimum_diameter_um : float
        Smaller droplets are left out, µm.
    method : str, optional
        How droplets are told: "rings", "enclosed", "spots" or "packed"; by default as the clip
        suggests.
    packed : bool
        Whether droplets are so many that the chamber is never seen empty; then they are told by
        their dark rims alone, whatever their inside looks like, and may overlap.
    maximum_diameter_um : float, optional
        The largest droplet of a packed scene, µm; by default a third of the image's shorter side.
    rim_contrast : float
        Least brightening across the rim of one, as a fraction of the way from the frame's darkest
        to its light.
    rim_score : float
        How round, even and closed its rim must be, from 0 to 1, that of a sharp black ring.
    find_obstacles : bool
        Whether pillars of any radius are looked for in the background; those of a radius that is
        known from `laboratory` are in any case.
    obstacles : tuple of (x, y, radius), optional
        Where they are instead, centres and radii in pixels.
    lattice : Lattice, optional
        A regular array of them instead; as a table in TOML, or as a setting of the command
        ``lattice={pitch_um=900, radius_um=85, x_px=320, y_px=256}``.
    contact_distance_um : float, optional
        An outline that comes this near to an obstacle is in contact, µm; by default the contact is
        where the gap stops closing, if that is nearer than 16 µm.
    velocity_frames : int
        Frames up to the contact to which the velocity is fitted; half as many after it help.
    maximum_step_px : float, optional
        Largest displacement of a droplet between two frames, pixels, beyond that of its own
        motion; by default half its diameter.
    memory : int
        For how many frames a droplet may be lost.
    area_tolerance : float
        How much areas may differ, of 1, across a break-up or a coalescence.
    laboratory : Laboratory
        What the camera does not see.

    Raises
    ------
    InputError
        A value is missing, out of its range or of the wrong type.
    """

    pixel_size_um: Number | None = number(1e-3, 1e4, "the side of a pixel in µm", default=None)
    fps: Number | None = _derived(1e-3, 1e6, "frames a second")
    frames: str | None = explained("START:STOP or START:STOP:STEP", "a range", default=None)
    crop: tuple[_Even, _Even, _Side, _Side] | None = explained(
        "left, top, width and height in pixels, the first two even",
        f"a part of {SMALLEST_SIDE} × {SMALLEST_SIDE} pixels or more",
        default=None,
    )
    channel: str | None = explained("a name or number", "one of the clip's channels", default=None)
    edge_level: Number | None = _derived(0.05, 0.95, "a fraction of the ring's darkness")
    pale_edge_level: Number | None = _derived(0.05, 0.95, "a fraction of the ring's darkness")
    inner_edge_level: Number | None = _derived(0.05, 0.99, "a fraction of the ring's darkness")
    ring_darkness: Number | None = _derived(1.0, 255.0, "grey levels of 255")
    ring_width_um: Number | None = _derived(0.0, 1e4, "a width in µm")
    interior_level: Number = number(0.0, 1.0, "a fraction of the interior's colour", default=0.5)
    interior: tuple[_Level, _Level, _Level] | None = explained(
        "three numbers from 0 to 255", "red, green and blue of the interior", default=None
    )
    clicks: tuple[tuple[WholeNumber, Number, Number], ...] = explained(
        "a list of [frame, x, y]", "places inside droplets", default=()
    )
    minimum_diameter_um: Number | None = _derived(0.0, 1e5, "the smallest droplet in µm")
    method: Method | None = explained(
        f"one of {', '.join(METHOD_NAMES)}", "a method, or none: the clip decides", default=None
    )
    packed: bool = explained("true or false", "whether droplets fill the view", default=False)
    maximum_diameter_um: Number | None = _derived(1e-3, 1e6, "the largest droplet in µm")
    rim_contrast: Number = number(0.0, 1.0, "a fraction of the light", default=0.12)
    rim_score: Number = number(0.0, 1.0, "how sure a droplet must be", default=0.22)
    find_obstacles: bool = explained(
        "true or false", "whether pillars of any radius are looked for", default=False
    )
    obstacles: tuple[tuple[Number, Number, Annotated[Number, Field(gt=0)]], ...] | None = explained(
        "a list of [x, y, radius] in pixels", "where the obstacles are", default=None
    )
    lattice: Lattice | None = explained(
        "a table with pitch_um, radius_um, x_px and y_px", "a regular array", default=None
    )
    contact_distance_um: Number | None = number(0.0, 1e4, "a distance in µm", default=None)
    velocity_frames: WholeNumber = explained(
        "a whole number from 3 to 100", "frames of the velocity's fit", ge=3, le=100, default=8
    )
    maximum_step_px: Number | None = _derived(0.1, 1e4, "a displacement in pixels")
    memory: WholeNumber = explained(
        "a whole number from 0 to 100", "frames", ge=0, le=100, default=3
    )
    area_tolerance: Number = number(0.0, 1.0, "a fraction of the area", default=0.15)
    laboratory: Laboratory = explained("a Laboratory", "what is known", default=Laboratory())

    @property
    def contact_um(self) -> float:
        """How near to an obstacle a droplet is in contact at all, µm."""
        given = self.contact_distance_um
        return CONTACT_DISTANCE_UM if given is None else given

    @property
    def pixel_um(self) -> float:
        """Side of a pixel, µm.

        Raises
        ------
        InputError
            It is not known yet: see `pinchoff.video.scale.scaled`.
        """
        if self.pixel_size_um is None:
            raise InputError.of(
                "pixel_size_um", "given", "nothing", "give the side of a pixel in µm"
            )
        return self.pixel_size_um

    @model_validator(mode="before")
    @classmethod
    def _packed_is_a_method(cls, given: Any) -> Any:
        if isinstance(given, dict) and given.get("packed") is True and not given.get("method"):
            return {**given, "method": "packed"}
        return given

    @model_validator(mode="after")
    def _agrees(self) -> Self:
        if self.frames is not None:
            frame_range(self.frames)
        if self.pixel_size_um is not None:
            self._agree_in_pixels(self.pixel_size_um)
        if self.obstacles is not None and self.lattice is not None:
            advice = "give one of the two"
            raise InputError.of("lattice", "left out beside obstacles", "both", advice)
        return self

    def _agree_in_pixels(self, pixel_um: float) -> None:
        """Refuse sizes that do not go together, once that of a pixel is known."""
        smallest, largest = self.minimum_diameter_um, self.maximum_diameter_um
        if smallest is None:
            smallest = SMALLEST_DROPLET_PX * pixel_um
        if largest is not None and not largest > smallest:
            rule, advice = f"larger than minimum_diameter_um, {smallest:g}", "check both"
            raise InputError.of("maximum_diameter_um", rule, largest, advice)
        if self.method == "packed" and smallest < SMALLEST_RIM_PX * pixel_um:
            rule = f"{SMALLEST_RIM_PX:g} pixels or more in a packed scene"
            got = f"{smallest:g} µm, {smallest / pixel_um:.3g} pixels"
            raise InputError.of("minimum_diameter_um", rule, got, "ask for larger droplets")

    def require_scale(self, size: tuple[int, int]) -> None:
        """Refuse a scale at which pillars or droplets could not be seen in a frame of a size.

        Raises
        ------
        InputError
            A length that is given is less than a few pixels, or does not fit into the frame.
        """
        lattice = self.lattice
        lengths = {
            "obstacle_radius_um": self.laboratory.obstacle_radius_um,
            "lattice.radius_um": None if lattice is None else lattice.radius_um,
            "maximum_diameter_um": self.maximum_diameter_um,
        }
        smallest = self.minimum_diameter_um
        if smallest is not None and smallest / self.pixel_um > min(size):
            lengths["minimum_diameter_um"] = smallest
        for name, length in lengths.items():
            pixels = math.nan if length is None else length / self.pixel_um
            if pixels < SMALLEST_LENGTH_PX or pixels > max(size):
                rule = f"from {SMALLEST_LENGTH_PX:g} pixels to the frame's {max(size)}"
                got = f"{length:g} µm at {self.pixel_um:g} µm a pixel, {pixels:.3g} px"
                raise InputError.of(name, rule, got, "check both lengths and their units")

    @property
    def minimum_area_px(self) -> float:
        """Area of the smallest droplet, pixels."""
        smallest = SMALLEST_DROPLET_PX
        if self.minimum_diameter_um is not None:
            smallest = self.minimum_diameter_um / self.pixel_um
        return 0.25 * math.pi * smallest**2
