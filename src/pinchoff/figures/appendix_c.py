"""Appendix C: viscosity and line tension act through their ratio, the capillary number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from pinchoff.collisions.law import PAPER_SIMULATION_LINE
from pinchoff.figures import style
from pinchoff.figures.plane import CRITICAL_SYMMETRY, logarithmic_axes
from pinchoff.studies.boundary.collapse import Spread, collapse_spread, slopes
from pinchoff.support.numerals import numeral

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.studies.boundary.search import Boundary


def appendix_c(boundary: Boundary, axes: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw S_c against μ̃ for each γ̃, and all of it against μ̃/γ̃ [paper, appendix C].

    Dashed lines have the slope of the paper's simulations, -0.72; they go through the middle of
    the points.

    Parameters
    ----------
    boundary : Boundary
        It must have several line tensions and several simulation capillary numbers.
    axes : sequence of 2 Axes, optional
        Where to draw; by default a new figure across one column, one panel above the other.

    Returns
    -------
    list of 2 Axes

    Raises
    ------
    InputError
        No two line tensions have a critical symmetry at the same capillary number.
    """
    rows = boundary.found
    spread = collapse_spread(rows)
    slope = slopes(rows)
    with style.journal_style():
        above, below = style.panels(axes, style.ONE_COLUMN, 5.2, nrows=2)
        colors = style.ordered_colors(rows["line_tension"])
        for k, (tension, group) in enumerate(rows.groupby("line_tension")):
            fitted = slope.get(float(str(tension)))
            label = f"{tension:g}" + ("" if fitted is None else f"  ({numeral(fitted, '.3f')})")
            look = {"color": colors[float(str(tension))], "label": label}
            _draw_points(above, k, group["drag"], group["critical_symmetry"], look)
            _draw_dashes(above, group["drag"], group["critical_symmetry"])
            ratio = group["simulation_capillary_number"]
            _draw_points(below, k, ratio, group["critical_symmetry"], look)
        _draw_dashes(below, rows["simulation_capillary_number"], rows["critical_symmetry"])
        _finish(above, rows["drag"], r"viscosity $\tilde{\mu}$", room=8)
        _finish(below, rows["simulation_capillary_number"], r"$\tilde{\mu}/\tilde{\gamma}$")
        above.legend(title=r"$\tilde{\gamma}$  (slope)", loc="lower left", handletextpad=0.1)
        below.text(0.04, 0.05, _spread_text(spread), transform=below.transAxes, fontsize=7)
        return [above, below]


def _spread_text(spread: Spread) -> str:
    dashes = f"dashed: slope {numeral(PAPER_SIMULATION_LINE.beta)}"
    return (
        f"{dashes}\nspread about the mean of all $\\tilde{{\\gamma}}$:\n"
        f"rms {spread.typical:.2%}, largest {spread.largest:.2%}\n"
        f"(half a bracket: {spread.bracket:.2%} at most)"
    )


def _draw_points(
    axes: Axes, k: int, x: pd.Series, symmetry: pd.Series, look: dict[str, Any]
) -> None:
    # Each further series has smaller marks, so that all marks at one place are seen.
    size = max(7.5 - 1.5 * k, 1.5)
    mark = style.MARKERS[k % len(style.MARKERS)]
    axes.plot(x, symmetry, ls="none", marker=mark, ms=size, mew=0.9, mfc="none", **look)


def _draw_dashes(axes: Axes, x: pd.Series, symmetry: pd.Series) -> None:
    """Draw the paper's slope through the logarithmic middle of some points."""
    middle_x, middle_s = np.exp(np.log(x).mean()), np.exp(np.log(symmetry).mean())
    ends = np.array([x.min() * 0.85, x.max() * 1.15])
    line = middle_s * (ends / middle_x) ** PAPER_SIMULATION_LINE.beta
    axes.plot(ends, line, color="0.5", ls="--", lw=0.7, zorder=1)


def _finish(axes: Axes, x: pd.Series, label: str, room: float = 1.3) -> None:
    """Scale the axes, with `room` to the left of the points."""
    logarithmic_axes(axes, np.array([x.min() / room, x.max() * 1.3]))
    axes.set_xlabel(label)
    axes.set_ylabel(CRITICAL_SYMMETRY)
    axes.set_ylim(0.19, 1.2)
