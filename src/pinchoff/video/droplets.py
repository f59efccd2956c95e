"""A droplet in a frame, and what finds it: the one interface of all segmentations."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pinchoff.video.reading import Frame

Floats = NDArray[np.float64]


class Droplet(NamedTuple):
    """One droplet in one frame; pixels, origin at the centre of the top left one, y down.

    Attributes
    ----------
    outline : ndarray, shape (n, 2)
        Clockwise as seen.
    area : float
        Enclosed by it, pixels.
    x, y : float
        Its centre of mass.
    cut : bool
        Whether the edge of the frame or of the view cuts it.
    group : int
        Droplets that touch one another have the same number in their frame; -1: touches none.
    whole : Droplet or None
        Both parts as one droplet, where they may be one whose neck is too thin to show an inside.
    """

    outline: Floats
    area: float
    x: float
    y: float
    cut: bool
    group: int
    whole: Droplet | None = None


class Segmenter(Protocol):
    """What finds the droplets in the frames of one clip, whatever came before each of them."""

    def droplets(self, frame: Frame) -> list[Droplet]: ...
