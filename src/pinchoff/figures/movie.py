"""A film of a run, as H.264 in an MP4 file: every player and slide program shows it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pinchoff.figures import style
from pinchoff.figures.scene import Scale, Window, draw_chamber, draw_droplets, draw_scale_bar
from pinchoff.support.errors import InputError
from pinchoff.video.writing import ClipWriter, Pixels

if TYPE_CHECKING:
    from pinchoff.model.outlines import Outlines

_PIXELS = (960, 540)  # both even, as yuv420p needs
_DOTS_PER_INCH = 160
_FONT_SIZE = 11  # points
_REACH = (2.5, 1.3)  # shown beside, and above and below the obstacles [D0]
_QUALITY = 18  # constant rate factor of x264: no visible loss


def write_movie(
    path: str | os.PathLike[str],
    outlines: Outlines,
    fps: int = 30,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Film a run as H.264 (yuv420p, 960 by 540 pixels) in an MP4 file.

    Every frame of the outlines in which a droplet is in view becomes one frame of the film.

    Parameters
    ----------
    path : path
        The file, ``.mp4``; it appears when it is complete.
    outlines : Outlines
        The run.
    fps : int
        Frames of the outlines per second of film.
    progress : callable, optional
        Called after every frame with the frames done and the frames in all.

    Raises
    ------
    InputError
        PyAV or OpenCV is not installed, the name does not end in ``.mp4``, fps is not from 1 to
        240, or no droplet ever comes into view.
    """
    if not 1 <= fps <= 240:
        raise InputError.of("fps", "from 1 to 240", fps, "choose frames per second of film")
    window = _window(outlines)
    frames = _frames_in_view(outlines, window)
    if not frames:
        raise InputError.of("outlines", "near the obstacles", outlines, "give a whole run")
    with ClipWriter(path, _PIXELS, fps, _QUALITY) as film:
        for done, pixels in enumerate(_drawn(outlines, frames, window), start=1):
            film.append(pixels)
            if progress is not None:
                progress(done, len(frames))


def _window(outlines: Outlines) -> Window:
    """Return a window about the obstacles, or about the whole run where it has none."""
    if len(outlines.obstacles):
        centres, radii = outlines.obstacles[:, :2], outlines.obstacles[:, 2:]
        low = (centres - radii).min(axis=0) - _REACH
        high = (centres + radii).max(axis=0) + _REACH
    else:
        low, high = outlines.vertices.min(axis=0) - 0.5, outlines.vertices.max(axis=0) + 0.5
    middle, extent = (low + high) / 2, high - low
    ratio = _PIXELS[0] / _PIXELS[1]
    half_width = max(extent[0], extent[1] * ratio) / 2
    half_height = half_width / ratio
    return Window(
        float(middle[0] - half_width),
        float(middle[0] + half_width),
        float(middle[1] - half_height),
        float(middle[1] + half_height),
    )


def _frames_in_view(outlines: Outlines, window: Window) -> list[int]:
    x, y = outlines.vertices.T
    inside = (window.left < x) & (x < window.right) & (window.bottom < y) & (y < window.top)
    seen = np.logical_or.reduceat(inside, outlines.offsets[:-1])
    return [int(frame) for frame in np.unique(outlines.frame[seen])]


def _drawn(outlines: Outlines, frames: list[int], window: Window) -> Iterator[Pixels]:
    """Draw the frames one after the other: (height, width, 3) of red, green and blue."""
    scale = Scale.of(outlines)
    with style.journal_style(_FONT_SIZE):
        size = (_PIXELS[0] / _DOTS_PER_INCH, _PIXELS[1] / _DOTS_PER_INCH)
        canvas: Any = FigureCanvasAgg(Figure(figsize=size, dpi=_DOTS_PER_INCH))  # it has no types
        axes = canvas.figure.add_axes((0, 0, 1, 1))
        draw_chamber(axes, outlines, window)
        draw_scale_bar(axes, window, scale)
        label = axes.text(0.02, 0.96, "", transform=axes.transAxes, va="top")
        for frame in frames:
            droplets = draw_droplets(axes, outlines[frame], rim=1.5)
            label.set_text(scale.time_label(outlines.times[frame]))
            canvas.draw()
            yield np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])
            droplets.remove()
