"""Figures of many droplets in an array: the droplets, their sizes, rates, contacts and lineage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from pinchoff.collisions.law import breakup_probability
from pinchoff.figures import style
from pinchoff.figures.scene import smooth_outline
from pinchoff.fits.fractions import broken_fractions, logarithmic_edges, merged_edges
from pinchoff.studies.emulsion_sizes import ancestors
from pinchoff.support import palette
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
_LEAST_NUMBER = 1e-3  # Bk; below it a droplet has only grazed the pillar


def droplets_in_array(
    droplets: Sequence[Outline],
    array: PillarArray,
    time: float,
    color: Literal["generation", "size"] = "generation",
) -> Axes:
    """Draw the droplets of one frame among the pillars, coloured by generation or size.

    Parameters
    ----------
    droplets : sequence of Outline
    array : PillarArray
    time : float
        Of the frame, t0.
    color : {"generation", "size"}, optional
        Number of break-ups in a droplet's ancestry, or its diameter.
    """
    with style.journal_style():
        wide = style.TWO_COLUMNS
        height = min(8.0, 0.86 * wide * array.width / array.length + 0.5)
        figure = Figure(figsize=(wide, height), layout="constrained")
        axes = figure.subplots()
        axes.set_facecolor(palette.FLUID)
        for x, y, radius in array.circles:
            for shift in (-array.width, 0.0, array.width):
                axes.add_patch(Circle((x, y + shift), radius, color=palette.OBSTACLE, lw=0))
        vertices = [droplet.vertices for droplet in droplets]
        if color == "generation":
            values = np.array([droplet.generation for droplet in droplets], dtype=np.float64)
            norm: Normalize = BoundaryNorm(np.arange(-0.5, max(values, default=0) + 1), 256)
            said = "break-ups in its ancestry"
        else:
            values = np.array([_diameter(one) for one in vertices])
            norm, said = Normalize(0.0, max(values, default=1.0)), "diameter ($D_0$)"
        colors = ScalarMappable(norm, palette.ORDERED_MAP)
        shades = colors.to_rgba(values)
        for shift in (-array.width, 0.0, array.width):  # what crosses the edge of the cell
            shapes = [smooth_outline(one) + np.array([0.0, shift]) for one in vertices]
            droplet_shapes = PolyCollection(
                shapes,
                facecolors=shades,
                edgecolors=palette.DROPLET_RIM,
                linewidths=0.5,
                zorder=2,
            )
            axes.add_collection(droplet_shapes)
        axes.set(xlim=(0, array.length), ylim=(0, array.width), aspect="equal")
        axes.set(xlabel="$x$ ($D_0$)", ylabel="$y$ ($D_0$)", title=f"$t$ = {time:.4g} $t_0$")
        bar = figure.colorbar(colors, ax=axes, label=said, fraction=0.03, pad=0.01)
        if color == "generation":
            bar.set_ticks(np.arange(0, max(values, default=0) + 1).tolist())
            bar.minorticks_off()
        return axes


def sizes_over_time(sizes: pd.DataFrame, study: SizeStudy) -> Axes:
    """Draw the distribution of diameters against time, by area, and its means."""
    with style.journal_style():
        figure = Figure(figsize=(style.TWO_COLUMNS, 2.5), layout="constrained")
        axes = figure.subplots()
        times = study.series["time"].to_numpy(np.float64)
        at = np.linspace(times[0], times[-1], min(len(times), 80) + 1)
        d = sizes["diameter"].to_numpy(np.float64)
        t = sizes["time"].to_numpy(np.float64)
        found, *_ = np.histogram2d(t, d, (at, study.edges), weights=d**2)
        share = found / np.maximum(found.sum(axis=1, keepdims=True), 1e-300)
        image = axes.pcolormesh(at, study.edges, share.T, cmap="Greys", rasterized=True)
        figure.colorbar(image, ax=axes, label="share of the area", pad=0.01)
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
        figure = Figure(figsize=(style.ONE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplots()
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


def rates_over_time(events: pd.DataFrame, study: SizeStudy, bins: int = 24) -> Axes:
    """Draw what happens per t0 against time."""
    with style.journal_style():
        figure = Figure(figsize=(style.ONE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplots()
        end = float(study.series["time"].iloc[-1])
        edges = np.linspace(0.0, end, bins + 1)
        kinds = events["kind"].astype(str)
        named = {"entered": "entered", "breakup": "broke", "left": "left", "merge": "merged"}
        for (kind, said), color in zip(named.items(), palette.CATEGORIES, strict=False):
            times = events["time"][kinds == kind]
            if len(times):
                counts = np.histogram(times, edges)[0] / np.diff(edges)
                axes.stairs(counts, edges, color=color, label=said, lw=1.2)
        axes.axvline(study.start, color=palette.INK, lw=0.8, ls=":")
        axes.set(xlabel="time ($t_0$)", ylabel="droplets per $t_0$", xlim=(0, end))
        axes.set_ylim(bottom=0)
        axes.legend(loc="upper left", ncols=3, bbox_to_anchor=(0, 1.15), columnspacing=1.0)
        return axes


def contact_breakups(contacts: pd.DataFrame) -> Axes:
    """Draw the share of the contacts that broke the droplet against Bk, with the paper's law.

    Parameters
    ----------
    contacts : DataFrame
        Of `contact_outcomes`.
    """
    with style.journal_style():
        figure = Figure(figsize=(style.ONE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplots()
        seen = contacts[contacts["settled"] & (contacts["breakup_number"] > _LEAST_NUMBER)]
        number = seen["breakup_number"].to_numpy(np.float64)
        wide = np.geomspace(_LEAST_NUMBER, max(10.0, number.max(initial=1.0)), 400)
        law = breakup_probability(wide, WIDTH)
        axes.plot(wide, law, color=palette.BLUE, label="isolated collisions (paper)")
        if len(seen):
            edges = logarithmic_edges(number.min(), number.max(), 6)
            edges = merged_edges(number, edges, _FEWEST)
            found = broken_fractions(number, seen["broke"].to_numpy(bool), edges)
            reach = np.stack([found.fraction - found.low, found.high - found.fraction])
            axes.errorbar(
                found.middle,
                found.fraction,
                np.maximum(reach, 0.0),
                fmt="o",
                ms=2.5,
                lw=0.8,
                color=palette.BLACK,
                label=f"{len(seen)} contacts, 95 %",
            )
        axes.set(xscale="log", xlabel="breakup number Bk at contact", ylim=(-0.04, 1.2))
        axes.set_yticks(np.linspace(0, 1, 6))
        axes.set_ylabel("share that broke")
        axes.legend(loc="upper left")
        return axes


def pair_contacts(events: pd.DataFrame) -> Axes:
    """Draw the contacts of two droplets that have ended: their duration and their clock.

    Parameters
    ----------
    events : DataFrame
        Of an `Emulsion` with a coalescence.
    """
    with style.journal_style():
        figure = Figure(figsize=(style.ONE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplots()
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
        axes.set(xscale="log", yscale="log")
        axes.set(xlabel="duration of the contact ($t_0$)", ylabel="clock $C$ at its end")
        axes.legend(loc="lower right")
        return axes


def lineage_tree(family: pd.DataFrame, end: float) -> Axes:
    """Draw the droplet with the most descendants, and the first of them: time along, a line each.

    Parameters
    ----------
    family : DataFrame
        Of `lineage`.
    end : float
        Of the run, t0.
    """
    with style.journal_style():
        figure = Figure(figsize=(style.ONE_COLUMN, 2.5), layout="constrained")
        axes = figure.subplots()
        axes.set(xlabel="time ($t_0$)", yticks=[])
        axes.spines[["left", "top", "right"]].set_visible(False)
        eldest = [next(reversed([*ancestors(family, k)]), k) for k in family.index]
        if not eldest:
            return axes
        first = max(set(eldest), key=lambda k: (eldest.count(k), -k))
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
    """Give each droplet a height: those without daughters in turn, a mother amid hers."""
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


def _diameter(vertices: np.typing.NDArray[np.float64]) -> float:
    x, y = vertices.T
    area = 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    return math.sqrt(4 / math.pi * area)
