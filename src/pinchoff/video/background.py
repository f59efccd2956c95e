"""The empty chamber: what a clip shows where no droplet is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.video.reading import Frame

Pixels = NDArray[np.uint8]
Image = NDArray[np.float32]

SAMPLE_SIZE = 24
"""Frames, spread evenly over the clip, from which the background is taken."""

_PAIRED = 4  # every fourth frame of the sample is kept with the next one

_GRID = 16  # the lamp is compared on every 16th pixel of every 16th row
_LEAST_LIGHT = 0.02  # of the mean: beyond the edge of the view there is none
_ILLUMINATION_SHARE = 0.12  # of the shorter side: how far the light is even


@dataclass(frozen=True, eq=False)
class Background:
    """The empty chamber.

    Attributes
    ----------
    luma : ndarray of float32, shape (height, width)
    chroma : ndarray of float32, shape (2, height/2, width/2), or None
    light : ndarray of float32, shape (height, width)
        The light alone, 1 on average: the background without obstacles and dust.
    noise : float
        Standard deviation of one frame's brightness about it, grey levels.
    """

    luma: Image
    chroma: Image | None
    light: Image
    noise: float

    def lamp(self, luma: Pixels) -> float:
        """Return how bright a frame is, relative to the background.

        The median of the ratio on a grid, then the mean of what is within three of its
        deviations: droplets, on less than half of the grid, do not count.
        """
        ratio = luma[::_GRID, ::_GRID] / np.maximum(self.luma[::_GRID, ::_GRID], 1.0)
        middle = float(np.median(ratio))
        off = np.abs(ratio - middle)
        near = ratio[off <= 4.5 * max(float(np.median(off)), 1e-3)]
        return float(near.mean()) if near.size else middle


class Sample(NamedTuple):
    """Frames of a clip.

    Attributes
    ----------
    frames : list of Frame
        Spread evenly over it.
    pairs : list of (Frame, Frame)
        Some of them, each with the next one that was read.
    read : int
        Frames of the clip that were read.
    """

    frames: Sequence[Frame]
    pairs: Sequence[tuple[Frame, Frame]] = ()
    read: int = 0


def sample(frames: Iterable[Frame]) -> Sample:
    """Return frames spread evenly over a clip of any length.

    Every k-th is kept, and k doubles whenever there are twice as many as wanted, so that memory
    stays bounded; of every fourth of these the next one too.
    """
    kept: list[Frame] = []
    following: dict[int, Frame] = {}  # by the number of the frame before
    stride, count = 1, 0
    last: Frame | None = None
    for frame in frames:
        if last is not None and kept and kept[-1] is last and (len(kept) - 1) % _PAIRED == 0:
            following[last.number] = frame
        if count % stride == 0:
            kept.append(frame)
            if len(kept) == 2 * SAMPLE_SIZE:
                kept, stride = kept[::2], 2 * stride
                firsts = {first.number for first in kept[::_PAIRED]}
                following = {n: after for n, after in following.items() if n in firsts}
        last = frame
        count += 1
    pairs = [(frame, following[frame.number]) for frame in kept if frame.number in following]
    return Sample(kept, pairs, count)


def median_background(frames: Sequence[Frame]) -> Background:
    """Return the median of frames, pixel by pixel.

    Parameters
    ----------
    frames : sequence of Frame
        One or more of one size. One alone is never empty: then the light stands for the chamber.
    """
    if len(frames) == 1:
        return _still_background(frames[0])
    lumas = np.stack([frame.luma for frame in frames])
    luma = pixel_median(lumas)
    first = frames[0].chroma
    chroma = None
    if first is not None:
        chroma = pixel_median(np.stack([_chroma(frame) for frame in frames]))
    return _background(luma, chroma, _noise(lumas, luma))


def pixel_median(images: Pixels) -> Image:
    """Return the median over the first axis, as NumPy's, but nine times as fast.

    Bit by bit from the highest: a bit of the k-th largest value is set if that many values are as
    large with it.

    Parameters
    ----------
    images : ndarray of uint8, shape (n, ...)
        Fewer than 256.
    """
    rows = images.reshape(len(images), -1)
    middle = [_kth_largest(rows, rank) for rank in {len(rows) // 2 + 1, len(rows) - len(rows) // 2}]
    total = np.sum(middle, axis=0, dtype=np.float32)
    return np.reshape(total / np.float32(len(middle)), images.shape[1:])


def _kth_largest(rows: Pixels, rank: int) -> Pixels:
    found = np.zeros(rows.shape[1], dtype=np.uint8)
    for bit in range(7, -1, -1):
        with_bit = found | np.uint8(1 << bit)
        count = np.zeros_like(found)
        for row in rows:
            count += row >= with_bit
        found = np.where(count >= rank, with_bit, found)
    return found


def masked_background(
    frames: Sequence[Frame], droplets: Sequence[Pixels], before: Background
) -> Background:
    """Return the mean of frames where no droplet is; what is never free stays as it was.

    The median leans towards the droplets where they often pass; this mean does not.

    Parameters
    ----------
    frames : sequence of Frame
    droplets : sequence of ndarray of uint8, shape (height, width)
        Not zero where a droplet is, or near it.
    before : Background
    """
    luma = _masked_mean(
        [(frame.luma / before.lamp(frame.luma)).astype(np.float32) for frame in frames],
        droplets,
        before.luma,
    )
    chroma = before.chroma
    if chroma is not None:
        size = (chroma.shape[2], chroma.shape[1])
        halves = [cv2.resize(mask, size, interpolation=cv2.INTER_AREA) for mask in droplets]
        planes = [
            _masked_mean([_chroma(f)[k].astype(np.float32) for f in frames], halves, chroma[k])
            for k in (0, 1)
        ]
        chroma = np.stack(planes)
    return _background(luma, chroma, before.noise)


def _chroma(frame: Frame) -> Pixels:
    assert frame.chroma is not None  # all frames of a clip have colour, or none has
    return frame.chroma


def _masked_mean(images: Sequence[Image], masks: Sequence[Pixels], fallback: Image) -> Image:
    total, count = np.zeros_like(fallback), np.zeros_like(fallback)
    for image, mask in zip(images, masks, strict=True):
        free = cv2.compare(mask, 0, cv2.CMP_EQ)
        cv2.accumulate(np.ascontiguousarray(image), total, mask=free)
        count += free > 0
    enough = count >= 3
    mean: Image = np.where(enough, total / np.maximum(count, 1.0), fallback)
    return mean


def _background(luma: Image, chroma: Image | None, noise: float) -> Background:
    height, width = luma.shape
    reach = max(1, int(_ILLUMINATION_SHARE * min(height, width) / 4)) | 1
    small = cv2.resize(
        luma, (max(1, width // 4), max(1, height // 4)), interpolation=cv2.INTER_AREA
    )
    # Obstacles and dust are dark and small: closing fills them, smoothing takes the steps away.
    closed = cv2.morphologyEx(small, cv2.MORPH_CLOSE, np.ones((reach, reach), np.uint8))
    smooth = cv2.GaussianBlur(closed, (0, 0), reach / 2.0)
    light = cv2.resize(smooth, (width, height), interpolation=cv2.INTER_LINEAR)
    even = np.maximum(light / max(float(light.mean()), 1.0), np.float32(_LEAST_LIGHT))
    return Background(luma, chroma, even, noise)


def _still_background(frame: Frame) -> Background:
    luma = frame.luma.astype(np.float32)
    seen = _background(luma, None, _noise(frame.luma[None], luma))
    chroma = None
    if frame.chroma is not None:
        tints = np.median(frame.chroma, axis=(1, 2), keepdims=True).astype(np.float32)
        chroma = np.broadcast_to(tints, frame.chroma.shape).copy()
    empty: Image = seen.light * np.float32(luma.mean() / seen.light.mean())
    return Background(empty, chroma, seen.light, seen.noise)


def _noise(lumas: Pixels, luma: Image) -> float:
    if len(lumas) < 2:
        blurred = cv2.GaussianBlur(luma, (0, 0), 1.0)
        return max(1.0, float(1.6 * np.median(np.abs(luma - blurred))))
    chamber = np.maximum(luma[::_GRID, ::_GRID], 1.0)
    ratio = lumas[:, ::_GRID, ::_GRID] / chamber
    lamp = np.maximum(np.median(ratio, axis=(1, 2), keepdims=True), 1e-3)
    off = np.abs(ratio / lamp - 1.0) * chamber  # a lamp that flickers is no noise
    return max(1.0, float(1.4826 * np.median(off)))
