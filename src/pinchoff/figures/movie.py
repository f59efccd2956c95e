"""A film of a run: as H.264 in an MP4 file, as a GIF, or as a player in a page."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pinchoff.figures import style
from pinchoff.figures.scene import Scale, Window, draw_chamber, draw_droplets, draw_scale_bar
from pinchoff.support.errors import InputError
from pinchoff.support.files import written_aside
from pinchoff.support.numerals import counted
from pinchoff.video.writing import ClipWriter, Pixels

if TYPE_CHECKING:
    from pinchoff.model.outlines import Outlines

_PIXELS = (960, 540)  # both even, as yuv420p needs
_DOTS_PER_INCH = 160
_SMALL_DOTS_PER_INCH = 96  # of a GIF and of a player
_FONT_SIZE = 11  # points
_REACH = (2.5, 1.3)  # shown beside, and above and below the obstacles [D0]
_QUALITY = 18  # constant rate factor of x264: no visible loss
_BUTTONS = {
    "minus": "−",
    "fast-backward": "|◀",
    "step-backward": "◁|",
    "play fa-flip-horizontal": "◀",
    "play": "▶",
    "pause": "❚❚",
    "step-forward": "|▷",
    "fast-forward": "▶|",
    "plus": "+",
}
"""What stands on the buttons of a player, by the names of their icons in matplotlib's page."""

Progress: TypeAlias = Callable[[int, int], object]
"""What is called with the frames done and the frames in all."""


def write_movie(
    path: str | os.PathLike[str],
    outlines: Outlines,
    fps: int = 30,
    progress: Progress | None = None,
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
    _require_rate(fps)
    stage = _Stage(outlines, fps)
    with ClipWriter(path, _PIXELS, fps, _QUALITY) as film:
        for pixels in stage.pictures(progress):
            film.append(pixels)


@dataclass(frozen=True, repr=False)
class Player:
    """A film with buttons, which a notebook shows.

    Attributes
    ----------
    page : str
        Its HTML, with everything inside.
    frame_count : int
    """

    page: str
    frame_count: int

    def _repr_html_(self) -> str:
        return self.page

    def __repr__(self) -> str:
        return f"<Player of {counted(self.frame_count, 'frame')}: a notebook shows it>"


def animate(
    outlines: Outlines,
    path: str | os.PathLike[str] | None = None,
    fps: int = 30,
    progress: Progress | None = None,
) -> Player | None:
    """Film a run, into a file or as a player for a notebook.

    Parameters
    ----------
    outlines : Outlines
        The run. Every frame in which a droplet is in view is shown.
    path : path, optional
        The file, which appears when it is complete: ``.gif``, ``.html``, or ``.mp4``, which needs
        the extra ``video``.
    fps : int, optional
        Frames of the outlines per second of film, from 1 to 240.
    progress : callable, optional
        Called after every frame of an ``.mp4`` or ``.gif`` with the frames done and the frames in
        all.

    Returns
    -------
    Player or None
        The player, if there is no path.

    Raises
    ------
    InputError
        An argument is wrong, or no droplet ever comes into view.

    Examples
    --------
    >>> import pinchoff as po
    >>> po.simulate(po.Parameters(), outlines=1.0).animate()
    <Player of 5 frames: a notebook shows it>
    """
    _require_rate(fps)
    if path is None:
        return _player(outlines, fps)
    target = Path(path)
    writers = {".mp4": write_movie, ".gif": _write_gif, ".html": _write_page}
    if target.suffix not in writers:
        rule = f"a name ending in {', '.join(writers)}"
        raise InputError.of("path", rule, target.name, "choose one of them")
    writers[target.suffix](target, outlines, fps, progress)
    return None


def _require_rate(fps: int) -> None:
    if not 1 <= fps <= 240:
        raise InputError.of("fps", "from 1 to 240", fps, "choose frames per second of film")


def _write_gif(path: Path, outlines: Outlines, fps: int, progress: Progress | None) -> None:
    from PIL import Image

    stage = _Stage(outlines, fps, _SMALL_DOTS_PER_INCH)
    first, *others = [
        Image.fromarray(pixels).quantize(64, method=Image.Quantize.FASTOCTREE)
        for pixels in stage.pictures(progress)
    ]
    # A GIF counts hundredths of a second, and viewers slow down what is faster than two.
    duration = max(20, round(100 / fps) * 10)
    with written_aside(path) as unfinished:
        first.save(
            unfinished, "gif", save_all=True, append_images=others, duration=duration, loop=0
        )


def _write_page(path: Path, outlines: Outlines, fps: int, _: Progress | None) -> None:
    with written_aside(path) as unfinished:
        page = _player(outlines, fps).page
        unfinished.write_text(f"<!doctype html><meta charset='utf-8'>{page}", encoding="utf-8")


def _player(outlines: Outlines, fps: int) -> Player:
    from matplotlib import rc_context
    from matplotlib.animation import FuncAnimation

    stage = _Stage(outlines, fps, _SMALL_DOTS_PER_INCH)
    look: Any = {"animation.embed_limit": 200, "savefig.dpi": _SMALL_DOTS_PER_INCH}
    with rc_context(look):
        film = FuncAnimation(stage.canvas.figure, stage.show, frames=stage.frames)
        return Player(_without_network(film.to_jshtml(fps=fps)), len(stage.frames))


def _without_network(page: str) -> str:
    """Return matplotlib's player with letters on its buttons: its symbols come from the web."""
    page = re.sub(r"<link[^>]*font-awesome[^>]*>", "", page)
    return re.sub(r'<i class="fa fa-([\w -]+)"></i>', lambda icon: _BUTTONS[icon[1]], page)


def _window(outlines: Outlines) -> Window:
    """Return a window about the obstacles, or about the whole run where it has none."""
    if len(outlines.obstacles):
        seen, (beside, above) = Window.around(outlines, ()), _REACH
    else:
        seen, (beside, above) = Window.around(outlines, range(len(outlines))), (0.5, 0.5)
    ratio = _PIXELS[0] / _PIXELS[1]
    half_width = max(seen.width / 2 + beside, (seen.height / 2 + above) * ratio)
    half_height = half_width / ratio
    x, y = (seen.left + seen.right) / 2, (seen.bottom + seen.top) / 2
    return Window(x - half_width, x + half_width, y - half_height, y + half_height)


def _frames_in_view(outlines: Outlines, window: Window) -> list[int]:
    x, y = outlines.vertices.T
    inside = (window.left < x) & (x < window.right) & (window.bottom < y) & (y < window.top)
    seen = np.logical_or.reduceat(inside, outlines.offsets[:-1])
    return [int(frame) for frame in np.unique(outlines.frame[seen])]


class _Stage:
    """A figure that shows one frame of a run after the other."""

    def __init__(self, outlines: Outlines, fps: int, dots_per_inch: int = _DOTS_PER_INCH) -> None:
        window = _window(outlines)
        self.frames = _frames_in_view(outlines, window)
        if not self.frames:
            raise InputError.of("outlines", "near the obstacles", outlines, "give a whole run")
        self._outlines = outlines
        self._scale = Scale.of(outlines)
        size = (_PIXELS[0] / _DOTS_PER_INCH, _PIXELS[1] / _DOTS_PER_INCH)
        with style.journal_style(_FONT_SIZE):
            figure = Figure(figsize=size, dpi=dots_per_inch)
            self.canvas: Any = FigureCanvasAgg(figure)  # it has no types
            self._axes = figure.add_axes((0, 0, 1, 1))
            draw_chamber(self._axes, outlines, window)
            draw_scale_bar(self._axes, window, self._scale)
            corner = self._axes.transAxes
            self._label = self._axes.text(0.02, 0.96, "", transform=corner, va="top")
            if len(self.frames) > 1:
                place: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": "small"}
                self._axes.text(0.98, 0.96, self._pace(fps), transform=corner, **place)
        self._droplets: Any = None

    def _pace(self, fps: int) -> str:
        """Say how much of the run a second of film shows."""
        step = float(np.median(np.diff(self._outlines.times[self.frames])))
        shown = fps * step * self._scale.time
        return f"1 s of film: {shown:.3g} {self._scale.time_unit}"

    def show(self, frame: int) -> None:
        """Show a frame of the outlines."""
        if self._droplets is not None:
            self._droplets.remove()
        self._droplets = draw_droplets(self._axes, self._outlines[frame], rim=1.5)
        self._label.set_text(self._scale.time_label(self._outlines.times[frame]))

    def pictures(self, progress: Progress | None = None) -> Iterator[Pixels]:
        """Draw all frames: (height, width, 3) of red, green and blue."""
        with style.journal_style(_FONT_SIZE):
            for done, frame in enumerate(self.frames, start=1):
                self.show(frame)
                self.canvas.draw()
                yield np.ascontiguousarray(np.asarray(self.canvas.buffer_rgba())[..., :3])
                if progress is not None:
                    progress(done, len(self.frames))
