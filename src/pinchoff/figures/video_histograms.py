"""Figures of a table of filmed collisions: histograms, and what happened when."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from pinchoff.figures import style
from pinchoff.support import palette

if TYPE_CHECKING:
    import pandas as pd

_BINS = 20


def histograms(table: pd.DataFrame) -> list[Axes]:
    """Draw histograms of D, v, S and Ca of the accepted collisions, broken on unbroken.

    Parameters
    ----------
    table : DataFrame
        Collisions.

    Returns
    -------
    list of Axes
        Four; what was never measured is said to be so.
    """
    table = table[table["accepted"].astype(bool)]
    broke = table["broke"].fillna(False).to_numpy(bool)
    names = ["area_um2", "speed_mm_s", "symmetry", "capillary_number"]
    area, speed, symmetry, capillary = table[names].to_numpy(np.float64).T
    quantities = {
        "$D$ (µm)": np.sqrt(4.0 * area / math.pi),
        "$v$ (mm/s)": speed,
        "$S$": symmetry,
        "Ca (10⁻³)": 1e3 * capillary,
    }
    with style.journal_style():
        panels = style.panels(None, style.TWO_COLUMNS, 2.0, ncols=4)
        for panel, (label, values) in zip(panels, quantities.items(), strict=True):
            measured = np.isfinite(values)
            panel.set_xlabel(label)
            if not measured.any():
                panel.set(xticks=[], yticks=[])
                panel.text(0.5, 0.5, "not measured", ha="center", transform=panel.transAxes)
                continue
            limits = (0.0, 1.0) if values is symmetry else None
            edges = np.histogram_bin_edges(values[measured], _BINS, limits).tolist()
            panel.hist(
                [values[measured & broke], values[measured & ~broke]],
                edges,
                stacked=True,
                color=[palette.BROKE, palette.UNBROKEN],
                label=["broke", "did not"],
            )
            panel.yaxis.set_major_locator(MaxNLocator(5, integer=True))
        panels[0].set_ylabel("collisions")
        named = panels[0].get_legend_handles_labels()
        panels[0].figure.legend(*named, loc="outside upper right", ncols=2)  # clear of the bars
    return panels


def diameters(areas_um2: NDArray[np.float64]) -> Axes:
    """Draw a histogram of the diameters of circles with some areas, shape (n,), in µm²."""
    with style.journal_style():
        panel = style.one_panel(2.0)
        panel.hist(np.sqrt(4.0 * areas_um2 / math.pi), _BINS, color=palette.UNBROKEN)
        panel.set(xlabel="$D$ (µm)", ylabel="droplets")
        panel.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    return panel


def timeline(table: pd.DataFrame) -> Axes:
    """Draw every collision as a stroke at its contact time, one line for each clip.

    Parameters
    ----------
    table : DataFrame
        Collisions with the column ``clip``.
    """
    clips = list(dict.fromkeys(table["clip"]))
    accepted = table["accepted"].to_numpy(bool)
    broke = table["broke"].fillna(False).to_numpy(bool)
    kinds = (
        ("broke", palette.BROKE, accepted & broke),
        ("did not", palette.UNBROKEN, accepted & ~broke),
        ("rejected", palette.REJECTED, ~accepted),
    )
    rows = np.array([clips.index(clip) for clip in table["clip"]], dtype=np.float64)
    times = table["contact_time_s"].to_numpy(np.float64)
    with style.journal_style():
        height = 0.9 + 0.18 * max(1, len(clips))
        (axes,) = style.panels(None, style.TWO_COLUMNS, height)
        for kind, colour, mask in kinds:
            axes.vlines(times[mask], rows[mask] - 0.4, rows[mask] + 0.4, colour, lw=1, label=kind)
        axes.set(xlabel="time of contact (s)", yticks=range(len(clips)), yticklabels=clips)
        axes.invert_yaxis()
        axes.margins(x=0.01)
        axes.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    return axes
