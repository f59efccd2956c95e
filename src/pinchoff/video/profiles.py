"""The darkness across an outline: a ring of one width and darkness, blurred more or less.

Blur moves the place where the darkness changes fastest outwards as soon as it is not small against
the ring's width; it hardly moves the darkness at the ring's true edge. So the blurred ring is
fitted, and the outline is drawn at the darkness that the fit has at its edge. What the focus does
in the course of a clip tells width and darkness apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import ndtr

Floats = NDArray[np.float64]

REACHES = (12.0, 24.0, 48.0)
"""How far inwards profiles may go, pixels: as far as the ring asks for."""

_OUTWARDS = 0.25  # of that
_SAMPLES = 61
_EVERY = 3  # points of an outline between two profiles: neighbours see the same pixels
_MOST_BLURS = 8  # parts of the clip, each with a blur of its own
_USUAL_WIDTH, _USUAL_BLUR = 0.3, 1.2  # of the reach, and pixels: where the fit begins


def across(reach: float) -> Floats:
    """Return where a profile is taken, pixels outwards from the outline."""
    return np.linspace(-reach, _OUTWARDS * reach, _SAMPLES)


class RingFit(NamedTuple):
    """A blurred ring fitted to profiles.

    Attributes
    ----------
    darkness : float
        Of the ring without blur, grey levels.
    width : float
        Pixels.
    interior : float
        Darkness of what it encloses, grey levels.
    blurs : ndarray, shape (K,)
        Standard deviations, pixels, in the order of the profiles.
    """

    darkness: float
    width: float
    interior: float
    blurs: Floats

    def edge(self, curvature: float) -> float:
        """Return the darkness at the ring's outer edge at the median blur, grey levels.

        Blur mixes half of what lies inside a straight edge with half of what lies outside; a
        curved edge has less inside, by blur times curvature over sqrt(8 pi) to first order.

        Parameters
        ----------
        curvature : float
            Of the outlines on average, 1/pixel.
        """
        blur = float(np.median(self.blurs))
        inside = 0.5 - blur * curvature / math.sqrt(8.0 * math.pi)
        beyond = float(ndtr(-self.width / blur))
        return self.darkness * inside + (self.interior - self.darkness) * beyond


def mean_profile(dark: NDArray[Any], outlines: Sequence[Floats], places: Floats) -> Floats:
    """Return the mean darkness across outlines.

    Parameters
    ----------
    dark : ndarray of float32, shape (height, width)
    outlines : sequence of ndarray, shape (n, 2)
        One or more, clockwise as seen, pixels.
    places : ndarray, shape (m,)
        What `across` returns.
    """
    total, count = np.zeros(len(places)), 0
    for outline in outlines:
        tangent = np.roll(outline, -3, axis=0) - np.roll(outline, 3, axis=0)
        length = np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-9)
        outward = (np.column_stack([tangent[:, 1], -tangent[:, 0]]) / length[:, None])[::_EVERY]
        where = outline[::_EVERY, None, :] + places[None, :, None] * outward[:, None, :]
        where = where.astype(np.float32)
        total += cv2.remap(dark, where[..., 0], where[..., 1], cv2.INTER_CUBIC).sum(axis=0)
        count += len(outward)
    return total / count


def fit_ring(profiles: Sequence[Floats], places: Floats) -> RingFit:
    """Fit one ring, with a blur for every part of the clip, by least squares.

    Parameters
    ----------
    profiles : sequence of ndarray, shape (m,)
        In the order of time; neighbours are averaged.
    places : ndarray, shape (m,)
        Where they were taken.
    """
    parts = np.array_split(np.arange(len(profiles)), min(_MOST_BLURS, len(profiles)))
    seen = np.array([np.mean([profiles[k] for k in part], axis=0) for part in parts])
    count, darkest = len(seen), max(float(seen.max()), 1.0)

    def misfit(unknown: Floats) -> Floats:
        darkness, interior, width = *unknown[:2], np.exp(unknown[2])
        edges, blurs = unknown[3 : 3 + count, None], np.exp(unknown[3 + count :, None])
        inside = darkness * ndtr((edges - places) / blurs)
        inside += (interior - darkness) * ndtr((edges - width - places) / blurs)
        off: Floats = (inside - seen).ravel()
        return off

    start = [1.1 * darkest, 0.2 * darkest, math.log(-_USUAL_WIDTH * places[0])]
    start = np.r_[start, np.zeros(count), np.full(count, math.log(_USUAL_BLUR))]
    # Levenberg and Marquardt's method: a few milliseconds; lengths as logarithms stay positive.
    found = least_squares(misfit, start, method="lm").x
    darkness, interior = found[:2].tolist()
    return RingFit(darkness, math.exp(found[2]), interior, np.exp(found[3 + count :]))


def apparent_width(profile: Floats, places: Floats, level: float) -> float:
    """Return over what width a profile is above a level, pixels.

    0 where it never is, or does not fall below it inwards.
    """
    above = profile > level
    ends = np.flatnonzero(above[1:] != above[:-1])
    outer = ends[above[ends]][-1:]
    inner = ends[~above[ends]]
    inner = inner[inner < outer][-1:] if outer.size else inner[:0]
    if not inner.size:
        return 0.0
    inwards, outwards = (
        places[k] + (places[1] - places[0]) * (level - profile[k]) / (profile[k + 1] - profile[k])
        for k in (int(inner[0]), int(outer[0]))
    )
    return float(outwards - inwards)
