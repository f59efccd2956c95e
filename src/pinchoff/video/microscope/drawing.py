"""Outlines to pixels: what covers how much of each pixel, then light, blur and noise."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.microscope.appearance import Microscope

Floats = NDArray[np.float64]
Image = NDArray[np.float32]
Pixels = NDArray[np.uint8]

OVERSAMPLING = 4
"""Finer pixels a pixel's side, on which outlines are drawn and averaged."""

_FRACTION_BITS = 8  # of OpenCV's coordinates: 1/256 of a finer pixel
_MARGIN = 2  # pixels round an outline


class Canvas:
    """Draw frames of one clip.

    Parameters
    ----------
    microscope : Microscope
    obstacles : ndarray, shape (M, 3)
        Centre x, y and radius, pixels.
    frame_count : int
        Frames of the clip, over which the focus drifts once there and back.
    """

    def __init__(self, microscope: Microscope, obstacles: Floats, frame_count: int) -> None:
        self._look = microscope
        self._frames = max(1, frame_count)
        self._random = np.random.default_rng(microscope.seed)
        self._ring_px = microscope.ring_width_um / microscope.pixel_size_um
        self._empty = self._background(obstacles)
        self._light = self._uneven_light() * self._dust()

    def draw(self, index: int, instants: Iterable[Iterable[Floats]]) -> Pixels:
        """Return one frame: (height, width, 3) of red, green and blue.

        Parameters
        ----------
        index : int
            Number of the frame.
        instants : iterable of iterable of ndarray, shape (n, 2)
            The droplets' outlines, pixels, at one instant or at several while the shutter was open.
        """
        exposures = [self._scene(outlines) for outlines in instants]
        image = exposures[0] if len(exposures) == 1 else np.mean(exposures, axis=0)
        blur = self._blur(index)
        if blur > 0.0:
            image = cv2.GaussianBlur(image, (0, 0), blur)
        lamp = 1.0 + self._look.flicker * self._random.standard_normal()
        image = image * (self._light * np.float32(lamp))[:, :, None]
        noise = self._random.standard_normal(image.shape[:2], dtype=np.float32)
        image += np.float32(self._look.noise) * noise[:, :, None]
        pixels: Pixels = cv2.convertScaleAbs(np.maximum(image, 0.0))
        return pixels

    def _scene(self, outlines: Iterable[Floats]) -> Image:
        image = self._empty.copy()
        ring, interior = _channels(self._look.ring), _channels(self._look.interior)
        for outline in outlines:
            window, inside, core = coverage(outline, self._look.size, self._ring_px)
            if not inside.size:
                continue
            part = image[window]
            part += inside[:, :, None] * (ring - part)
            part += core[:, :, None] * (interior - ring)
        return image

    def _background(self, obstacles: Floats) -> Image:
        look = self._look
        image = np.empty((look.height, look.width, 3), dtype=np.float32)
        image[:] = look.fluid
        y, x = np.mgrid[: look.height, : look.width].astype(np.float32)
        for centre_x, centre_y, radius in obstacles:
            depth = radius - np.hypot(x - centre_x, y - centre_y)
            inside = np.clip(depth + 0.5, 0.0, 1.0)[:, :, None]
            rim_px = look.pillar_rim_um / look.pixel_size_um
            core = np.clip(depth - rim_px + 0.5, 0.0, 1.0)[:, :, None]
            image += inside * (_channels(look.pillar_rim) - image)
            image += core * (_channels(look.pillar) - _channels(look.pillar_rim))
        return image

    def _uneven_light(self) -> Image:
        look = self._look
        y, x = np.mgrid[: look.height, : look.width].astype(np.float32)
        # Brightest a little off the middle, as lamps are.
        across = (x - 0.42 * look.width) / look.width
        down = (y - 0.55 * look.height) / look.height
        light: Image = 1.0 - np.float32(2.0 * look.unevenness) * (across**2 + down**2)
        return light

    def _dust(self) -> Image:
        look = self._look
        specks = np.ones((look.height, look.width), dtype=np.float32)
        for _ in range(look.dust):
            x, y = self._random.uniform((0, 0), look.size)
            radius, depth = self._random.uniform((1.0, 0.1), (3.5, 0.6))
            yy, xx = np.mgrid[: look.height, : look.width].astype(np.float32)
            specks *= 1.0 - np.float32(depth) * np.clip(radius - np.hypot(xx - x, yy - y), 0, 1)
        return specks

    def _blur(self, index: int) -> float:
        phase = math.pi * index / self._frames
        return float(self._look.blur_px + self._look.focus_drift_px * math.sin(phase))


def _channels(colour: tuple[int, int, int]) -> Image:
    return np.array(colour, dtype=np.float32)


def coverage(
    outline: Floats, size: tuple[int, int], ring_px: float
) -> tuple[tuple[slice, slice], Image, Image]:
    """Return how much of each pixel lies inside an outline, and inside its ring.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
        Pixels.
    size : (int, int)
        Width and height of the image.
    ring_px : float
        Width of the ring, pixels.

    Returns
    -------
    window : (slice, slice)
        Rows and columns of the image that the outline touches.
    inside, core : ndarray, shape (rows, columns)
        0 to 1: within the outline, and farther than the ring's width within it.
    """
    low = np.floor(outline.min(axis=0)).astype(int) - _MARGIN
    high = np.ceil(outline.max(axis=0)).astype(int) + _MARGIN + 1
    width, height = (high - low).tolist()
    fine = np.zeros((height * OVERSAMPLING, width * OVERSAMPLING), dtype=np.uint8)
    # Pixel k spans k - 1/2 to k + 1/2; finer pixels likewise, hence the halves.
    points = (outline - low + 0.5) * OVERSAMPLING - 0.5
    fixed = [np.rint(points * (1 << _FRACTION_BITS)).astype(np.int32)]
    # OpenCV fills all finer pixels that the outline runs through: half of each is outside.
    cv2.fillPoly(fine, fixed, 255, shift=_FRACTION_BITS)
    cv2.polylines(fine, fixed, True, 128, shift=_FRACTION_BITS)
    # The outline runs through the finer pixels at 128, from which the depth is counted.
    depth = cv2.distanceTransform(cv2.compare(fine, 128, cv2.CMP_GT), cv2.DIST_L2, 5)
    core = cv2.convertScaleAbs(np.maximum(depth - (ring_px * OVERSAMPLING - 0.5), 0.0), alpha=255)
    rows, in_rows = _overlap(int(low[1]), height, size[1])
    columns, in_columns = _overlap(int(low[0]), width, size[0])
    inside, core = (
        cv2.resize(fine_share, (width, height), interpolation=cv2.INTER_AREA)[in_rows, in_columns]
        for fine_share in (fine, core)
    )
    return (rows, columns), inside * np.float32(1 / 255), core * np.float32(1 / 255)


def _overlap(start: int, length: int, size: int) -> tuple[slice, slice]:
    """Return where pixels from `start` on lie in 0 to `size`, and which of them those are."""
    first, last = min(max(start, 0), size), max(0, min(start + length, size))
    return slice(first, last), slice(first - start, max(first, last) - start)
