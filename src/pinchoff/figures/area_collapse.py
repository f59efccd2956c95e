"""How far one separating line serves several size ratios."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pinchoff.figures import style
from pinchoff.figures.plane import CRITICAL_SYMMETRY, logarithmic_axes
from pinchoff.support.numerals import numeral

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.studies.boundary.line_fit import LineFit
    from pinchoff.studies.boundary.search import Boundary


def area_collapse(boundary: Boundary, axes: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw how far one line serves several size ratios: with Ã, and with Ã to its best power.

    Parameters
    ----------
    boundary : Boundary
        It must have several size ratios and several simulation capillary numbers.
    axes : sequence of 2 Axes, optional
        Where to draw; by default a new figure across two columns.

    Returns
    -------
    list of 2 Axes

    Raises
    ------
    InputError
        The boundary has too few points to fit the exponent of Ã.
    """
    fits = [boundary.fit(), boundary.fit(free_area=True)]
    with style.journal_style():
        panels = style.panels(axes, style.TWO_COLUMNS, 2.9, ncols=2, sharey=True)
        for panel, fit in zip(panels, fits, strict=True):
            _draw_collapse(panel, boundary.found, fit)
        panels[0].set_ylabel(CRITICAL_SYMMETRY)
        panels[1].legend(title="$D_0/R$", loc="center left", bbox_to_anchor=(1.01, 0.5))
        return panels


def _draw_collapse(axes: Axes, rows: pd.DataFrame, fit: LineFit) -> None:
    power = fit.area_exponent.value
    free = fit.coefficients.size == 3
    forcing = rows["capillary_number"] * rows["normalized_thickness"]
    scaled = forcing * rows["normalized_area"] ** power
    colors = style.ordered_colors(rows["size_ratio"])
    for k, (ratio, group) in enumerate(rows.groupby("size_ratio")):
        axes.plot(
            scaled[group.index],
            group["critical_symmetry"],
            ls="none",
            marker=style.MARKERS[k % len(style.MARKERS)],
            ms=3.5,
            color=colors[float(str(ratio))],
            label=f"{ratio:g}",
        )
    wide = np.geomspace(0.9 * scaled.min(), 1.1 * scaled.max(), 50)
    line = fit.alpha.value * wide**fit.beta.value
    axes.plot(wide, line, color="0.4", lw=0.8, zorder=1, label="one line, fitted")
    logarithmic_axes(axes, wide)
    exponent = rf"^{{\,{numeral(power)}}}" if free else ""
    axes.set_xlabel(rf"Ca $\tilde{{A}}{exponent}\,\tilde{{z}}$")
    text = f"$\\beta$ = {numeral(fit.beta.value)}, rms distance {fit.scatter:.1%}"
    if free:
        p = fit.area_exponent
        interval = f"{numeral(p.low)} to {numeral(p.high)}"
        text = f"$p$ = {numeral(p.value)} ({interval})\n{text}"
    axes.text(0.97, 0.96, text, ha="right", va="top", transform=axes.transAxes, fontsize=7)
