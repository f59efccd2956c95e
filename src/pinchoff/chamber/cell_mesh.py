"""Triangles for a rectangular cell that repeats itself, with round pillars in it.

Nodes are set round the pillars, finer where a gap is narrow, and in the fluid on the leaves of a
quadtree, as in `pinchoff.chamber.mesh`. Delaunay's triangulation of the cell and what surrounds it
is cut so that every triangle of the torus appears once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from pinchoff.chamber.mesh import (
    CLEARANCE,
    ROUNDS,
    Floats,
    Integers,
    TriangleMesh,
    anticlockwise,
    off_walls,
    quadtree_leaves,
    smoothed,
    wall_size,
)
from pinchoff.model.arrays import PillarArray

_LEAST_ROUND_PILLAR = 24  # elements
_PROBES = 360  # places round a pillar at which its distance from others is looked at
_JITTER = 1e-3  # of the element size: without ties both images of a seam are cut alike
_MARGIN = 4.0  # round the cell, in its largest elements
_IMAGES = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]  # of the cell
_LARGEST = 0.25  # element size, of the least period


@dataclass(frozen=True, eq=False)
class PeriodicMesh(TriangleMesh):
    """A triangulation of a torus, unwrapped: nodes near a seam appear once for each image.

    Attributes
    ----------
    representative : ndarray, shape (n,)
        Number of each node on the torus; images of one node share it.
    """

    representative: Integers


def build_cell_mesh(array: PillarArray, elements: float) -> PeriodicMesh:
    """Return a mesh of an array's cell, with so many elements across a gap between pillars.

    Raises
    ------
    RuntimeError
        The mesh does not cover the fluid: gaps are too narrow for so few elements.
    """
    size = np.array([array.length, array.width])
    wall, local, pillar = _wall_nodes(array, elements)
    inner, largest = _inner_nodes(array, size, wall, local)
    margin = _MARGIN * largest
    points = np.concatenate([wall, inner])
    tree = cKDTree(wall % size, boxsize=size)
    for _ in range(ROUNDS):
        points = smoothed(points, len(wall), *_surrounded(points, size, margin))
        # Nodes that crossed a seam come back into the cell; walls stay whole.
        points[len(wall) :] %= size
        points = points[off_walls(tree, local, points, len(wall))]
    return _on_torus(array, points, pillar, size, margin)


def _wall_nodes(array: PillarArray, elements: float) -> tuple[Floats, Floats, Integers]:
    """Return nodes round the pillars, the element size at each, and whose they are.

    They are denser where another pillar is near. The polygon through a pillar's nodes has the
    pillar's own area.
    """
    nodes, sizes, owners = [], [], []
    angle = np.linspace(0.0, 2.0 * math.pi, _PROBES + 1)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    for k, (gap, (x, y, radius)) in enumerate(
        zip(_gap_round(array, ring), array.circles, strict=True)
    ):
        coarsest = 2.0 * math.pi * radius / _LEAST_ROUND_PILLAR
        wanted = wall_size(1.0, elements) * np.minimum(gap, 2.0 * radius)
        density = radius / np.minimum(wanted, coarsest)
        passed = np.append(0.0, np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(angle)))
        count = math.ceil(passed[-1])
        at = np.interp(np.arange(count) * (passed[-1] / count), passed, angle)
        sector = np.diff(np.append(at, at[0] + 2.0 * math.pi))
        corner = radius * math.sqrt(2.0 * math.pi / np.sum(np.sin(sector)))
        nodes.append([x, y] + corner * np.column_stack([np.cos(at), np.sin(at)]))
        sizes.append(corner * np.maximum(sector, np.roll(sector, 1)))
        owners.append(np.full(count, k))
    return np.concatenate(nodes), np.concatenate(sizes), np.concatenate(owners)


def _gap_round(array: PillarArray, ring: Floats) -> Iterator[Floats]:
    """Yield for each pillar how far its neighbours are from its edge, at each point of the ring."""
    size = np.array([array.length, array.width])
    shifts = [(0, 0), *_IMAGES]
    centres = np.concatenate([array.circles[:, :2] + np.array(s) * size for s in shifts])
    radii = np.tile(array.circles[:, 2], len(shifts))
    tree = cKDTree(centres)
    for x, y, radius in array.circles:
        reach = 3.0 * radius + radii.max()  # what is farther away than 2 R does not matter
        near = tree.query_ball_point((x, y), reach)
        others = [i for i in near if math.hypot(centres[i, 0] - x, centres[i, 1] - y) > radius]
        places = [x, y] + radius * ring
        away = np.linalg.norm(places[:, None, :] - centres[others], axis=2) - radii[others]
        yield np.min(away, axis=1, initial=2.0 * radius)


def _inner_nodes(
    array: PillarArray, size: Floats, wall: Floats, local: Floats
) -> tuple[Floats, float]:
    """Return the centres of a quadtree's leaves in the fluid, and the largest leaf's side."""
    tree = cKDTree(wall % size, boxsize=size)
    counts = np.ceil(size / (_LARGEST * float(size.min()))).astype(int)
    points, span = quadtree_leaves(tree, local, np.zeros(2), counts, size / counts)
    jitter = np.random.default_rng(0).uniform(-1, 1, points.shape)
    points = (points + _JITTER * span[:, None] * jitter) % size
    distance, nearest = tree.query(points)
    kept = (distance > CLEARANCE * local[nearest]) & ~_in_pillars(array, points, size)
    return points[kept][np.argsort(points[kept, 0])], float(span[kept].max())


def _in_pillars(array: PillarArray, points: Floats, size: Floats) -> Integers:
    """Tell which points, in the cell, lie in a pillar or an image of one."""
    inside = np.zeros(len(points), dtype=bool)
    tree = cKDTree(points % size, boxsize=size)
    for x, y, radius in array.circles:
        inside[tree.query_ball_point((x, y), radius)] = True
    return inside


def _surrounded(points: Floats, size: Floats, margin: float) -> tuple[Floats, Integers]:
    """Return the points with their images in a margin round the cell, and whose images they are.

    The margin is wide enough that triangles over the cell are those of the endless array.
    """
    places, numbers = [points], [np.arange(len(points))]
    for shift in _IMAGES:
        image = points + np.array(shift) * size
        near = ((image > -margin) & (image < size + margin)).all(axis=1)
        places.append(image[near])
        numbers.append(np.flatnonzero(near))
    return np.concatenate(places), np.concatenate(numbers)


def _on_torus(
    array: PillarArray, points: Floats, pillar: Integers, size: Floats, margin: float
) -> PeriodicMesh:
    places, numbers = _surrounded(points, size, margin)
    triangles = Delaunay(places).simplices.astype(np.int64)
    corners = places[triangles]
    middle = corners.mean(axis=1)
    in_cell = ((middle >= 0) & (middle < size)).all(axis=1)
    pillar_of = np.append(pillar, np.full(len(points) - len(pillar), -1))  # -1 in the fluid
    of = pillar_of[numbers[triangles]]
    # All three corners on one pillar: the triangle lies in it, as its polygon is convex.
    solid = (of[:, 0] >= 0) & (of[:, 0] == of[:, 1]) & (of[:, 0] == of[:, 2])
    triangles = triangles[in_cell & ~solid]
    used, local = np.unique(triangles, return_inverse=True)
    mesh = PeriodicMesh(
        points=places[used],
        triangles=anticlockwise(places[used], local.reshape(-1, 3)),
        wall_count=0,
        representative=numbers[used],
    )
    fluid = array.porosity * array.length * array.width
    if not math.isclose(float(mesh.areas().sum()), fluid, rel_tol=1e-9):
        raise RuntimeError(
            f"the mesh must cover the fluid's {fluid:.6g} D0²; got {mesh.areas().sum():.6g}; "
            "ask for more elements across a gap"
        )
    return mesh
