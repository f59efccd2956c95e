"""Segmentation: droplets as dark rings round an interior, with sub-pixel outlines.

A frame is subtracted from the empty chamber, so that obstacles and uneven light drop out. What is
darker than a threshold is ring; what a ring encloses, and has the droplets' colour, is interior;
a ring belongs to the interior that it encloses. Two interiors in one connected dark region are
two droplets that touch.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from pinchoff import _core
from pinchoff.video.background import Background
from pinchoff.video.contours import Floats, trace
from pinchoff.video.droplets import Droplet
from pinchoff.video.likeness import Image, Likeness, Pixels, Walk
from pinchoff.video.reading import Frame

_DENOISING = (3, 0.7)  # size and standard deviation of the filter before thresholds, pixels
_FREE = -1
_ALL_RING = 4.0  # ring widths: thinner droplets may show no interior
_TWO_RINGS = 1.5  # ring widths: thicker than one ring, which may be a piece of a broken one
_CONVEX = 0.85  # least share of its convex hull that a droplet without interior fills
_ROUND = 0.7  # least share of the circle about it that such a droplet fills
_INTERIOR_SHARE = 0.25  # least of the smallest droplet's area: the ring takes the rest
_THINNEST_WALL = 1.4  # ring widths between two droplets that touch
_PALEST_WALL = 0.75  # of the ring's darkness, likewise


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
    ring_width : float
        Pixels; 0 where it is not known.
    pale_edge : float
        Like `edge`, where the ring is too pale to be closed there; none is looked for if it is
        not less than `edge`.
    hole : float
        Like `edge`, what the ring is darker than on its inner side; it counts if it is larger,
        because the interior is as dark as the edge.
    """

    ring: float
    edge: float
    colour: Floats
    interior: float
    minimum_area: float
    ring_width: float = 0.0
    pale_edge: float = 1.0
    hole: float = 0.0


class RingSegmenter:
    """Find the droplets in the frames of one clip.

    Parameters
    ----------
    background : Background
    levels : Levels
    """

    def __init__(self, background: Background, levels: Levels) -> None:
        self.background = background
        self._levels = levels
        self._ring = levels.ring * background.light
        self._likeness = Likeness(background, levels.colour)

    def darkness(self, frame: Frame, lamp: float) -> Pixels:
        """Return how much darker than the empty chamber a frame is, grey levels.

        Parameters
        ----------
        frame : Frame
        lamp : float
            What `Background.lamp` says of it.
        """
        empty = cv2.convertScaleAbs(self.background.luma, alpha=lamp)
        dark = cv2.subtract(empty, frame.luma)
        size, deviation = _DENOISING
        smooth: Pixels = cv2.GaussianBlur(dark, (size, size), deviation)
        return smooth

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame, the touching ones apart.

        Where something of the droplets' colour has no closed ring about it, the ring may be pale,
        because the droplet moves fast or is out of focus: there a lower level is tried.
        """
        lamp = self.background.lamp(frame.luma)
        dark = self.darkness(frame, lamp)
        if not self._likeness.known:
            return self._enclosed(lamp, None, dark, self._levels.edge)
        alike = self._likeness.of(frame, lamp)
        found = self._enclosed(lamp, alike, dark, self._levels.edge)
        pale_level = self._levels.pale_edge
        if pale_level >= self._levels.edge:
            return found
        claimed = _claimed(found, alike.shape)
        if not self._left_over(alike, claimed):
            return found
        pale = self._enclosed(lamp, alike, dark, pale_level)
        new = [each for each in pale if not _is_in(claimed, each)]
        # What a new one touches was seen with a piece of it.
        groups = {each.group for each in new} - {_FREE}
        new += [each for each in pale if each.group in groups and _is_in(claimed, each)]
        taken = _claimed(new, alike.shape)
        kept = [each for each in found if not _is_in(taken, each)]
        last = max((each.group for each in kept), default=_FREE)
        return kept + [
            each if each.group == _FREE else each._replace(group=each.group + last + 1)
            for each in new
        ]

    def _left_over(self, alike: Image, claimed: Pixels) -> bool:
        """Return whether something of the droplets' colour, not cut by the frame, was not found."""
        rest = cv2.subtract(cv2.compare(alike, self._levels.interior, cv2.CMP_GE), claimed)
        least = _INTERIOR_SHARE * self._levels.minimum_area / 4.0  # at half the resolution
        if cv2.countNonZero(rest) < least:
            return False
        rest = cv2.morphologyEx(rest, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        walks, _ = cv2.findContours(rest, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        size = (rest.shape[1], rest.shape[0])
        return any(cv2.contourArea(walk) >= least and not _is_cut(walk, size) for walk in walks)

    def _enclosed(
        self, lamp: float, alike: Image | None, dark: Pixels, level: float
    ) -> list[Droplet]:
        """Return what rings darker than a level, a fraction of the ring's darkness, enclose."""
        # Light that is brighter by some factor darkens a ring by as many more grey levels.
        threshold = cv2.convertScaleAbs(self._ring, alpha=level * lamp)
        ring = cv2.compare(dark, threshold, cv2.CMP_GT)
        if alike is not None:
            self._close_at_edges(alike, dark, threshold, ring)
        if self._levels.hole > self._levels.edge:
            self._open_interiors(lamp, dark, ring)
        bodies = self._bodies(lamp * level / self._levels.edge, alike, dark, ring)
        walks: list[Walk] = []
        groups: list[int] = []
        wholes: dict[int, int] = {}  # of a group that may be one droplet: place of its walk
        for group, body in enumerate(bodies):
            parts = [body.walk] if len(body.interiors) == 1 else _apart(ring, body)
            walks += parts
            groups += [group if len(parts) > 1 else _FREE] * len(parts)
            if len(parts) > 1 and self._may_be_one(parts, body):
                wholes[group] = len(walks)
                walks.append(body.walk)
                groups.append(_FREE)
        excess = cv2.subtract(dark, threshold, dtype=cv2.CV_16S)
        height, width = dark.shape
        found = [
            _droplet(outline, walk, group, (width, height)) if len(outline) >= 3 else None
            for outline, walk, group in zip(trace(walks, excess), walks, groups, strict=True)
        ]
        return [
            each._replace(whole=found[wholes[each.group]]) if each.group in wholes else each
            for place, each in enumerate(found)
            if each is not None and place not in wholes.values()
        ]

    def _close_at_edges(self, alike: Image, dark: Pixels, threshold: Pixels, ring: Pixels) -> None:
        """Close the rings of droplets that the frame cuts, along its edge where they are."""
        for edge in (np.s_[:1, :], np.s_[-1:, :], np.s_[:, :1], np.s_[:, -1:]):
            line = ring[edge].reshape(-1)
            # The frame's edge may lie on the pale flank of a ring.
            flank = dark[edge].reshape(-1) > 0.5 * threshold[edge].reshape(-1)
            inside = self._likeness.along(alike, edge, flank) >= self._levels.interior
            ring[edge] = np.where(inside, 255, line).reshape(ring[edge].shape)

    def _open_interiors(self, lamp: float, dark: Pixels, ring: Pixels) -> None:
        """Take out of dark regions what a still darker ring encloses."""
        level = cv2.convertScaleAbs(self._ring, alpha=self._levels.hole * lamp)
        darker = cv2.compare(dark, level, cv2.CMP_GT)
        contours, hierarchy = cv2.findContours(darker, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        least = _INTERIOR_SHARE * self._levels.minimum_area
        holes = [
            hole
            for k, hole in enumerate(contours)
            if hierarchy[0, k, 3] >= 0 and cv2.contourArea(hole) >= least
        ]
        inside = np.zeros_like(ring)
        cv2.drawContours(inside, holes, -1, 255, cv2.FILLED)
        cv2.drawContours(inside, holes, -1, 0, 1)  # their walks lie on the ring
        ring[inside > 0] = 0

    def _bodies(self, light: float, alike: Image | None, dark: Pixels, ring: Pixels) -> list[_Body]:
        """Return the connected rings that enclose interiors, with these, and small droplets.

        `light` is how much darker than at average light and focus the rings are.
        """
        contours, hierarchy = cv2.findContours(ring, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        found: dict[int, list[Walk]] = {}
        parents = hierarchy[0, :, 3].tolist() if len(contours) else []
        least = _INTERIOR_SHARE * self._levels.minimum_area
        for hole, parent in zip(contours, parents, strict=True):
            if parent < 0 or len(hole) ** 2 < 4.0 * np.pi * least:
                continue
            if cv2.contourArea(hole) >= least:
                interiors = found.setdefault(parent, [])
                if self._is_interior(alike, ring, hole):
                    interiors.append(hole)
        bodies = [
            _Body(contours[k], [holes] if len(holes) == 1 else self._sorted(holes, dark, light))
            for k, holes in found.items()
            if holes
        ]
        return bodies + [
            _Body(walk, [[]])
            for k, (walk, parent) in enumerate(zip(contours, parents, strict=True))
            if parent < 0 and k not in found and self._is_all_ring(walk)
        ]

    def _is_all_ring(self, walk: Walk) -> bool:
        """Return whether a dark spot is a droplet too small or too thin to show an interior.

        It is convex, and either round or thicker than a piece of a ring.
        """
        ring, least = self._levels.ring_width, self._levels.minimum_area
        if len(walk) ** 2 < 8.0 * least:
            return False  # too few pixels all round; most specks end here
        area = cv2.contourArea(walk) + 0.5 * len(walk) + 1.0  # the walk runs through its pixels
        hull = cv2.convexHull(walk)
        if area < least or area < _CONVEX * (cv2.contourArea(hull) + 0.5 * len(walk) + 1.0):
            return False
        left, top, wide, high = cv2.boundingRect(walk)
        spot = np.zeros((high + 2, wide + 2), dtype=np.uint8)
        cv2.drawContours(spot, [walk], -1, 1, cv2.FILLED, offset=(1 - left, 1 - top))
        thickness = 2.0 * float(cv2.distanceTransform(spot, cv2.DIST_L2, 5).max()) - 1.0
        _, radius = cv2.minEnclosingCircle(walk)
        is_round = area >= _ROUND * np.pi * (radius + 0.5) ** 2
        return thickness <= _ALL_RING * ring and (is_round or thickness >= _TWO_RINGS * ring)

    def _sorted(self, holes: list[Walk], dark: Pixels, light: float) -> list[list[Walk]]:
        """Sort the holes of one ring into droplets.

        Between two droplets that touch is a wall as dark as their rings. Where it is paler, it is
        a neck so thin that hardly any inside shows.
        """
        left, top, wide, high = cv2.boundingRect(np.concatenate(holes))
        window = np.s_[top : top + high, left : left + wide]
        level = self._ring[window] * np.float32(_PALEST_WALL * light)
        pale = (dark[window] <= level).astype(np.uint8)
        _, labels = cv2.connectedComponents(pale, connectivity=4)
        inside = [self._label_within(labels, hole - (left, top)) for hole in holes]
        return [
            [hole for hole, own in zip(holes, inside, strict=True) if own == label]
            for label in sorted(set(inside))
        ]

    def _may_be_one(self, parts: list[Walk], body: _Body) -> bool:
        """Return whether parts that meet may be one droplet with a neck that shows no inside.

        Then the neck is no wider than two rings and a pixel, which an inside has at least, or the
        wall across it thinner.
        """
        ring = self._levels.ring_width
        for (k, one), (j, other) in itertools.combinations(enumerate(parts), 2):
            bridge = _bridge(one, other)
            if bridge == 0.0 or bridge <= 2.0 * ring + 1.0:
                continue
            walls = itertools.product(body.interiors[k], body.interiors[j])
            if not any(_is_nearer(*pair, _THINNEST_WALL * ring - 1.0) for pair in walls):
                return False
        return True

    @staticmethod
    def _label_within(labels: NDArray[np.int32], hole: Walk) -> int:
        """Return the label that most pixels within a hole have."""
        left, top, wide, high = cv2.boundingRect(hole)
        mask = np.zeros((high, wide), dtype=np.uint8)
        cv2.drawContours(mask, [hole], -1, 1, cv2.FILLED, offset=(-left, -top))
        return int(np.bincount(labels[top : top + high, left : left + wide][mask > 0]).argmax())

    def _is_interior(self, alike: Image | None, ring: Pixels, hole: Walk) -> bool:
        return alike is None or Likeness.within(alike, ring, hole) >= self._levels.interior


class _Body(NamedTuple):
    """A connected ring: its outermost pixels, and the holes that are each droplet's interior."""

    walk: Walk
    interiors: list[list[Walk]]


def _claimed(droplets: Sequence[Droplet], shape: tuple[int, ...]) -> Pixels:
    """Return a mask of droplets at half the resolution, `shape`."""
    mask = np.zeros(shape, dtype=np.uint8)
    for each in droplets:
        cv2.fillPoly(mask, [np.rint(0.5 * each.outline).astype(np.int32)], 255)
    return mask


def _is_in(claimed: Pixels, droplet: Droplet) -> bool:
    """Return whether most of a droplet is in a mask at half the resolution."""
    own = _claimed([droplet], claimed.shape)
    return 2 * cv2.countNonZero(cv2.min(own, claimed)) > cv2.countNonZero(own)


def _is_nearer(one: Walk, other: Walk, limit: float) -> bool:
    """Return whether a pixel of one walk is nearer than some pixels to one of another."""
    one, other = _near(one, other, limit), _near(other, one, limit)
    squares = ((one[:, None] - other[None]) ** 2).sum(axis=2)
    return bool((squares < limit**2).any()) if limit > 0.0 else False


def _near(one: Walk, other: Walk, limit: float) -> NDArray[np.int32]:
    """Return the pixels of a walk, (n, 2), within a limit of the rectangle about another."""
    reach = math.ceil(limit)
    low, high = other[:, 0, :].min(axis=0) - reach, other[:, 0, :].max(axis=0) + reach
    points = one[:, 0, :]
    return points[np.all((points >= low) & (points <= high), axis=1)]


def _bridge(one: Walk, other: Walk) -> float:
    """Return how wide the border is along which two parts of a region meet, pixels."""
    points = _near(one, other, 1.0)
    near = np.abs(points[:, None] - _near(other, one, 1.0)[None]).sum(axis=2) == 1
    border = points[near.any(axis=1)]
    if not len(border):
        return 0.0
    extent = np.hypot(*(border[:, None] - border[None]).transpose(2, 0, 1)).max()
    return float(extent) + 1.0


def _apart(ring: Pixels, body: _Body) -> list[Walk]:
    """Part a connected region among its interiors: every pixel goes to the nearest one."""
    left, top, wide, high = cv2.boundingRect(body.walk)
    window = np.s_[top : top + high, left : left + wide]
    region = np.zeros((high, wide), dtype=np.uint8)
    cv2.drawContours(region, [body.walk], -1, 255, cv2.FILLED, offset=(-left, -top))
    owner = np.zeros((high, wide), dtype=np.int32)
    for number, holes in enumerate(body.interiors, start=1):
        cv2.drawContours(owner, holes, -1, number, cv2.FILLED, offset=(-left, -top))
    owner[ring[window] > 0] = 0
    _, nearest = cv2.distanceTransformWithLabels(
        np.where(owner == 0, 255, 0).astype(np.uint8),
        cv2.DIST_L2,
        5,
        labelType=cv2.DIST_LABEL_CCOMP,
    )
    owner_of = np.zeros(int(nearest.max()) + 1, dtype=np.int32)
    owner_of[nearest[owner > 0]] = owner[owner > 0]
    whole = owner_of[nearest]
    whole[region == 0] = 0
    parts = []
    windows = find_objects(whole, max_label=len(body.interiors))
    for number, (holes, part) in enumerate(zip(body.interiors, windows, strict=True), start=1):
        walks: Sequence[Walk] = []
        if part is not None:
            own = np.where(whole[part] == number, 255, 0).astype(np.uint8)
            corner = (left + part[1].start, top + part[0].start)
            walks, _ = cv2.findContours(
                own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=corner
            )
        parts.append(max([*walks, holes[0]], key=len))
    return parts


def _droplet(outline: Floats, walk: Walk, group: int, size: tuple[int, int]) -> Droplet:
    x, y = _core.centroid(outline)
    return Droplet(outline, _core.area(outline), x, y, _is_cut(walk, size), group)


def _is_cut(walk: Walk, size: tuple[int, int]) -> bool:
    """Return whether pixels reach the edge of an image of some width and height."""
    left, top, wide, high = cv2.boundingRect(walk)
    return bool(left <= 0 or top <= 0 or left + wide >= size[0] or top + high >= size[1])
