"""The share of collisions that break, against the breakup number."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from pinchoff.collisions.law import transition_factor
from pinchoff.figures import style
from pinchoff.figures.plane import set_plain_ticks
from pinchoff.fits.fractions import Fractions, broken_fractions, logarithmic_edges, merged_edges
from pinchoff.support import palette

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.fits import LawFit

_LAW, _STEP = palette.BLUE, palette.ORANGE
_NEAR = (0.3, 3.0)  # Bk of the inset
_PER_DECADE, _PER_DECADE_NEAR = 6, 20
_LOWEST = 1e-6  # Bk; below this the droplet has only grazed the obstacle
_FEWEST = 40  # collisions in a bin: bins with fewer are joined


def breakup_probability(table: pd.DataFrame, fit: LawFit, axes: Axes | None = None) -> Axes:
    """Draw N_break/N_total against Bk with binomial intervals, the sigmoid and the step.

    Parameters
    ----------
    table : DataFrame
        Checked collisions.
    fit : LawFit
        The fitted law: it gives Bk and the sigmoid curve.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import pinchoff as po
    >>> collisions = po.import_collisions(po.virtual_experiment(1, 400, symmetry_noise=0))
    >>> axes = breakup_probability(collisions.table, po.fit_law(collisions))
    >>> axes.get_xlabel()
    'breakup number Bk'
    """
    seen = table[table["symmetry"] > 0]
    number = fit.breakup_number(seen)
    broke = seen["broke"].to_numpy(dtype=bool)
    with style.journal_style():
        axes = style.one_panel(2.9) if axes is None else axes
        lowest = max(number.min(), _LOWEST)
        edges = logarithmic_edges(lowest, number.max(), _PER_DECADE)
        edges = merged_edges(number, edges, _FEWEST)
        _draw(axes, number, broke, fit, edges)
        axes.set_ylim(-0.04, 1.06)
        axes.set_xlabel("breakup number Bk")
        axes.set_ylabel(r"$N_\mathrm{break}/N_\mathrm{total}$")
        _title(axes, fit)
        inset = axes.inset_axes((0.14, 0.36, 0.42, 0.46))
        _draw(inset, number, broke, fit, logarithmic_edges(*_NEAR, _PER_DECADE_NEAR))
        inset.set_xlim(*_NEAR)
        set_plain_ticks(inset.xaxis, [0.3, 1.0, 3.0])
        inset.tick_params(labelsize=6)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.19), ncols=2, columnspacing=1.0)
        if fit.synthetic:
            style.mark_synthetic(axes, x=0.3, y=0.17)
        return axes


def draw_fractions(axes: Axes, found: Fractions, size: float, label: str) -> None:
    """Draw shares that broke with their intervals, as points of a size."""
    reach = np.stack([found.fraction - found.low, found.high - found.fraction])
    look: Any = {"color": palette.BLACK, "fmt": "o", "ms": size, "lw": 0.7, "label": label}
    axes.errorbar(found.middle, found.fraction, np.maximum(reach, 0.0), **look)


def _draw(
    axes: Axes,
    number: NDArray[np.float64],
    broke: NDArray[np.bool_],
    fit: LawFit,
    edges: NDArray[np.float64],
) -> None:
    axes.set_xscale("log")
    wide = np.geomspace(edges[0], edges[-1], 800)
    axes.plot(wide, wide > 1.0, color=_STEP, lw=1.0, label="step at Bk = 1")
    # Noise in S spreads the data wider than the curve, which is the law of the exact S.
    label = f"law, $w$ = {fit.w.value:.3g}" + (", exact $S$" if fit.symmetry_noise else "")
    axes.plot(wide, fit.probability(wide), color=_LAW, lw=1.4, label=label)
    found = broken_fractions(number, broke, edges, fit.confidence)
    draw_fractions(axes, found, 2, f"data, {fit.confidence:.0%}")
    axes.set_xlim(edges[0], edges[-1])


def _title(axes: Axes, fit: LawFit) -> None:
    if fit.w.value > 0:
        factor = f"{transition_factor(fit.w.value):.2f} in Bk"
    else:
        factor = f"{transition_factor(fit.w.high):.3g} in Bk at most"
    axes.set_title(f"5–95 % within a factor {factor}", loc="right", fontsize=7)
