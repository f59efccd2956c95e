"""The plane of the break-up law, S against Ca Ã z̃: its axes, the marks in it and its lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FixedLocator

from pinchoff.collisions.law import Line
from pinchoff.support import palette

if TYPE_CHECKING:
    from numpy.typing import NDArray

OUTCOMES = ((False, palette.UNBROKEN, "does not break"), (True, palette.BROKE, "breaks"))

CONTROL_PARAMETER = r"Ca $\tilde{A}\,\tilde{z}$"
SYMMETRY = "symmetry $S$"
CRITICAL_SYMMETRY = "critical symmetry $S_c$"

_SIZES = ((100, 4.0), (1000, 2.5), (10_000, 1.4))  # of a mark [points], by how many there are
_SMALLEST = 0.7
_FILLED = 1.6  # smaller marks are filled: an open one would be all rim


def draw_outcomes(
    axes: Axes,
    forcing: NDArray[np.float64],
    symmetry: NDArray[np.float64],
    broke: NDArray[np.bool_],
    *,
    marker: str = "o",
    size: float | None = None,
) -> None:
    """Draw collisions: filled green where they broke, open violet where they did not.

    They are drawn in a shuffled order, so that neither kind hides the other.

    Parameters
    ----------
    axes : Axes
    forcing, symmetry : ndarray, shape (n,)
        Ca Ã z̃ and S.
    broke : ndarray of bool, shape (n,)
    marker : str, optional
        Shape of a mark.
    size : float, optional
        Its size in points; by default smaller the more collisions there are.
    """
    size = mark_size(len(broke)) if size is None else size
    rim = 0.5 if size >= _FILLED else 0.0
    colors: dict[bool, tuple[str, str]] = {}
    for kind, color, label in OUTCOMES:
        colors[kind] = ("white" if rim and not kind else color, color)
        if (broke == kind).any():
            face, edge = colors[kind]
            shape: dict[str, Any] = {"mfc": face, "mec": edge, "mew": rim, "ls": "none"}
            axes.plot([], [], marker=marker, ms=max(size, 3.0), label=label, **shape)
    order = np.random.default_rng(0).permutation(len(broke))
    axes.scatter(
        forcing[order],
        symmetry[order],
        size**2,
        marker=marker,
        facecolors=[colors[bool(kind)][0] for kind in broke[order]],
        edgecolors=[colors[bool(kind)][1] for kind in broke[order]],
        linewidths=rim,
        rasterized=True,
        zorder=1,
    )


def mark_size(count: int) -> float:
    """Return the size of a mark [points] where so many collisions are drawn.

    Examples
    --------
    >>> mark_size(50) > mark_size(5000)
    True
    """
    return next((size for most, size in _SIZES if count <= most), _SMALLEST)


def draw_line(axes: Axes, line: Line, span: NDArray[np.float64], **look: Any) -> None:
    """Draw a separating line over a span of Ca Ã z̃, up to S = 1: no larger symmetry exists."""
    wide = np.geomspace(span[0], span[-1], 200)
    height = line.alpha * wide**line.beta
    possible = height <= 1.0
    axes.plot(wide[possible], height[possible], **{"zorder": 3, **look})


def formula(line: Line) -> str:
    """Write a separating line as α (Ca Ã z̃)^β, in matplotlib's TeX.

    Examples
    --------
    >>> formula(Line(0.089, -0.72)).startswith("0.089 (Ca")
    True
    """
    return rf"{line.alpha:.3f} (Ca $\tilde{{A}}\tilde{{z}}$)$^{{{line.beta:.2f}}}$"


def logarithmic_axes(
    axes: Axes, span: NDArray[np.float64], heights: tuple[float, float] | None = None
) -> None:
    """Scale both axes logarithmically, x over a span, with ticks written as plain numbers.

    The y axis is one of symmetries, from the lower to the upper of `heights`.
    """
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(span[0], span[-1])
    close = [0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0]
    if heights is not None:
        axes.set_ylim(*heights)
    wide = heights is not None and heights[0] < 0.1
    set_plain_ticks(axes.xaxis, _round_ticks(span[0], span[-1]))
    set_plain_ticks(axes.yaxis, _round_ticks(heights[0], 1.0) if wide and heights else close)


def set_plain_ticks(axis: Axis, ticks: Sequence[float], digits: str = "g") -> None:
    """Write plain numbers at some places of a logarithmic axis, and none at any other."""
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(f"{{x:{digits}}}")
    axis.set_minor_formatter("")


def _round_ticks(low: float, high: float) -> list[float]:
    """Return 1, 2 and 5 of each decade, 1 alone where these would be many, more where few."""
    extent = math.log10(high / low)
    steps: tuple[float, ...] = (1,) if extent >= 2.5 else (1, 2, 5)
    if extent < 0.7:
        steps = (1, 1.5, 2, 3, 4, 6, 8)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [float(f"{step}e{decade}") for decade in decades for step in steps]
    return [tick for tick in ticks if low <= tick <= high]
