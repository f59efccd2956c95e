"""The depth-averaged flow through an array of pillars, for the engine.

The array's cell repeats itself along and across the flow. Between an inlet and an outlet it stands
with margins of free fluid (`PillarArray.with_margins`), in which the flow gets even again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from pinchoff.chamber.brinkman import Field, solve
from pinchoff.chamber.cell_mesh import build_cell_mesh
from pinchoff.chamber.mesh import Floats, Integers
from pinchoff.model import flow as flows
from pinchoff.model.arrays import PillarArray
from pinchoff.support.arguments import checked_number, checked_positive, finite_or_nan
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber
    from pinchoff.model.flow import Flow
    from pinchoff.support.progress import Show

ELEMENTS = 6.0
"""Elements across a gap unless said otherwise: the drag of a lattice is then right to 0.4 %."""

_NODES_PER_RADIUS, _NODES_PER_GAP, _NODES_PER_LAYER = 12.0, 10.0, 4.0  # of the sampled flow
_TOLERANCE = 1e-7  # the mean speed is then right to 1e-5
_MOST_NODES = 50_000_000
_NARROWEST = 0.02  # gap, D0, that the sampled flow resolves by itself


@dataclass(frozen=True, eq=False)
class ArrayFlow:
    """The flow through an array: lengths in D0, speeds in v_f∞.

    Attributes
    ----------
    array : PillarArray
    thickness : float
        z of the chamber, D0.
    pressure_gradient : float
        Mean fall of the pressure along x over μ v_f∞/D0².
    field : Field
        Velocity and pressure on the mesh of the cell.
    """

    array: PillarArray
    thickness: float
    pressure_gradient: float
    field: Field

    @cached_property
    def mean_velocity(self) -> tuple[float, float]:
        """Velocity averaged over the whole cell, pillars included (Darcy's), v_f∞."""
        total = _integral(self.field)
        u, v = total / (self.array.length * self.array.width)
        return float(u), float(v)

    @property
    def permeability(self) -> float:
        """Darcy's, along x: mean speed over the fall of the pressure, times μ; D0²."""
        return self.mean_velocity[0] / self.pressure_gradient

    @property
    def drag(self) -> float:
        """Mean force along x on a pillar, per height, over μ v_f∞; the plates' friction excluded.

        The pressure's fall carries the pillars and, with a finite thickness, the plates.
        """
        cell = self.array.length * self.array.width
        friction = 12.0 / self.thickness**2 * self.mean_velocity[0] * cell
        return (self.pressure_gradient * cell - friction) / len(self.array.circles)

    def velocity(self, points: ArrayLike) -> Floats:
        """Return the velocity at points, shape (n, 2), anywhere in the endless array.

        It is zero in pillars.
        """
        size = np.array([self.array.length, self.array.width])
        places = np.mod(np.asarray(points, dtype=np.float64).reshape(-1, 2), size)
        found = np.zeros(places.shape)
        left = np.arange(len(places))
        # The mesh's seams are jagged: what one image of the cell lacks, its neighbour has.
        for shift in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)]:
            here = places[left] + np.array(shift) * size
            found[left] = self.field.at(here)
            left = left[(found[left] == 0).all(axis=1)]
        return found

    def sampled(
        self, *, pad: float = 2.0, spacing: float | None = None, periodic: str = ""
    ) -> Flow:
        """Return the flow on a grid, as the engine takes it.

        Parameters
        ----------
        pad : float, optional
            How far beyond the cell's edges the grid goes on, D0: a droplet that has crossed an
            edge meets the array's next image there.
        spacing : float, optional
            Of the grid's nodes, D0; by default 12 nodes across a radius, 10 across the narrowest
            gap and 4 across the layer z/√12 in which the velocity falls to zero.
        periodic : {"", "x", "y", "xy"}, optional
            Along which axes the grid repeats itself for ever, instead of the pad.

        Raises
        ------
        InputError
            A number is not positive, or there would be too many nodes.
        """
        if spacing is None:
            layer = self.thickness / math.sqrt(12.0)
            narrowest = max(self.array.least_gap, _NARROWEST) / _NODES_PER_GAP
            finest = self.array.circles[:, 2].min() / _NODES_PER_RADIUS
            spacing = float(min(narrowest, finest, layer / _NODES_PER_LAYER))
        spacing = checked_positive("spacing", spacing, "give it in D0")
        pad = checked_number("pad", pad, "give it in D0", low=0.0)
        x, x_inner, x_nodes = _axis(self.array.length, pad, spacing, "x" in periodic)
        y, y_inner, y_nodes = _axis(self.array.width, pad, spacing, "y" in periodic)
        if x.size * y.size > _MOST_NODES:
            got = f"{spacing:g}, that is {x.size * y.size:,} nodes"
            rule = f"such that there are at most {_MOST_NODES:,} nodes"
            raise InputError.of("spacing", rule, got, "enlarge it, or take a smaller cell")
        grid = np.stack(np.meshgrid(x_inner, y_inner), axis=-1)
        velocity = self.velocity(grid.reshape(-1, 2)).reshape(grid.shape)
        whole = velocity[np.ix_(y_nodes, x_nodes)]
        return flows.sampled(x, y, whole[..., 0], whole[..., 1], periodic=periodic)


def array_flow(
    array: PillarArray,
    *,
    thickness: float,
    mean_speed: float | None = None,
    pressure_gradient: float | None = None,
    elements: float = ELEMENTS,
    show: Show | None = None,
) -> ArrayFlow:
    """Return the flow through an array, along +x.

    Parameters
    ----------
    array : PillarArray
    thickness : float
        z of the chamber, D0; infinity for the plane Stokes flow.
    mean_speed : float, optional
        Along x, averaged over the cell with its pillars: the speed of the undisturbed fluid before
        the array, v_f∞; by default 1.
    pressure_gradient : float, optional
        In place of it, the mean fall of the pressure along x, μ v_f∞/D0².
    elements : float, optional
        Elements across a gap.
    show : callable, optional
        Called with the number of iterations so far.

    Returns
    -------
    ArrayFlow

    Raises
    ------
    InputError
        A number is out of its range, or both a speed and a pressure are given.
    RuntimeError
        The mesh does not fit the gaps, or the iteration did not converge.

    Examples
    --------
    The drag on the pillars of a square lattice, a tenth of which is solid, is 24.83 μ U
    (Sangani and Acrivos, Int. J. Multiphase Flow 8, 193, 1982):

    >>> import math
    >>> import pinchoff as po
    >>> radius = math.sqrt(0.1 / math.pi)
    >>> lattice = po.arrays.square(rows=1, columns=1, radius=radius, gap=1 - 2 * radius)
    >>> flow = po.chamber.array_flow(lattice, thickness=math.inf)
    >>> abs(flow.drag / 24.83 - 1) < 0.01
    True
    """
    if not isinstance(array, PillarArray):
        raise InputError.of("array", "a PillarArray", array, "build it with pinchoff.arrays")
    if not (thickness == math.inf or finite_or_nan(thickness) > 0):
        raise InputError.of("thickness", "positive", thickness, "give z in D0, or math.inf")
    if mean_speed is not None and pressure_gradient is not None:
        got = f"{mean_speed} and pressure_gradient={pressure_gradient}"
        raise InputError.of("mean_speed", "alone", got, "leave one of them out")
    for name, value in (("mean_speed", mean_speed), ("pressure_gradient", pressure_gradient)):
        if value is not None:
            checked_positive(name, value, "leave it out for a mean speed of 1")
    elements = checked_number("elements", elements, "leave it out for 6", low=3.0, high=64.0)
    mesh = build_cell_mesh(array, elements)
    field = solve(mesh, thickness, pressure_gradient=(-1.0, 0.0), tolerance=_TOLERANCE, show=show)
    unit = ArrayFlow(array, thickness, 1.0, field)
    if pressure_gradient is None:
        wanted = 1.0 if mean_speed is None else mean_speed
        pressure_gradient = wanted / unit.mean_velocity[0]
    # Creeping flow is proportional to what drives it.
    return ArrayFlow(array, thickness, pressure_gradient, field.scaled(pressure_gradient))


def imaging_array(chamber: Chamber) -> PillarArray:
    """Return the obstacles of a device's imaging area as an array, in D0.

    D0 is the droplet diameter of the chamber's operation. The array repeats itself: the chamber's
    side walls are not part of it.

    Parameters
    ----------
    chamber : Chamber
        With a stagger of 0 or 0.5 and, if staggered, an even number of columns left after the
        last odd one is dropped.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber
    >>> array = imaging_array(Chamber())
    >>> len(array.circles)
    30
    """
    imaging = chamber.imaging
    pitch = imaging.pitch_um
    columns = imaging.columns - imaging.columns % 2 if imaging.stagger else imaging.columns
    column, row = np.meshgrid(np.arange(max(columns, 1)), np.arange(imaging.rows), indexing="ij")
    y = np.mod((row + 0.25 + imaging.stagger * (column % 2)) * pitch, imaging.rows * pitch)
    x = (column + 0.5) * pitch
    radii = np.full(x.size, imaging.obstacle_radius_um)
    circles = np.column_stack([x.ravel(), y.ravel(), radii])
    in_um = PillarArray(circles, max(columns, 1) * pitch, imaging.rows * pitch)
    return in_um.scaled(1.0 / chamber.operation.droplet_diameter_um)


def _integral(field: Field) -> Floats:
    """Return the integral of the velocity: quadratic elements are exact at edges' middles."""
    middles = field.velocity[field.nodes_of[3:]].mean(axis=0)
    return np.asarray(field.mesh.areas() @ middles)


def _axis(
    period: float, pad: float, spacing: float, periodic: bool
) -> tuple[Floats, Floats, Integers]:
    """Return a grid axis over cell and pad, the nodes in one period, and each node's among them."""
    count = max(4, math.ceil(period / spacing))
    beyond = math.ceil(pad / (period / count)) if pad else 0
    numbers = np.arange(count) if periodic else np.arange(-beyond, count + beyond + 1)
    step = period / count
    whole = np.asarray(np.mod(numbers, count), dtype=np.int64)
    return np.asarray(numbers * step), np.asarray(np.arange(count) * step), whole
