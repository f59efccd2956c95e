"""S against Ca Ã z̃ of collisions that broke, of those that did not, and of both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, Line
from pinchoff.figures import style
from pinchoff.figures.separating_line import BROKE, UNBROKEN, logarithmic_axes, signed

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from pinchoff.fits import LawFit

_LOWEST = 0.02  # S: from here on down a droplet only grazes the obstacle
_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
_MARKERS = ((100, 4.0), (1000, 2.5), (10_000, 1.4))  # points, by how many collisions there are
_SMALLEST = 0.7


def separated_outcomes(
    table: pd.DataFrame, fit: LawFit, axes: Sequence[Axes] | None = None
) -> list[Axes]:
    """Draw the paper's split of its collisions: broke, both, did not; with the separating line.

    Where exponents were left free, Ã and z̃ on the axis carry them.

    Parameters
    ----------
    table : DataFrame
        Checked collisions, such as ``import_collisions(...).table``.
    fit : LawFit
    axes : sequence of 3 Axes, optional
        Where to draw; by default a new figure across two columns.

    Returns
    -------
    list of 3 Axes
    """
    seen = table[table["symmetry"] > 0]
    symmetry = seen["symmetry"].to_numpy()
    broke = seen["broke"].to_numpy(dtype=bool)
    # Bk = Ca Ã z̃ (S/α)^(-1/β), with the exponents that were fitted: so this is Ca Ã z̃.
    forcing = fit.breakup_number(seen) * (symmetry / fit.line.alpha) ** (1.0 / fit.line.beta)
    with style.journal_style():
        if axes is None:
            figure = Figure(figsize=(style.TWO_COLUMNS, 2.75), layout="constrained")
            axes = list(figure.subplots(1, 3, sharex=True, sharey=True))
        size = next((ms for most, ms in _MARKERS if len(seen) <= most), _SMALLEST)
        shown = (("breaks", broke), ("both", np.ones_like(broke)), ("does not break", ~broke))
        span = np.array([forcing.min() / 1.3, forcing.max() * 1.3])
        for panel, (title, which) in zip(axes, shown, strict=True):
            _draw_points(panel, forcing[which], symmetry[which], broke[which], size)
            _draw_line(panel, fit.line, span, "#000000", "--", f"fit: {_formula(fit.line)}")
            paper = PAPER_EXPERIMENT_LINE
            _draw_line(panel, paper, span, "#d55e00", "-", f"paper: {_formula(paper)}")
            logarithmic_axes(panel, span)
            panel.set_ylim(_LOWEST, 1.25)
            panel.yaxis.set_major_locator(FixedLocator(_TICKS))
            panel.set_title(f"{title}: {int(which.sum()):,}", loc="left")
            panel.set_xlabel(_label(fit))
        axes[0].set_ylabel("symmetry $S$")
        axes[0].figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2
        )
        _say_what_is_missing(axes[0], table, fit)
        return list(axes)


def _draw_points(
    axes: Axes,
    forcing: NDArray[np.float64],
    symmetry: NDArray[np.float64],
    broke: NDArray[np.bool_],
    size: float,
) -> None:
    """Draw both kinds in one shuffled layer, so that neither hides the other."""
    order = np.random.default_rng(0).permutation(len(broke))
    colors = np.where(broke[order], BROKE, UNBROKEN)
    axes.scatter(
        forcing[order], symmetry[order], s=size**2, c=colors, linewidths=0, rasterized=True
    )


def _draw_line(
    axes: Axes, line: Line, span: NDArray[np.float64], color: str, dashes: str, label: str
) -> None:
    wide = np.geomspace(span[0], span[1], 200)
    height = line.alpha * wide**line.beta
    there = height <= 1.0  # no larger symmetry exists
    axes.plot(wide[there], height[there], color=color, ls=dashes, lw=1, label=label, zorder=3)


def _formula(line: Line) -> str:
    return rf"$S_c$ = {line.alpha:.3f} (Ca $\tilde{{A}}\tilde{{z}}$)$^{{{line.beta:.2f}}}$"


def _label(fit: LawFit) -> str:
    powers = {"area": "", "thickness": ""}
    for name, key in (("area", "epsilon_1"), ("thickness", "epsilon_3")):
        if name in fit.free:
            powers[name] = rf"^{{\,{signed(fit.estimates[key].value)}}}"
    return rf"Ca $\tilde{{A}}{powers['area']}\,\tilde{{z}}{powers['thickness']}$"


def _say_what_is_missing(axes: Axes, table: pd.DataFrame, fit: LawFit) -> None:
    below = int((table["symmetry"] < _LOWEST).sum())
    said = f"{below:,} more below $S$ = {_LOWEST}" if below else ""
    axes.text(0.03, 0.03, said, transform=axes.transAxes, fontsize=6.5)
    if fit.synthetic:
        style.mark_synthetic(axes, x=0.03, y=0.1)
