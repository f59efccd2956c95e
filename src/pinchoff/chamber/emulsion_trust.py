"""How far a run of many droplets can be trusted, where the flow does not feel the droplets.

Droplets that move with the fluid disturb it little. Where they are held by pillars the fluid would
go round them, or push harder; the model's flow does neither. These numbers say how often.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, cKDTree

from pinchoff.model.arrays import Floats, PillarArray

if TYPE_CHECKING:
    from pinchoff.model.flow import Flow
    from pinchoff.model.outlines import Outline, Outlines

HELD = 0.1
"""A droplet that moves more slowly than this share of v_f∞ is held."""

_FRAMES = 4  # of a piece, in which droplets are looked at


@dataclass(frozen=True)
class Trust:
    """What tells how far the results hold.

    Attributes
    ----------
    frames : int
        That were looked at.
    slip : float
        Mean of |v_droplet - v_flow| over droplets, v_f∞; the flow is the undisturbed one, averaged
        over the droplet's vertices.
    slip_95 : float
        What 95 % of the droplets stay below, v_f∞.
    held : float
        Share of the droplets that move at less than 0.1 v_f∞.
    blocked : float
        Share of the gaps between neighbouring pillars whose middle a held droplet covers.
    largest_island : int
        Most droplets that touched each other at one time, within a vertex spacing.
    """

    frames: int
    slip: float
    slip_95: float
    held: float
    blocked: float
    largest_island: int

    def verdict(self) -> str:
        """Say in words how far the results can be trusted."""
        if self.slip < 0.1 and self.blocked < 0.01:
            return (
                "Droplets move nearly as the fluid would without them, and hardly any gap is "
                "blocked: a flow that does not feel the droplets is a fair first approximation."
            )
        if self.blocked < 0.05:
            return (
                "Droplets slip against the fluid where pillars slow them down. Break-ups near "
                "pillars happen in a flow that is disturbed in reality: take rates as estimates."
            )
        return (
            "Held droplets block gaps. In reality the pressure behind them would rise until they "
            "move or the fluid goes elsewhere; here it does not. Clogs and what follows from them "
            "may be artefacts of the model."
        )


def measure_trust(
    pieces: Iterable[Outlines], array: PillarArray, flow: Flow, begin: float, spacing: float
) -> Trust:
    """Look at the droplets of some frames of a run, whose outlines come in pieces.

    Frames before the time `begin`, t0, are left out. Outlines within the `spacing` of two
    vertices, D0, touch.
    """
    gaps = neighbour_gaps(array)
    slips, speeds, blocked, largest, seen = [], [], [], 0, 0
    for outlines in pieces:
        late = np.flatnonzero(outlines.times >= begin).tolist()
        for frame in late[:: max(1, len(late) // _FRAMES)]:
            droplets = outlines[frame]
            if not droplets:
                continue
            seen += 1
            velocity = np.array([d.velocities.mean(axis=0) for d in droplets])
            vertices = np.concatenate([d.vertices for d in droplets])
            counts = np.array([len(d.vertices) for d in droplets])
            starts = np.cumsum(counts) - counts
            fluid = np.add.reduceat(np.asarray(flow.velocity(vertices)), starts) / counts[:, None]
            slips.append(np.hypot(*(velocity - fluid).T))
            speeds.append(np.hypot(*velocity.T))
            still = [d for d, v in zip(droplets, speeds[-1], strict=True) if v < HELD]
            blocked.append(_covered(gaps, still, array.width))
            largest = max(largest, _largest_island(vertices, counts, array.width, spacing))
    if not seen:
        return Trust(0, math.nan, math.nan, math.nan, math.nan, 0)
    slip, speed = np.concatenate(slips), np.concatenate(speeds)
    return Trust(
        seen,
        float(slip.mean()),
        float(np.quantile(slip, 0.95)),
        float((speed < HELD).mean()),
        float(np.mean(blocked)),
        largest,
    )


def neighbour_gaps(array: PillarArray) -> Floats:
    """Return the middles of the gaps between neighbouring pillars, shape (g, 2), D0.

    Two pillars are neighbours if no third one's centre lies in the circle over the line between
    their centres (Gabriel's graph), with the array's images across the flow.

    Examples
    --------
    >>> from pinchoff.model import arrays
    >>> len(neighbour_gaps(arrays.square(rows=3, columns=4, radius=0.2, gap=1.0)))
    21
    """
    shifts = np.array([[0.0, k * array.width, 0.0] for k in (0, -1, 1)])
    images = (array.circles[None] + shifts[:, None]).reshape(-1, 3)
    if np.ptp(images[:, 0]) < 1e-9:  # one column: Delaunay needs an area
        order = np.argsort(images[:, 1])
        edges = np.column_stack([order[:-1], order[1:]])
    else:
        corners = Delaunay(images[:, :2]).simplices
        edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    first, second = images[edges[:, 0]], images[edges[:, 1]]
    along = second[:, :2] - first[:, :2]
    length = np.hypot(*along.T)
    near, _ = cKDTree(images[:, :2]).query((first[:, :2] + second[:, :2]) / 2, k=3)
    neighbours = near[:, 2] > 0.5 * length * (1 + 1e-6)
    share = (0.5 + 0.5 * (first[:, 2] - second[:, 2]) / length)[:, None]
    middles = first[:, :2] + share * along
    inside = (middles[:, 1] >= 0) & (middles[:, 1] < array.width)
    return np.asarray(middles[neighbours & inside])


def _covered(gaps: Floats, droplets: list[Outline], width: float) -> float:
    """Return the share of the gaps' middles that lie in a droplet, also across the cell's edge."""
    from shapely import Polygon, contains_xy

    covered = np.zeros(len(gaps), dtype=bool)
    for droplet in droplets:
        outline = Polygon(droplet.vertices)
        for shift in (-width, 0.0, width):
            covered |= contains_xy(outline, gaps[:, 0], gaps[:, 1] + shift)
    return float(covered.mean()) if len(gaps) else 0.0


def _largest_island(
    vertices: Floats, counts: np.typing.NDArray[np.int64], width: float, spacing: float
) -> int:
    """Return how many droplets the largest group of touching ones has."""
    owner = np.repeat(np.arange(len(counts)), counts)
    low = vertices[:, 0].min()
    long = np.ptp(vertices[:, 0]) + 2 * spacing + 1.0
    places = np.column_stack([vertices[:, 0] - low, np.mod(vertices[:, 1], width) % width])
    pairs = cKDTree(places, boxsize=(long, width)).query_pairs(spacing, output_type="ndarray")
    a, b = owner[pairs].T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(counts),) * 2)
    _, label = connected_components(graph, directed=False)
    return int(np.bincount(label).max())
