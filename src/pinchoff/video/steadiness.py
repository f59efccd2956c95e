"""Whether the picture itself moves, as on a stage that drifts or shakes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.droplets import Droplet, Segmenter
from pinchoff.video.reading import Frame

_PAIRS = 5  # of frames that are compared
_SHIFT_PX = 0.5  # least that the picture goes between them
_EXPLAINED = 0.8  # of what differs between two frames, what is left once one is moved back
_MOST_DIFFERENT = 60.0  # grey levels: a droplet that comes and goes counts for no more
_NOTHING = 0.5  # grey levels: frames that differ by less are the same
_AROUND, _AROUND_PX = 0.5, 6.0  # radii, and pixels at least, beyond an outline: light about it
_FARTHEST = 0.25  # of the shorter side: farther it is not believed to go
_FREE_SHARE = 0.05  # least part of the frame without droplets in which it can be seen
_TO_AND_FRO = 0.5  # of the way that the picture goes, what it is farther in the end, at most
_TOGETHER = 0.5  # of what differs, what is left where all goes to and fro together


class PictureMoved(NamedTuple):
    """The picture itself moved, by so many pixels, between two frames given by number."""

    pixels: float
    first: int
    last: int


def picture_moved(
    pairs: Sequence[tuple[Frame, Frame]], segmenter: Segmenter
) -> PictureMoved | None:
    """Return by how much the picture itself moves from a frame to another, None if it does not.

    It moves if what is no droplet does, dirt and walls and shades; or if everything goes to and
    fro together, as no droplets do. What stands cannot be told from what moves then.
    """
    places = np.linspace(0, len(pairs) - 1, min(_PAIRS, len(pairs)))
    some = [pairs[round(place)] for place in places.tolist()]
    shifts = [_shift(*pair) for pair in some]
    left = [_left_over(one, other, shift) for (one, other), shift in zip(some, shifts, strict=True)]
    moved = [k for k, share in enumerate(left) if share < _EXPLAINED]
    if 2 * len(moved) <= len(some):
        return None
    ways = np.array(shifts)[moved]
    lengths = np.hypot(*ways.T)
    farthest = moved[int(lengths.argmax())]
    found = PictureMoved(float(lengths.max()), some[farthest][0].number, some[farthest][1].number)
    to_and_fro = np.hypot(*ways.sum(axis=0)) <= _TO_AND_FRO * lengths.sum()
    if len(moved) > 2 and to_and_fro and float(np.median(left)) < _TOGETHER:
        return found
    around = [
        _left_over(one, other, shift, segmenter)
        for (one, other), shift in [(some[k], shifts[k]) for k in moved]
    ]
    return found if 2 * sum(share < _EXPLAINED for share in around) > len(some) else None


def _images(pair: tuple[Frame, Frame]) -> list[NDArray[np.float32]]:
    """Return two frames' grey levels, a little smoothed, about zero, in the light of the first."""
    images = [cv2.GaussianBlur(each.luma.astype(np.float32), (0, 0), 1.0) for each in pair]
    # Not by their means, which change with every droplet that comes or goes.
    light = [max(float(np.median(image)), 1e-3) for image in images]
    return [image * (light[0] / own) - light[0] for image, own in zip(images, light, strict=True)]


def _shift(one: Frame, other: Frame) -> tuple[float, float]:
    """Return how far most of what is in a frame is to the right and down in another, pixels."""
    height, width = one.luma.shape
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    first, last = _images((one, other))
    (x, y), _ = cv2.phaseCorrelate(first, last, window)
    return float(x), float(y)


def _left_over(
    one: Frame, other: Frame, shift: tuple[float, float], segmenter: Segmenter | None = None
) -> float:
    """Return how much of what differs between frames, where no droplet is, a shift leaves."""
    height, width = one.luma.shape
    if not _SHIFT_PX <= math.hypot(*shift) <= _FARTHEST * min(height, width):
        return 1.0
    images = _images((one, other))
    back = np.array([[1.0, 0.0, -shift[0]], [0.0, 1.0, -shift[1]]])
    moved = cv2.warpAffine(images[1], back, (width, height), borderMode=cv2.BORDER_REPLICATE)
    margin = math.ceil(max(map(abs, shift)))
    free = np.zeros((height, width), dtype=np.uint8)
    free[margin : height - margin, margin : width - margin] = 255
    if segmenter is not None:
        for droplet in segmenter.droplets(one):
            _take_out(free, droplet, shift)
        for droplet in segmenter.droplets(other):
            _take_out(free, droplet, (-shift[0], -shift[1]))
    if cv2.countNonZero(free) < _FREE_SHARE * free.size:
        return 1.0
    before, after = (
        cv2.mean(np.minimum(np.abs(images[0] - image), _MOST_DIFFERENT), free)[0]
        for image in (images[1], moved)
    )
    return (after + _NOTHING) / (before + _NOTHING)


def _take_out(free: NDArray[np.uint8], droplet: Droplet, shift: tuple[float, float]) -> None:
    """Take a droplet, and the light about it, out of a mask, where it is and where it goes."""
    width = 2 * round(max(_AROUND_PX, _AROUND * math.sqrt(droplet.area / math.pi)))
    for move in ((0.0, 0.0), shift):
        walk = np.rint(droplet.outline + move).astype(np.int32)
        cv2.fillPoly(free, [walk], 0)
        cv2.polylines(free, [walk], True, 0, width)
