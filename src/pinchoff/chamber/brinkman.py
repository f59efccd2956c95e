r"""Depth-averaged creeping flow between two plates, no-slip at walls and pillars.

The Hele-Shaw equation with Brinkman's term,

.. math:: -\frac{12\mu}{z^2}\,\mathbf u + \mu\nabla^2\mathbf u - \nabla p = 0, \qquad
          \nabla\cdot\mathbf u = s,

where s is what ports bring in or take out; in a cell that repeats itself a mean pressure gradient
drives the flow instead. Taylor and Hood's elements (velocity quadratic, pressure
linear) on triangles; MINRES, preconditioned with a few Chebyshev steps for the velocity and, for
the pressure, with the sum of inverses of Cahouet and Chabard (Int. J. Numer. Meth. Fluids 8, 1988).
The number of iterations hardly grows with the mesh, and memory in proportion to it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg

from pinchoff.chamber.cell_mesh import PeriodicMesh
from pinchoff.chamber.mesh import Floats, Integers, TriangleMesh

if TYPE_CHECKING:
    from pinchoff.support.progress import Show

_CHEBYSHEV_STEPS = 6
_CHEBYSHEV_SPAN = 40.0  # of the eigenvalues that the Chebyshev steps damp evenly
_POWER_STEPS, _POWER_MARGIN = 20, 1.15  # of the estimate of the greatest eigenvalue
TOLERANCE = 1e-9
"""Residual at which the iteration ends: velocities are then right to 1e-4 of the greatest."""

_MOST_ITERATIONS = 2000


@dataclass(frozen=True, eq=False)
class Field:
    """Velocity and pressure on a mesh.

    Attributes
    ----------
    mesh : TriangleMesh
    velocity : ndarray, shape (nodes + edges, 2)
        At the nodes and then at the middles of the edges, in the unit of the sources times µm.
    pressure : ndarray, shape (nodes,)
        Over the viscosity: unit of velocity per µm.
    nodes_of : ndarray, shape (6, triangles)
        Rows of `velocity` of each triangle: corners, then the edges 01, 12, 02.
    corners_of : ndarray, shape (3, triangles)
        Rows of the mesh's points of each triangle.
    iterations : int
        How many MINRES took.
    reactions : ndarray, shape (nodes + edges, 2)
        Force of the fluid on the walls, by node, over the viscosity and the thickness.
    """

    mesh: TriangleMesh
    velocity: Floats
    pressure: Floats
    nodes_of: Integers
    corners_of: Integers
    iterations: int
    reactions: Floats

    def scaled(self, factor: float) -> Field:
        """Return the flow that is so many times as fast."""
        return replace(
            self,
            velocity=factor * self.velocity,
            pressure=factor * self.pressure,
            reactions=factor * self.reactions,
        )

    def at(self, points: Floats) -> Floats:
        """Return the velocity at points, shape (n, 2): zero outside the fluid."""
        triangle = self.mesh.locate(points)
        found = triangle >= 0
        weights = _quadratic(self._barycentric(points[found], triangle[found]))
        nodes = self.nodes_of[:, triangle[found]]
        values = np.zeros(points.shape)
        values[found] = np.einsum("kn,knc->nc", weights, self.velocity[nodes])
        return values

    def pressure_at(self, points: Floats) -> Floats:
        """Return the pressure at points, shape (n, 2): NaN outside the fluid."""
        triangle = self.mesh.locate(points)
        found = triangle >= 0
        weights = self._barycentric(points[found], triangle[found])
        values = np.full(len(points), np.nan)
        nodes = self.nodes_of[:3, triangle[found]]
        values[found] = np.sum(weights * self.pressure[nodes], axis=0)
        return values

    def _barycentric(self, points: Floats, triangle: Integers) -> Floats:
        a, b, c = self.mesh.points[self.corners_of[:, triangle]]
        to_b, to_c, to = b - a, c - a, points - a
        whole = to_b[:, 0] * to_c[:, 1] - to_b[:, 1] * to_c[:, 0]
        second = (to[:, 0] * to_c[:, 1] - to[:, 1] * to_c[:, 0]) / whole
        third = (to_b[:, 0] * to[:, 1] - to_b[:, 1] * to[:, 0]) / whole
        return np.stack([1.0 - second - third, second, third])


class Source(NamedTuple):
    """A place where fluid comes in (or, at a negative rate, goes out), evenly over its area.

    Attributes
    ----------
    covers : callable
        Tells of points (n, 2) whether they lie in it.
    rate : float
        Fluid per time and thickness: the unit of velocity times µm.
    """

    covers: Callable[[Floats], NDArray[np.bool_]]
    rate: float


def _quadratic(weights: Floats) -> Floats:
    """Return the six quadratic shape functions at barycentric coordinates, shape (3, n)."""
    a, b, c = weights
    corners = weights * (2.0 * weights - 1.0)
    return np.concatenate([corners, 4.0 * np.stack([a * b, b * c, a * c])])


@dataclass(frozen=True, eq=False)
class _System:
    """Matrices of the discrete equations, over all degrees of freedom."""

    momentum: Any  # of one component, (n, n)
    divergence: tuple[Any, Any]  # of the components, (m, n)
    source: Floats  # (m,)
    weight: Floats  # the integral of each shape function of the velocity, (n,)
    pressure_mass: Floats  # lumped, (m,)
    pressure_stiffness: Any  # (m, m)
    nodes: Floats  # where the velocity's degrees of freedom sit, (n, 2)
    wall: Integers
    nodes_of: Integers
    corners_of: Integers


def solve(
    mesh: TriangleMesh,
    thickness_um: float,
    *,
    sources: Sequence[Source] = (),
    wall_velocity: Callable[[Floats], Floats] | None = None,
    pressure_gradient: tuple[float, float] = (0.0, 0.0),
    tolerance: float = TOLERANCE,
    show: Show | None = None,
) -> Field:
    """Return the flow in a mesh.

    Parameters
    ----------
    mesh : TriangleMesh
    thickness_um : float
        z, µm; infinity for the plane Stokes flow.
    sources : sequence of Source
        Where fluid comes in and goes out; their rates must sum to zero.
    wall_velocity : callable, optional
        Of points (n, 2) on walls, the velocity there (n, 2); zero by default.
    pressure_gradient : (float, float), optional
        Mean gradient over the viscosity that drives the flow against it, in a periodic mesh.
    tolerance : float, optional
        Residual over the right side at which the iteration ends.
    show : callable, optional
        Called with the number of iterations so far.

    Raises
    ------
    RuntimeError
        The iteration did not converge.
    """
    system = _assembled(mesh, thickness_um, sources)
    velocity = np.zeros((len(system.nodes), 2))
    if wall_velocity is not None:
        velocity[system.wall] = wall_velocity(system.nodes[system.wall])
    drive = -np.outer(system.weight, pressure_gradient)
    pressure, iterations = _iterate(system, velocity, drive, thickness_um, tolerance, show)
    forces = system.momentum @ velocity - drive
    forces -= np.column_stack([b.T @ pressure for b in system.divergence])
    return Field(mesh, velocity, pressure, system.nodes_of, system.corners_of, iterations, -forces)


def _assembled(mesh: TriangleMesh, thickness_um: float, sources: Sequence[Source]) -> _System:
    from skfem import Basis, BilinearForm, ElementTriP1, ElementTriP2, LinearForm, MeshTri
    from skfem.helpers import dot, grad

    friction = 12.0 / thickness_um**2
    triangulation = MeshTri(mesh.points.T.copy(), mesh.triangles.T.copy())
    quadratic = Basis(triangulation, ElementTriP2(), intorder=4)
    linear = quadratic.with_element(ElementTriP1())
    wrap = _Wrap.of(mesh, quadratic)
    momentum = BilinearForm(lambda u, v, _: dot(grad(u), grad(v)) + friction * u * v)
    divergence = [BilinearForm(lambda u, q, _, k=k: grad(u)[k] * q) for k in range(2)]
    stiffness = BilinearForm(lambda p, q, _: dot(grad(p), grad(q)))
    inflow = np.zeros(linear.N)
    for source in sources:
        form = LinearForm(lambda q, w, s=source: _within(s, w.x) * q)
        part = form.assemble(linear)
        inflow += part * (source.rate / part.sum())  # quadrature sees its edge only roughly
    linear_weight = LinearForm(lambda q, _: 1.0 * q).assemble(linear)
    return _System(
        momentum=wrap.matrix(momentum.assemble(quadratic), wrap.nodes, wrap.nodes).tocsr(),
        divergence=(
            wrap.matrix(divergence[0].assemble(quadratic, linear), wrap.corners, wrap.nodes),
            wrap.matrix(divergence[1].assemble(quadratic, linear), wrap.corners, wrap.nodes),
        ),
        source=wrap.vector(inflow, wrap.corners),
        weight=wrap.vector(LinearForm(lambda v, _: 1.0 * v).assemble(quadratic), wrap.nodes),
        pressure_mass=wrap.vector(linear_weight, wrap.corners),
        pressure_stiffness=wrap.matrix(
            stiffness.assemble(linear), wrap.corners, wrap.corners
        ).tocsc(),
        nodes=wrap.places(quadratic.doflocs.T),
        wall=wrap.wall,
        nodes_of=wrap.nodes[quadratic.element_dofs],
        corners_of=triangulation.t,
    )


@dataclass(frozen=True, eq=False)
class _Wrap:
    """Which degrees of freedom of a periodic mesh are images of one another.

    Attributes
    ----------
    nodes, corners : ndarray
        Number of each degree of freedom of the velocity, and of the pressure.
    wall : ndarray
        Numbers of the velocity's degrees of freedom on walls.
    """

    nodes: Integers
    corners: Integers
    wall: Integers

    @classmethod
    def of(cls, mesh: TriangleMesh, quadratic: Any) -> _Wrap:
        if not isinstance(mesh, PeriodicMesh):
            every = np.arange(quadratic.N)
            return cls(every, np.arange(len(mesh.points)), quadratic.get_dofs().all())
        _, corners = np.unique(mesh.representative, return_inverse=True)
        # An edge is known by its two ends; one with a single triangle lies on a pillar.
        of_triangle = corners[quadratic.mesh.t]
        ends = np.stack([of_triangle[[0, 1]], of_triangle[[1, 2]], of_triangle[[0, 2]]])
        edges, number, count = np.unique(
            np.sort(ends, axis=1).transpose(0, 2, 1).reshape(-1, 2),
            axis=0,
            return_inverse=True,
            return_counts=True,
        )
        first_edge = int(corners.max()) + 1
        nodes = np.empty(quadratic.N, dtype=np.int64)
        nodes[quadratic.element_dofs[:3]] = of_triangle
        nodes[quadratic.element_dofs[3:]] = first_edge + number.reshape(3, -1)
        on_wall = np.flatnonzero(count == 1)
        wall = np.union1d(edges[on_wall].ravel(), first_edge + on_wall)
        return cls(nodes, corners, wall)

    def matrix(self, matrix: Any, rows: Integers, columns: Integers) -> Any:
        """Return a matrix with the rows and the columns of images added up."""
        found = matrix.tocoo()
        shape = (int(rows.max()) + 1, int(columns.max()) + 1)
        return sparse.csr_matrix((found.data, (rows[found.row], columns[found.col])), shape)

    def vector(self, vector: Floats, numbers: Integers) -> Floats:
        """Return a vector with the entries of images added up."""
        return np.asarray(np.bincount(numbers, vector), dtype=np.float64)

    def places(self, places: Floats) -> Floats:
        """Return the place of each degree of freedom of the velocity; of images, one place."""
        chosen = np.empty((int(self.nodes.max()) + 1, 2))
        chosen[self.nodes] = places
        return chosen


def _within(source: Source, x: Floats) -> Floats:
    """Tell which quadrature points, shape (2, triangles, points), a source covers."""
    return source.covers(x.reshape(2, -1).T).reshape(x.shape[1:]).astype(np.float64)


def _iterate(
    system: _System,
    velocity: Floats,
    drive: Floats,
    thickness_um: float,
    tolerance: float,
    show: Show | None,
) -> tuple[Floats, int]:
    """Solve for the velocity off the walls, in place, and return the pressure."""
    inner = np.setdiff1d(np.arange(len(velocity)), system.wall, assume_unique=True)
    momentum = system.momentum[inner][:, inner]
    b = [part[:, inner] for part in system.divergence]
    known = system.momentum[inner] @ velocity  # of the walls' velocity alone
    leaving = sum(part @ velocity[:, k] for k, part in enumerate(system.divergence))
    right = np.concatenate([(drive[inner] - known).ravel(), leaving - system.source])
    for_velocity = _chebyshev(momentum)
    for_pressure = _cahouet_chabard(system, thickness_um)
    n = len(inner)

    def precondition(x: Floats) -> Floats:
        u = for_velocity(x[: 2 * n].reshape(n, 2))
        return np.concatenate([u.ravel(), for_pressure(x[2 * n :])])

    count = 0

    def counted(_: Floats) -> None:
        nonlocal count
        count += 1
        if show is not None:
            show(count)

    x, failed = linalg.minres(
        linalg.LinearOperator((right.size, right.size), _saddle_point(momentum, b)),
        right,
        rtol=tolerance,
        maxiter=_MOST_ITERATIONS,
        M=linalg.LinearOperator((right.size, right.size), precondition),
        callback=counted,
    )
    if failed:
        raise RuntimeError(f"the flow did not converge in {_MOST_ITERATIONS} iterations")
    velocity[inner] = x[: 2 * n].reshape(n, 2)
    pressure = x[2 * n :]
    return pressure - pressure @ system.pressure_mass / system.pressure_mass.sum(), count


def _saddle_point(momentum: Any, b: list[Any]) -> Callable[[Floats], Floats]:
    """Return the product with the whole matrix; velocities come node by node, then pressures."""
    n = momentum.shape[0]
    bt = [part.T.tocsr() for part in b]

    def product(x: Floats) -> Floats:
        u, p = x[: 2 * n].reshape(n, 2), x[2 * n :]
        au = momentum @ u
        au -= np.column_stack([part @ p for part in bt])
        return np.concatenate([au.ravel(), -(b[0] @ u[:, 0]) - (b[1] @ u[:, 1])])

    return product


def _chebyshev(matrix: Any) -> Callable[[Floats], Floats]:
    """Return a polynomial of a matrix, scaled by its diagonal, that approximates its inverse.

    Its degree is fixed and it starts from zero. So it is linear, symmetric and positive.
    """
    inverse = 1.0 / matrix.diagonal()[:, None]
    vector = np.random.default_rng(0).standard_normal(matrix.shape[0])
    for _ in range(_POWER_STEPS):
        vector = inverse[:, 0] * (matrix @ vector)
        greatest = float(np.linalg.norm(vector))
        vector /= greatest
    greatest *= _POWER_MARGIN
    middle = 0.5 * greatest * (1.0 + 1.0 / _CHEBYSHEV_SPAN)
    half = 0.5 * greatest * (1.0 - 1.0 / _CHEBYSHEV_SPAN)

    def apply(right: Floats) -> Floats:
        ratio = half / middle
        step = inverse * right / middle
        x = step.copy()
        residual = right
        for _ in range(_CHEBYSHEV_STEPS - 1):
            residual = residual - matrix @ step
            following = 1.0 / (2.0 * middle / half - ratio)
            step = following * ratio * step + (2.0 * following / half) * (inverse * residual)
            ratio = following
            x += step
        return np.asarray(x)

    return apply


def _cahouet_chabard(system: _System, thickness_um: float) -> Callable[[Floats], Floats]:
    """Return the approximate inverse of the pressure's Schur complement."""
    friction = 12.0 / thickness_um**2
    mass = system.pressure_mass
    if friction == 0.0:
        return lambda right: np.asarray(right / mass)
    # A trace of mass makes the stiffness, whose constants are free, invertible.
    trace = 1e-10 * system.pressure_stiffness.diagonal().mean() / mass.mean()
    solved = linalg.splu(
        (system.pressure_stiffness + sparse.diags(trace * mass)).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        options={"SymmetricMode": True},
        diag_pivot_thresh=0.0,
    )

    def apply(right: Floats) -> Floats:
        flat = right - mass * (right.sum() / mass.sum())
        free = solved.solve(flat)
        free -= mass @ free / mass.sum()
        return np.asarray(right / mass + friction * free)

    return apply
