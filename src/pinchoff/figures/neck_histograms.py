"""The thinnest necks of droplets that break and that do not, and what a camera sees of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from pinchoff.collisions.schema import synthetic
from pinchoff.figures import style
from pinchoff.figures.plane import OUTCOMES
from pinchoff.studies.necks import ThinningHistory, last_frame_necks
from pinchoff.support import paper_constants as paper
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import numeral

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

FRAME_RATES = (30.0, paper.FRAME_RATE, 240.0, 1000.0)
"""Cameras that are compared, frames/s; the paper's makes 60."""

_PAPER_LIMIT_UM = paper.NECK_THICKNESS * paper.MEDIAN_DIAMETER_UM
_BINS = 40


def neck_histograms(
    table: pd.DataFrame, history: ThinningHistory | None = None, axes: Sequence[Axes] | None = None
) -> list[Axes]:
    """Draw the distribution of the thinnest neck, and what cameras would see of one that breaks.

    Parameters
    ----------
    table : DataFrame
        Checked collisions with ``neck_um``, or else ``neck_thickness`` in D0.
    history : ThinningHistory, optional
        How the neck of one droplet thins until it breaks. Without it only one panel is drawn.
    axes : sequence of Axes, optional
        Where to draw, one or two; by default a new figure.

    Returns
    -------
    list of Axes

    Raises
    ------
    InputError
        No necks were measured.
    """
    name, unit = (
        ("neck_um", "µm")
        if "neck_um" in table and table["neck_um"].notna().any()
        else ("neck_thickness", "$D_0$")
    )
    necks = table[name].to_numpy(dtype=np.float64)
    broke = table["broke"].to_numpy(dtype=bool)
    measured = np.isfinite(necks)
    if not measured.any():
        rule = "one with the thinnest necks"
        raise InputError.of("table", rule, "none measured", "leave this figure out")
    with style.journal_style():
        columns, width = (1, style.ONE_COLUMN) if history is None else (2, style.TWO_COLUMNS)
        panels = style.panels(axes, width, 2.6, ncols=columns)
        _draw_necks(panels[0], necks[measured], broke[measured], unit)
        if history is not None:
            _draw_cameras(panels[1], history)
        if synthetic(table):
            style.mark_synthetic(panels[0], y=0.5)
        return panels


def _draw_necks(
    axes: Axes, necks: NDArray[np.float64], broke: NDArray[np.bool_], unit: str
) -> None:
    """Draw how many droplets had a thinnest neck of each thickness, by what came of them."""
    edges = np.linspace(0.0, necks.max() * 1.02, _BINS + 1).tolist()
    for kind, color, label in reversed(OUTCOMES):
        values = necks[broke == kind]
        if len(values) > 1 and np.ptp(values) < 0.1 * edges[1]:
            # Simulated droplets are cut at one thickness: a line, not one tall bar.
            place = float(np.median(values))
            text = f"{label}: {len(values):,}, all at {numeral(place, '.3g')} {unit}"
            axes.axvline(place, color=color, lw=1.6, label=text)
            continue
        axes.hist(values, edges, color=color, alpha=0.65, label=f"{label}: {len(values):,}")
    if unit == "µm":
        label = rf"paper's $d_\text{{min-neck}}$, {_PAPER_LIMIT_UM:.1f} µm"
        axes.axvline(_PAPER_LIMIT_UM, color="k", ls="--", lw=0.8, label=label)
    axes.set_xlabel(rf"thinnest neck $d_\mathrm{{neck}}$ ({unit})")
    axes.set_ylabel("collisions")
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))  # clear of the bars


def _draw_cameras(axes: Axes, history: ThinningHistory) -> None:
    """Draw the cumulative distribution of the neck in the last frame before the break-up."""
    for rate, color in style.ordered_colors(FRAME_RATES).items():
        necks = np.sort(last_frame_necks(history, rate))
        share = (np.arange(len(necks)) + 0.5) / len(necks)
        axes.plot(necks, share, color=color, label=f"{rate:g} frames/s")
    axes.set_ylim(0, 1.02)
    axes.set_xlabel("neck in the last frame before the break-up (µm)")
    axes.set_ylabel("share of films with a thinner one")
    axes.set_title("one neck, any phase of the camera", loc="right", fontsize=7)
    axes.legend(loc="lower right")
