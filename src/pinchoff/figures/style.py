"""The one look of all figures: sizes and fonts of a two-column journal, and how they are saved.

A label gives its unit in parentheses: "speed (mm/s)". The colours are those of
`pinchoff.support.palette`.
"""

from __future__ import annotations

import functools
import io
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pinchoff.support import palette
from pinchoff.support.files import written_aside
from pinchoff.support.progress import on_display

#: Widths of a figure [inch]: one column (8.3 cm), and across both (17.1 cm).
ONE_COLUMN = 3.27
TWO_COLUMNS = 6.73

#: Resolution of written pictures [dots per inch].
DOTS_PER_INCH = 300

#: Resolution of a figure on a screen [dots per inch].
SCREEN_DOTS_PER_INCH = 150

#: Marks of groups that are told apart by mark and colour.
MARKERS = "osD^vPX*"

_SALT = "pinchoff"  # for the names inside an SVG, so that the same figure gives the same file

STYLE: dict[str, Any] = {
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(color=palette.CATEGORIES),
    "axes.titlepad": 3,
    "axes.titlesize": 8,
    "figure.dpi": DOTS_PER_INCH,
    "font.family": "DejaVu Sans",  # ships with matplotlib: the same picture on every machine
    "font.size": 8,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "mathtext.fontset": "dejavusans",
    "savefig.dpi": DOTS_PER_INCH,
    "text.color": palette.INK,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
}


def mark_synthetic(axes: Axes, x: float = 0.98, y: float = 0.03) -> None:
    """Write "synthetic data" at a place in the axes."""
    axes.text(
        x,
        y,
        "synthetic data",
        transform=axes.transAxes,
        ha="right" if x > 0.5 else "left",
        fontsize=6.5,
        fontstyle="italic",
        color=palette.VERMILION,
        zorder=9,
    )


def journal_style(font_size: float = STYLE["font.size"]) -> AbstractContextManager[None]:
    """Return a context in which figures take the look of this package; font size in points."""
    if on_display() and not _off_screen.get():
        _prepare_display()
    settings: Any = {**STYLE, "font.size": font_size}  # matplotlib lists its keys as literals
    return mpl.rc_context(settings)


_off_screen: ContextVar[bool] = ContextVar("off_screen", default=False)


@contextmanager
def off_screen() -> Iterator[None]:
    """Make figures that no display shows, because they go into a file or a page."""
    token = _off_screen.set(True)
    try:
        yield
    finally:
        _off_screen.reset(token)


def new_figure(width: float, height: float, *, layout: str | None = "constrained") -> Figure:
    """Return an empty figure of a size in inches.

    It is one of pyplot's where a display can show it: in IPython, in notebooks, and in programs
    that use pyplot with a window. Elsewhere it is not, and need not be closed.

    Examples
    --------
    >>> new_figure(3.0, 2.0).get_size_inches().tolist()
    [3.0, 2.0]
    """
    if _off_screen.get() or not (on_display() or _has_window()):
        return Figure(figsize=(width, height), layout=layout)  # type: ignore[arg-type]
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width, height), layout=layout, dpi=SCREEN_DOTS_PER_INCH)


def one_panel(height: float) -> Axes:
    """Return the axes of a new figure across one column, of a height in inches."""
    axes: Axes = new_figure(ONE_COLUMN, height).subplots()
    return axes


def panels(axes: Sequence[Axes] | None, width: float, height: float, **grid: Any) -> list[Axes]:
    """Return the axes that were given, or else those of a new figure, row by row; sizes in inches.

    `grid` is what `matplotlib.figure.Figure.subplots` takes.
    """
    if axes is not None:
        return list(axes)
    return list(new_figure(width, height).subplots(squeeze=False, **grid).flat)


@functools.cache
def _prepare_display() -> None:
    """Load pyplot's backend, before a context of settings takes back at its end what loading sets.

    A notebook would show the first figure and no other.
    """
    from matplotlib import pyplot

    pyplot.switch_backend(pyplot.get_backend())


def _has_window() -> bool:
    pyplot = sys.modules.get("matplotlib.pyplot")
    return pyplot is not None and pyplot.get_backend().lower() != "agg"


def ordered_colors(values: Iterable[float]) -> dict[float, Any]:
    """Return a colour for each value of a quantity with an order, from dark to light.

    Neighbours in the order differ by the same step of colour, however far apart their values are.

    Examples
    --------
    >>> list(ordered_colors([8, 2, 4, 2]))
    [2, 4, 8]
    """
    ranked = sorted(set(values))
    shades = mpl.colormaps[palette.ORDERED_MAP](np.linspace(0.0, 0.88, max(2, len(ranked))))
    return {value: tuple(shade) for value, shade in zip(ranked, shades, strict=False)}


def png(axes: Axes, dots_per_inch: float | Literal["figure"] = "figure") -> bytes:
    """Return the figure of some axes as a PNG picture."""
    figure = axes.figure
    assert isinstance(figure, Figure)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=dots_per_inch)
    return stream.getvalue()


def save(path: str | os.PathLike[str], axes: Axes) -> None:
    """Write the figure of some axes as a picture, complete or not at all.

    The suffix chooses the format, as in .png, .pdf and .svg. The same figure is the same file,
    byte for byte.

    Examples
    --------
    >>> import tempfile
    >>> axes = Figure().subplots()
    >>> path = Path(tempfile.mkdtemp()) / "figure.svg"
    >>> save(path, axes)
    >>> first = path.read_bytes()
    >>> save(path, axes)
    >>> path.read_bytes() == first
    True
    """
    figure = axes.figure
    assert isinstance(figure, Figure)
    target = Path(path)
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(target.suffix)
    with (
        mpl.rc_context({"svg.hashsalt": _SALT, "svg.fonttype": "none"}),
        written_aside(target) as unfinished,
    ):
        figure.savefig(unfinished, dpi=DOTS_PER_INCH, metadata=undated)
