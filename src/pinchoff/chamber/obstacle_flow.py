"""The computed flow round one obstacle in the engine, beside the Stokes flow of the paper."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from shapely import LineString, Point

from pinchoff.model import flow as flows
from pinchoff.model.parameters import Parameters, PhysicalScale
from pinchoff.model.simulation import Collision, Flow, simulate
from pinchoff.studies.boundary import Boundary, boundary
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.chamber.flow_check import FlowCheck
    from pinchoff.chamber.pillars import Pillar

NODES_PER_RADIUS = 12.0
"""Nodes at least of the sampled flow across the obstacle's radius."""

NODES_PER_LAYER = 4.0
"""Nodes at least across the layer z/√12 in which the velocity falls to zero."""

SIMULATION_CAPILLARY_NUMBERS = (20.0, 28.0, 40.0, 56.0, 80.0)
"""At which the separating lines of the two flows are compared."""

OFFSET = 0.05
"""Start y of the collision that is shown, D0."""

_BEHIND, _ASIDE = 5.0, 2.5  # extent of the sampled flow downstream and sideways, D0
_FARTHEST, _NEAREST = 3.0, 0.75  # start of the droplet, D0
_SCAN = 16  # intervals over the offset, at each point of a line
_CLEARANCE = 0.1  # of the droplet to solids on its way, D0
_STRIDE = 0.05  # of the search for its start, D0


@dataclass(frozen=True, eq=False)
class FlowComparison:
    """Collisions in the chamber's flow and in the Stokes flow, all else equal.

    Attributes
    ----------
    obstacle : Pillar
        The obstacle that stands at the origin of both.
    flow : Flow
        The chamber's, in D0 and v_f∞, the mean speed in the imaging area.
    in_chamber, in_stokes : Collision
        One collision each, with outlines.
    line_in_chamber, line_in_stokes : Boundary
        The separating line of each flow.
    """

    obstacle: Pillar
    flow: Flow
    in_chamber: Collision
    in_stokes: Collision
    line_in_chamber: Boundary
    line_in_stokes: Boundary

    def to_dict(self) -> dict[str, Any]:
        """Return for either flow the collision, S_c, and α and β of the line, or None."""
        runs = {"chamber": self.in_chamber, "stokes": self.in_stokes}
        lines = {"chamber": self.line_in_chamber, "stokes": self.line_in_stokes}
        return {
            "obstacle": self.obstacle._asdict(),
            "start_distance_D0": self.in_chamber.parameters.start_distance,
            **{name: _reported(runs[name], lines[name]) for name in runs},
        }


def flow_around(
    check: FlowCheck, obstacle: Pillar | None = None, *, before: float = _FARTHEST + 1.0
) -> Flow:
    """Return the computed flow round an obstacle, for the engine.

    Parameters
    ----------
    check : FlowCheck
    obstacle : Pillar, optional
        By default the one nearest to the middle of the imaging area.
    before : float, optional
        How far upstream of the obstacle it reaches, D0.

    Returns
    -------
    Flow
        With the obstacle's centre at the origin, in units of the operation's droplet diameter D0
        and of the mean speed in the imaging area; zero in every pillar.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber, check_flow
    >>> few = {"rows": 4, "columns": 2}
    >>> check = check_flow(Chamber(imaging=few, operation={"elements_across_gap": 4}))
    >>> along, across = flow_around(check).velocity(np.array([[-2.0, 0.0]]))[0]
    >>> bool(0.8 < along < 1.2), bool(abs(across) < 0.05)
    (True, True)
    """
    obstacle = check.central_obstacle() if obstacle is None else obstacle
    diameter = check.chamber.operation.droplet_diameter_um
    layer = check.chamber.thickness_um / math.sqrt(12.0)
    spacing = min(obstacle.radius_um / NODES_PER_RADIUS, layer / NODES_PER_LAYER) / diameter
    x = np.arange(-before, _BEHIND + spacing, spacing)
    y = np.arange(-_ASIDE, _ASIDE + spacing, spacing)
    grid = np.stack(np.meshgrid(x, y), axis=-1) * diameter
    places = grid.reshape(-1, 2) + np.array([obstacle.x_um, obstacle.y_um])
    velocity = check.velocity(places).reshape(grid.shape) / check.imaging_speed_mm_s
    return flows.sampled(x, y, velocity[..., 0], velocity[..., 1])


def collision_parameters(check: FlowCheck, obstacle: Pillar, offset: float) -> Parameters:
    """Return the parameters of a collision with an obstacle at the operation's rates.

    The droplet starts at y = `offset`, D0, as far upstream as the obstacles before this one let it,
    and no farther than 3 D0.
    """
    operation, chamber = check.chamber.operation, check.chamber
    scale = PhysicalScale(
        diameter_um=operation.droplet_diameter_um,
        obstacle_radius_um=obstacle.radius_um,
        speed_mm_s=check.imaging_speed_mm_s,
        viscosity_mPa_s=operation.viscosity_mPa_s,
        surface_tension_mN_m=operation.surface_tension_mN_m,
        thickness_um=chamber.thickness_um,
    )
    return Parameters.of_scale(
        scale,
        offset_um=offset * operation.droplet_diameter_um,
        start_distance=start_distance(check, obstacle),
    )


def compare_with_stokes(
    check: FlowCheck,
    *,
    capillary_numbers: Sequence[float] = SIMULATION_CAPILLARY_NUMBERS,
    progress: bool | None = False,
) -> FlowComparison:
    """Run the same collisions in the chamber's flow and in the Stokes flow of the paper.

    Both have one obstacle, the same droplet and the same start; the separating lines vary the
    offset on the side of y > 0.

    Parameters
    ----------
    check : FlowCheck
    capillary_numbers : sequence of float, optional
        Ca_sim of the points of the lines.
    progress : bool, optional
        As for `pinchoff.boundary`.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber, check_flow
    >>> few = {"rows": 4, "columns": 2}
    >>> check = check_flow(Chamber(imaging=few, operation={"elements_across_gap": 4}))
    >>> compared = compare_with_stokes(check, capillary_numbers=[80.0])
    >>> compared.in_stokes.outcome
    'broke'
    """
    obstacle = check.central_obstacle()
    parameters = collision_parameters(check, obstacle, OFFSET)
    flow = flow_around(check, obstacle, before=parameters.start_distance + 1.0)
    points = {"simulation_capillary_number": list(capillary_numbers)}
    base = parameters.replace(scale=None)
    lines = []
    for around in (flow, None):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # Boundary.failures has them
            lines.append(boundary(base, points, scan=_SCAN, progress=progress, flow=around))
    return FlowComparison(
        obstacle,
        flow,
        simulate(parameters, flow=flow, outlines=True),
        simulate(parameters, outlines=True),
        *lines,
    )


def _reported(collision: Collision, line: Boundary) -> dict[str, Any]:
    try:
        fit = line.fit()
        fitted = [fit.alpha.value, fit.beta.value]
    except InputError:  # too few points have a critical symmetry
        fitted = None
    return {
        "outcome": collision.outcome,
        "symmetry": collision.symmetry,
        "contact_speed": collision.contact_speed,
        "daughter_area_ratio": collision.daughter_area_ratio,
        "control_parameter": line.table["control_parameter"].tolist(),
        "critical_symmetry": line.table["critical_symmetry"].tolist(),
        "line": fitted,
    }


def start_distance(check: FlowCheck, obstacle: Pillar) -> float:
    """Return how far upstream a head-on droplet can start with its way clear of solids, D0.

    Raises
    ------
    InputError
        It has no clear way at all.
    """
    layout = check.chamber.layout
    diameter = check.chamber.operation.droplet_diameter_um
    here = (obstacle.x_um, obstacle.y_um)
    own = Point(here).buffer(1.01 * obstacle.radius_um)
    room = shapely.union(layout.fluid, own)
    shapely.prepare(room)
    nearest = max(_NEAREST, obstacle.radius_um / diameter + 0.5 + _CLEARANCE)
    for distance in np.arange(_FARTHEST, nearest, -_STRIDE):
        way = LineString([(here[0] - distance * diameter, here[1]), here])
        if room.contains(way.buffer((0.5 + _CLEARANCE) * diameter)):
            return float(distance)
    raise InputError.of(
        "operation.droplet_diameter_um",
        "such that the droplet fits between the obstacles upstream",
        diameter,
        "lower it, or raise imaging.pitch_um",
    )
