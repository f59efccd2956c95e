"""Sub-pixel outlines: where brightness crosses its threshold between pixels.

OpenCV walks round a region from pixel to pixel. Between each pixel of that walk and each of its
neighbours outside, the crossing is interpolated; these points in the order of the walk are the
outline that marching squares would give.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Directions 0 to 7, clockwise as seen with y down: east, south-east, south, ...
_STEP_X = np.array([1, 1, 0, -1, -1, -1, 0, 1])
_STEP_Y = np.array([0, 1, 1, 1, 0, -1, -1, -1])
_DIRECTION = np.full((3, 3), 0)
_DIRECTION[_STEP_Y + 1, _STEP_X + 1] = np.arange(8)


def _sweeps() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return, for the steps into and out of a pixel, how many neighbours are outside, and which.

    On a walk that is clockwise as seen, what is outside lies on the left hand: in the directions
    from the one that the walk came from, turning clockwise, to the one that it goes on in.
    """
    counts = np.zeros((8, 8), dtype=np.int64)
    directions = np.zeros((8, 8, 4), dtype=np.int64)
    for into in range(8):
        for out in range(8):
            turn = (out - into - 4) % 8 or 8
            swept = [(into + 4 + k) % 8 for k in range(1, turn)]
            sides = [direction for direction in swept if direction % 2 == 0]
            counts[into, out] = len(sides)
            directions[into, out, : len(sides)] = sides
    return counts, directions


_COUNTS, _SIDES = _sweeps()


def trace(walks: Sequence[NDArray[np.int32]], excess: NDArray[np.int16]) -> list[Floats]:
    """Return the sub-pixel outlines of regions.

    Parameters
    ----------
    walks : sequence of ndarray, shape (n, 1, 2)
        Their outermost pixels x, y as ``cv2.findContours`` gives them without approximation.
    excess : ndarray, shape (height, width)
        What is compared with zero: positive within the edge that is looked for, negative outside.
        Between two regions, where it is positive on both sides, an outline runs halfway.

    Returns
    -------
    list of ndarray, shape (m, 2)
        x and y in pixels, clockwise as seen with y down.
    """
    if not walks:
        return []
    # OpenCV walks round the outside counter-clockwise as seen.
    points = [walk[::-1, 0, :] for walk in walks]
    lengths = np.array([len(walk) for walk in points])
    ends = np.cumsum(lengths)
    pixels = np.concatenate(points).astype(np.int64)
    following = np.arange(1, len(pixels) + 1)
    following[ends - 1] = ends - lengths
    step = pixels[following] - pixels
    out = _DIRECTION[step[:, 1] + 1, step[:, 0] + 1]
    into = np.empty_like(out)
    into[following] = out
    counts = _COUNTS[into, out]
    counts[lengths.repeat(lengths) == 1] = 0  # a single pixel has no way round
    owner = np.repeat(np.arange(len(pixels)), counts)
    nth = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    side = _SIDES[into[owner], out[owner], nth]
    x, y = pixels[owner, 0], pixels[owner, 1]
    share = _crossing(x, y, side, excess)
    crossings = np.column_stack([x + share * _STEP_X[side], y + share * _STEP_Y[side]])
    per_walk = np.add.reduceat(counts, ends - lengths)
    return np.split(crossings, np.cumsum(per_walk)[:-1])


def _crossing(
    x: NDArray[np.int64],
    y: NDArray[np.int64],
    side: NDArray[np.int64],
    excess: NDArray[np.int16],
) -> Floats:
    """Return how far from each pixel to its neighbour the edge lies, 0 to 1."""
    height, width = excess.shape
    beyond_x = np.clip(x + _STEP_X[side], 0, width - 1)
    beyond_y = np.clip(y + _STEP_Y[side], 0, height - 1)
    inside = excess[y, x].astype(np.float64)
    outside = excess[beyond_y, beyond_x].astype(np.float64)
    crosses = (inside > 0) & (outside <= 0)
    share = np.full(len(x), 0.5)
    np.divide(inside, inside - outside, out=share, where=crosses)
    return share
