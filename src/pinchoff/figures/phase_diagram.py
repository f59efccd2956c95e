"""Three figures of S against Ca Ã z̃: where collisions break, and where they do not.

They are `phase_diagram` of very many collisions, `separating_line` of a simulated
boundary, and `separated_outcomes`, which shows the collisions of a fitted law by what came of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import Normal, Stroke

from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, PAPER_SIMULATION_LINE
from pinchoff.collisions.schema import synthetic
from pinchoff.figures import style
from pinchoff.figures.plane import (
    CONTROL_PARAMETER,
    OUTCOMES,
    SYMMETRY,
    draw_line,
    draw_outcomes,
    formula,
    logarithmic_axes,
    mark_size,
)
from pinchoff.support import palette
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted, numeral

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from pinchoff.collisions.importing import ImportedCollisions
    from pinchoff.fits import LawFit
    from pinchoff.studies.boundary.line_fit import LineFit
    from pinchoff.studies.boundary.search import Boundary
    from pinchoff.studies.sweep.summary import Points

#: The paper's separating lines: line, name, colour and dashes.
PAPER_LINES = (
    (PAPER_SIMULATION_LINE, "paper, simulations", palette.SIMULATION_LINE, (0, (4, 2))),
    (PAPER_EXPERIMENT_LINE, "paper, experiments", palette.EXPERIMENT_LINE, (0, (1, 1.5))),
)

_GROUPS = ("capillary_number", "normalized_area", "normalized_thickness")
_GRAZING = 0.02  # S: from here on down a droplet only grazes the obstacle


def phase_diagram(
    collisions: Points | pd.DataFrame | ImportedCollisions | Boundary, axes: Axes | None = None
) -> Axes:
    """Draw S against Ca Ã z̃, both logarithmic, with the paper's separating lines.

    Parameters
    ----------
    collisions : Points, DataFrame, ImportedCollisions or Boundary
        The collisions, one at least, as any table has them: rows that are not accepted, or without
        outcome, are left out. If `Points` are a sample of more, the picture says so.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
        Their figure is ``axes.figure``.

    Raises
    ------
    InputError
        No collision can be drawn.

    Examples
    --------
    >>> import pinchoff as po
    >>> axes = phase_diagram(po.simulate_many([po.Parameters(offset=0.1)]))
    >>> axes.get_title("right")
    '1 collision'
    """
    points = points_of(collisions)
    with style.journal_style():
        axes = style.one_panel(3.4) if axes is None else axes
        span = np.array([points.forcing.min() / 1.2, points.forcing.max() * 1.2])
        logarithmic_axes(axes, span, (_lowest_symmetry(points), 1.15))
        draw_outcomes(axes, points.forcing, points.symmetry, points.broke)
        for line, name, color, dashes in PAPER_LINES:
            # a white rim, so that the line is seen among many marks
            halo = [Stroke(linewidth=2.4, foreground="white"), Normal()]
            draw_line(axes, line, span, color=color, ls=dashes, label=name, path_effects=halo)
        axes.set_xlabel(CONTROL_PARAMETER)
        axes.set_ylabel(SYMMETRY)
        _legend_below(axes, ncols=2, columnspacing=1.2)
        axes.set_title(_how_many(points, axes.get_ylim()[0]), loc="right", fontsize=7)
    return axes


def points_of(collisions: Points | pd.DataFrame | ImportedCollisions | Boundary) -> Points:
    """Return the collisions of any table in the plane of the break-up law.

    Raises
    ------
    InputError
        It is no table with the columns of the law, or none of its rows can be drawn.
    """
    from pinchoff.studies.sweep.summary import Points

    if isinstance(collisions, Points):
        return collisions
    table = _table_of(collisions)
    forcing = _control_parameter(table)
    symmetry = table["symmetry"].to_numpy(dtype=np.float64)
    broke = table["broke"].to_numpy(dtype=np.float64, na_value=math.nan)
    seen = (forcing > 0) & (symmetry > 0) & np.isfinite(forcing * broke)
    if "accepted" in table:
        seen &= table["accepted"].to_numpy(dtype=bool)
    if not seen.any():
        rule = "collisions of which one at least is accepted, with an outcome and S > 0"
        raise InputError.of("collisions", rule, f"{len(table)} others", "see reject_reason")
    return Points(forcing[seen], symmetry[seen], broke[seen] > 0, int(seen.sum()))


def _table_of(collisions: pd.DataFrame | ImportedCollisions | Boundary) -> pd.DataFrame:
    """Return the table of a result, or the table itself."""
    table: Any = getattr(collisions, "runs", None)
    table = getattr(collisions, "table", collisions) if table is None else table
    needed = (*_GROUPS, "symmetry", "broke")
    missing = [name for name in needed if name not in getattr(table, "columns", ())]
    if missing:
        got = f"{type(collisions).__name__} without {', '.join(missing)}"
        advice = "read it with pinchoff.import_collisions, which finds or computes them"
        raise InputError.of("collisions", "a table of collisions", got, advice)
    found: pd.DataFrame = table
    return found


def separating_line(
    boundary: Boundary | pd.DataFrame | ImportedCollisions,
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
    boundary : Boundary, DataFrame or ImportedCollisions
        What `pinchoff.boundary` returned, or any table of collisions.
    fit : LineFit, optional
        A line with p = 1 to draw with its interval, over the range that it was fitted on.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.
    measured : DataFrame, optional
        Collisions of an experiment to draw behind, as small points.

    Returns
    -------
    Axes

    Raises
    ------
    InputError
        No run touched the obstacle.
    """
    runs = _table_of(boundary)
    runs = runs[runs["symmetry"].notna() & runs["broke"].notna()]
    if runs.empty:
        got, advice = "runs that never touched", "start nearer to head-on"
        raise InputError.of("boundary", "one with contacts", got, advice)
    control, broke = _control_parameter(runs), runs["broke"].to_numpy(dtype=bool)
    span = np.array([0.8 * control.min(), 1.25 * control.max()])
    with style.journal_style():
        axes = style.one_panel(3.9 if measured is None else 4.2) if axes is None else axes
        logarithmic_axes(axes, span, (0.15, 1.1))
        draw_outcomes(axes, control, runs["symmetry"].to_numpy(), broke, marker="*")
        if measured is not None:
            _draw_measured(axes, measured)
        for line, name, color, dashes in PAPER_LINES:
            draw_line(axes, line, span, color=color, ls=dashes, label=f"{name}: {formula(line)}")
        if fit is not None:
            _draw_interval(axes, fit)
        axes.set_xlabel(CONTROL_PARAMETER)
        axes.set_ylabel(SYMMETRY)
        _legend_below(axes)
        return axes


def separated_outcomes(
    table: pd.DataFrame, fit: LawFit, axes: Sequence[Axes] | None = None
) -> list[Axes]:
    """Draw collisions as the paper splits them, broke, both, did not, with the separating line.

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

    Examples
    --------
    >>> import pinchoff as po
    >>> collisions = po.import_collisions(po.virtual_experiment(1, 400, symmetry_noise=0))
    >>> panels = separated_outcomes(collisions.table, po.fit_law(collisions))
    >>> [panel.get_title("left").split(":")[0] for panel in panels]
    ['breaks', 'both', 'does not break']
    """
    seen = table[table["symmetry"] > 0]
    symmetry = seen["symmetry"].to_numpy()
    broke = seen["broke"].to_numpy(dtype=bool)
    # Bk = Ca Ã z̃ (S/α)^(-1/β) with the fitted exponents, so the product is Ca Ã z̃ with them.
    forcing = fit.breakup_number(seen) * (symmetry / fit.line.alpha) ** (1.0 / fit.line.beta)
    with style.journal_style():
        shared = {"ncols": 3, "sharex": True, "sharey": True}
        panels = style.panels(axes, style.TWO_COLUMNS, 2.85, **shared)
        span = np.array([forcing.min() / 1.3, forcing.max() * 1.3])
        shown = (("breaks", broke), ("both", np.ones_like(broke)), ("does not break", ~broke))
        for panel, (title, which) in zip(panels, shown, strict=True):
            logarithmic_axes(panel, span, (_GRAZING, 1.25))
            size = mark_size(len(seen))
            draw_outcomes(panel, forcing[which], symmetry[which], broke[which], size=size)
            for line, name, color, dashes in (
                (fit.line, "fit", palette.FITTED_LINE, "--"),
                (PAPER_EXPERIMENT_LINE, "paper", palette.EXPERIMENT_LINE, "-"),
            ):
                label = f"{name}: $S_c$ = {formula(line)}"
                draw_line(panel, line, span, color=color, ls=dashes, lw=1, label=label)
            panel.set_title(f"{title}: {int(which.sum()):,}", loc="left")
            panel.set_xlabel(_scaled_parameter(fit))
        panels[0].set_ylabel(SYMMETRY)
        named = panels[1].get_legend_handles_labels()
        panels[0].figure.legend(*named, loc="outside upper left", ncols=2)
        _say_what_is_missing(panels[0], table, fit)
        return panels


def _legend_below(axes: Axes, **look: Any) -> None:
    axes.figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center", labelspacing=0.3, **look
    )


def _control_parameter(table: pd.DataFrame) -> NDArray[np.float64]:
    return np.asarray(np.prod([table[name].to_numpy(np.float64) for name in _GROUPS], axis=0))


def _lowest_symmetry(points: Points) -> float:
    """Return where the axis begins: well below every S that broke, and below the paper's lines."""
    broke = points.symmetry[points.broke]
    broke = broke[broke > 0]
    ends = [line.alpha * points.forcing.max() ** line.beta for line, *_ in PAPER_LINES]
    return float(min([2.5 * _GRAZING, *(0.5 * broke), *(0.5 * np.array(ends))]))


def _how_many(points: Points, lowest: float) -> str:
    """Say how many collisions there are, and what is not shown of them."""
    drawn, population = len(points.symmetry), points.population
    sample = "" if drawn == population else f"random {drawn:,} of "
    below = int((points.symmetry < lowest).sum())
    return f"{sample}{counted(population, 'collision')}" + (
        f"; {below:,} below $S$ = {lowest:.2g}" if below else ""
    )


def _draw_measured(axes: Axes, measured: pd.DataFrame) -> None:
    """Draw collisions of an experiment as a faint layer of points."""
    broke = measured["broke"].to_numpy(dtype=bool)
    control, symmetry = _control_parameter(measured), measured["symmetry"].to_numpy()
    drawn = synthetic(measured)
    look: dict[str, Any] = {"marker": ".", "ls": "none", "mew": 0}
    for kind, color, label in OUTCOMES:
        place = control[broke == kind], symmetry[broke == kind]
        axes.plot(*place, ms=1.8, color=color, alpha=0.4, zorder=0.5, rasterized=True, **look)
        label = f"{'synthetic' if drawn else 'measured'}, {label}"
        axes.plot([], [], ms=4, color=color, alpha=0.6, label=label, **look)
    if drawn:
        axes.set_title("small points: synthetic data", loc="right", fontsize=7)


def _draw_interval(axes: Axes, fit: LineFit) -> None:
    control = np.geomspace(*fit.control_range, 100)
    value, low, high = fit.symmetry(control)
    color, band = palette.FITTED_LINE, f"its {fit.confidence:.0%} interval"
    axes.plot(control, value, color=color, label=f"here: {formula(fit.line)}", zorder=2.5)
    axes.fill_between(control, low, high, color=color, alpha=0.2, lw=0, zorder=2.2, label=band)


def _scaled_parameter(fit: LawFit) -> str:
    """Write Ca Ã z̃ with the exponents that were left free."""
    powers = {"area": "", "thickness": ""}
    for name, key in (("area", "epsilon_1"), ("thickness", "epsilon_3")):
        if name in fit.free:
            powers[name] = rf"^{{\,{numeral(fit.estimates[key].value)}}}"
    return rf"Ca $\tilde{{A}}{powers['area']}\,\tilde{{z}}{powers['thickness']}$"


def _say_what_is_missing(axes: Axes, table: pd.DataFrame, fit: LawFit) -> None:
    below = int((table["symmetry"] < _GRAZING).sum())
    text = f"{below:,} more below $S$ = {_GRAZING}" if below else ""
    axes.text(0.03, 0.03, text, transform=axes.transAxes, fontsize=6.5)
    if fit.synthetic:
        style.mark_synthetic(axes, x=0.03, y=0.1)
