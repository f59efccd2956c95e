"""A film of droplets in an array: the whole cell, with what crosses its edges, coloured by size."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pinchoff.figures import style
from pinchoff.figures.emulsion_figures import diameter_of, draw_pillars, droplet_shapes
from pinchoff.figures.scene import Scale, round_length
from pinchoff.support import palette
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted
from pinchoff.video.writing import ClipWriter, Pixels

if TYPE_CHECKING:
    from pinchoff.model.arrays import PillarArray
    from pinchoff.model.outlines import Outlines

_PACE = 5.0  # t0 a second
_SLOWEST, _FASTEST = 5, 50  # frames a second
_WIDTH, _HIGHEST = 1280, 960  # pixels
_FOOT = 90  # pixels below the cell, for time, count and scale
_DOTS_PER_INCH = 160
_QUALITY = 20  # constant rate factor of x264


def film_rate(interval: float) -> int:
    """Return the frames a second at which a film runs at 5 t0 a second, from 5 to 50.

    Examples
    --------
    >>> film_rate(0.5), film_rate(0.1)
    (10, 50)
    """
    return int(min(max(round(_PACE / interval), _SLOWEST), _FASTEST))


def write_emulsion_film(
    path: str | os.PathLike[str],
    pieces: Iterable[Outlines],
    array: PillarArray,
    largest: float,
    interval: float,
    periodic: str = "y",
    progress: Callable[[float], object] | None = None,
) -> int:
    """Film a run as H.264 (yuv420p, 1280 pixels wide) in an MP4 file; return how many frames.

    Parameters
    ----------
    path : path
        The file, ``.mp4``; it appears when it is complete.
    pieces : iterable of Outlines
        Of a run, one after the other: one of them at a time is in memory.
    array : PillarArray
    largest : float
        Diameter at the end of the colour scale, D0.
    interval : float
        Time between two frames, t0.
    periodic : str, optional
        Axes along which the cell repeats itself.
    progress : callable, optional
        Called after every frame with its time, t0.

    Raises
    ------
    InputError
        PyAV or OpenCV is not installed, the name does not end in ``.mp4``, or there is no frame.
    """
    pictures = _pictures(pieces, array, largest, periodic, progress)
    first = next(pictures, None)
    if first is None:
        raise InputError.of("pieces", "outlines of a run", "none", "set outlines = true")
    count = 1
    height, width = first.shape[:2]
    with ClipWriter(Path(path), (width, height), film_rate(interval), _QUALITY) as film:
        film.append(first)
        for pixels in pictures:
            film.append(pixels)
            count += 1
    return count


def _pictures(
    pieces: Iterable[Outlines],
    array: PillarArray,
    largest: float,
    periodic: str,
    progress: Callable[[float], object] | None,
) -> Iterator[Pixels]:
    with style.journal_style(11):
        stage = None
        for outlines in pieces:
            stage = stage or _Stage(array, largest, periodic, Scale.of(outlines))
            for frame, time in enumerate(outlines.times.tolist()):
                yield stage.picture(outlines, frame, time)
                if progress is not None:
                    progress(time)


class _Stage:
    """A figure that shows one frame of a run after the other."""

    def __init__(self, array: PillarArray, largest: float, periodic: str, scale: Scale) -> None:
        self._array, self._periodic, self._scale = array, periodic, scale
        pixels = min(_WIDTH / array.length, (_HIGHEST - _FOOT) / array.width)
        # H.264 halves the colour's resolution: both sides are even.
        width = max(640, 2 * round(pixels * array.length / 2))
        height = 2 * round(pixels * array.width / 2) + _FOOT
        figure = Figure(figsize=(width / _DOTS_PER_INCH, height / _DOTS_PER_INCH))
        figure.set_dpi(_DOTS_PER_INCH)
        self._canvas: Any = FigureCanvasAgg(figure)  # it has no types
        self._axes = figure.add_axes((0, _FOOT / height, 1, 1 - _FOOT / height))
        draw_pillars(self._axes, array, periodic)
        self._axes.set(xticks=[], yticks=[])
        self._axes.spines[:].set_visible(False)
        self._colors = ScalarMappable(Normalize(0.0, largest * scale.length), palette.ORDERED_MAP)
        middle = 0.5 * _FOOT / height
        self._label = figure.text(0.02, middle, "", va="center")
        self._draw_foot(figure, middle)
        self._droplets: Any = None

    def _draw_foot(self, figure: Figure, middle: float) -> None:
        """Draw the colours' scale and a bar of a round length."""
        place = figure.add_axes((0.5, middle - 0.06 * middle, 0.2, 0.45 * middle))
        bar = figure.colorbar(self._colors, cax=place, orientation="horizontal")
        bar.ax.tick_params(labelsize="x-small", pad=1)
        bar.ax.minorticks_off()
        diameter = f"diameter ({self._scale.length_unit})"
        figure.text(0.49, middle, diameter, va="center", ha="right", fontsize="small")
        extent = self._array.length * self._scale.length
        length = round_length(0.12 * extent)
        share = length / extent
        ends, height = (0.97 - share, 0.97), 0.7 * middle + 0.01
        bar_of_length = Line2D(ends, [height, height], color=palette.INK, lw=2)
        bar_of_length.set_solid_capstyle("butt")
        figure.add_artist(bar_of_length)
        label = f"{length:g} {self._scale.length_unit}"
        figure.text(0.97 - share / 2, middle * 1.1, label, ha="center", fontsize="small")

    def picture(self, outlines: Outlines, frame: int, time: float) -> Pixels:
        """Return one frame: (height, width, 3) of red, green and blue."""
        droplets = outlines[frame]
        sizes = self._scale.length * np.array([diameter_of(one.vertices) for one in droplets])
        if self._droplets is not None:
            self._droplets.remove()
        shades = self._colors.to_rgba(sizes)
        shapes = droplet_shapes(droplets, self._array, self._periodic, shades, rim=0.9)
        self._droplets = self._axes.add_collection(shapes, autolim=False)
        self._label.set_text(
            f"{self._scale.time_label(time)}   {counted(len(droplets), 'droplet')}"
        )
        self._canvas.draw()
        return np.ascontiguousarray(np.asarray(self._canvas.buffer_rgba())[..., :3])
