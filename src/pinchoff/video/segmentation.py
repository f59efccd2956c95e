"""Segmentation: droplets as dark rings round an interior, with sub-pixel outlines.

A frame is subtracted from the empty chamber, so that obstacles and uneven light drop out. What is
darker than a threshold is ring; what a ring encloses, and has the droplets' colour, is interior;
a ring belongs to the interior that it encloses. Two interiors in one connected dark region are
two droplets that touch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.background import Background
from pinchoff.video.contours import Floats, trace
from pinchoff.video.reading import Frame

Pixels = NDArray[np.uint8]

_DENOISING = (3, 0.7)  # size and standard deviation of the filter before thresholds, pixels
_FREE = -1


class Droplet(NamedTuple):
    """One droplet in one frame; pixels, origin at the centre of the top left one, y down.

    Attributes
    ----------
    outline : ndarray, shape (n, 2)
        Clockwise as seen.
    area : float
        Enclosed by it, pixels.
    x, y : float
        Its centre of mass.
    cut : bool
        Whether the frame's edge cuts it.
    group : int
        Droplets that touch one another have the same number in their frame; -1: touches none.
    """

    outline: Floats
    area: float
    x: float
    y: float
    cut: bool
    group: int


@dataclass(frozen=True, eq=False)
class Levels:
    """The thresholds of a clip.

    Attributes
    ----------
    ring : float
        How much darker than the fluid the ring is, grey levels at average light.
    edge : float
        Where the outline lies, a fraction of `ring`.
    colour : ndarray, shape (3,)
        Interior less fluid: brightness at average light, blue and red difference; zeros where the
        interior cannot be told from the fluid.
    interior : float
        Least similarity to that colour, from 0, the fluid's, to 1.
    minimum_area : float
        Of a droplet, pixels.
    """

    ring: float
    edge: float
    colour: Floats
    interior: float
    minimum_area: float


class Segmenter:
    """Find the droplets in the frames of one clip.

    Parameters
    ----------
    background : Background
    levels : Levels
    """

    def __init__(self, background: Background, levels: Levels) -> None:
        self._background = background
        self._levels = levels
        threshold = levels.edge * levels.ring * background.light
        self._threshold = np.clip(np.rint(threshold), 1, 255).astype(np.uint8)
        self._has_colour = bool(np.any(levels.colour != 0.0))

    def darkness(self, frame: Frame) -> Pixels:
        """Return how much darker than the empty chamber a frame is, grey levels."""
        lamp = self._background.lamp(frame.luma)
        empty = cv2.convertScaleAbs(self._background.luma, alpha=lamp)
        dark = cv2.subtract(empty, frame.luma)
        size, deviation = _DENOISING
        smooth: Pixels = cv2.GaussianBlur(dark, (size, size), deviation)
        return smooth

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame, the touching ones apart."""
        dark = self.darkness(frame)
        ring = cv2.compare(dark, self._threshold, cv2.CMP_GT)
        bodies = self._interiors(frame, ring)
        filled = self._filled(ring, bodies)
        walks, _ = cv2.findContours(filled, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        owned = _owners(walks, bodies)
        chosen: list[NDArray[np.int32]] = []
        groups: list[int] = []
        inside = filled
        for k, interiors in enumerate(owned):
            if len(interiors) == 1:
                chosen.append(walks[k])
                groups.append(_FREE)
            elif len(interiors) > 1:
                parts = _apart(filled, bodies, interiors, walks[k])
                chosen += parts
                groups += [k] * len(parts)
        excess = cv2.subtract(dark, self._threshold, dtype=cv2.CV_16S)
        outlines = trace(chosen, excess, inside)
        height, width = dark.shape
        return [
            _droplet(outline, walk, group, (width, height))
            for outline, walk, group in zip(outlines, chosen, groups, strict=True)
            if len(outline) >= 3
        ]

    def _interiors(self, frame: Frame, ring: Pixels) -> _Interiors:
        """Find the regions that are not ring and have the droplets' colour."""
        rest = cv2.bitwise_not(ring)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(rest, connectivity=4)
        areas = stats[:, cv2.CC_STAT_AREA]
        # The ring takes some of a small droplet's area.
        big = np.flatnonzero(areas >= 0.25 * self._levels.minimum_area)
        big = big[big != 0]
        largest = big[np.argmax(areas[big])] if len(big) else 0
        height, width = ring.shape
        found = []
        for label in big.tolist():
            left, top, wide, high, _ = stats[label].tolist()
            at_edge = left == 0 or top == 0 or left + wide == width or top + high == height
            window = slice(top, top + high), slice(left, left + wide)
            if self._has_colour:
                likeness = self._likeness(frame, labels, label, window)
                wanted = likeness >= self._levels.interior
            else:
                wanted = label != largest and not at_edge
            if wanted:
                found.append(label)
        return _Interiors(labels, stats, found)

    def _likeness(
        self, frame: Frame, labels: NDArray[np.int32], label: int, window: tuple[slice, slice]
    ) -> float:
        """Return how much of the droplets' colour a region has: 0 is the fluid's, 1 theirs."""
        colour, background = self._levels.colour, self._background
        rows, columns = (slice(s.start + s.start % 2, s.stop, 2) for s in window)
        mask = (labels[rows, columns] == label).astype(np.uint8)
        if not mask.any():
            return 0.0
        light = float(background.light[window].mean())
        seen = np.zeros(3)
        seen[0] = cv2.mean(frame.luma[rows, columns], mask)[0]
        seen[0] -= cv2.mean(background.luma[rows, columns], mask)[0]
        seen[0] /= light
        if frame.chroma is not None and background.chroma is not None:
            half = tuple(
                slice(s.start // 2, s.start // 2 + n)
                for s, n in zip((rows, columns), mask.shape, strict=True)
            )
            for k in (0, 1):
                seen[k + 1] = (
                    cv2.mean(frame.chroma[k][half], mask)[0]
                    - cv2.mean(background.chroma[k][half], mask)[0]
                )
        return float(seen @ colour / (colour @ colour))

    @staticmethod
    def _filled(ring: Pixels, bodies: _Interiors) -> Pixels:
        shade = np.zeros(len(bodies.stats), dtype=np.uint8)
        shade[bodies.found] = 255
        filled: Pixels = cv2.bitwise_or(ring, shade[bodies.labels])
        return filled


class _Interiors(NamedTuple):
    """Labels of all regions between rings, and which of them are interiors of droplets."""

    labels: NDArray[np.int32]
    stats: NDArray[np.int32]
    found: list[int]

    def a_pixel_of(self, label: int) -> tuple[int, int]:
        """Return x and y of the leftmost pixel in a region's top row."""
        left, top, wide = self.stats[label, :3].tolist()
        return left + int(np.argmax(self.labels[top, left : left + wide] == label)), top


def _owners(walks: Sequence[NDArray[np.int32]], bodies: _Interiors) -> list[list[int]]:
    """Return for each outermost walk the interiors that lie within it."""
    boxes = [cv2.boundingRect(walk) for walk in walks]
    owned: list[list[int]] = [[] for _ in walks]
    for label in bodies.found:
        x, y = bodies.a_pixel_of(label)
        for k, (left, top, wide, high) in enumerate(boxes):
            within = left <= x < left + wide and top <= y < top + high
            if within and cv2.pointPolygonTest(walks[k], (float(x), float(y)), False) >= 0:
                owned[k].append(label)
                break
    return owned


def _apart(
    filled: Pixels, bodies: _Interiors, interiors: Sequence[int], walk: NDArray[np.int32]
) -> list[NDArray[np.int32]]:
    """Part a connected region among its interiors: every pixel goes to the nearest one."""
    left, top, wide, high = cv2.boundingRect(walk)
    window = slice(top, top + high), slice(left, left + wide)
    labels = bodies.labels[window]
    region = np.zeros((high, wide), dtype=np.uint8)
    cv2.drawContours(region, [walk], -1, 255, cv2.FILLED, offset=(-left, -top))
    outside = np.where(np.isin(labels, interiors), 0, 255).astype(np.uint8)
    _, nearest = cv2.distanceTransformWithLabels(
        outside, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_CCOMP
    )
    parts = []
    for label in interiors:
        x, y = bodies.a_pixel_of(label)
        own = np.where((nearest == nearest[y - top, x - left]) & (region > 0), 255, 0)
        walks, _ = cv2.findContours(
            own.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=(left, top)
        )
        parts.append(max(walks, key=len))
    return parts


def _droplet(
    outline: Floats, walk: NDArray[np.int32], group: int, size: tuple[int, int]
) -> Droplet:
    left, top, wide, high = cv2.boundingRect(walk)
    cut = left <= 0 or top <= 0 or left + wide >= size[0] or top + high >= size[1]
    x, y = _core.centroid(outline)
    return Droplet(outline, _core.area(outline), x, y, cut, group)
