"""The flow of oil through the device: speeds, pressures, and whether they suit its purpose."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Point

from pinchoff.chamber.brinkman import Field, Source, solve
from pinchoff.chamber.mesh import Floats, Size, build_mesh, wall_size
from pinchoff.support.errors import InputError
from pinchoff.support.paper_constants import OIL_RATES_UL_MIN
from pinchoff.support.quantities import capillary_number, reynolds_number

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.pillars import Pillar
    from pinchoff.support.progress import Show


_ROUND_PILLAR = 2.5  # elements round an obstacle, for each that spans the narrowest gap
_IN_LAYER = 0.1  # elements in the layer z/√12 at a wall, for each that spans the gap
_COARSER = 1.5  # walls outside the imaging area, where nothing is measured
_IN_NARROWS = 3.0  # elements at least in the narrowest channel of all
_LARGEST_UM = 128.0
_SECTION_NODES = 4001
_SECTIONS = 20  # through which the flow is summed
_GRID_UM = 10.0  # of the points at which the imaging area's speed is looked at


class Gap(NamedTuple):
    """The narrowest gap between an obstacle of the imaging area and what stands beside it, µm."""

    width_um: float
    start: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True, eq=False)
class FlowCheck:
    """The computed flow of a device, in µm, mm/s and Pa.

    Attributes
    ----------
    chamber : Chamber
        The device, with the flow rates of its `operation`.
    field : Field
        Velocity in mm/s; pressure over viscosity in mm/(s µm).
    seconds : float
        How long mesh and solution took.
    """

    chamber: Chamber
    field: Field
    seconds: float

    def velocity(self, points_um: Floats) -> Floats:
        """Return the depth-averaged velocity at points, shape (n, 2), in mm/s: zero in solids."""
        return self.field.at(np.asarray(points_um, dtype=np.float64).reshape(-1, 2))

    def pressure_Pa(self, points_um: Floats) -> Floats:  # noqa: N802
        """Return the pressure at points, shape (n, 2), in Pa, where the outlet has none."""
        port = self.chamber.layout.ports["outlet"]
        places = np.vstack([[port.x_um, port.y_um], np.reshape(points_um, (-1, 2))])
        pressure = self.field.pressure_at(places)
        # 1 mPa s × 1 mm/(s µm) is 1 Pa.
        viscosity = self.chamber.operation.viscosity_mPa_s
        return np.asarray((pressure[1:] - pressure[0]) * viscosity)

    def flow_rate_uL_min(  # noqa: N802
        self, x_um: float, from_y_um: float, to_y_um: float
    ) -> float:
        """Return what flows downstream through a line across, µL/min."""
        y = np.linspace(from_y_um, to_y_um, _SECTION_NODES)
        u = self.velocity(np.column_stack([np.full_like(y, x_um), y]))[:, 0]
        return float(np.trapezoid(u, y)) / _rate(1.0, self.chamber.thickness_um)

    @cached_property
    def imaging_speeds(self) -> NDArray[np.float64]:
        """Speed on a square grid over the imaging area, mm/s; NaN in obstacles. Rows go along y."""
        at, chamber = self.chamber.layout.stations, self.chamber
        half = chamber.imaging.rows * chamber.imaging.pitch_um / 2
        x = np.arange(at.imaging + _GRID_UM / 2, at.exit, _GRID_UM)
        y = np.arange(-half + _GRID_UM / 2, half, _GRID_UM)
        grid = np.stack(np.meshgrid(x, y), axis=-1)
        speed = np.hypot(*self.velocity(grid.reshape(-1, 2)).T).reshape(grid.shape[:2])
        fluid = chamber.layout.regions["imaging"]
        inside = shapely.contains_xy(fluid, grid[..., 0], grid[..., 1])
        return np.where(inside, speed, np.nan)

    @property
    def imaging_speed_mm_s(self) -> float:
        """Mean speed of the fluid in the imaging area, mm/s: the v_f∞ of its collisions."""
        return float(np.nanmean(self.imaging_speeds))

    @cached_property
    def summary(self) -> dict[str, float]:
        """The numbers of the check, with their units in their names."""
        return _summary(self)

    def table(self, oil_rates_uL_min: tuple[float, ...] = OIL_RATES_UL_MIN) -> pd.DataFrame:  # noqa: N803
        """Return speed, Ca and Re at other rates of oil, the water in proportion.

        Creeping flow is proportional to its rate. A droplet is taken to travel as fast as the oil
        about it, averaged over the depth.

        Returns
        -------
        DataFrame
            ``oil_rate_uL_min``, ``speed_mm_s``, ``capillary_number``, ``reynolds_number`` and
            ``pressure_drop_Pa``.
        """
        import pandas as pd

        share = np.array(oil_rates_uL_min) / self.chamber.operation.oil_rate_uL_min
        return pd.DataFrame(
            {
                "oil_rate_uL_min": oil_rates_uL_min,
                "speed_mm_s": self.imaging_speed_mm_s * share,
                "capillary_number": self.summary["capillary_number"] * share,
                "reynolds_number": self.summary["reynolds_number"] * share,
                "pressure_drop_Pa": self.summary["pressure_drop_Pa"] * share,
            }
        )

    def central_obstacle(self) -> Pillar:
        """Return the obstacle nearest to the middle of the imaging area."""
        at = self.chamber.layout.stations
        middle = (at.imaging + at.exit) / 2
        obstacles = [p for p in self.chamber.layout.pillars if p.region == "imaging"]
        if not obstacles:
            advice = "give it more rows or columns"
            raise InputError.of("imaging", "an area with an obstacle", "none", advice)
        return min(obstacles, key=lambda p: math.hypot(p.x_um - middle, p.y_um))


def check_flow(chamber: Chamber, *, show: Show | None = None) -> FlowCheck:
    """Compute the flow in a device at the rates of its operation.

    Oil stands for the water too: one viscosity. Ports bring fluid in and out evenly over their
    area, so that all walls are no-slip.

    Parameters
    ----------
    chamber : Chamber
    show : callable, optional
        Called with the number of iterations so far.

    Returns
    -------
    FlowCheck

    Examples
    --------
    A coarse mesh, which is off by a few per cent:

    >>> from pinchoff.chamber import Chamber
    >>> few = {"rows": 4, "columns": 2}
    >>> check = check_flow(Chamber(imaging=few, operation={"elements_across_gap": 4}))
    >>> round(check.imaging_speed_mm_s, 1)
    1.6
    """
    started = time.perf_counter()
    mesh = build_mesh(chamber.layout.fluid, _wall_size(chamber), _LARGEST_UM)
    field = solve(mesh, chamber.thickness_um, sources=_sources(chamber), show=show)
    return FlowCheck(chamber, field, time.perf_counter() - started)


def narrowest_gap(chamber: Chamber) -> Gap:
    """Return the narrowest gap between an obstacle of the imaging area and another solid."""
    layout = chamber.layout
    walls = [p.boundary for p in shapely.get_parts(shapely.union_all(list(layout.walls.values())))]
    others = [*walls, *layout.discs]
    tree = shapely.STRtree(others)
    gaps = []
    for k, (pillar, disc) in enumerate(zip(layout.pillars, layout.discs, strict=True)):
        if pillar.region == "imaging":
            near = tree.query(Point(pillar.x_um, pillar.y_um).buffer(3 * chamber.imaging.pitch_um))
            lines = [shapely.shortest_line(disc, others[j]) for j in near if j != k + len(walls)]
            gaps.append(min(lines, key=lambda line: line.length))
    best: LineString = min(gaps, key=lambda line: line.length)
    start, end = best.coords
    return Gap(best.length, start, end)


def _wall_size(chamber: Chamber) -> Size:
    """Return the element size on walls: fine in the imaging area, coarser but in the narrows."""
    elements = chamber.operation.elements_across_gap
    fine = min(
        wall_size(narrowest_gap(chamber).width_um, elements),
        2 * math.pi * chamber.imaging.obstacle_radius_um / _ROUND_PILLAR / elements,
        chamber.thickness_um / math.sqrt(12.0) / _IN_LAYER / elements,
    )
    narrows = min(
        chamber.inlets.post_gap_um,
        chamber.junction.orifice_width_um,
        chamber.junction.water_width_um,
    )
    coarse = _COARSER * fine
    narrow = min(coarse, narrows / _IN_NARROWS)
    at, half = chamber.layout.stations, chamber.imaging.rows * chamber.imaging.pitch_um / 2

    def size(points: Floats) -> Floats:
        x, y = points.T
        within = (x > at.imaging) & (x < at.exit) & (np.abs(y) < half)
        return np.select([within, x < at.channel], [fine, narrow], coarse)

    return size


def _rate(uL_min: float, thickness_um: float) -> float:  # noqa: N803
    """Return a flow rate per thickness, mm/s µm: 1 µL/min is 1e9 µm³ in 60e3 ms."""
    return uL_min * 1e9 / 60e3 / thickness_um


def _inflow(chamber: Chamber) -> dict[str, float]:
    """Return what comes in through each port, µL/min."""
    operation = chamber.operation
    return {
        "oil": operation.oil_rate_uL_min,
        "water": operation.water_rate_uL_h / 60.0,
        "extra_oil_left": operation.extra_oil_rate_uL_min,
    }


def _sources(chamber: Chamber) -> list[Source]:
    inflow, ports = _inflow(chamber), chamber.layout.ports
    rates = {**inflow, "outlet": -sum(inflow.values())}
    return [
        Source(ports[name].covers, _rate(rate, chamber.thickness_um))
        for name, rate in rates.items()
        if rate
    ]


def _summary(check: FlowCheck) -> dict[str, float]:
    chamber, operation = check.chamber, check.chamber.operation
    speeds, at = check.imaging_speeds, chamber.layout.stations
    speed = check.imaging_speed_mm_s
    half = chamber.junction.channel_width_um / 2
    middle = (at.channel + at.imaging) / 2
    central = check.flow_rate_uL_min(middle, -half, half)
    channel = central * _rate(1.0, chamber.thickness_um) / (2 * half)
    ports = chamber.layout.ports
    inlets = np.array([[ports[name].x_um, ports[name].y_um] for name in ("oil", "water")])
    oil, water = check.pressure_Pa(inlets)
    ca = capillary_number(operation.viscosity_mPa_s, speed, operation.surface_tension_mN_m)
    gap = narrowest_gap(chamber)
    return {
        "imaging_speed_mm_s": speed,
        "imaging_speed_variation": float(np.nanstd(speeds)) / speed,
        "imaging_speed_variation_across": _spread(speeds, chamber.imaging.rows, axis=0),
        "imaging_speed_variation_along": _spread(speeds, chamber.imaging.columns, axis=1),
        "droplet_channel_speed_mm_s": channel,
        "droplet_channel_over_imaging_speed": channel / speed,
        "droplet_channel_share": central / check.flow_rate_uL_min(middle, -1e5, 1e5),
        "pressure_drop_Pa": float(oil),
        "pressure_drop_water_Pa": float(water),
        "capillary_number": float(ca),
        "reynolds_number": reynolds_number(
            operation.density_kg_m3,
            speed,
            chamber.imaging.obstacle_radius_um,
            operation.viscosity_mPa_s,
        ),
        "mass_error": _mass_error(check),
        "narrowest_gap_um": gap.width_um,
        "elements_across_gap": _elements_across(check, gap),
        "triangles": float(len(check.field.mesh.triangles)),
        "iterations": float(check.field.iterations),
        "seconds": round(check.seconds, 3),
    }


def _spread(speeds: Floats, parts: int, axis: int) -> float:
    """Return the standard deviation of strips' mean speeds over their mean.

    The strips are a pitch wide, so that each holds the same share of obstacles.
    """
    strips = np.array_split(speeds, parts, axis=axis)
    means = np.array([np.nanmean(strip) for strip in strips])
    return float(means.std() / means.mean())


def _mass_error(check: FlowCheck) -> float:
    """Return the largest relative difference between the flow through a section and the inflow."""
    chamber, at = check.chamber, check.chamber.layout.stations
    total = sum(_inflow(chamber).values())
    # From behind the corners at which the three channels join: there u is not smooth.
    ends = (at.imaging + 0.25 * chamber.imaging.pitch_um, at.exit + 0.7 * (at.outlet - at.exit))
    wide = chamber.width_um / 2
    through = [check.flow_rate_uL_min(x, -wide, wide) for x in np.linspace(*ends, _SECTIONS)]
    return float(np.max(np.abs(np.array(through) / total - 1.0)))


def _elements_across(check: FlowCheck, gap: Gap) -> float:
    """Return how many elements span the gap: its length in edges of the triangles it crosses."""
    share = (np.arange(2000) + 0.5)[:, None] / 2000
    points = np.array(gap.start) * (1 - share) + np.array(gap.end) * share
    mesh = check.field.mesh
    triangle = mesh.locate(points)
    edges = np.sqrt(mesh.areas()[triangle[triangle >= 0]] * 4.0 / math.sqrt(3.0))
    return float(np.mean(1.0 / edges) * gap.width_um)
