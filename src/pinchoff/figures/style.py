"""The one look of all figures: sizes and fonts of a two-column journal, colours that stay apart.

Line colours are from the palette of Okabe and Ito, which readers with any colour vision can tell
apart; the droplets are pink with a dark rim, as under the microscope.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

import matplotlib as mpl
from cycler import cycler
from matplotlib.axes import Axes

#: Widths of a figure [inch]: one column (8.3 cm), and across both (17.1 cm).
ONE_COLUMN = 3.27
TWO_COLUMNS = 6.73

#: Resolution of written pictures [dots per inch].
DOTS_PER_INCH = 300

DROPLET = "#f2a6bd"
DROPLET_RIM = "#40202c"
FLUID = "#eeeeec"
OBSTACLE = "#4d4d4d"
INK = "#1a1a1a"
NECK = "#d55e00"
CENTRELINE = "#0072b2"

STYLE: dict[str, Any] = {
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": cycler(
        color=["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]
    ),
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
    "text.color": INK,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
}


def mark_synthetic(axes: Axes, x: float = 0.98, y: float = 0.03) -> None:
    """Write at a place in the axes that what they show was not measured."""
    axes.text(
        x,
        y,
        "synthetic data",
        transform=axes.transAxes,
        ha="right" if x > 0.5 else "left",
        fontsize=6.5,
        fontstyle="italic",
        color="#d55e00",
        zorder=9,
    )


def journal_style(font_size: float = STYLE["font.size"]) -> AbstractContextManager[None]:
    """Return a context in which figures take the look of this package; font size in points."""
    settings: Any = {**STYLE, "font.size": font_size}  # matplotlib lists its keys as literals
    return mpl.rc_context(settings)
