"""Two drawings of what is measured on an outline: the neck between vertices, and the symmetry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle, PathPatch, Polygon
from matplotlib.path import Path

from pinchoff.figures import style
from pinchoff.figures.scene import Window, draw_chamber, draw_droplets, smooth_outline
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
    # velocity of the centre of mass: all mass sits on the vertices
    velocity = droplet.velocities.mean(axis=0)
    along = velocity / np.hypot(*velocity)
    across = np.array([-along[1], along[0]])
    above = (droplet.vertices.mean(axis=0) - centre) @ across > 0
    with style.journal_style():
        axes = style.one_panel(2.5) if axes is None else axes
        _draw_scene(axes, outlines, frame)
        for side, color, label in (
            (1.0 if above else -1.0, _LARGE, r"$A_\mathrm{large}$"),
            (-1.0 if above else 1.0, _SMALL, r"$A_\mathrm{small}$"),
        ):
            _shade(axes, droplet.vertices, centre, along, side * across, color, label)
        axes.axline(
            tuple(centre),
            tuple(centre + along),
            color=palette.INK,
            lw=1,
            ls=(0, (4, 2)),
            zorder=3.5,
        )
        start = droplet.vertices.mean(axis=0)
        arrow = {"arrowstyle": "-|>", "color": "white", "lw": 3, "mutation_scale": 14}
        axes.annotate("", start + 0.12 * along, start - 0.25 * along, arrowprops=arrow, zorder=4)
        axes.annotate("$v$", start - 0.1 * along + 0.06 * across, color="white", zorder=4)
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
    obstacle = outlines.obstacles[0]
    corners = np.concatenate(
        [
            *(outline.vertices for outline in outlines[frame]),
            obstacle[:2] + obstacle[2:] * [[1, 1], [-1, -1]],
        ]
    )
    left, bottom = corners.min(axis=0) - _MARGIN
    right, top = corners.max(axis=0) + _MARGIN
    draw_chamber(axes, outlines, Window(float(left), float(right), float(bottom), float(top)))
    draw_droplets(axes, outlines[frame])


def _shorter_arc(vertices: Floats, i: int, j: int) -> Floats:
    first, last = sorted((i, j))
    inner = vertices[first : last + 1]
    outer = np.concatenate([vertices[last:], vertices[: first + 1]])
    lengths = [np.hypot(*np.diff(arc, axis=0).T).sum() for arc in (inner, outer)]
    return inner if lengths[0] <= lengths[1] else outer


def _shade(
    axes: Axes,
    outline: Floats,
    centre: Floats,
    along: Floats,
    normal: Floats,
    color: str,
    label: str,
) -> None:
    """Fill the part of an outline on one side of the line through `centre`."""
    base = centre + np.outer([-_FAR, _FAR], along)
    half = Polygon(
        np.concatenate([base, base[::-1] + _FAR * normal]), fc=color, ec="none", zorder=2.5
    )
    half.set_label(label)
    axes.add_patch(half)
    half.set_clip_path(PathPatch(Path(smooth_outline(outline)), transform=axes.transData))
    curve = smooth_outline(outline)
    rim = LineCollection([np.concatenate([curve, curve[:1]])], color=palette.DROPLET_RIM, lw=1)
    rim.set_zorder(3)
    axes.add_collection(rim)
