"""Obstacles: circles found in the background, or a lattice of them."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.background import Background
from pinchoff.video.droplets import Droplet
from pinchoff.video.settings import Lattice, VideoSettings

Floats = NDArray[np.float64]
Image = NDArray[np.float32]

_ANGLES = np.linspace(0.0, 2.0 * math.pi, 180, endpoint=False)
_REACH = 0.3  # of the radius: how far the edge is looked for on either side
_STEP_PX = 0.25
_SMOOTHING_PX = 0.5  # along rays; more would draw the two edges of a thin rim apart
_SUPPORT = 0.6  # of the circumference in view must show the edge
_LEAST_ARC = 0.2  # of the circumference must be in view
_TOLERANCE = 0.2  # of a given radius
_ANY_RADIUS = (0.01, 0.15)  # of the image's shorter side, where none is given
_SAME_CENTRE = 0.3  # radii between an obstacle and what was taken for a droplet
_STRICTNESS = 0.6  # of OpenCV's circle detection: 1 takes perfect circles only


def known_obstacles(settings: VideoSettings, size: tuple[int, int]) -> Floats | None:
    """Return the obstacles that the settings give, (M, 3) in pixels; None where they give none."""
    if settings.obstacles is not None:
        return np.array(settings.obstacles, dtype=np.float64).reshape(-1, 3)
    if settings.lattice is not None:
        return lattice_obstacles(settings.lattice, settings.pixel_um, size)
    return None


def obstacles_of(background: Background, settings: VideoSettings) -> Floats:
    """Return the obstacles that the settings give, or else those in the background.

    They are looked for where a radius is given or `find_obstacles` asks for any; otherwise there
    are none.
    """
    height, width = background.luma.shape
    known = known_obstacles(settings, (width, height))
    if known is not None:
        return known
    radius = settings.laboratory.obstacle_radius_um
    if radius is None:
        if not settings.find_obstacles:
            return np.empty((0, 3))
        return find_obstacles(background)
    radius_px = radius / settings.pixel_um
    found = find_obstacles(background, radius_px)
    found[:, 2] = radius_px  # known better than the blurred edge shows it
    return found


def is_obstacle(droplet: Droplet, obstacles: Floats) -> bool:
    """Return whether what was taken for a droplet is an obstacle: it covers one and no more."""
    away = np.hypot(obstacles[:, 0] - droplet.x, obstacles[:, 1] - droplet.y)
    share = droplet.area / (math.pi * obstacles[:, 2] ** 2)
    same = (away <= _SAME_CENTRE * obstacles[:, 2]) & (share > 0.5) & (share < 1.6)
    return bool(same.any())


def find_obstacles(background: Background, radius_px: float | None = None) -> Floats:
    """Return the circular obstacles in the empty chamber from top to bottom, (M, 3) in pixels.

    They are of a radius that is given, or of any. Circles are fitted to the steepest change of
    brightness along rays from their centres, to a fraction of a pixel.
    """
    image = background.luma / background.light
    found: list[Floats] = []
    for candidate in _candidates(image, radius_px):
        circle = _refined(image, candidate, background.noise, radius_px)
        if circle is not None and all(
            np.hypot(*(circle[:2] - other[:2])) > 0.7 * (circle[2] + other[2]) for other in found
        ):
            found.append(circle)
    if not found:
        return np.empty((0, 3))
    return np.array(sorted(found, key=lambda each: (round(each[1]), each[0])))


def _candidates(image: Image, radius_px: float | None) -> Floats:
    shorter = min(image.shape)
    if radius_px is None:
        low, high = (share * shorter for share in _ANY_RADIUS)
    else:
        low, high = (1.0 - _TOLERANCE) * radius_px, (1.0 + _TOLERANCE) * radius_px
    low, high = max(3.0, low), max(4.0, high)
    pad = math.ceil(high)  # so that the centre may lie outside the frame
    grey = cv2.convertScaleAbs(image, alpha=200.0 / max(float(np.median(image)), 1.0))
    padded = cv2.copyMakeBorder(grey, pad, pad, pad, pad, cv2.BORDER_REPLICATE)
    circles = cv2.HoughCircles(
        cv2.GaussianBlur(padded, (0, 0), 1.0),
        cv2.HOUGH_GRADIENT_ALT,
        dp=1.5,
        minDist=max(low, 8.0),
        param1=60,
        param2=_STRICTNESS,
        minRadius=int(low),
        maxRadius=math.ceil(high),
    )
    if circles is None:
        return np.empty((0, 3))
    found: Floats = circles.reshape(-1, circles.shape[-1])[:, :3] - np.array([pad, pad, 0.0])
    return found


def _refined(image: Image, circle: Floats, noise: float, radius_px: float | None) -> Floats | None:
    """Fit a circle to the edge near a candidate; None if there is too little of an edge."""
    for _ in range(3):
        radii, strengths, seen = _edge(image, circle)
        strong = seen & (strengths > max(2.0, noise))
        if seen.mean() < _LEAST_ARC or strong.sum() < _SUPPORT * seen.sum():
            return None
        points = circle[:2] + radii[:, None] * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
        circle = _fitted_circle(points[strong])
    if radius_px is not None and abs(circle[2] / radius_px - 1.0) > _TOLERANCE:
        return None
    return circle


def _edge(image: Image, circle: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Return the edge along rays from a circle's centre: radii, strengths, whether it is seen."""
    x, y, radius = circle.tolist()
    radii = np.arange((1.0 - _REACH) * radius, (1.0 + _REACH) * radius, _STEP_PX)
    across = (x + np.cos(_ANGLES)[:, None] * radii).astype(np.float32)
    down = (y + np.sin(_ANGLES)[:, None] * radii).astype(np.float32)
    profile = cv2.remap(image, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = cv2.GaussianBlur(profile, (0, 0), sigmaX=_SMOOTHING_PX / _STEP_PX, sigmaY=2.0)
    slope = np.gradient(profile, _STEP_PX, axis=1)
    # Usually the obstacle's edge is darker than the fluid; where it is brighter, the other way.
    typical = np.median(slope, axis=0)
    if -typical.min() > typical.max():
        slope = -slope
    best = np.clip(np.argmax(slope, axis=1), 1, len(radii) - 2)
    rows = np.arange(len(_ANGLES))
    before, here, after = (slope[rows, best + k] for k in (-1, 0, 1))
    curve = before - 2.0 * here + after
    shift = np.where(curve < 0.0, 0.5 * (before - after) / np.where(curve < 0.0, curve, 1.0), 0.0)
    height, width = image.shape
    end_x, end_y = across[:, -1], down[:, -1]
    seen = (end_x >= 0) & (end_y >= 0) & (end_x <= width - 1) & (end_y <= height - 1)
    return radii[best] + np.clip(shift, -0.5, 0.5) * _STEP_PX, here, seen


def _fitted_circle(points: Floats) -> Floats:
    """Fit a circle by least squares, twice, the second time without the farthest tenth."""
    kept = points
    for _ in range(2):
        middle = kept.mean(axis=0)
        rows = np.column_stack([2.0 * (kept - middle), np.ones(len(kept))])
        squares = ((kept - middle) ** 2).sum(axis=1)
        (x, y, rest), *_ = np.linalg.lstsq(rows, squares, rcond=None)
        radius = math.sqrt(max(rest + x * x + y * y, 0.0))
        circle = np.array([middle[0] + x, middle[1] + y, radius])
        off = np.abs(np.hypot(*(points - circle[:2]).T) - radius)
        kept = points[off <= np.quantile(off, 0.9)]
    return circle


def lattice_obstacles(lattice: Lattice, pixel_size_um: float, size: tuple[int, int]) -> Floats:
    """Return the obstacles of a regular array that are wholly or partly in view, (M, 3) in pixels.

    Raises
    ------
    InputError
        The pitch is not larger than the diameter.
    """
    if not 2.0 * lattice.radius_um < lattice.pitch_um:
        rule, advice = "larger than the diameter of an obstacle", "check both"
        got = f"{lattice.pitch_um:g} µm for a radius of {lattice.radius_um:g} µm"
        raise InputError.of("lattice.pitch_um", rule, got, advice)
    pitch_px, radius_px = lattice.pitch_um / pixel_size_um, lattice.radius_um / pixel_size_um
    if radius_px < 1.0:
        got, advice = f"{radius_px:.2g} pixels", "check it and the pixel's size"
        raise InputError.of("lattice.radius_um", "a pixel or more", got, advice)
    angle = math.radians(lattice.angle_deg)
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    second = 0.5 * along + math.sqrt(0.75) * across if lattice.hexagonal else across
    steps = pitch_px * np.stack([along, second])
    # From the obstacle nearest to the middle of the image, however far away the given one is.
    origin, middle = np.array([lattice.x_px, lattice.y_px]), 0.5 * np.array(size)
    origin += np.round(np.linalg.solve(steps.T, middle - origin)) @ steps
    reach = math.ceil(math.hypot(*size) / pitch_px) + 2
    places = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
    centres = origin + places.T @ steps
    inside = np.all((centres > -radius_px) & (centres < np.array(size) - 1 + radius_px), axis=1)
    kept = centres[inside]
    return np.column_stack([kept, np.full(len(kept), radius_px)])
