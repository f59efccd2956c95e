"""The separating line: runs that broke and that did not, and the lines between them."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, PAPER_SIMULATION_LINE, Line
from pinchoff.collisions.schema import synthetic
from pinchoff.figures import style
from pinchoff.support.errors import InputError
from pinchoff.support.files import written_aside

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.gsd import Floats
    from pinchoff.studies.boundary.fit import LineFit
    from pinchoff.studies.boundary.search import Boundary

BROKE = "#009e73"
UNBROKEN = "#7b5ea7"
OURS = "#000000"

#: The paper's separating lines: line, name, colour and dashes.
PAPER_LINES = (
    (PAPER_SIMULATION_LINE, "paper, simulations", "#0072b2", (0, (4, 2))),
    (PAPER_EXPERIMENT_LINE, "paper, experiments", "#d55e00", (0, (1, 1.5))),
)
_LOWEST_SYMMETRY = 0.15
_MANY = 1000  # from so many on stars are smaller

# Seven and eight: together 56 looks before one comes back.
COLORS = ("#000000", "#0072b2", "#56b4e9", "#009e73", "#e69f00", "#d55e00", "#cc79a7")
MARKERS = "osD^vPX*"


def separating_line(
    boundary: Boundary,
    fit: LineFit | None = None,
    axes: Axes | None = None,
    *,
    measured: pd.DataFrame | None = None,
) -> Axes:
    """Draw S against Ca Ã z̃ on logarithmic axes, as the paper's overlay of its simulations.

    Stars are runs that touched the obstacle: filled where the droplet broke, open where it did
    not. A captured droplet did not break; runs without an outcome are left out.

    Parameters
    ----------
    boundary : Boundary
        What `pinchoff.boundary` returned.
    fit : LineFit, optional
        A line with p = 1 to draw with its interval, over the range that it was fitted on.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.
    measured : DataFrame, optional
        Collisions of an experiment to draw behind, as small points.

    Returns
    -------
    Axes
    """
    with style.journal_style():
        if axes is None:
            axes = _one_panel()
        control = _draw_runs(axes, boundary.runs)
        if measured is not None:
            _draw_measured(axes, measured)
        wide = np.geomspace(0.8 * control.min(), 1.25 * control.max(), 200)
        for line, name, color, dashes in PAPER_LINES:
            label = f"{name}: {_formula(line)}"
            axes.plot(wide, line.alpha * wide**line.beta, color=color, ls=dashes, label=label)
        if fit is not None:
            _draw_fit(axes, fit)
        logarithmic_axes(axes, wide)
        axes.set_xlabel(r"Ca $\tilde{A}\,\tilde{z}$")
        axes.set_ylabel("symmetry $S$")
        axes.set_ylim(_LOWEST_SYMMETRY, 1.1)
        axes.legend(loc="upper center", bbox_to_anchor=(0.43, -0.19), labelspacing=0.3)
        return axes


def area_collapse(boundary: Boundary, axes: Sequence[Axes] | None = None) -> list[Axes]:
    """Draw how far one line serves several size ratios: with Ã, and with Ã to its best power.

    Parameters
    ----------
    boundary : Boundary
        With several values of the size ratio and of the simulation capillary number.
    axes : sequence of 2 Axes, optional
        Where to draw; by default a new figure across two columns.

    Returns
    -------
    list of 2 Axes

    Raises
    ------
    InputError
        The boundary does not decide the exponent of Ã.
    """
    fits = [boundary.fit(), boundary.fit(free_area=True)]
    with style.journal_style():
        if axes is None:
            figure = Figure(figsize=(style.TWO_COLUMNS, 2.9), layout="constrained")
            axes = list(figure.subplots(1, 2, sharey=True))
        for panel, fit in zip(axes, fits, strict=True):
            _draw_collapse(panel, boundary.found, fit)
        axes[0].set_ylabel("critical symmetry $S_c$")
        axes[1].legend(title="$D_0/R$", loc="center left", bbox_to_anchor=(1.01, 0.5))
        return list(axes)


def write_figure(path: str | os.PathLike[str], axes: Axes) -> None:
    """Write the figure of some axes as a picture, complete or not at all."""
    figure = axes.figure
    assert isinstance(figure, Figure)
    with written_aside(Path(path)) as unfinished:
        figure.savefig(unfinished, dpi=style.DOTS_PER_INCH)


def _one_panel() -> Axes:
    figure = Figure(figsize=(style.ONE_COLUMN, 3.7), layout="constrained")
    return figure.subplots()


def _draw_runs(axes: Axes, runs: pd.DataFrame) -> Floats:
    """Draw a star for each run that touched, and return Ca Ã z̃ of all of them."""
    control = runs["capillary_number"] * runs["normalized_area"] * runs["normalized_thickness"]
    touched = runs["symmetry"].notna() & runs["broke"].notna()
    if not touched.any():
        raise InputError.of(
            "boundary", "one with contacts", "runs that never touched", "start nearer to head-on"
        )
    broke = runs["broke"].fillna(False).astype(bool)
    for which, color, label in (
        (touched & broke, BROKE, "breaks"),
        (touched & ~broke, UNBROKEN, "does not break"),
    ):
        axes.plot(
            control[which],
            runs.loc[which, "symmetry"],
            ls="none",
            marker="*",
            ms=4 if len(runs) < _MANY else 2.5,
            mew=0.5 if len(runs) < _MANY else 0.3,
            mfc=color if label == "breaks" else "white",
            mec=color,
            label=label,
        )
    return np.asarray(control[touched])


def _draw_measured(axes: Axes, measured: pd.DataFrame) -> None:
    """Draw collisions of an experiment as a faint layer of points."""
    groups = ("capillary_number", "normalized_area", "normalized_thickness")
    forcing = np.prod([measured[name].to_numpy() for name in groups], axis=0)
    colors = np.where(measured["broke"].to_numpy(dtype=bool), BROKE, UNBROKEN)
    axes.scatter(
        forcing, measured["symmetry"], s=1.5, c=colors, alpha=0.3, linewidths=0, rasterized=True
    ).set_zorder(0.5)
    if synthetic(measured):
        style.mark_synthetic(axes, x=0.03)


def _draw_fit(axes: Axes, fit: LineFit) -> None:
    control = np.geomspace(*fit.control_range, 100)
    value, low, high = fit.symmetry(control)
    label = f"here: {_formula(fit.line)}"
    band = f"its {fit.confidence:.0%} interval"
    axes.plot(control, value, color=OURS, label=label, zorder=2.5)
    axes.fill_between(control, low, high, color=OURS, alpha=0.2, lw=0, zorder=2.2, label=band)


def _draw_collapse(axes: Axes, rows: pd.DataFrame, fit: LineFit) -> None:
    power = fit.area_exponent.value
    free = fit.coefficients.size == 3
    forcing = rows["capillary_number"] * rows["normalized_thickness"]
    scaled = forcing * rows["normalized_area"] ** power
    for k, (ratio, group) in enumerate(rows.groupby("size_ratio")):
        axes.plot(
            scaled[group.index],
            group["critical_symmetry"],
            ls="none",
            marker=MARKERS[k % len(MARKERS)],
            ms=3.5,
            color=COLORS[k % len(COLORS)],
            label=f"{ratio:g}",
        )
    wide = np.geomspace(0.9 * scaled.min(), 1.1 * scaled.max(), 50)
    axes.plot(wide, fit.alpha.value * wide**fit.beta.value, color="0.4", lw=0.8, zorder=1)
    logarithmic_axes(axes, wide)
    exponent = rf"^{{\,{power:.2f}}}" if free else ""
    axes.set_xlabel(rf"Ca $\tilde{{A}}{exponent}\,\tilde{{z}}$")
    said = f"$\\beta$ = {signed(fit.beta.value)}, rms distance {fit.scatter:.1%}"
    if free:
        p = fit.area_exponent
        said = f"$p$ = {p.value:.2f} ({p.low:.2f} to {p.high:.2f})\n{said}"
    axes.text(0.97, 0.96, said, ha="right", va="top", transform=axes.transAxes, fontsize=7)


def _formula(line: Line) -> str:
    return rf"{line.alpha:.3f} (Ca $\tilde{{A}}\tilde{{z}}$)$^{{{line.beta:.2f}}}$"


def signed(value: float, digits: int = 2) -> str:
    """Write a number with a true minus sign."""
    return f"{value:.{digits}f}".replace("-", "\N{MINUS SIGN}")


def logarithmic_axes(axes: Axes, span: Floats) -> None:
    """Scale both axes logarithmically, x over a span, with ticks written as plain numbers.

    The y axis is one of symmetries.
    """
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(span[0], span[-1])
    for axis, ticks in (
        (axes.xaxis, _plain_ticks(span[0], span[-1])),
        (axes.yaxis, [0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0]),
    ):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _plain_ticks(low: float, high: float) -> list[float]:
    """Return 1, 2 and 5 of each decade, or 1 alone where those are many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = (1, 2, 5) if math.log10(high / low) < 2.5 else (1,)
    return [float(f"{step}e{decade}") for decade in decades for step in steps]
