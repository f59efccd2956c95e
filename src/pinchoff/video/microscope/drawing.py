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

_FRACTION_BITS = 8  # binary places of OpenCV's coordinates: 1/256 of a finer pixel
_MARGIN = 1  # pixels round an outline
_BLUR_REACH = 4.0  # standard deviations: a pixel's light does not reach farther
_NOISE_LENGTH, _NOISE_FRAMES = 1 << 22, 4  # numbers, and frames of them, that noise is taken from

Window = tuple[slice, slice]
"""Rows and columns of an image."""


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
        self._light = cv2.merge([self._uneven_light() * self._dust()] * 3)
        self._lit_empty: tuple[float, Image] | None = None  # blur, and how it looks with it
        pixels = microscope.height * microscope.width
        length = max(_NOISE_LENGTH, _NOISE_FRAMES * pixels)
        self._noise = self._random.standard_normal(length, dtype=np.float32)
        self._noise *= np.float32(microscope.noise)

    def draw(self, index: int, instants: Iterable[Iterable[Floats]]) -> Pixels:
        """Return one frame: (height, width, 3) of red, green and blue.

        Parameters
        ----------
        index : int
            Number of the frame.
        instants : iterable of iterable of ndarray, shape (n, 2)
            The droplets' outlines, pixels, at one instant or at several while the shutter was open.
        """
        scenes, windows = [], []
        for outlines in instants:
            scene, changed = self._scene(outlines)
            scenes.append(scene)
            windows += changed
        scene = scenes[0] if len(scenes) == 1 else np.mean(scenes, axis=0)
        image = self._seen(scene, windows, self._blur(index))
        if self._look.flicker > 0.0:
            image *= np.float32(1.0 + self._look.flicker * self._random.standard_normal())
        noise = self._frame_noise()
        pixels: Pixels = cv2.add(image, cv2.merge([noise] * 3), dtype=cv2.CV_8U)
        return pixels

    def _frame_noise(self) -> Image:
        """Return one frame's noise: a piece of a long row of numbers, begun anywhere."""
        height, width = self._look.height, self._look.width
        first = int(self._random.integers(len(self._noise) - height * width))
        return self._noise[first : first + height * width].reshape(height, width)

    def _lit(self, blur: float) -> Image:
        """Return the empty chamber out of focus, in its uneven light."""
        if self._lit_empty is None or self._lit_empty[0] != blur:
            image = cv2.multiply(_blurred(self._empty, blur), self._light)
            self._lit_empty = blur, image
        return self._lit_empty[1]

    def _seen(self, scene: Image, windows: list[Window], blur: float) -> Image:
        """Return a scene out of focus, in its uneven light: new only where it is not empty."""
        image = self._lit(blur).copy()
        reach = math.ceil(_BLUR_REACH * blur) + 1
        for window in windows:
            around = _grown(window, reach, self._look.size)
            farther = _grown(around, reach, self._look.size)
            rows, columns = (
                slice(inner.start - outer.start, inner.stop - outer.start)
                for inner, outer in zip(around, farther, strict=True)
            )
            blurred = _blurred(scene[farther], blur)[rows, columns]
            image[around] = cv2.multiply(blurred, self._light[around])
        return image

    def _scene(self, outlines: Iterable[Floats]) -> tuple[Image, list[Window]]:
        """Return a sharp scene in even light, and where it is not the empty chamber."""
        image, windows = self._empty.copy(), []
        colours = np.column_stack([_channels(self._look.ring), _channels(self._look.interior)])
        for outline in outlines:
            window, inside, core = coverage(outline, self._look.size, self._ring_px)
            if not inside.size:
                continue
            # What is behind, times how much of it shows, then ring and interior by their shares.
            behind = cv2.multiply(image[window], cv2.merge([1.0 - inside] * 3))
            shares = np.stack([inside - core, core], axis=-1)
            image[window] = behind + cv2.transform(shares, colours)
            windows.append(window)
        return image, windows

    def _background(self, obstacles: Floats) -> Image:
        look = self._look
        rim, core = _channels(look.pillar_rim), _channels(look.pillar)
        image = np.empty((look.height, look.width, 3), dtype=np.float32)
        image[:] = look.fluid
        for x, y, radius in obstacles:
            window, away = self._distances(x, y, radius)
            depth = (radius - away)[:, :, None]
            rim_px = look.pillar_rim_um / look.pixel_size_um
            part = image[window]
            part += np.clip(depth + 0.5, 0.0, 1.0) * (rim - part)
            part += np.clip(depth - rim_px + 0.5, 0.0, 1.0) * (core - rim)
        return image

    def _distances(self, x: float, y: float, radius: float) -> tuple[Window, Floats]:
        """Return where a disc lies in the image, and its pixels' distances from the centre."""
        parts, away = [], []
        for centre, length in ((y, self._look.height), (x, self._look.width)):
            first = max(0, math.floor(centre - radius) - 1)  # an edge is blurred over a pixel
            part = slice(first, max(first, math.ceil(centre + radius) + 2))
            parts.append(part)
            away.append(np.arange(length, dtype=np.float32)[part] - centre)
        return (parts[0], parts[1]), np.hypot(away[1], away[0][:, None])

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
            window, away = self._distances(x, y, radius)
            specks[window] *= 1.0 - np.float32(depth) * np.clip(radius - away, 0, 1)
        return specks

    def _blur(self, index: int) -> float:
        phase = math.pi * index / self._frames
        return float(self._look.blur_px + self._look.focus_drift_px * math.sin(phase))


def _blurred(image: Image, blur: float) -> Image:
    if blur <= 0.0:
        return image
    blurred: Image = cv2.GaussianBlur(image, (0, 0), blur)
    return blurred


def _grown(window: Window, reach: int, size: tuple[int, int]) -> Window:
    """Return rows and columns with some more on every side, as far as the image goes."""
    rows, columns = (
        slice(max(0, part.start - reach), min(length, part.stop + reach))
        for part, length in zip(window, (size[1], size[0]), strict=True)
    )
    return rows, columns


def _channels(colour: tuple[int, int, int]) -> Image:
    return np.array(colour, dtype=np.float32)


def coverage(outline: Floats, size: tuple[int, int], ring_px: float) -> tuple[Window, Image, Image]:
    """Return how much of each pixel lies inside an outline, and inside its ring.

    Parameters
    ----------
    outline : ndarray, shape (n, 2)
    size : (int, int)
        Width and height of the image.
    ring_px : float

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
    inside_finely = np.zeros((height * OVERSAMPLING, width * OVERSAMPLING), dtype=np.uint8)
    # Pixel k spans k - 1/2 to k + 1/2; finer pixels likewise, hence the halves.
    points = (outline - low + 0.5) * OVERSAMPLING - 0.5
    fixed = [np.rint(points * (1 << _FRACTION_BITS)).astype(np.int32)]
    # OpenCV fills all finer pixels that the outline runs through: half of each is outside.
    cv2.fillPoly(inside_finely, fixed, 255, shift=_FRACTION_BITS)
    cv2.polylines(inside_finely, fixed, True, 128, shift=_FRACTION_BITS)
    # The outline runs through the finer pixels at 128, from which the depth is counted.
    depth = cv2.distanceTransform(cv2.compare(inside_finely, 128, cv2.CMP_GT), cv2.DIST_L2, 5)
    ring = ring_px * OVERSAMPLING - 0.5
    core = cv2.addWeighted(depth, 255, depth, 0, -255 * ring, dtype=cv2.CV_8U)  # 0 to 255 at most
    rows, in_rows = _overlap(int(low[1]), height, size[1])
    columns, in_columns = _overlap(int(low[0]), width, size[0])
    inside, core = (
        cv2.resize(finely, (width, height), interpolation=cv2.INTER_AREA)[in_rows, in_columns]
        for finely in (inside_finely, core)
    )
    return (rows, columns), inside * np.float32(1 / 255), core * np.float32(1 / 255)


def _overlap(start: int, length: int, size: int) -> tuple[slice, slice]:
    """Return where pixels from `start` on lie in 0 to `size`, and which of them those are."""
    first, last = min(max(start, 0), size), max(0, min(start + length, size))
    return slice(first, last), slice(first - start, max(first, last) - start)
