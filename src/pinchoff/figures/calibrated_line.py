"""The figures of a calibration: the objective over two constants, and the line it ends with."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.ticker import FixedLocator, LogLocator

from pinchoff.figures import style
from pinchoff.figures.plane import (
    CONTROL_PARAMETER,
    CRITICAL_SYMMETRY,
    logarithmic_axes,
    set_plain_ticks,
)
from pinchoff.studies.calibration.targets import CollisionsTarget
from pinchoff.support import palette

if TYPE_CHECKING:
    from pinchoff.model.gsd import Floats
    from pinchoff.studies.calibration.fitting import Calibration
    from pinchoff.studies.calibration.sensitivity import Landscape

_LABELS = {
    "edge_stiffness": r"edge stiffness $\tilde{k}_l$",
    "neck_separation": "arc threshold",
    "neck_thickness": "neck thickness ($D_0$)",
    "line_tension": r"line tension $\tilde{\gamma}$",
}
_START = palette.VERMILION
_BEST = palette.BLUE
_LOW = 0.08  # S: an axis that begins below it gets fewer ticks
_FEW_TICKS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)


def objective_landscape(
    landscape: Landscape, label: str = "objective", unit: str = "", axes: Axes | None = None
) -> Axes:
    """Draw the objective over two constants, with its value in every cell and the best set.

    Parameters
    ----------
    landscape : Landscape
    label : str, optional
        What the objective is.
    unit : str, optional
        Unit of the arc threshold, such as "(perimeter)".
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
    """
    with style.journal_style():
        axes = style.one_panel(3.1) if axes is None else axes
        norm = LogNorm(landscape.objective.min(), landscape.objective.max())
        edges = (_edges(landscape.x), _edges(landscape.y))
        mesh = axes.pcolormesh(
            *edges, landscape.objective, cmap=f"{palette.ORDERED_MAP}_r", norm=norm
        )
        _write_values(axes, landscape, norm)
        axes.plot(*landscape.best, "o", ms=17, mfc="none", mec=_START, mew=1.2)
        axes.set_title("ring: best set", loc="right", fontsize=7)
        axes.set_xscale("log")
        axes.set_yscale("log")
        for axis, name, values in (
            (axes.xaxis, landscape.names[0], landscape.x),
            (axes.yaxis, landscape.names[1], landscape.y),
        ):
            set_plain_ticks(axis, values.tolist(), ".2g")
            axis.set_tick_params(which="minor", length=0)
            measured_in = unit if name == "neck_separation" else ""
            axis.set_label_text(" ".join([_LABELS.get(name, name), measured_in]).strip())
        ticks = LogLocator(subs=(1.0, 2.0, 5.0))
        bar = axes.figure.colorbar(mesh, ax=axes, label=label, ticks=ticks, format="{x:g}")
        bar.ax.yaxis.set_minor_formatter("")
        return axes


def calibrated_line(calibration: Calibration, axes: Axes | None = None) -> Axes:
    """Draw S_c of the base and of the best set against Ca Ã z̃, with the target.

    A point above S = 1 means that not even a head-on droplet breaks there.

    Parameters
    ----------
    calibration : Calibration
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
    """
    control, target = calibration.control, calibration.target
    with style.journal_style():
        axes = style.one_panel(3.0) if axes is None else axes
        wide = np.geomspace(0.9 * control[0], 1.1 * control[-1], 100)
        if not isinstance(target, CollisionsTarget):
            axes.plot(wide, target.symmetry(wide), color="0.3", label=f"target: {target.name}")
        for evaluation, name, marker, color in (
            (calibration.start, "base", "s", _START),
            (calibration.best, "best set", "o", _BEST),
        ):
            label = f"{name}, {target.objective_name} {evaluation.objective:.3g}"
            values = evaluation.critical_symmetry
            face = "none" if name == "base" else color
            axes.plot(control, values, marker, ms=5, mfc=face, mec=color, label=label)
        axes.axhline(1.0, color="0.6", lw=0.6, ls=":", zorder=0)
        logarithmic_axes(axes, wide)
        if axes.get_ylim()[0] < _LOW:
            axes.yaxis.set_major_locator(FixedLocator(_FEW_TICKS))
        axes.set_xlabel(CONTROL_PARAMETER)
        axes.set_ylabel(CRITICAL_SYMMETRY)
        axes.legend(loc="upper center", bbox_to_anchor=(0.45, -0.17), labelspacing=0.3)
        return axes


def _edges(values: Floats) -> Floats:
    logs = np.log(values)
    middle = (logs[1:] + logs[:-1]) / 2
    ends = ([2 * logs[0] - middle[0]], middle, [2 * logs[-1] - middle[-1]])
    return np.asarray(np.exp(np.concatenate(ends)), dtype=np.float64)


def _write_values(axes: Axes, landscape: Landscape, norm: LogNorm) -> None:
    for j, y in enumerate(landscape.y):
        for i, x in enumerate(landscape.x):
            value = landscape.objective[j, i]
            color = "white" if float(norm(value)) > 0.55 else "black"
            text = f"{value:.2f}".removeprefix("0")
            axes.text(x, y, text, ha="center", va="center", fontsize=5.5, color=color)
