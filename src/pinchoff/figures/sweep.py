"""The phase diagram: which collisions break, in the plane of the break-up law."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from pinchoff.figures import style
from pinchoff.figures.separating_line import BROKE, PAPER_LINES, UNBROKEN, write_figure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.studies.sweep.summary import Points

_LOWEST_SYMMETRY = 0.05  # below, a droplet only grazes the obstacle
_LARGEST, _SMALLEST = 3.0, 0.5  # markers [points]
_CROWD = 300  # collisions that are drawn with the largest markers


def phase_diagram(points: Points, axes: Axes | None = None) -> Axes:
    """Draw S against Ca Ã z̃, both logarithmic, with the paper's separating lines.

    Parameters
    ----------
    points : Points
        The collisions, one at least; if they are a sample of more, the picture says so.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
        Their figure is ``axes.figure``.
    """
    with style.journal_style():
        if axes is None:
            figure = Figure(figsize=(style.ONE_COLUMN, 3.4), layout="constrained")
            axes = figure.subplots()
        _scale_axes(axes, points)
        _draw_points(axes, points)
        _draw_lines(axes)
        axes.set_xlabel(r"Ca $\tilde{A}\,\tilde{z}$")
        axes.set_ylabel("symmetry $S$")
        axes.legend(
            loc="upper center",
            bbox_to_anchor=(0.45, -0.17),
            ncols=2,
            columnspacing=1.2,
            labelspacing=0.3,
        )
        _say_how_many(axes, points)
    return axes


def write_phase_diagram(path: str | os.PathLike[str], points: Points) -> None:
    """Write the phase diagram as a picture; the suffix chooses its format."""
    write_figure(path, phase_diagram(points))


def _scale_axes(axes: Axes, points: Points) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(points.forcing.min() / 1.2, points.forcing.max() * 1.2)
    axes.set_ylim(_lowest_symmetry(points), 1.15)
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        steps = (1.0, 2.0, 5.0) if high < 300 * low else (1.0,)
        axis.set_major_locator(LogLocator(subs=steps, numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _lowest_symmetry(points: Points) -> float:
    """Return where the axis begins: well below whatever broke, and below the paper's lines."""
    broke = points.symmetry[points.broke]
    broke = broke[broke > 0]
    ends = [line.alpha * points.forcing.max() ** line.beta for line, *_ in PAPER_LINES]
    return float(min([_LOWEST_SYMMETRY, *(0.5 * broke), *(0.5 * np.array(ends))]))


def _draw_points(axes: Axes, points: Points) -> None:
    """Draw both kinds in one shuffled layer, so that neither hides the other."""
    count = len(points.symmetry)
    size = max(_SMALLEST, _LARGEST * min(1.0, (_CROWD / count) ** 0.35))
    for broke, color, label in ((False, UNBROKEN, "does not break"), (True, BROKE, "breaks")):
        small = size < _LARGEST / 2
        face = color if broke or small else "white"
        shape: dict[str, Any] = {"marker": "o" if broke else "s", "mfc": face, "mec": color}
        shape |= {"ls": "none", "mew": 0 if small else 0.5}
        axes.plot([], [], ms=_LARGEST, label=label, **shape)
        for piece in _layers(points.broke == broke):
            x, y = points.forcing[piece], points.symmetry[piece]
            order = 1.0 + piece[0] / (2 * count)
            axes.plot(x, y, ms=size, zorder=order, rasterized=True, **shape)


def _layers(chosen: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Cut the chosen points into a few runs, which the two kinds then draw in turn."""
    places = np.flatnonzero(chosen)
    return [piece for piece in np.array_split(places, 20) if len(piece)]


def _draw_lines(axes: Axes) -> None:
    wide = np.geomspace(*axes.get_xlim(), 200)
    for line, name, color, dashes in PAPER_LINES:
        value = line.alpha * wide**line.beta
        seen = value <= 1.0  # there is no larger symmetry
        halo = [Stroke(linewidth=2.4, foreground="white"), Normal()]  # stands out of a crowd
        x, y = wide[seen], value[seen]
        axes.plot(x, y, color=color, ls=dashes, label=name, zorder=3, path_effects=halo)


def _say_how_many(axes: Axes, points: Points) -> None:
    """Say above the axes how many collisions there are, and what is not shown of them."""
    drawn, there = len(points.symmetry), points.population
    lowest = axes.get_ylim()[0]
    below = int((points.symmetry < lowest).sum())
    text = f"{there:,} collisions" if drawn == there else f"random {drawn:,} of {there:,}"
    if below:
        text += f"; {below:,} are below $S$ = {lowest:.2g}"
    axes.set_title(text, loc="right", fontsize=7)
