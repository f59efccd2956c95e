"""A user's own segmentation: any function from a picture to outlines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.support.errors import InputError
from pinchoff.video.droplets import Droplet
from pinchoff.video.reading import Frame

Floats = NDArray[np.float64]

SegmentFunction = Callable[[NDArray[np.uint8]], Sequence[Any]]
"""From brightness, (height, width), to closed outlines, each (n, 2): x and y in pixels, the origin
at the centre of the top left one."""

_AT_EDGE = 1.0  # pixels from the outermost ones: there the frame cuts an outline


class FunctionSegmenter:
    """Find droplets by a function that returns their outlines.

    Parameters
    ----------
    function : callable
    minimum_area : float
        Of a droplet, pixels.
    """

    def __init__(self, function: SegmentFunction, minimum_area: float) -> None:
        self._function, self.minimum_area = function, minimum_area

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame.

        Raises
        ------
        InputError
            The function returns something else than outlines.
        """
        height, width = frame.luma.shape
        found = []
        for given in self._function(frame.luma):
            outline = _checked(given)
            area = _core.area(outline)
            if area < self.minimum_area:
                continue
            x, y = _core.centroid(outline)
            low, high = outline.min(axis=0), outline.max(axis=0)
            last = np.array([width, height]) - 1.0
            cut = bool(np.any(low <= _AT_EDGE) or np.any(high >= last - _AT_EDGE))
            found.append(Droplet(outline, area, x, y, cut, -1))
        return found


def _checked(given: Any) -> Floats:
    """Return an outline that goes round clockwise as seen."""
    rule, advice = "a closed outline of three or more points x, y", "return arrays of shape (n, 2)"
    try:
        outline = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError.of("segment", rule, type(given).__name__, advice) from None
    if outline.ndim != 2 or outline.shape[1] != 2 or len(outline) < 3:
        raise InputError.of("segment", rule, f"an array of shape {outline.shape}", advice)
    if not np.isfinite(outline).all():
        raise InputError.of("segment", rule, "points that are not finite", advice)
    x, y = outline.T
    turning = float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return np.ascontiguousarray(outline if turning >= 0.0 else outline[::-1])


def function_name(function: SegmentFunction) -> str:
    """Return a function's name, with the module it is in."""
    module = getattr(function, "__module__", "")
    return f"{module}.{getattr(function, '__qualname__', type(function).__name__)}"
