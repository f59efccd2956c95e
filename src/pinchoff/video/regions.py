"""Regions of a picture that may be droplets, and rays across their borders.

What every segmentation by regions needs: whether a shape is a droplet's, evenly spaced rays
across its border, which of them the frame or the dark edge of the view ends.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.droplets import Droplet
from pinchoff.video.signal import Image

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Pixels = NDArray[np.uint8]
Walk = NDArray[np.int32]

LEAST_CONTRAST = 1.5
"""Deviations of the noise below which nothing is taken for a rim or an edge."""

SAME = 0.5
"""Ratio of areas above which two regions are one droplet at two levels."""

_CELLS = 0.4  # share of a region that droplets within it fill, if it is no droplet itself

_BAY = 0.35  # widest mouth of a bay that a speck on the rim makes, square roots of the area
_DENT = 0.5  # the same for the outline
_FINE = 16.0  # parts of a pixel in which outlines are compared with their hulls
_CONVEX = 0.93  # least share of its convex hull that a droplet fills, without such bays
_FULL = 0.62  # least share of the smallest rectangle about it: a disc fills 0.79, a triangle 0.5
_LONGEST = 10.0  # its sides
_SPACING = 1.5  # of rays along the border, pixels
_FEWEST_RAYS, _MOST_RAYS = 24, 256
_AT_EDGE = 1.5  # pixels from the outermost ones
_LARGEST = 0.6  # of the frame
_SMOOTHING = 1.5  # of the border and of the outline, rays
_CLOSED = 0.9  # least share of a border, away from the frame's, with contrast
_FAINT = 0.25  # of the median contrast: fainter is a gap
_RIMMED = 0.42  # least share of the whole border: a quarter of a disc in a corner has 0.44
_CUT_SHARE = 0.04  # of the border along the dark edge of the view
_VIEW_DARKEST = 0.002  # quantile of the grey levels that is as dark as it gets
_VIEW_DARKNESS = 0.12  # of the way from there to the median grey level
_VIEW_BLUR = 1 / 64  # of the shorter side of the frame: how wide its edge is, besides
_VIEW_WIDTH = 1 / 16  # of the shorter side: what is narrower is a wall, not the edge of the view


class Border(NamedTuple):
    """Rays outwards from the border of an enclosed region.

    Attributes
    ----------
    points, normals : ndarray, shape (n, 2)
        Pixels, clockwise as seen; outward unit vectors.
    at_edge : ndarray of bool, shape (n,)
        Where the region ends at the frame.
    """

    points: Floats
    normals: Floats
    at_edge: Bools


def outside_view(images: Sequence[Image]) -> Pixels | None:
    """Return a mask of the dark edge of the view, as of an eyepiece; None where there is none.

    Parameters
    ----------
    images : sequence of ndarray, shape (height, width)
        Grey levels in some frames: it is dark in all of them.
    """
    brightest = cv2.GaussianBlur(images[0], (0, 0), 1.0)
    for image in images[1:]:
        cv2.max(brightest, cv2.GaussianBlur(image, (0, 0), 1.0), dst=brightest)
    darkest, usual = np.quantile(brightest[::4, ::4], [_VIEW_DARKEST, 0.5])
    level = float(darkest + _VIEW_DARKNESS * (usual - darkest))
    dark = cv2.compare(brightest, level, cv2.CMP_LT)
    height, width = dark.shape
    side = max(3, int(_VIEW_WIDTH * min(height, width))) | 1
    dark = cv2.copyMakeBorder(dark, side, side, side, side, cv2.BORDER_REPLICATE)
    dark = cv2.morphologyEx(dark, cv2.MORPH_OPEN, np.ones((side, side), np.uint8))
    dark = dark[side:-side, side:-side]
    _, parts = cv2.connectedComponents(dark)
    sides = np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]])
    at_sides = np.isin(parts, sides[sides > 0])
    mask: Pixels = np.where(at_sides, np.uint8(255), np.uint8(0))
    return mask if mask.any() else None


def without_dents(outline: Floats) -> Floats:
    """Return an outline, (n, 2) in pixels, without the dents that specks on its rim make."""
    scaled = np.rint(outline * _FINE).astype(np.int32)[:, None, :]
    return outline[_outside_bays(scaled, cv2.convexHull(scaled, returnPoints=False), _DENT)]


def _outside_bays(walk: Walk, hull: NDArray[np.int32], widest: float) -> Bools:
    """Return which points of a walk are not in bays up to a width, square roots of its area.

    Its convex hull goes through the walk's places in `hull`.
    """
    keep = np.ones(len(walk), dtype=bool)
    try:
        defects = cv2.convexityDefects(walk, hull)
    except cv2.error:  # walks that touch themselves
        return keep
    if defects is None:
        return keep
    mouth = widest * math.sqrt(cv2.contourArea(walk))
    rows = defects.reshape(-1, 4)
    for start, end in rows[rows[:, 3] > 256, :2].tolist():  # deeper than a unit
        across = math.hypot(*(walk[end, 0] - walk[start, 0]).tolist())
        if across <= mouth:
            if start < end:
                keep[start + 1 : end] = False
            else:
                keep[start + 1 :] = False
                keep[:end] = False
    return keep


def compact_part(walk: Walk) -> Walk | None:
    """Return the walk round a region without the narrow bays that specks on its rim make.

    None if the region is not convex then, or a sliver, or three-cornered.
    """
    corners = cv2.convexHull(walk, returnPoints=False)
    hull = walk[corners.reshape(-1)]
    if not _fills(cv2.contourArea(hull), hull):
        return None
    whole = walk[_outside_bays(walk, corners, _BAY)]
    return whole if _fills(cv2.contourArea(whole), hull) else None


def _fills(area: float, hull: Walk) -> bool:
    """Return whether an area fills its convex hull, which is not a sliver and no triangle."""
    if area < _CONVEX * cv2.contourArea(hull):
        return False
    _, sides, _ = cv2.minAreaRect(hull)
    short, long = min(sides), max(sides)
    return bool(long <= _LONGEST * max(short, 1.0) and area >= _FULL * short * long)


class Rectangle(NamedTuple):
    """Part of a frame that can be seen, pixels; its edge is as wide as it is not sharp."""

    left: int
    top: int
    width: int
    height: int
    edge: float


def seen_part(view: Pixels | None, size: tuple[int, int]) -> Rectangle:
    """Return the part of a frame of some width and height that `outside_view` leaves."""
    if view is None:
        return Rectangle(0, 0, *size, _AT_EDGE + 1.0)
    left, top, wide, high = cv2.boundingRect(cv2.compare(view, 0, cv2.CMP_EQ))
    return Rectangle(left, top, wide, high, _AT_EDGE + 1.0 + _VIEW_BLUR * min(size))


def is_ground(walk: Walk, seen: Rectangle) -> bool:
    """Return whether a region is what droplets are in: it goes from one edge to the other.

    Parameters
    ----------
    walk : ndarray, shape (n, 1, 2)
        Round it.
    seen : Rectangle
        What `seen_part` returns.
    """
    left, top, wide, high = cv2.boundingRect(walk)
    if wide * high > _LARGEST * seen.width * seen.height:
        return True
    left, top = left - seen.left, top - seen.top
    across = left <= seen.edge and left + wide >= seen.width - seen.edge
    return bool(across or (top <= seen.edge and top + high >= seen.height - seen.edge))


def border_of(line: NDArray[Any], size: tuple[int, int] | None = None) -> Border:
    """Return evenly spaced points round a region, clockwise as seen, with outward normals.

    Parameters
    ----------
    line : ndarray, shape (n, 2)
        Round the region, pixels.
    size : (int, int), optional
        Width and height of the frame, pixels, if the region may end at its edge.
    """
    points, normals, at_edge = _core.region_border(
        line.astype(np.float64),
        _SPACING,
        _FEWEST_RAYS,
        _MOST_RAYS,
        _SMOOTHING,
        _AT_EDGE,
        (0, 0) if size is None else size,
    )
    return Border(points, normals, at_edge)


def part_below(values: Floats, share: float) -> float:
    """Return the value below which a share of some values, one or more, lies."""
    order = np.sort(values)
    place = share * (len(order) - 1)
    low = int(place)
    high = min(low + 1, len(order) - 1)
    return float(order[low] + (place - low) * (order[high] - order[low]))


def smoothed(values: Floats) -> Floats:
    """Return values round a closed line, or rows of them, smoothed a little."""
    lines = np.ascontiguousarray(values, dtype=np.float64).reshape(-1, values.shape[-1])
    padded = np.concatenate([lines[:, -8:], lines, lines[:, :8]], axis=1)
    smooth = cv2.GaussianBlur(padded, (0, 0), sigmaX=_SMOOTHING, sigmaY=0.01)
    return np.asarray(smooth[:, 8:-8]).reshape(values.shape)


def closedness(contrast: Floats, at_edge: Bools, noise: float) -> float:
    """Return how closed and even a rim is, from 0 to 1; 0 if it is not closed."""
    free = np.sort(contrast[~at_edge])
    if len(free) < max(1.0, _RIMMED * len(contrast)):
        return 0.0
    middle = float(free[len(free) // 2])
    least = max(_FAINT * middle, LEAST_CONTRAST * noise)
    if len(free) - int(np.searchsorted(free, least)) < _CLOSED * len(free):
        return 0.0
    low = float(free[len(free) // 10])
    return math.sqrt(max(low, 0.0) / middle)


def leaves_view(view: Pixels | None, points: Floats, normals: Floats, reach: float) -> bool:
    """Return whether the dark edge of the view cuts a droplet.

    Parameters
    ----------
    view : ndarray, shape (height, width), or None
        What `outside_view` returns.
    points, normals : ndarray, shape (n, 2)
        Round the droplet, outward unit vectors.
    reach : float
        How far beyond the points the edge of the view begins if it does cut it, pixels.
    """
    if view is None:
        return False
    height, width = view.shape
    beyond = points + reach * normals
    x = np.clip(np.rint(beyond[:, 0]), 0, width - 1).astype(int)
    y = np.clip(np.rint(beyond[:, 1]), 0, height - 1).astype(int)
    return bool(np.count_nonzero(view[y, x]) >= _CUT_SHARE * len(points))


class Region(Protocol):
    """A region at one level; lengths in pixels."""

    @property
    def walk(self) -> Walk: ...
    @property
    def area(self) -> float: ...
    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def score(self) -> float: ...


_R = TypeVar("_R", bound=Region)


def one_a_droplet(regions: Sequence[_R], shape: tuple[int, ...]) -> list[_R]:
    """Return one region a droplet: of several levels the best, of nested ones the outer.

    Not the outer one where others fill it: then it is what holds the droplets.
    """
    order = sorted(regions, key=lambda region: -region.area)
    owner = np.full(shape, -1, dtype=np.int16)
    kept: list[_R] = []
    inner: dict[int, list[_R]] = {}
    for region in order:
        outer = int(owner[round(region.y), round(region.x)])
        if outer < 0:
            cv2.drawContours(owner, [region.walk], -1, len(kept), cv2.FILLED)
            kept.append(region)
        elif region.area >= SAME * kept[outer].area:
            if region.score > kept[outer].score:
                kept[outer] = region
        else:
            inner.setdefault(outer, []).append(region)
    found: list[_R] = []
    for number, region in enumerate(kept):
        within = one_a_droplet(inner[number], shape) if number in inner else []
        filled = sum(droplet.area for droplet in within)
        if len(within) > 1 and filled >= _CELLS * region.area:
            found += within
        else:
            found.append(region)
    return found


class Groups:
    """Which droplets touch: each is in the group of every other that it meets."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))

    def _root(self, member: int) -> int:
        parent = self._parent
        while parent[member] != member:
            parent[member] = parent[parent[member]]  # half as far the next time
            member = parent[member]
        return member

    def join(self, one: int, other: int) -> None:
        self._parent[self._root(one)] = self._root(other)

    def grouped(self, droplets: Sequence[Droplet | None]) -> list[Droplet]:
        """Return the members that are droplets, each with its group's number, -1 if alone."""
        roots = [self._root(member) for member in range(len(self._parent))]
        sizes = Counter(
            root for root, each in zip(roots, droplets, strict=True) if each is not None
        )
        numbers: dict[int, int] = {}
        for root in roots:
            if sizes[root] > 1:
                numbers.setdefault(root, len(numbers))
        return [
            each._replace(group=numbers.get(root, -1))
            for root, each in zip(roots, droplets, strict=True)
            if each is not None
        ]
