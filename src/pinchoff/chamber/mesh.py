"""Triangles that fit the geometry: fine at walls and pillars, coarser away from them.

Nodes are set along the walls at the wall's element size; in the fluid on the leaves of a quadtree,
where the size grows in proportion to the distance from the nearest wall. Delaunay's triangulation
joins them; a wall edge that it lacks is halved until it has all of them. Then the inner nodes move
to the middle of their neighbours.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree
from shapely import MultiPolygon

from pinchoff.chamber.shapes import polygons

if TYPE_CHECKING:
    from matplotlib.tri import TriFinder

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Size: TypeAlias = Callable[[Floats], Floats]
"""Element size at points (n, 2), µm."""

GROWTH = 0.15
"""Element size gained per distance from the wall: about where the fewest elements resolve a gap."""

_LEAST_EDGE_UM = 0.05  # bends shallower than this are drawn straight
_CORNER = math.radians(20.0)  # a bend sharper than this keeps its vertex
_QUADTREE_SHARE = 1.25  # largest leaf per wanted size, so that sizes are right on average
CLEARANCE = 0.62
"""Part of the wall's element size that is kept free of inner nodes."""

ROUNDS = 2
"""Of triangulating and smoothing."""

_SMOOTHINGS = 5  # in a round
_MOST_HALVINGS = 12


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """A triangulation of the fluid.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        Nodes, µm; the first ``wall_count`` lie on walls and pillars.
    triangles : ndarray, shape (m, 3)
        Nodes of each triangle, anticlockwise.
    wall_count : int
        How many nodes lie on walls.
    """

    points: Floats
    triangles: Integers
    wall_count: int

    @cached_property
    def _finder(self) -> TriFinder:
        from matplotlib.tri import Triangulation  # faster than finding the triangles by qhull

        x, y = self.points.T
        return Triangulation(x, y, self.triangles).get_trifinder()

    def locate(self, points: Floats) -> Integers:
        """Return the triangle that each point lies in, -1 outside the fluid."""
        return np.asarray(self._finder(points[:, 0], points[:, 1]), dtype=np.int64)

    def areas(self) -> Floats:
        """Return the area of each triangle, µm²."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return 0.5 * _cross(b - a, c - a)


def wall_size(gap_um: float, elements: float, growth: float = GROWTH) -> float:
    """Return the size at the walls with which so many elements span a gap.

    With h = h_w + G d, half a gap g holds ln(1 + G g / 2 h_w) / G elements.
    """
    return growth * gap_um / 2 / math.expm1(growth * elements / 2)


def build_mesh(fluid: MultiPolygon, size: Size, largest_um: float) -> TriangleMesh:
    """Return a mesh of the fluid.

    Parameters
    ----------
    fluid : MultiPolygon
        The fluid, with holes where pillars stand, µm.
    size : callable
        Element size at points on walls.
    largest_um : float
        No element is wanted larger.

    Raises
    ------
    RuntimeError
        Walls are so near each other that their edges cannot be had.
    """
    rings = [
        _spaced(np.asarray(ring.coords)[:-1], size)
        for polygon in polygons(fluid.simplify(_LEAST_EDGE_UM))
        for ring in (polygon.exterior, *polygon.interiors)
    ]
    shapely.prepare(fluid)
    rings = _conforming(rings)
    wall = np.concatenate(rings)
    edges = _ring_edges(rings)
    spans = np.hypot(*(wall[edges[:, 1]] - wall[edges[:, 0]]).T)
    local = np.maximum(spans, np.roll(spans, 1))
    inner = _inner_nodes(fluid, wall, local, largest_um)
    points = np.concatenate([wall, inner])
    tree = cKDTree(wall)
    for _ in range(ROUNDS):
        points = smoothed(points, len(wall), points, np.arange(len(points)))
        points = points[off_walls(tree, local, points, len(wall))]
    return _inside(fluid, points, len(wall))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _spaced(ring: Floats, size: Size) -> Floats:
    """Return nodes along a ring, spaced by the wall's size, with the corners among them."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    bend = np.abs(np.arctan2(_cross(before, after), np.sum(before * after, axis=1)))
    corners = np.flatnonzero(bend > _CORNER)
    if not corners.size:
        corners = np.array([0])
    ring = np.roll(ring, -corners[0], axis=0)
    stops = [*(corners - corners[0]), len(ring)]
    closed = np.concatenate([ring, ring[:1]])
    parts = [_spaced_line(closed[a : b + 1], size) for a, b in itertools.pairwise(stops)]
    return np.concatenate(parts)


def _spaced_line(line: Floats, size: Size) -> Floats:
    """Return nodes along a line of vertices, its first included and its last left out."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    # The size is looked up finely enough for it to change along one straight wall.
    fine = np.unique(np.concatenate([along, np.linspace(0, along[-1], 200)]))
    at = np.column_stack([np.interp(fine, along, line[:, k]) for k in range(2)])
    density = 1.0 / size(at)
    counted = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(fine))])
    whole = line.shape[0] > 2 and np.array_equal(line[0], line[-1])
    parts = max(8 if whole else 1, math.ceil(counted[-1] - 1e-9))
    wanted = np.interp(np.arange(parts) * (counted[-1] / parts), counted, fine)
    return np.column_stack([np.interp(wanted, along, line[:, k]) for k in range(2)])


def _ring_edges(rings: Sequence[Floats]) -> Integers:
    """Return the pairs of nodes along all rings, which are numbered one after the other."""
    start, edges = 0, []
    for ring in rings:
        nodes = np.arange(start, start + len(ring))
        edges.append(np.column_stack([nodes, np.roll(nodes, -1)]))
        start += len(ring)
    return np.concatenate(edges)


def _conforming(rings: list[Floats]) -> list[Floats]:
    """Halve wall edges that have another wall's node in the circle over them.

    Then every wall edge belongs to Delaunay's triangulation, as long as inner nodes keep away.
    """
    for _ in range(_MOST_HALVINGS):
        wall = np.concatenate(rings)
        edges = _ring_edges(rings)
        a, b = wall[edges[:, 0]], wall[edges[:, 1]]
        nearest, _ = cKDTree(wall).query(0.5 * (a + b), k=1)
        halved = nearest < 0.5 * np.hypot(*(b - a).T) * (1.0 - 1e-9)
        if not halved.any():
            return rings
        bounds = np.cumsum([0, *map(len, rings)])
        rings = [
            np.insert(
                ring,
                np.flatnonzero(halved[start : start + len(ring)]) + 1,
                (0.5 * (a + b))[start : start + len(ring)][halved[start : start + len(ring)]],
                axis=0,
            )
            for ring, start in zip(rings, bounds, strict=False)
        ]
    raise RuntimeError("walls lie so near each other that no mesh fits them")


def _inner_nodes(fluid: MultiPolygon, wall: Floats, local: Floats, largest_um: float) -> Floats:
    """Return the leaves' centres of a quadtree as fine as the size field wants it."""
    tree = cKDTree(wall)
    left, low, right, high = fluid.bounds
    corner, size = np.array([left, low]), np.array([right - left, high - low])
    counts = np.ceil(size / largest_um).astype(int)
    points, _ = quadtree_leaves(tree, local, corner, counts, np.array([largest_um, largest_um]))
    points = points[shapely.contains_xy(fluid, points[:, 0], points[:, 1])]
    distance, nearest = tree.query(points)
    kept = points[distance > CLEARANCE * local[nearest]]
    return np.asarray(kept[np.argsort(kept[:, 0])])  # neighbours near each other in memory


def quadtree_leaves(
    tree: cKDTree, local: Floats, corner: Floats, counts: Integers, cell: Floats
) -> tuple[Floats, Floats]:
    """Return the leaves' centres, (n, 2), and longer sides, (n,), fine where walls are near.

    `tree` holds the nodes on walls, whose element sizes are `local`. The first cells begin at
    `corner`; `counts` of them stand along x and y.
    """
    x, y = (corner[k] + (np.arange(counts[k]) + 0.5) * cell[k] for k in range(2))
    centres = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    leaves, spans = [], []
    while len(centres):
        distance, nearest = tree.query(centres)
        span = cell.max()
        # A cell far outside the fluid stays coarse; one that the wall may cross is looked into.
        wanted = local[nearest] + GROWTH * np.maximum(distance - 0.5 * span, 0.0)
        split = span > _QUADTREE_SHARE * wanted
        leaves.append(centres[~split])
        spans.append(np.full(len(leaves[-1]), span))
        quarter = 0.25 * cell * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])
        centres = (centres[split][:, None, :] + quarter).reshape(-1, 2)
        cell = cell * 0.5
    return np.concatenate(leaves), np.concatenate(spans)


def off_walls(tree: cKDTree, local: Floats, points: Floats, wall_count: int) -> NDArray[np.bool_]:
    """Tell the nodes of the wall, which come first, and inner ones that are not too near it."""
    distance, nearest = tree.query(points[wall_count:])
    return np.concatenate([np.ones(wall_count, dtype=bool), distance > 0.5 * local[nearest]])


def smoothed(points: Floats, wall_count: int, images: Floats, numbers: Integers) -> Floats:
    """Move the nodes, (n, 2), behind those of the wall to the middle of their neighbours.

    Neighbours are sought among `images`, (m, 2): the nodes, and behind them images of those nodes
    that `numbers`, (m,), says.
    """
    starts, neighbours = Delaunay(images).vertex_neighbor_vertices
    count = len(points)
    counts = np.diff(starts[: count + 1])
    ends = neighbours[: starts[count]]
    of = numbers[ends]
    shift = images[ends] - points[of]
    moved = points.copy()
    for _ in range(_SMOOTHINGS):
        sums = np.add.reduceat(moved[of] + shift, starts[:count], axis=0)
        moved[wall_count:] = (sums / counts[:, None])[wall_count:]
    return moved


def _inside(fluid: MultiPolygon, points: Floats, wall_count: int) -> TriangleMesh:
    """Return the triangles of the fluid, anticlockwise."""
    simplices = Delaunay(points).simplices.astype(np.int64)
    corners = points[simplices]
    middle = corners.mean(axis=1)
    within = shapely.contains_xy(fluid, middle[:, 0], middle[:, 1])
    # Three nodes of one straight wall may make a triangle without area.
    area = 0.5 * _cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    longest = np.max(np.sum((corners - np.roll(corners, 1, axis=1)) ** 2, axis=2), axis=1)
    within &= np.abs(area) > 1e-6 * longest
    return TriangleMesh(points, anticlockwise(points, simplices[within]), wall_count)


def anticlockwise(points: Floats, triangles: Integers) -> Integers:
    """Return triangles, (m, 3), with the nodes of each in this order."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.where(_cross(b - a, c - a)[:, None] < 0, triangles[:, ::-1], triangles)
