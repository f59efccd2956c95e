"""What the microscope shows and how: size, colours, light, blur, noise and compression."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

from pinchoff.support.checked import Checked, Number, WholeNumber, explained, number

Colour: TypeAlias = tuple[
    Annotated[int, Field(ge=0, le=255)],
    Annotated[int, Field(ge=0, le=255)],
    Annotated[int, Field(ge=0, le=255)],
]


def _colour(meaning: str, default: Colour) -> Colour:
    field: Colour = explained(
        "three whole numbers from 0 to 255", f"the colour of {meaning}", default=default
    )
    return field


class Microscope(Checked):
    """How a clip looks; the defaults are the paper's camera [paper, sec. 2].

    Parameters
    ----------
    width, height : int
        Pixels, both even.
    pixel_size_um : float
        Side of a pixel in the chamber, µm.
    fps : float
        Frames a second.
    fluid, interior, ring, pillar, pillar_rim : (int, int, int)
        Red, green and blue of the oil, of the inside of a droplet, of the dark ring inside its
        outline, of an obstacle and of the ring inside its edge.
    ring_width_um, pillar_rim_um : float
        Width of the two rings, µm.
    blur_px : float
        Standard deviation of the blur, pixels.
    focus_drift_px : float
        How much the blur grows and shrinks again in the course of a clip, pixels.
    exposure : float
        Share of the time between two frames during which the shutter is open.
    unevenness : float
        How much darker the corners are than the middle, of 1.
    flicker : float
        Amplitude of the lamp's flicker, of 1.
    dust : int
        How many specks of dust lie on the optics.
    noise : float
        Standard deviation of the camera's noise, grey levels.
    crf : int
        Constant rate factor of the H.264 compression.
    seed : int
        Of noise, flicker and dust.

    Raises
    ------
    InputError
        A value is out of its range or of the wrong type.
    """

    width: WholeNumber = explained(
        "an even number from 16 to 8192", "pixels", ge=16, le=8192, multiple_of=2, default=640
    )
    height: WholeNumber = explained(
        "an even number from 16 to 8192", "pixels", ge=16, le=8192, multiple_of=2, default=512
    )
    pixel_size_um: Number = number(1e-3, 1e4, "the side of a pixel in µm", default=5.28)
    fps: Number = number(0.1, 1e5, "frames a second", default=60.0)
    fluid: Colour = _colour("the oil", (206, 204, 198))
    interior: Colour = _colour("the inside of a droplet", (226, 142, 172))
    ring: Colour = _colour("the ring inside a droplet's outline", (58, 40, 48))
    pillar: Colour = _colour("an obstacle", (188, 188, 184))
    pillar_rim: Colour = _colour("the ring inside an obstacle's edge", (104, 104, 102))
    ring_width_um: Number = number(0.0, 1e4, "the width of the ring in µm", default=18.0)
    pillar_rim_um: Number = number(0.0, 1e4, "the width of the rim in µm", default=12.0)
    blur_px: Number = number(0.0, 20.0, "the blur in pixels", default=0.8)
    focus_drift_px: Number = number(0.0, 20.0, "the growth of the blur in pixels", default=0.0)
    exposure: Number = number(0.0, 1.0, "the share of time the shutter is open", default=0.0)
    unevenness: Number = number(0.0, 0.9, "how much darker the corners are", default=0.15)
    flicker: Number = number(0.0, 0.5, "the amplitude of the flicker", default=0.0)
    dust: WholeNumber = explained(
        "a whole number from 0 to 10000", "how many specks", ge=0, le=10000, default=0
    )
    noise: Number = number(0.0, 100.0, "the noise in grey levels", default=4.0)
    crf: WholeNumber = explained("a whole number from 0 to 51", "x264's", ge=0, le=51, default=20)
    seed: WholeNumber = explained("a whole number from 0", "any", ge=0, default=0)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.width, self.height
