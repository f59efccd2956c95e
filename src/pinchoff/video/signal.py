"""The picture in which droplets show best: brightness, or one colour, as it is or inverted.

Strongly coloured light, or dye, leaves the signal in one of the three colours. Where rims are
brighter than what is about them, the negative shows them dark. What follows knows one picture
only, in which rims are dark.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.reading import Frame

Image = NDArray[np.float32]

CHANNELS = ("brightness", "red", "green", "blue", "redness", "blueness")
"""Brightness, the three colours, and how red or blue something is whatever its brightness."""

# Of the blue and the red difference in each colour, and how much more contrast against its noise
# than brightness, which has the finer resolution, a colour must have.
_MIXING = {"red": (0.0, 1.14), "green": (-0.395, -0.581), "blue": (2.032, 0.0)}
_DARK = 24.0  # grey levels: what is darker has no colour
_TINT_SCALE = 127.0  # grey levels for what is all red, or all blue
_TINTS = {"blueness": 0, "redness": 1}
_CLEARLY_BETTER = 1.5
_TINTED = 12.0  # grey levels between what is most and least red, or blue


class Signal(NamedTuple):
    """A picture in which rims are dark.

    Attributes
    ----------
    channel : str
        One of `CHANNELS`.
    inverted : bool
        Whether it is the negative.
    """

    channel: str = "brightness"
    inverted: bool = False

    def of(self, frame: Frame) -> Image:
        """Return it of a frame, grey levels from 0 to 255, shape (height, width)."""
        image: Image = frame.luma.astype(np.float32)
        if self.channel in _TINTS and frame.chroma is not None:
            height, width = frame.luma.shape
            tint = frame.chroma[_TINTS[self.channel]].astype(np.float32) - np.float32(128.0)
            # Of the light that is there: a rim is dark, but as red as what it encloses.
            light = np.maximum(cv2.GaussianBlur(image, (0, 0), 1.0), np.float32(_DARK))
            image = np.asarray(cv2.resize(tint, (width, height)))
            image = np.clip(_TINT_SCALE * image / light + np.float32(128.0), 0.0, 255.0)
            image = image.astype(np.float32)
        elif self.channel != "brightness" and frame.chroma is not None:
            height, width = frame.luma.shape
            for weight, plane in zip(_MIXING[self.channel], frame.chroma, strict=True):
                if weight:
                    whole = cv2.resize(plane.astype(np.float32), (width, height))
                    image += np.float32(weight) * (whole - np.float32(128.0))
            np.clip(image, 0.0, 255.0, out=image)
        return np.float32(255.0) - image if self.inverted else image


def noise_of(image: Image) -> float:
    """Return the standard deviation of an image's noise, grey levels, at least half a level.

    It is what two smoothings differ by over most of the image: edges take the smaller part of it.
    """
    rough = image - cv2.GaussianBlur(image, (0, 0), 1.0)
    return max(0.5, float(1.6 * np.median(np.abs(rough[::2, ::2]))))


def best_channel(frames: Sequence[Frame]) -> str:
    """Return the channel with the most contrast against its noise."""
    if frames[0].chroma is None:
        return CHANNELS[0]
    contrasts = {
        channel: _contrast(frames, channel) for channel in CHANNELS if channel not in _TINTS
    }
    best = max(contrasts, key=contrasts.__getitem__)
    clearly = contrasts[best] > _CLEARLY_BETTER * contrasts[CHANNELS[0]]
    return best if clearly else CHANNELS[0]


def strong_tint(frames: Sequence[Frame]) -> str | None:
    """Return in which of the two tints the frames differ much from place to place, if in one."""
    if frames[0].chroma is None:
        return None
    spread = {}
    for tint, k in _TINTS.items():
        planes = [frame.chroma[k] for frame in frames if frame.chroma is not None]
        low, high = np.quantile(np.stack(planes), [0.02, 0.98])
        spread[tint] = float(high - low)
    best = max(spread, key=spread.__getitem__)
    return best if spread[best] >= _TINTED else None


def _contrast(frames: Sequence[Frame], channel: str) -> float:
    """Return how much the darkest and brightest per cent differ from their surroundings."""
    seen = []
    for frame in frames[:: max(1, len(frames) // 3)]:
        image = Signal(channel).of(frame)
        reach = max(3, min(image.shape) // 16) | 1
        smooth = cv2.GaussianBlur(image, (0, 0), 1.0)
        local = smooth - cv2.blur(image, (reach, reach))
        low, high = np.quantile(local[::2, ::2], [0.01, 0.99])
        seen.append((high - low) / noise_of(image))
    return float(np.mean(seen))
