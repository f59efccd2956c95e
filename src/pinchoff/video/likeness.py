"""How much of the droplets' colour something in a frame has."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.background import Background
from pinchoff.video.contours import Floats
from pinchoff.video.reading import Frame

Image = NDArray[np.float32]
Pixels = NDArray[np.uint8]
Walk = NDArray[np.int32]
"""Pixels x, y round a region, (n, 1, 2), as ``cv2.findContours`` gives them."""


class Likeness:
    """How much of the droplets' colour something has: 0 is the fluid's, 1 theirs.

    Parameters
    ----------
    background : Background
    colour : ndarray, shape (3,)
        As in `Levels`.
    """

    def __init__(self, background: Background, colour: Floats) -> None:
        self.known = bool(np.any(colour != 0.0))
        weights = (colour / max(float(colour @ colour), 1e-9)).astype(np.float32)
        # At the colour's resolution, half that of brightness.
        self._brightness = np.ascontiguousarray(weights[0] / background.light[::2, ::2])
        self._colour = [float(weight) for weight in weights[1:]]
        self._fluid = self._sum(background.luma, background.chroma, 1.0)

    def of(self, frame: Frame, lamp: float) -> Image:
        """Return the map for every second pixel of a frame, given how bright the lamp is."""
        alike = self._sum(frame.luma, frame.chroma, lamp)
        alike -= self._fluid
        return alike

    def _sum(self, luma: NDArray[Any], chroma: NDArray[Any] | None, lamp: float) -> Image:
        small = np.ascontiguousarray(luma[::2, ::2])
        total: Image = cv2.multiply(small, self._brightness, scale=1.0 / lamp, dtype=cv2.CV_32F)
        if chroma is not None:
            for weight, plane in zip(self._colour, chroma, strict=True):
                total = cv2.addWeighted(total, 1.0, plane.astype(np.float32), weight, 0.0)
        return total

    @staticmethod
    def within(alike: Image, ring: Pixels, hole: Walk) -> float:
        """Return its mean over the pixels that a hole in a ring encloses."""
        left, top, wide, high = cv2.boundingRect(hole)
        left, top = left + left % 2, top + top % 2
        mask = np.zeros((high, wide), dtype=np.uint8)
        cv2.drawContours(mask, [hole], -1, 1, cv2.FILLED, offset=(-left, -top))
        around = ring[top : top + high : 2, left : left + wide : 2]
        inside = cv2.subtract(mask[::2, ::2][: around.shape[0], : around.shape[1]], around)
        rows, columns = inside.shape
        part = alike[top // 2 : top // 2 + rows, left // 2 : left // 2 + columns]
        return float(cv2.mean(part, inside)[0])

    @staticmethod
    def along(alike: Image, edge: tuple[slice, slice], dark: NDArray[np.bool_]) -> Image:
        """Return the values along an edge of the frame, smoothed over a few pixels.

        Parameters
        ----------
        alike : ndarray
            What `of` returns.
        edge : (slice, slice)
        dark : ndarray, shape (length,)
            Where a ring runs along the edge; it counts as alike, so that nothing stays open beside
            it.
        """
        line = np.clip(alike[edge].reshape(-1), 0.0, 1.0)
        line[dark[::2]] = 1.0
        line = cv2.blur(line.reshape(1, -1), (5, 1), borderType=cv2.BORDER_REPLICATE)
        along: Image = np.repeat(line[0], 2)[: dark.size]
        return along
