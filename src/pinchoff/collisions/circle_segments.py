r"""A circular droplet cut by a straight centreline: areas, symmetry, and why β is near -3/4.

A centreline that leaves a segment of height h of a circle of diameter D has

.. math:: S = \frac{2 A_\mathrm{small}}{A}
    = \frac{2}{\pi}\left[\arccos(1 - 2t) - 2 (1 - 2t)\sqrt{t - t^2}\right], \qquad t = h/D

If all collisions on the separating line share one h, then S_c falls with the area as A^β, with
β = -3/4 for h ≪ D [paper, section 4.2].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

SMALL_SEGMENT_EXPONENT = -0.75
"""β of one h for all areas, in the limit h ≪ D [paper, section 4.2]."""


def segment_area(height: ArrayLike, diameter: ArrayLike) -> Floats:
    """Return the area of a circular segment.

    Parameters
    ----------
    height, diameter : array_like, shape (...)
        h, from 0 to the diameter, and D, in one unit.

    Returns
    -------
    ndarray, shape (...)
        In the square of that unit.

    Examples
    --------
    >>> float(segment_area(0.5, 1.0).round(4))  # half of the circle
    0.3927
    """
    d = np.asarray(diameter, dtype=np.float64)
    return np.asarray(0.125 * np.pi * d**2 * _twice_share(np.asarray(height) / d))


def symmetry_of_height(relative_height: ArrayLike) -> Floats:
    """Return S of a circle whose smaller part is a segment of height h.

    Parameters
    ----------
    relative_height : array_like, shape (...)
        h/D, from 0 to 1/2.

    Examples
    --------
    >>> symmetry_of_height([0.0, 0.25, 0.5]).round(3).tolist()
    [0.0, 0.391, 1.0]
    """
    return np.asarray(_twice_share(np.asarray(relative_height, dtype=np.float64)))


def height_of_symmetry(symmetry: float) -> float:
    """Return h/D, from 0 to 1/2, of a circle with such an S: the inverse of `symmetry_of_height`.

    Examples
    --------
    >>> round(height_of_symmetry(1.0), 6)
    0.5
    """
    from scipy.optimize import brentq  # slow to import

    return float(brentq(lambda t: float(symmetry_of_height(t)) - symmetry, 0.0, 0.5))


def area_ratio_bound(symmetry: ArrayLike) -> Floats:
    """Return S/(2 - S), A1/A2 of daughters without exchange between the sides [paper, eq. DDR].

    Examples
    --------
    >>> float(area_ratio_bound(0.5))
    0.3333333333333333
    """
    s = np.asarray(symmetry, dtype=np.float64)
    return np.asarray(s / (2.0 - s))


def symmetry_of_impact(relative_impact: ArrayLike) -> Floats:
    """Return S of a circle whose centre passes the obstacle's at a distance b.

    Parameters
    ----------
    relative_impact : array_like, shape (...)
        The size of b over D; S is 0 from 1/2 on, where the centreline misses the droplet.

    Examples
    --------
    >>> symmetry_of_impact([0.0, 0.25, 0.6]).round(3).tolist()
    [1.0, 0.391, 0.0]
    """
    distance = np.minimum(np.abs(np.asarray(relative_impact, dtype=np.float64)), 0.5)
    return symmetry_of_height(0.5 - distance)


def local_exponent(relative_height: ArrayLike) -> Floats:
    r"""Return d ln S/d ln A of circles that share one h.

    From dS/dt = (16/π) √(t - t²), at constant h: -t/(2S) dS/dt. It is -3/4 for small h and -2/π
    for a circle cut in half.

    Parameters
    ----------
    relative_height : array_like, shape (...)
        t = h/D, above 0 and at most 1/2.

    Examples
    --------
    >>> local_exponent([1e-6, 0.5]).round(4).tolist()
    [-0.75, -0.6366]
    """
    t = np.asarray(relative_height, dtype=np.float64)
    return np.asarray(-8.0 / np.pi * t * np.sqrt(t - t**2) / _twice_share(t))


def _twice_share(t: Floats) -> Floats:
    """Return twice the segment's share of the circle's area."""
    cosine = np.clip(1.0 - 2.0 * t, -1.0, 1.0)
    return np.asarray(2.0 / np.pi * (np.arccos(cosine) - cosine * np.sqrt(1.0 - cosine**2)))
