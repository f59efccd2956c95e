"""Segmentation of packed scenes: droplets as closed dark rims, with no empty chamber to subtract.

Where droplets lie before and behind one another nothing shows what the empty chamber looks like.
What is left of a droplet is its rim, across which it gets brighter outwards, all round. Edges vote
for the centres of the circles that they may belong to; about every centre the closed outline with
the most brightening is traced in polar coordinates; outlines that are round, even and without gaps
are droplets, the best first, unless most of what they enclose is taken.
"""

from __future__ import annotations

import copy
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.droplets import Droplet
from pinchoff.video.methods.alike import more_alike
from pinchoff.video.reading import Frame
from pinchoff.video.signal import Signal
from pinchoff.video.standing import without_standing

Image = NDArray[np.float32]
Places = NDArray[np.int64]

_DENOISING = 0.8  # standard deviation of the filter before outlines are traced, pixels
_DARKEST, _BRIGHT = 0.1, 95.0  # percentiles of the grey levels: between them is the light
_VOTING_RADIUS = 8.0  # least radius in votes, pixels; what is larger votes in a smaller image
_PER_OCTAVE = 2  # radii that vote, between one and its double
_SHARPNESS = 0.1  # relative brightening a pixel from which an edge has a full vote
_SPREAD = 0.17  # of the votes for one centre, radii
_LEAST_VOTES = 0.4  # for a centre, a pixel of circumference; some 3 where the rim is sharp
_RAYS = 64  # directions in which an outline is traced
_STEPS = 44  # radii at which, between
_NEAREST, _FARTHEST = 0.5, 1.7  # candidate's radii
_WINDOW = 5  # steps inside and outside of an edge that are compared
_BEND = 2  # most steps between neighbouring rays
_BENDING = 0.02  # contrast that a step of bend has to be worth
_CLEAR = 0.5  # contrast above which an edge is no better
_ROUND = 6  # exponent of roundness in the score
_FAINT = 0.25  # exponent of contrast: that there is an edge says more than how strong it is
_FREE = 0.5  # of a droplet's area that no better droplet may cover
_REFINING, _FINE = 2.5, 0.5  # how far an outline is moved at last, and in which steps, pixels
_ROUNDS = 2  # of that


class _Circles(NamedTuple):
    """Where droplets may be: centres and radii, pixels, each of shape (n,)."""

    x: Image
    y: Image
    radius: Image


class _Outlines(NamedTuple):
    """Closed outlines, and what lies on both sides of them; each of shape (n, rays).

    Attributes
    ----------
    x, y : ndarray
        Pixels, clockwise as seen.
    contrast : ndarray
        Brightening outwards over the sum of both sides, from -1 to 1.
    inner, outer : ndarray
        Grey levels just inside and outside.
    """

    x: Image
    y: Image
    contrast: Image
    inner: Image
    outer: Image


class RimSegmenter:
    """Find the droplets in frames where they overlap, by their rims.

    Parameters
    ----------
    minimum_diameter, maximum_diameter : float
        Of the droplets, of the circle with their area, pixels.
    contrast : float
        Least brightening across a rim, on average over it; a fraction of the frame's light,
        which is counted from its darkest.
    score : float
        Least score of an outline, from 0 to 1, that of a sharp black ring. The higher, the fewer
        and the surer.
    obstacles : ndarray, shape (M, 3)
        Centre x, y and radius, pixels; they have dark rims too.
    signal : Signal, optional
        The picture in which rims are dark.
    """

    def __init__(
        self,
        minimum_diameter: float,
        maximum_diameter: float,
        contrast: float,
        score: float,
        obstacles: NDArray[np.float64],
        signal: Signal | None = None,
    ) -> None:
        self._standing = np.empty((0, 3))
        self._radii = (0.5 * minimum_diameter, 0.5 * maximum_diameter)
        self._contrast = contrast
        self._score = score
        self._obstacles = obstacles
        self.signal = signal or Signal()

    def without(self, standing: NDArray[np.float64]) -> RimSegmenter:
        """Return a segmenter that leaves out what stands still: rows of centre and area."""
        other = copy.copy(self)
        other._standing = standing
        return other

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame, the surest first; they may overlap."""
        luma = self.signal.of(frame)
        darkest, brightest = np.percentile(luma, [_DARKEST, _BRIGHT])
        dim = max(self._contrast * float(brightest - darkest), 1.0)
        circles = _candidates(luma, *self._radii, dim)
        smooth = cv2.GaussianBlur(luma, (0, 0), _DENOISING)
        # About its own centre an outline that is not round is traced better.
        about = _circles_of(_traced(smooth, circles, dim))
        outlines = _traced(smooth, about, dim)
        found = _circles_of(outlines)
        scores = _scores(outlines, found, dim)
        large = (found.radius >= self._radii[0]) & (found.radius <= self._radii[1])
        scores[~large] = 0.0
        order = np.argsort(-scores)
        order = order[: np.count_nonzero(scores >= self._score)]
        height, width = frame.luma.shape
        taken = np.zeros((height, width), dtype=np.uint8)
        for x, y, radius in self._obstacles:
            cv2.circle(taken, (round(x), round(y)), round(radius), 1, cv2.FILLED)
        droplets = []
        points_of = np.stack([outlines.x[order], outlines.y[order]], axis=2)
        for _ in range(_ROUNDS):
            points_of = _refined(smooth, points_of)
        for points in points_of.astype(np.float64):
            inside = np.clip(points, 0.0, (width - 1.0, height - 1.0))
            if _takes(taken, inside):
                x, y = _core.centroid(inside)
                cut = bool(np.any(inside != points))
                droplets.append(Droplet(inside, _core.area(inside), x, y, cut, -1))
        droplets += [each for each in more_alike(luma, droplets) if not self._on_obstacle(each)]
        return without_standing(droplets, self._standing)

    def _on_obstacle(self, droplet: Droplet) -> bool:
        away = np.hypot(self._obstacles[:, 0] - droplet.x, self._obstacles[:, 1] - droplet.y)
        return bool((away < self._obstacles[:, 2]).any())


def _candidates(luma: Image, smallest: float, largest: float, dim: float) -> _Circles:
    """Return the circles for which enough edges vote.

    Parameters
    ----------
    luma : ndarray, shape (height, width)
        Grey levels.
    smallest, largest : float
        Their radii, pixels.
    dim : float
        Grey levels below which brightening counts for less.
    """
    found = []
    scale = 1.0
    radius = smallest
    while radius <= largest:
        while radius >= 2.0 * _VOTING_RADIUS * scale:
            luma = cv2.pyrDown(luma)
            scale *= 2.0
        edges = _edges(luma, dim)
        while radius <= largest and radius < 2.0 * _VOTING_RADIUS * scale:
            y, x = _centres(edges, luma.shape, radius / scale)
            found.append(np.stack([x * scale, y * scale, np.full(len(x), radius)]))
            radius *= 2.0 ** (1.0 / _PER_OCTAVE)
    return _Circles(*np.concatenate(found, axis=1).astype(np.float32))


class _Edges(NamedTuple):
    """Pixels across which it gets brighter, each of shape (n,).

    Attributes
    ----------
    x, y : ndarray
    towards_x, towards_y : ndarray
        Unit vector to the brighter side.
    weight : ndarray
        Of the vote, to 1.
    """

    x: Image
    y: Image
    towards_x: Image
    towards_y: Image
    weight: Image


def _edges(luma: Image, dim: float) -> _Edges:
    smooth = cv2.GaussianBlur(luma, (0, 0), 1.0)
    along_x = cv2.Scharr(smooth, cv2.CV_32F, 1, 0, scale=1 / 32)
    along_y = cv2.Scharr(smooth, cv2.CV_32F, 0, 1, scale=1 / 32)
    slope = cv2.magnitude(along_x, along_y)
    weight = slope / (_SHARPNESS * (cv2.GaussianBlur(luma, (0, 0), 4.0) + dim))
    y, x = np.nonzero(weight > 0.3)  # the rest is mostly noise, and slow
    steep = slope[y, x]
    return _Edges(
        x.astype(np.float32),
        y.astype(np.float32),
        along_x[y, x] / steep,
        along_y[y, x] / steep,
        np.minimum(weight[y, x], 1.0),
    )


def _centres(edges: _Edges, shape: tuple[int, ...], radius: float) -> tuple[Places, Places]:
    """Return rows and columns of the pixels for which most edges vote that are a radius away."""
    height, width = shape
    x = np.rint(edges.x - radius * edges.towards_x).astype(np.int64)
    y = np.rint(edges.y - radius * edges.towards_y).astype(np.int64)
    within = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    places = y[within] * width + x[within]
    votes = np.bincount(places, weights=edges.weight[within], minlength=height * width)
    spread = _SPREAD * radius
    # The votes within the spread, a pixel of circumference.
    around = cv2.GaussianBlur(votes.reshape(shape).astype(np.float32), (0, 0), spread)
    around *= np.float32(spread**2 / radius)
    size = 2 * int(0.25 * radius) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    rows, columns = np.nonzero((around >= cv2.dilate(around, disc)) & (around > _LEAST_VOTES))
    return rows, columns


def _traced(luma: Image, circles: _Circles, dim: float) -> _Outlines:
    """Return the closed outline with the most brightening about each circle's centre."""
    rows = np.column_stack(circles).astype(np.float32)
    reach = (_NEAREST, _FARTHEST)
    return _Outlines(
        *_core.traced_outlines(
            luma, rows, _RAYS, _STEPS, reach, _WINDOW, _BEND, _BENDING, _CLEAR, dim
        )
    )


def _peak(brightening: Image, path: Places) -> Image:
    """Return how far from each step of a path it brightens fastest, at most half a step.

    Parameters
    ----------
    brightening : ndarray, shape (n, rays, steps)
    path : ndarray, shape (n, rays, 1)
    """
    last = brightening.shape[2] - 1
    before, here, after = (
        np.take_along_axis(brightening, np.clip(path + k, 0, last), 2) for k in (-1, 0, 1)
    )
    curvature = np.maximum(2.0 * here - before - after, 1e-3)
    offset: Image = np.clip(0.5 * (after - before) / curvature, -0.5, 0.5)
    return offset


def _refined(luma: Image, points: Image) -> Image:
    """Return outlines, (n, rays, 2), moved to where it brightens fastest near to them.

    What they were traced by looks at a few pixels on either side, and in steps.
    """
    if not len(points):
        return points
    reach = np.arange(-_REFINING, _REFINING + 1e-6, _FINE, dtype=np.float32)
    along = np.roll(points, -1, axis=1) - np.roll(points, 1, axis=1)
    along /= np.maximum(np.linalg.norm(along, axis=2, keepdims=True), 1e-6)
    outward = np.stack([along[..., 1], -along[..., 0]], axis=2)
    where = points[:, :, None, :] + reach[:, None] * outward[:, :, None, :]
    flat = where.reshape(len(points), -1, 2)
    seen = cv2.remap(
        luma, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    profile = cv2.GaussianBlur(seen.reshape(-1, reach.size), (5, 1), 1.0)
    slope = np.gradient(profile, axis=1).reshape(where.shape[:3])
    # A neighbour's edge is passed over for the own one, unless rays on both sides prefer it.
    slope = _middle_of(np.roll(slope, 1, axis=1), slope, np.roll(slope, -1, axis=1))
    best = slope.argmax(axis=2)[:, :, None]
    move = (best + _peak(slope, best)) * _FINE - _REFINING
    refined: Image = (points + move * outward).astype(np.float32)
    return refined


def _middle_of(one: Image, two: Image, three: Image) -> Image:
    """Return the median of three numbers, place by place."""
    middle: Image = np.maximum(np.minimum(one, two), np.minimum(np.maximum(one, two), three))
    return middle


def _circles_of(outlines: _Outlines) -> _Circles:
    """Return the circles with the outlines' centres of mass and areas."""
    middle_x, middle_y = (v.mean(axis=1, keepdims=True) for v in (outlines.x, outlines.y))
    x, y = outlines.x - middle_x, outlines.y - middle_y
    next_x, next_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    cross = x * next_y - next_x * y
    area = 0.5 * cross.sum(axis=1)
    centre_x = ((x + next_x) * cross).sum(axis=1) / (6.0 * area)
    centre_y = ((y + next_y) * cross).sum(axis=1) / (6.0 * area)
    return _Circles(middle_x[:, 0] + centre_x, middle_y[:, 0] + centre_y, np.sqrt(area / np.pi))


def _scores(outlines: _Outlines, circles: _Circles, dim: float) -> Image:
    """Return how surely each outline is a droplet's, from 0 to 1.

    It is round and convex; inside of it is a rim that is equally dark all round, measured by how
    much darker than its surroundings; and three quarters of it have at least some contrast.
    """
    brightening = outlines.outer.mean(axis=1) - outlines.inner.mean(axis=1)
    unevenness = outlines.inner.std(axis=1) / (np.maximum(brightening, 0.0) + dim)
    sides = np.hypot(*(np.roll(v, -1, axis=1) - v for v in (outlines.x, outlines.y)))
    perimeter = sides.sum(axis=1)
    points = np.stack([outlines.x, outlines.y], axis=2)
    hulls = np.array([cv2.contourArea(cv2.convexHull(each)) for each in points])
    area = np.pi * circles.radius**2
    roundness = (4.0 * np.pi * area / perimeter**2) * (area / np.maximum(hulls, 1.0))
    weak = np.maximum(np.quantile(outlines.contrast, 0.25, axis=1), 0.0)
    scores: Image = roundness**_ROUND * weak**_FAINT / (1.0 + unevenness)
    scores[brightening < dim] = 0.0
    return scores


def _takes(taken: NDArray[np.uint8], outline: NDArray[np.float64]) -> bool:
    """Mark what an outline encloses as taken, unless too much of it is."""
    walk = np.rint(outline).astype(np.int32)
    left, top, wide, high = cv2.boundingRect(walk)
    mask = np.zeros((high, wide), dtype=np.uint8)
    cv2.fillPoly(mask, [walk - (left, top)], 1)
    window = taken[top : top + high, left : left + wide]
    if np.count_nonzero(mask & ~window) < _FREE * np.count_nonzero(mask):
        return False
    window |= mask
    return True
