"""How much outlines look like droplets, whoever drew them.

An outline is right if something happens across it all round, it is smooth, and the same outline is
there again a moment later. That is asked of all methods alike, so that they can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pinchoff import _core
from pinchoff.video.droplets import Droplet
from pinchoff.video.regions import LEAST_CONTRAST, border_of
from pinchoff.video.signal import Image
from pinchoff.video.standing import alike, rows_of, standing_rows

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_REACH = 3  # across an outline, pixels
_NEAR = 4  # pixels to both sides within which an edge may be
_SHARP, _PLACED = 0.9, 0.15  # what a sharp edge on the outline shows; exponent of how much it does
_FAINT = 0.25  # of the median change across the outline: less is a gap
_ENDED = 0.3  # least share of a rim that ends outside
_FAR, _UNDONE = 0.35, 0.6  # radii within which a change that is undone by so much is a rim
_HALO = 0.6  # radii from an outline inwards in which a darker rim makes a bright one a halo
_HALO_DARK, _HALO_CORE = 0.8, 0.25  # how much darker than outside it is, and than the middle, halos
_HALO_WORTH = 0.6  # of a droplet's worth: that of the halo about it, which is larger
_STRENGTH = 0.25  # exponent of the change across it against the picture's strongest
_ROUGHNESS = 4.0  # exponent of hull's perimeter over the outline's
_WEIGHT = 0.75  # exponent of the area: a droplet is worth more whole than in pieces
_FARTHEST = 2.0  # radii that a droplet goes between two frames
_AREA_CHANGE = 0.2  # between two frames, of a droplet that is seen again


class Quality(NamedTuple):
    """What a method's outlines are worth in some frames.

    Attributes
    ----------
    score : float
        Sum over whole outlines of a power of the area, pixels, times how sure each is, from -1
        to 1; a frame.
    closed : float
        Share of the outlines' length across which something happens, from 0 to 1.
    droplets : float
        Whole ones a frame.
    persistent : float
        Share of them that is the same in the next frame; NaN where that is not known.
    """

    score: float
    closed: float
    droplets: float
    persistent: float = math.nan


class Picture(NamedTuple):
    """A picture in which droplets may be seen.

    Attributes
    ----------
    image : ndarray, shape (height, width)
        Grey levels.
    noise : float
        Standard deviation, grey levels.
    rims : bool
        Whether droplets may have rims in it, whose inner edges are not the outline: of a tint
        there are none.
    """

    image: Image
    noise: float
    rims: bool = True

    @property
    def strongest(self) -> float:
        """How much the strongest of it differs from what is near, grey levels."""
        local = cv2.blur(self.image, (15, 15))
        return float(np.quantile(np.abs(self.image - local)[::2, ::2], 0.99))


def quality(pictures: Sequence[Sequence[Picture]], found: Sequence[Sequence[Droplet]]) -> Quality:
    """Return what the outlines in some frames are worth; what stands still is worth nothing.

    Parameters
    ----------
    pictures : sequence of sequence of Picture
        Of each frame one or more, as in brightness and in a colour: a droplet is as sure as in
        the one that shows it best.
    found : sequence of list of Droplet
        In each frame.
    """
    score, shares = 0.0, []
    standing = standing_rows([rows_of(here) for here in found])
    for views, droplets in zip(pictures, found, strict=True):
        strongest = [view.strongest for view in views]
        for droplet in droplets:
            row = np.array([droplet.x, droplet.y, droplet.area])
            if droplet.cut or alike(standing, row).any():
                continue
            seen = [across(view.image, droplet.outline, view.noise) for view in views]
            sure, closed = max(
                (_how_sure(rim, view.rims, most), rim.closed)
                for rim, view, most in zip(seen, views, strongest, strict=True)
            )
            sure *= _smoothness(droplet.outline)
            worth = _HALO_WORTH if any(rim.halo for rim in seen) else 1.0
            score += worth * (2.0 * sure - 1.0) * droplet.area**_WEIGHT
            shares.append(closed)
    frames = max(1, len(pictures))
    return Quality(score / frames, float(np.mean(shares)) if shares else 0.0, len(shares) / frames)


class _Across(NamedTuple):
    """What an outline's rays show.

    Attributes
    ----------
    closed : float
        Share of them, from 0 to 1, on which it gets brighter or darker across the outline, the
        same way as on most, or that have a rim just inside.
    strength : float
        How much, grey levels.
    inner : float
        Share on which it is soon undone: then the outline is the inner edge of a rim.
    placed : float
        How much of what happens near the outline happens on it, from 0 to 1.
    halo : bool
        Whether it is the light about a droplet in phase contrast that ends here.
    """

    closed: float
    strength: float
    inner: float
    placed: float
    halo: bool


def across(image: Image, outline: Floats, noise: float) -> _Across:
    """Return what is seen across an outline.

    Parameters
    ----------
    image : ndarray, shape (height, width)
        Grey levels.
    outline : ndarray, shape (n, 2)
        Pixels.
    noise : float
        Grey levels.
    """
    points, normals, _ = border_of(outline)
    radius = float(np.hypot(*(points - points.mean(axis=0)).T).mean())
    seen = _core.across(
        image,
        points,
        normals,
        _REACH,
        max(2.0 * _REACH, _FAR * radius),
        _NEAR,
        _FAINT,
        _ENDED,
        _UNDONE,
        LEAST_CONTRAST * noise,
        (_HALO * radius, _HALO_DARK, _HALO_CORE),
    )
    return _Across(*seen)


def _how_sure(seen: _Across, rims: bool, strongest: float) -> float:
    """Return how sure an outline is after what its rays show, from 0 to 1."""
    sure = seen.closed**2 * (1.0 - 0.5 * seen.inner * rims)
    sure *= min(1.0, seen.strength / max(strongest, 1e-6)) ** _STRENGTH
    return float(sure * min(1.0, seen.placed / _SHARP) ** _PLACED)


def _smoothness(outline: Floats) -> float:
    points = outline.astype(np.float32)[:, None, :]
    hull = cv2.arcLength(cv2.convexHull(points), True)
    return float(min(1.0, hull / max(cv2.arcLength(points, True), 1e-6)) ** _ROUGHNESS)


def persistence(
    pairs: Sequence[tuple[Sequence[Droplet], Sequence[Droplet]]], size: tuple[int, int]
) -> float:
    """Return how much of the droplets, by their radii, is the same a frame later, from 0 to 1.

    What is lost or appears away from the frame's edge counts against it, unless the frame cuts it
    before or after, and so does the change of area of what is seen again.

    Parameters
    ----------
    pairs : sequence of (list of Droplet, list of Droplet)
        In a frame and in the next one.
    size : (int, int)
        Width and height of the frame, pixels.
    """
    total, wrong = 0.0, 0.0
    for before, after in pairs:
        old, new = rows_of(before), rows_of(after)
        distance = np.hypot(*(old[:, None, :2] - new[None, :, :2]).transpose(2, 0, 1))
        largest = np.maximum(old[:, None, 2], new[None, :, 2])
        change = np.abs(old[:, None, 2] - new[None, :, 2]) / np.maximum(largest, 1e-6)
        radius = np.sqrt(old[:, 2] / np.pi)
        allowed = (distance <= _FARTHEST * radius[:, None]) & (change <= _AREA_CHANGE)
        rows, columns = linear_sum_assignment(np.where(allowed, distance, 1e9))
        same = allowed[rows, columns]
        rows, columns = rows[same], columns[same]
        both = [
            not (before[row].cut or after[column].cut)
            for row, column in zip(rows, columns, strict=True)
        ]
        wrong += 2.0 * float(np.sum((radius[rows] * change[rows, columns])[both]))
        near = distance <= _FARTHEST * np.sqrt(largest / np.pi)
        for droplets, others, seen, again, close in (
            (before, after, old, rows, near),
            (after, before, new, columns, near.T),
        ):
            radii = np.sqrt(seen[:, 2] / np.pi)
            known = np.array([not _leaves(droplet, size) for droplet in droplets], dtype=bool)
            known &= ~_is_cut_in(others, seen, close)
            lost = known.copy()
            lost[again] = False
            known[again] = [not droplets[row].cut for row in again]
            total += float(radii[known].sum())
            wrong += float(radii[lost].sum())
    return max(0.0, 1.0 - wrong / total) if total > 0.0 else math.nan


def _is_cut_in(others: Sequence[Droplet], rows: Floats, near: Bools) -> Bools:
    """Return which droplets, rows of centre and area, the frame cuts in another frame.

    Parameters
    ----------
    others : sequence of Droplet
        In that frame.
    rows : ndarray, shape (n, 3)
    near : ndarray of bool, shape (n, len(others))
        Which of them each may be.
    """
    cut = np.array([other.cut for other in others], dtype=bool)
    part = rows_of(others)[None, :, 2] < rows[:, None, 2]
    found: Bools = (near & cut & part).any(axis=1)
    return found


def covered_twice(found: Sequence[Sequence[Droplet]], size: tuple[int, int]) -> float:
    """Return which part of what whole droplets cover, in frames of a width and height, two do."""
    total = once = 0
    for droplets in found:
        times = np.zeros((size[1], size[0]), dtype=np.uint16)
        for droplet in droplets:
            if not droplet.cut:
                corners = np.clip(np.rint(droplet.outline), 0, np.array(size) - 1).astype(np.int32)
                left, top, width, height = cv2.boundingRect(corners)
                own = np.zeros((height, width), dtype=np.uint8)
                cv2.fillPoly(own, [corners - (left, top)], 1)
                times[top : top + height, left : left + width] += own
        total += int(times.sum())
        once += cv2.countNonZero(times)
    return 1.0 - once / total if total else 0.0


def _leaves(droplet: Droplet, size: tuple[int, int]) -> bool:
    """Return whether a droplet is cut, or so near to the frame's edge that it may be next."""
    if droplet.cut:
        return True
    margin = 0.5 * math.sqrt(droplet.area / math.pi)
    low, high = droplet.outline.min(axis=0), droplet.outline.max(axis=0)
    return bool(np.any(low < margin) or np.any(high > np.array(size) - 1.0 - margin))
