"""Figures of many droplets in an array: the droplets, their sizes, rates, contacts and lineage."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, Normalize
from matplotlib.patches import Circle
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.collisions.law import breakup_probability
from pinchoff.figures import style
from pinchoff.figures.breakup_probability import draw_fractions
from pinchoff.figures.scene import smooth_outline
from pinchoff.fits.fractions import broken_fractions, logarithmic_edges, merged_edges
from pinchoff.studies.isolated_pillar import relative_breakup_number
from pinchoff.studies.lineage import ancestors
from pinchoff.support import palette
from pinchoff.support.numerals import counted
from pinchoff.support.paper_constants import WIDTH

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from pinchoff.model.arrays import PillarArray
    from pinchoff.model.outlines import Outline
    from pinchoff.studies.emulsion_sizes import SizeStudy

_MEMBERS = 60  # of a family; more cannot be told apart
_FEWEST = 20  # contacts in a bin; bins with fewer are joined
_LEAST_CONTACT, _LEAST_CLOCK = 1e-3, 1e-4  # shorter ones, or emptier, are drawn here
_LEAST_NUMBER = 1e-3  # Bk: a droplet below it has only grazed the pillar


def droplets_in_array(
    droplets: Sequence[Outline],
    array: PillarArray,
    time: float,
    color: Literal["generation", "size"] = "generation",
    periodic: str = "y",
) -> Axes:
    """Draw the droplets of one frame, at a time in t0, among the pillars.

    A colour is the number of break-ups in a droplet's ancestry, or its diameter. `periodic` are
    the axes along which the cell repeats itself.
    """
    with style.journal_style():
        wide = style.TWO_COLUMNS
        height = min(8.0, 0.86 * wide * array.width / array.length + 0.5)
        (axes,) = style.panels(None, wide, height)
        draw_pillars(axes, array, periodic)
        if color == "generation":
            values = np.array([droplet.generation for droplet in droplets], dtype=np.float64)
            norm: Normalize = BoundaryNorm(np.arange(-0.5, max(values, default=0) + 1), 256)
            said = "break-ups in its ancestry"
        else:
            values = np.array([diameter_of(droplet.vertices) for droplet in droplets])
            norm, said = Normalize(0.0, max(values, default=1.0)), "diameter ($D_0$)"
        colors = ScalarMappable(norm, palette.ORDERED_MAP)
        axes.add_collection(droplet_shapes(droplets, array, periodic, colors.to_rgba(values)))
        axes.set(xlabel="$x$ ($D_0$)", ylabel="$y$ ($D_0$)", title=f"$t$ = {time:.4g} $t_0$")
        bar = axes.figure.colorbar(colors, ax=axes, label=said, fraction=0.03, pad=0.01)
        if color == "generation":
            bar.set_ticks(np.arange(0, max(values, default=0) + 1).tolist())
            bar.minorticks_off()
        return axes


def draw_pillars(axes: Axes, array: PillarArray, periodic: str) -> None:
    """Draw the fluid and the pillars of a cell, with those that reach in across its edges."""
    axes.set_facecolor(palette.FLUID)
    for x, y, radius in array.circles:
        for shift in _images(array, periodic):
            circle = Circle((x + shift[0], y + shift[1]), radius, color=palette.OBSTACLE, lw=0)
            axes.add_patch(circle)
    axes.set(xlim=(0, array.length), ylim=(0, array.width), aspect="equal")


def droplet_shapes(
    droplets: Sequence[Outline],
    array: PillarArray,
    periodic: str,
    shades: NDArray[np.float64],
    rim: float = 0.5,
) -> PolyCollection:
    """Return droplets as smooth shapes, with those that reach in across the cell's edges.

    Each has its colour, (n, 4), and a rim in points.
    """
    size = np.array([array.length, array.width])
    shapes, colors = [], []
    for droplet, shade in zip(droplets, shades, strict=True):
        outline = smooth_outline(droplet.vertices)
        low, high = outline.min(axis=0), outline.max(axis=0)
        for shift in _images(array, periodic):
            if ((high + shift > 0) & (low + shift < size)).all():
                shapes.append(outline + shift)
                colors.append(shade)
    return PolyCollection(
        shapes, facecolors=colors, edgecolors=palette.DROPLET_RIM, linewidths=rim, zorder=2
    )


def _images(array: PillarArray, periodic: str) -> NDArray[np.float64]:
    """Return by how much what is in the cell is moved to be seen across its edges, (n, 2)."""
    along = (-1, 0, 1) if "x" in periodic else (0,)
    across = (-1, 0, 1) if "y" in periodic else (0,)
    return np.array([(i * array.length, j * array.width) for i in along for j in across])


def sizes_over_time(sizes: pd.DataFrame, study: SizeStudy) -> Axes:
    """Draw the distribution of diameters against time, by area, and its means."""
    with style.journal_style():
        (axes,) = style.panels(None, style.TWO_COLUMNS, 2.5)
        times = study.series["time"].to_numpy(np.float64)
        at = np.linspace(times[0], times[-1], min(len(times), 80) + 1)
        d = sizes["diameter"].to_numpy(np.float64)
        t = sizes["time"].to_numpy(np.float64)
        found, *_ = np.histogram2d(t, d, (at, study.edges), weights=d**2)
        share = found / np.maximum(found.sum(axis=1, keepdims=True), 1e-300)
        image = axes.pcolormesh(at, study.edges, share.T, cmap="Greys", rasterized=True)
        axes.figure.colorbar(image, ax=axes, label="share of the area", pad=0.01)
        axes.plot(times, study.series["mean_diameter"], color=palette.BLUE, label="mean")
        weighted = study.series["weighted_diameter"]
        axes.plot(times, weighted, color=palette.VERMILION, label="mean, weighted by area")
        axes.axvline(study.start, color=palette.INK, lw=0.8, ls=":")
        axes.set(xlabel="time ($t_0$)", ylabel="diameter ($D_0$)", xlim=(0, times[-1]))
        axes.legend(loc="lower right", ncols=2)
        return axes


def size_distribution(study: SizeStudy) -> Axes:
    """Draw the distribution of diameters, by number and by area, with standard errors."""
    with style.journal_style():
        axes = style.one_panel(2.5)
        middle = 0.5 * (study.edges[1:] + study.edges[:-1])
        for density, color, said in (
            (study.by_number, palette.BLUE, "by number"),
            (study.by_area, palette.VERMILION, "by area"),
        ):
            axes.stairs(density[:, 0], study.edges, color=color, label=said)
            axes.errorbar(middle, density[:, 0], density[:, 1], fmt="none", color=color, lw=0.8)
        axes.set(xlabel="diameter ($D_0$)", ylabel="density ($1/D_0$)", xlim=(0, study.edges[-1]))
        axes.set_ylim(bottom=0)
        axes.legend(loc="upper left")
        return axes


def sizes_over_sweep(table: pd.DataFrame, varied: Sequence[str]) -> Axes:
    """Draw the mean diameter and that weighted by area, D0, against what was varied.

    The table has a row a run. The first of the varied keys with numbers is along x, and there is
    a line for each combination of the others.
    """
    with style.journal_style():
        panels = style.panels(None, style.TWO_COLUMNS, 2.6, ncols=2, sharey=True)
        along = next((name for name in varied if table[name].dtype.kind in "if"), None)
        others = [name for name in varied if name != along]
        groups = table.groupby(others, sort=False) if others else [((), table)]
        names = {"mean_diameter": "mean", "weighted_diameter": "weighted by area"}
        for (name, said), axes in zip(names.items(), panels, strict=True):
            for (chosen, rows), color in zip(groups, itertools.cycle(palette.CATEGORIES)):
                x = np.arange(len(rows)) if along is None else rows[along].to_numpy(np.float64)
                error = np.nan_to_num(rows[f"{name}_error"].to_numpy(np.float64))
                label = ", ".join(f"{k} = {v}" for k, v in zip(others, chosen, strict=True))
                look: Any = {"fmt": "o-", "ms": 3, "lw": 0.8, "color": color}
                axes.errorbar(x, rows[name], error, label=label or None, **look)
            axes.set(xlabel=along or "run", ylabel=f"diameter, {said} ($D_0$)")
            axes.set_ylim(bottom=0)
        if others:
            panels[0].legend(fontsize="small")
        return panels[0]


_RATED = {"entered": "entered", "breakup": "broke", "left": "left", "merge": "merged"}


def rated_events(events: pd.DataFrame) -> pd.Series[bool]:
    """Tell which events `rates_over_time` draws."""
    return events["kind"].astype(str).isin(_RATED)


def rates_over_time(events: pd.DataFrame, study: SizeStudy, bins: int = 24) -> Axes:
    """Draw what happens per t0 against time."""
    with style.journal_style():
        axes = style.one_panel(2.5)
        end = study.end
        edges = np.linspace(0.0, end, bins + 1)
        kinds = events["kind"].astype(str)
        for (kind, said), color in zip(_RATED.items(), palette.CATEGORIES, strict=False):
            times = events["time"][kinds == kind]
            if len(times):
                counts = np.histogram(times, edges)[0] / np.diff(edges)
                axes.stairs(counts, edges, color=color, label=said, lw=1.2)
        axes.axvline(study.start, color=palette.INK, lw=0.8, ls=":")
        axes.set(xlabel="time ($t_0$)", ylabel="droplets per $t_0$", xlim=(0, end))
        axes.set_ylim(bottom=0)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper left", ncols=4, bbox_to_anchor=(0, 1.15), columnspacing=1.0)
        return axes


def contact_breakups(contacts: pd.DataFrame, isolated: pd.DataFrame | None = None) -> Axes:
    """Draw the share of contacts, of `contact_outcomes`, that broke the droplet against Bk.

    With `isolated`, of `isolated_pillar`, a second panel has Bk over that of a pillar alone in the
    same flow, for a droplet of the same diameter. Returns the first panel.
    """
    columns, wide = (1, style.ONE_COLUMN) if isolated is None else (2, style.TWO_COLUMNS)
    with style.journal_style():
        axes = style.panels(None, wide, 2.5, ncols=columns)
        seen = contacts[contacts["settled"] & (contacts["breakup_number"] > _LEAST_NUMBER)]
        broke = seen["broke"].to_numpy(bool)
        number = seen["breakup_number"].to_numpy(np.float64)
        _broken_shares(axes[0], number, broke, "isolated collisions (paper)")
        axes[0].set(xlabel="breakup number Bk at contact", ylabel="share that broke")
        if isolated is not None:
            relative = relative_breakup_number(seen, isolated)
            known = np.isfinite(relative) & (relative > _LEAST_NUMBER)
            alone = "a pillar alone, this flow"
            _broken_shares(axes[1], relative[known], broke[known], alone)
            axes[1].set(xlabel="Bk over that of a pillar alone in this flow")
        return axes[0]


def _broken_shares(
    axes: Axes, number: NDArray[np.float64], broke: NDArray[np.bool_], law: str
) -> None:
    wide = np.geomspace(_LEAST_NUMBER, max(10.0, number.max(initial=1.0)), 400)
    axes.plot(wide, breakup_probability(wide, WIDTH), color=palette.BLUE, label=law)
    if len(number):
        edges = logarithmic_edges(number.min(), number.max(), 6)
        found = broken_fractions(number, broke, merged_edges(number, edges, _FEWEST))
        draw_fractions(axes, found, 2.5, f"{counted(len(number), 'contact')}, 95 %")
    axes.set(xscale="log", ylim=(-0.04, 1.3))
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.legend(loc="upper left")


def pair_contacts(events: pd.DataFrame) -> Axes:
    """Draw the contacts of two droplets that have ended: their duration and their clock."""
    with style.journal_style():
        axes = style.one_panel(2.5)
        axes.set(xscale="log", yscale="log")  # first: no contact has limits that suit it
        kinds = events["kind"].astype(str)
        for kind, said, color in (
            ("parted", "parted", palette.BLUE),
            ("merge", "merged", palette.VERMILION),
        ):
            ended = events[kinds == kind]
            lasted = np.maximum(ended["time"] - ended["since"], _LEAST_CONTACT)
            clock = np.maximum(ended["clock"], _LEAST_CLOCK)
            label = f"{said}: {len(ended)}"
            axes.plot(lasted, clock, ".", ms=3, color=color, alpha=0.6, mew=0, label=label)
        axes.axhline(1.0, color=palette.INK, lw=0.8, ls=":")
        axes.set(xlabel="duration of the contact ($t_0$)", ylabel="clock $C$ at its end")
        axes.legend(loc="lower right", markerscale=3)
        return axes


def lineage_tree(family: pd.DataFrame, end: float) -> Axes:
    """Draw the droplet with the most descendants, and the first of them: time along, a line each.

    The family is one of `lineage`, and the run ends at `end`, t0.
    """
    with style.journal_style():
        axes = style.one_panel(2.5)
        axes.set(xlabel="time ($t_0$)", yticks=[])
        axes.spines[["left", "top", "right"]].set_visible(False)
        eldest = [next(reversed([*ancestors(family, k)]), k) for k in family.index]
        if not eldest:
            return axes
        counts = Counter(eldest)
        first = max(counts, key=lambda k: (counts[k], -k))
        members = family[np.array(eldest) == first].head(_MEMBERS)  # by birth
        heights = _heights(members, int(first))
        merged = members[members["other_parent"] >= 0]
        joined = dict(zip(merged["other_parent"].tolist(), merged.index.tolist(), strict=True))
        for number, row in zip(members.index.tolist(), members.to_dict("records"), strict=True):
            y, born = heights[int(number)], 0.0 if math.isnan(row["born"]) else row["born"]
            ended = end if math.isnan(row["ended"]) else row["ended"]
            size = 1.0 if math.isnan(row["area"]) else math.sqrt(4 / math.pi * row["area"])
            axes.plot([born, ended], [y, y], color=palette.BLUE, lw=3 * size)
            if row["parent"] in heights:
                axes.plot([born, born], [heights[int(row["parent"])], y], color=palette.INK, lw=0.6)
            if joined.get(number) in heights:
                target = heights[joined[number]]
                axes.plot([ended, ended], [y, target], color=palette.INK, lw=0.6, ls=":")
            if row["fate"] == "left":
                axes.plot(ended, y, ">", color=palette.GREY, ms=3)
        return axes


def _heights(members: pd.DataFrame, first: int) -> dict[int, float]:
    """Give each droplet a height: in turn, or in the middle of its daughters where it has some."""
    daughters: dict[int, list[int]] = {int(k): [] for k in members.index}
    for number, parent in members["parent"].items():
        if parent in daughters:
            daughters[int(parent)].append(int(str(number)))
    order, stack = [], [first]
    while stack:
        order.append(stack.pop())
        stack += daughters[order[-1]]
    leaves = [k for k in order if not daughters[k]]
    heights = {k: float(place) for place, k in enumerate(leaves)}
    for k in reversed(order):
        if daughters[k]:
            heights[k] = float(np.mean([heights[d] for d in daughters[k]]))
    return heights


def diameter_of(vertices: NDArray[np.float64]) -> float:
    """Return the diameter of the circle of equal area."""
    return math.sqrt(4 / math.pi * abs(_core.area(vertices)))
