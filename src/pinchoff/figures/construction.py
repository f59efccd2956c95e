"""Two drawings of what is measured on an outline: the neck between vertices, and the symmetry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Circle, Polygon

from pinchoff.figures import style
from pinchoff.figures.scene import (
    Window,
    draw_centreline,
    draw_chamber,
    draw_droplets,
    smooth_outline,
)
from pinchoff.support import palette
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.gsd import Floats
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.results import Collision

_LARGE, _SMALL = palette.SKY, palette.YELLOW
_ARC = palette.GREEN
_MARGIN = 0.12  # between what is shown and the edge of the picture [D0]
_LABEL = 0.09  # from a curve to its name [D0]
_FAR = 50.0  # beyond everything that is drawn [D0]


def model_schematic(collision: Collision, axes: Axes | None = None) -> Axes:
    """Draw a droplet on its obstacle with vertices, a neck r_ij and the arc s_ij between its ends.

    Parameters
    ----------
    collision : Collision
        The droplet must break in it, and it must have outlines.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
    """
    outlines = _outlines_of(collision)
    frame = int(np.searchsorted(outlines.times, collision.breakup_time)) - 1
    droplet = outlines[frame][0]
    length, i, j = outlines.neck(droplet)
    with style.journal_style():
        axes = style.one_panel(2.5) if axes is None else axes
        _draw_scene(axes, outlines, frame)
        vertices = droplet.vertices
        spacing = np.hypot(*np.diff(vertices, axis=0, append=vertices[:1]).T).mean()
        circles = PatchCollection(
            [Circle(tuple(vertex), 0.5 * spacing) for vertex in vertices],
            facecolor="white",
            edgecolor=palette.DROPLET_RIM,
            lw=0.5,
            zorder=3.2,
        )
        axes.add_collection(circles)
        arc = _shorter_arc(vertices, i, j)
        axes.plot(*arc.T, color=_ARC, lw=1.6, zorder=3.4, label="$s_{ij}$, shorter arc")
        label = f"$r_{{ij}}$ = $d_\\mathrm{{neck}}$ = {length:.3f} $D_0$"
        axes.plot(*vertices[[i, j]].T, color=palette.NECK, lw=1.8, zorder=3.6, label=label)
        middle = arc[len(arc) // 2]
        outwards = middle - arc.mean(axis=0)
        place = middle + _LABEL * outwards / np.hypot(*outwards)
        axes.annotate("$s_{ij}$", place, ha="center", va="center", color=_ARC, zorder=6)
        centre = tuple(outlines.obstacles[0, :2])
        axes.annotate("$R$", centre, color="white", ha="center", va="center", zorder=5)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=2)
        axes.set_title(f"$N_v$ = {len(vertices)} vertices", loc="left")
        return axes


def symmetry_construction(collision: Collision, axes: Axes | None = None) -> Axes:
    """Draw the droplet at first contact, divided into A_large and A_small [paper, eq. symdef].

    Parameters
    ----------
    collision : Collision
        The droplet must touch the obstacle, and the collision must have outlines.
    axes : Axes, optional
        Where to draw; by default a new figure across one column.

    Returns
    -------
    Axes
    """
    outlines = _outlines_of(collision)
    frame = int(np.argmin(np.abs(outlines.times - collision.contact_time)))
    droplet = outlines[frame][0]
    centre = outlines.obstacles[0, :2]
    middle, velocity = droplet.vertices.mean(axis=0), droplet.velocities.mean(axis=0)
    along = velocity / np.hypot(*velocity)
    across = np.array([-along[1], along[0]])
    larger = across if (middle - centre) @ across > 0 else -across
    with style.journal_style():
        axes = style.one_panel(2.5) if axes is None else axes
        _draw_scene(axes, outlines, frame)
        look: Any = {"ec": palette.DROPLET_RIM, "lw": 1, "zorder": 3}
        rim = axes.add_patch(Polygon(smooth_outline(droplet.vertices), fill=False, **look))
        base = centre + np.outer([-_FAR, _FAR], along)
        for side, color, label in (
            (larger, _LARGE, r"$A_\mathrm{large}$"),
            (-larger, _SMALL, r"$A_\mathrm{small}$"),
        ):
            corners = np.concatenate([base, base[::-1] + _FAR * side])
            half = Polygon(corners, fc=color, ec="none", zorder=2.5, label=label)
            axes.add_patch(half).set_clip_path(rim)
        draw_centreline(axes, centre, droplet, palette.INK)
        arrow = {"arrowstyle": "-|>", "color": "white", "lw": 3, "mutation_scale": 14}
        axes.annotate("", middle + 0.12 * along, middle - 0.25 * along, arrowprops=arrow, zorder=4)
        axes.annotate("$v$", middle - 0.1 * along + 0.06 * across, color="white", zorder=4)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=2)
        s = collision.symmetry
        axes.set_title(
            rf"$S = 1 - (A_\mathrm{{large}} - A_\mathrm{{small}})/A$ = {s:.2f}", loc="left"
        )
        return axes


def _outlines_of(collision: Collision) -> Outlines:
    if collision.outlines is None or not np.isfinite(collision.contact_time):
        rule = "one with a contact and with outlines"
        raise InputError.of("collision", rule, collision, "simulate with outlines=0.01")
    return collision.outlines


def _draw_scene(axes: Axes, outlines: Outlines, frame: int) -> None:
    draw_chamber(axes, outlines, Window.around(outlines, [frame], _MARGIN))
    draw_droplets(axes, outlines[frame])


def _shorter_arc(vertices: Floats, i: int, j: int) -> Floats:
    first, last = sorted((i, j))
    inner = vertices[first : last + 1]
    outer = np.concatenate([vertices[last:], vertices[: first + 1]])
    lengths = [np.hypot(*np.diff(arc, axis=0).T).sum() for arc in (inner, outer)]
    return inner if lengths[0] <= lengths[1] else outer
