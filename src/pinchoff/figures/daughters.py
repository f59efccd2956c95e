"""The ratio of the daughters' areas against the symmetry of the collision."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pinchoff.collisions.circle_segments import area_ratio_bound
from pinchoff.collisions.schema import synthetic
from pinchoff.figures import style
from pinchoff.support import palette
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


def daughter_areas(
    table: pd.DataFrame, axes: Axes | None = None, *, curves: pd.DataFrame | None = None
) -> Axes:
    """Draw A1/A2 of droplets that broke against S, with the bound S/(2 - S).

    Parameters
    ----------
    table : DataFrame
        Checked collisions; those without measured daughters are left out.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.
    curves : DataFrame, optional
        Simulated break-ups; those of one Ca are joined to a line.

    Returns
    -------
    Axes

    Raises
    ------
    InputError
        No daughters were measured.
    """
    broke = table[table["broke"].astype(bool) & table["daughter_area_ratio"].notna()]
    if broke.empty:
        rule = "one with the areas of daughters"
        raise InputError.of("table", rule, "none measured", "leave this figure out")
    symmetry = broke["symmetry"].to_numpy()
    ratio = broke["daughter_area_ratio"].to_numpy()
    above = int((ratio > area_ratio_bound(symmetry)).sum())
    with style.journal_style():
        axes = style.one_panel(2.8) if axes is None else axes
        points = axes.scatter(
            symmetry,
            ratio,
            s=9 if len(broke) < 1000 else 4,
            c=broke["capillary_number"],
            cmap=palette.ORDERED_MAP,
            norm="log",
            linewidths=0,
            rasterized=True,
        )
        for ca, runs in () if curves is None else curves.groupby("capillary_number"):
            line = runs.sort_values("symmetry")
            color = points.to_rgba(np.array([float(str(ca))]))[0]
            axes.plot(line["symmetry"], line["daughter_area_ratio"], color=color, lw=1.2)
        wide = np.linspace(0.0, 1.0, 200)
        axes.plot(wide, area_ratio_bound(wide), "k:", label="$S/(2-S)$")
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1.02)
        axes.set_xlabel("symmetry $S$")
        axes.set_ylabel("daughters $A_1/A_2$")
        axes.set_title(f"{len(broke):,} broke, {above:,} above the bound", loc="right", fontsize=7)
        axes.legend(loc="upper left")
        bar = axes.figure.colorbar(points, ax=axes, label="Ca")
        bar.ax.tick_params(which="both", labelsize=6)
        if synthetic(table):
            style.mark_synthetic(axes)
        return axes
