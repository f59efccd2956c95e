"""What is the same in all frames of a clip, for methods that look at one level after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.reading import Frame
from pinchoff.video.signal import Signal, noise_of
from pinchoff.video.standing import Placed, alike, rows_of

_LOOKED_AT = 3  # frames whose noise is measured, about


class Surroundings(NamedTuple):
    """What is about the droplets of a clip.

    Attributes
    ----------
    noise : float
        Standard deviation, grey levels.
    levels : tuple of float
        Of darkness, grey levels below what is about them.
    view : ndarray of uint8, shape (height, width), or None
        Not zero beyond the dark edge of the view.
    standing : ndarray, shape (n, 3)
        Centre x, y and area of regions that never move.
    """

    noise: float
    levels: tuple[float, ...] = ()
    view: NDArray[np.uint8] | None = None
    standing: NDArray[np.float64] = np.empty((0, 3))

    def stands(self, region: Placed) -> bool:
        """Return whether a region is one of those that never move."""
        (row,) = rows_of([region])
        return bool(alike(self.standing, row).any())


def usual_noise(frames: Sequence[Frame], signal: Signal) -> float:
    """Return the noise of a clip in a signal, grey levels, from some of its frames."""
    some = frames[:: max(1, len(frames) // _LOOKED_AT)]
    return float(np.median([noise_of(signal.of(frame)) for frame in some]))
