"""What is white in a clip: the range of values that its camera filled becomes 0 to 255.

Cameras store 10, 12 or 14 bits in 16, and software stores fractions. What the container could
hold says nothing; what the clip does hold, over all of its pictures, does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]

_FULL = {np.dtype(np.uint16): 1 << 15}  # from here on nothing can change the result


class Range(NamedTuple):
    """Values that become black and white."""

    black: float
    white: float


BYTES = Range(0.0, 255.0)
"""Of pictures of eight bits: they stay as they are."""


def range_of(images: Iterable[NDArray[Any]]) -> Range:
    """Return the range that pictures fill.

    Black is 0, or the least value where some are negative. White is the largest number of the
    fewest bits that hold all values: of whole numbers 8 bits or more, and an even number, as
    cameras have. Fractions have the least power of four that none exceeds, most often 1.
    """
    least, most, whole = 0.0, 0.0, False
    for image in images:
        if image.dtype == np.uint8:
            return BYTES
        if image.dtype == np.bool_:
            return Range(0.0, 1.0)
        whole = whole or image.dtype.kind in "iu"
        values = image if whole else image[np.isfinite(image)]
        if values.size:
            least, most = min(least, float(values.min())), max(most, float(values.max()))
        if most >= _FULL.get(image.dtype, math.inf):
            break
    height = most - least
    if whole or height > 1.0:
        bits = max(8 if whole else 1, math.ceil(height).bit_length())
        return Range(least, least + 2.0 ** (bits + bits % 2) - 1.0)
    exponent = math.ceil(math.log(height, 4.0)) if height > 0.0 else 0
    return Range(least, least + 4.0**exponent)


def to_bytes(image: NDArray[Any], values: Range) -> Pixels:
    """Return a picture with 0 for black and 255 for white."""
    if image.dtype == np.uint8:
        return image
    if image.dtype.kind in "biu" and image.dtype.itemsize <= 2 and values.black == 0.0:
        plain = image.view(np.uint8) if image.dtype == np.bool_ else image
    else:
        plain = np.subtract(image, values.black, dtype=np.float32)
    scaled: Pixels = cv2.convertScaleAbs(
        np.maximum(plain, 0), alpha=255.0 / (values.white - values.black)
    )
    return scaled


def without_gaps(image: NDArray[Any]) -> tuple[NDArray[Any], int]:
    """Return a picture whose values that are no numbers are its median, and how many those were."""
    if image.dtype.kind != "f":
        return image, 0
    known = np.isfinite(image)
    gaps = image.size - int(np.count_nonzero(known))
    if not gaps:
        return image, 0
    middle = np.median(image[known]) if gaps < image.size else 0.0
    return np.where(known, image, image.dtype.type(middle)), gaps
