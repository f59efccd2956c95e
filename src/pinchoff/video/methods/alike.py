"""Droplets that look like those that were found.

Droplets of one size look alike, however light and shadow lie on them. The mean picture of the ones
that are sure is compared with every place of the frame; where it is nearly the same, up to
brightness and contrast, there is one more, with their mean outline.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.video.droplets import Droplet
from pinchoff.video.signal import Image

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

_FEWEST, _MOST = 3, 24  # droplets from which a mean picture is taken
_ONE_SIZE = 0.12  # how far their radii may be from the median, of it
_SHARE = 0.5  # of all that must be of one size
_RADIUS = 12.0  # of the mean picture, pixels: larger droplets are looked at more coarsely
_BEYOND = 1.15  # radii to its edge
_SIMILAR = 0.5  # least correlation with it
_CONTRAST = 0.5  # least standard deviation of a place, that of the droplets
_APART = 1.3  # radii between the centres of two droplets
_STRENGTH = 0.4  # least of that picture in what a place has for itself, that in the droplets
_OWN = 0.25  # least part of a place that no other droplet covers, if it can be judged by it
_VERTICES = 64


def more_alike(image: Image, droplets: Sequence[Droplet]) -> list[Droplet]:
    """Return more droplets of a frame that look like those that were found.

    Parameters
    ----------
    image : ndarray, shape (height, width)
        Grey levels.
    droplets : sequence of Droplet
        The sure ones. Unless most are of one size there are no others.
    """
    whole = [each for each in droplets if not each.cut]
    radii = np.sqrt(np.array([each.area for each in whole]) / math.pi)
    if len(whole) < _FEWEST:
        return []
    radius = float(np.median(radii))
    same = np.abs(radii - radius) <= _ONE_SIZE * radius
    if np.count_nonzero(same) < max(_FEWEST, _SHARE * len(whole)):
        return []
    examples = [each for each, alike in zip(whole, same, strict=True) if alike][:_MOST]
    scale = min(1.0, _RADIUS / radius)
    places = _places(image, examples, radius, scale)
    taken = np.array([[each.x, each.y] for each in droplets])
    outline = _mean_outline(examples)
    height, width = image.shape
    found = []
    for place in places:
        if (np.hypot(*(place - taken).T) < _APART * radius).any():
            continue
        taken = np.concatenate([taken, place[None]])
        points = outline + place
        inside = np.clip(points, 0.0, (width - 1.0, height - 1.0))
        x, y = _core.centroid(inside)
        found.append(Droplet(inside, _core.area(inside), x, y, bool(np.any(inside != points)), -1))
    return without_what_others_show(image, droplets, examples, found, radius)


def without_what_others_show(
    image: Image,
    droplets: Sequence[Droplet],
    examples: Sequence[Droplet],
    found: Sequence[Droplet],
    radius: float,
) -> list[Droplet]:
    """Return those of the droplets found that also show where none of the others is.

    Beside a droplet a place with nothing in it looks like one by half. What it has of the mean
    picture has to be as strong as `_STRENGTH` says, on the pixels that are its own.
    """
    half = math.ceil(_BEYOND * radius)
    side = (2 * half + 1, 2 * half + 1)
    patches = [cv2.getRectSubPix(image, side, (each.x, each.y)) for each in examples]
    spread = [max(float(patch.std()), 1e-6) for patch in patches]
    mean = np.mean([(p - p.mean()) / s for p, s in zip(patches, spread, strict=True)], axis=0)
    rows, columns = np.mgrid[-half : half + 1, -half : half + 1]
    disc = np.hypot(rows, columns) <= half + 0.5
    places = np.array([[each.x, each.y] for each in (*droplets, *found)])
    kept = []
    for number, each in enumerate(found, start=len(droplets)):
        own = disc.copy()
        others = np.delete(places, number, axis=0) - (each.x, each.y)
        for x, y in others[np.hypot(*others.T) < 2.0 * radius + half]:
            own &= np.hypot(columns - x, rows - y) > radius
        here = cv2.getRectSubPix(image, side, (each.x, each.y))[own]
        if np.count_nonzero(own) >= _OWN * np.count_nonzero(disc):
            about = mean[own] - mean[own].mean()
            strength = float(about @ here) / max(float(about @ about), 1e-6)
            if strength < _STRENGTH * float(np.median(spread)):
                continue
        kept.append(each)
    return kept


def _places(image: Image, examples: Sequence[Droplet], radius: float, scale: float) -> list[Floats]:
    """Return where it looks like the examples, x and y in pixels, the most alike first."""
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    scale_y, scale_x = small.shape[0] / image.shape[0], small.shape[1] / image.shape[1]
    half = math.ceil(_BEYOND * radius * scale)
    side = 2 * half + 1
    patches = []
    for each in examples:
        centre = ((each.x + 0.5) * scale_x - 0.5, (each.y + 0.5) * scale_y - 0.5)
        patches.append(cv2.getRectSubPix(small, (side, side), centre))
    spread = float(np.median([patch.std() for patch in patches]))
    mean = np.mean([(p - p.mean()) / max(float(p.std()), 1e-6) for p in patches], axis=0)
    rows, columns = np.mgrid[-half : half + 1, -half : half + 1]
    disc = (np.hypot(rows, columns) <= half + 0.5).astype(np.float32)
    padded = cv2.copyMakeBorder(small, half, half, half, half, cv2.BORDER_REPLICATE)
    alike = cv2.matchTemplate(padded, mean.astype(np.float32), cv2.TM_CCOEFF_NORMED, mask=disc)
    alike = np.nan_to_num(alike, posinf=0.0, neginf=0.0)
    local = cv2.blur(small, (side, side))
    squares = cv2.blur(small * small, (side, side))
    contrast = np.sqrt(np.maximum(squares - local * local, 0.0))
    window = int(_APART * radius * scale) | 1
    disc_around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (window, window))
    peaks = (alike >= cv2.dilate(alike, disc_around)) & (alike >= _SIMILAR)
    peaks &= contrast >= _CONTRAST * spread
    y, x = np.nonzero(peaks)
    order = np.argsort(-alike[y, x])
    across = x + _vertex(alike, y, x, 0, 1)
    down = y + _vertex(alike, y, x, 1, 0)
    places = np.column_stack([(across + 0.5) / scale_x - 0.5, (down + 0.5) / scale_y - 0.5])
    return list(places[order])


def _vertex(values: Image, y: Places, x: Places, dy: int, dx: int) -> Floats:
    """Return how far from each peak, along one axis, the parabola through it is highest."""
    height, width = values.shape
    before, here, after = (
        values[np.clip(y + k * dy, 0, height - 1), np.clip(x + k * dx, 0, width - 1)]
        for k in (-1, 0, 1)
    )
    bend = np.maximum(2.0 * here - before - after, 1e-6)
    shift: Floats = np.clip(0.5 * (after - before) / bend, -0.5, 0.5)
    return shift


def _mean_outline(examples: Sequence[Droplet]) -> Floats:
    """Return the mean outline about its centre, clockwise as seen, pixels."""
    angles = 2.0 * np.pi * np.arange(_VERTICES) / _VERTICES
    radii = []
    for each in examples:
        off = each.outline - (each.x, each.y)
        turned = np.arctan2(off[:, 1], off[:, 0]) % (2.0 * np.pi)
        order = np.argsort(turned)
        away = np.hypot(off[:, 0], off[:, 1])[order]
        radii.append(np.interp(angles, turned[order], away, period=2.0 * np.pi))
    mean = np.mean(radii, axis=0)
    return np.column_stack([mean * np.cos(angles), mean * np.sin(angles)])
