"""The geometry of the device, which masks, checks, flows and pillar positions all follow from.

Polygons in µm on a grid of 1 nm; x points downstream, the device begins at x = 0 and is symmetric
about y = 0. The fluid is one shape, cut into the regions of appendix A without gap or overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon, box
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.marks import build_marks
from pinchoff.chamber.parts import FLANK_SHARE
from pinchoff.chamber.pillars import Pillar
from pinchoff.chamber.shapes import (
    channel,
    disc,
    inside,
    mirrored,
    on_grid,
    polygons,
    staggered,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.chamber.device import Device

REGIONS = ("inlets", "junction", "oil_inputs", "expansion", "supports", "imaging", "exit")
"""Regions 1 to 7 of appendix A, by the names of their parameters."""


class Port(NamedTuple):
    """A punched hole through which fluid comes or goes, µm."""

    x_um: float
    y_um: float
    radius_um: float

    def covers(self, points_um: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which points, shape (n, 2), lie in it."""
        away = np.hypot(points_um[:, 0] - self.x_um, points_um[:, 1] - self.y_um)
        return np.asarray(away < self.radius_um)


class Stations(NamedTuple):
    """Where along x one part ends and the next begins, µm."""

    oil_trap: float
    arms: float
    water_port: float
    water_trap: float
    cross: float
    channel: float
    expansion: float
    straight: float
    imaging: float
    exit: float
    outlet: float
    end: float


@dataclass(frozen=True, eq=False)
class Layout:
    """Shapes of the device, µm.

    Attributes
    ----------
    regions : dict of str to MultiPolygon
        The fluid of each of `REGIONS`, with holes where pillars stand.
    walls : dict of str to MultiPolygon
        The same regions as if there were no pillars.
    pillars : list of Pillar
        All of them, region by region.
    ports : dict of str to Port
        ``oil``, ``water``, ``extra_oil_left``, ``extra_oil_right`` (seen downstream) and
        ``outlet``.
    marks : dict of str to MultiPolygon
        What else is on the mask, as `pinchoff.chamber.marks` names it.
    outline : Polygon
        The edge of the chip.
    stations : Stations
        Where the parts begin.
    tolerance_um : float
        How far a chord may stand off its curve.
    """

    regions: dict[str, MultiPolygon]
    walls: dict[str, MultiPolygon]
    pillars: list[Pillar]
    ports: dict[str, Port]
    marks: dict[str, MultiPolygon]
    outline: Polygon
    stations: Stations
    tolerance_um: float

    @cached_property
    def fluid(self) -> MultiPolygon:
        """All of the fluid, as one shape."""
        return MultiPolygon(polygons(shapely.union_all(list(self.regions.values()))))

    @cached_property
    def discs(self) -> list[Polygon]:
        """Every pillar, as it is drawn."""
        return [disc(p.x_um, p.y_um, p.radius_um, self.tolerance_um) for p in self.pillars]


def build_layout(device: Device) -> Layout:
    """Return the geometry of a device."""
    stations = _stations(device)
    ports = _ports(device, stations)
    tolerance = device.mask.chord_tolerance_um
    body, zones = _body(device, stations, ports), _zones(device, stations)
    pillars = _pillars(device, stations, zones)
    solid = shapely.union_all([disc(*p[:3], tolerance) for p in pillars])
    walls = {name: on_grid(shapely.intersection(body, zones[name])) for name in REGIONS}
    regions = {name: on_grid(shapely.difference(walls[name], solid)) for name in REGIONS}
    left, low, right, high = body.bounds
    margin = device.mask.margin_um
    outline = box(left - margin, low - margin, right + margin, high + margin)
    marks = build_marks(device, outline)
    return Layout(regions, walls, pillars, ports, marks, outline, stations, tolerance)


def _stations(device: Device) -> Stations:
    inlets, junction, expansion = device.inlets, device.junction, device.expansion
    port = inlets.port_diameter_um
    oil_trap = port + inlets.trap_length_um
    arms = oil_trap + inlets.arm_width_um / 2
    water_port = arms + inlets.arm_width_um / 2 + inlets.wall_um + port / 2
    water_trap = water_port + port / 2 + inlets.trap_length_um
    funnel = (_trap_width(device) - junction.water_width_um) / 2
    cross = water_trap + funnel + inlets.wall_um + junction.cross_width_um / 2
    behind = cross + junction.cross_width_um / 2
    straight = behind + inlets.wall_um + expansion.length_um
    imaging = straight + expansion.straight_um
    leaving = imaging + device.imaging.columns * device.imaging.pitch_um
    outlet = leaving + device.exit.length_um
    return Stations(
        oil_trap=oil_trap,
        arms=arms,
        water_port=water_port,
        water_trap=water_trap,
        cross=cross,
        channel=behind + junction.orifice_length_um + junction.taper_length_um,
        expansion=behind + inlets.wall_um,
        straight=straight,
        imaging=imaging,
        exit=leaving,
        outlet=outlet,
        end=outlet + device.exit.port_diameter_um / 2,
    )


def _trap_width(device: Device) -> float:
    """Width of a field of posts: about the port's, but a whole number of posts and gaps."""
    inlets = device.inlets
    pitch = inlets.post_diameter_um + inlets.post_gap_um
    posts = max(1, int((inlets.port_diameter_um - inlets.post_gap_um) / pitch))
    return posts * pitch + inlets.post_gap_um


def _arm_y(device: Device) -> float:
    """Middle of an oil channel that passes the water inlet."""
    inlets = device.inlets
    return inlets.port_diameter_um / 2 + inlets.wall_um + inlets.arm_width_um / 2


def _ports(device: Device, at: Stations) -> dict[str, Port]:
    inlet, extra = device.inlets.port_diameter_um / 2, device.oil_inputs.port_diameter_um / 2
    outer = _arm_y(device) + device.inlets.arm_width_um / 2
    side = outer + device.inlets.wall_um + extra
    return {
        "oil": Port(inlet, 0.0, inlet),
        "water": Port(at.water_port, 0.0, inlet),
        "extra_oil_left": Port(at.expansion - extra, side, extra),
        "extra_oil_right": Port(at.expansion - extra, -side, extra),
        "outlet": Port(at.outlet, 0.0, device.exit.port_diameter_um / 2),
    }


def _body(device: Device, at: Stations, ports: dict[str, Port]) -> BaseGeometry:
    """Return the fluid as if there were no pillars."""
    tolerance = device.mask.chord_tolerance_um
    holes = [disc(*port, tolerance) for port in ports.values()]
    return shapely.union_all(
        [
            *holes,
            *_inlet_shapes(device, at, ports),
            *_junction_shapes(device, at),
            mirrored(_side_shape(device, at)),
            mirrored(_extra_shape(device, at, ports["extra_oil_left"])),
            box(at.imaging, -device.width_um / 2, at.exit, device.width_um / 2),
            _exit_shape(device, at),
        ]
    )


def _inlet_shapes(device: Device, at: Stations, ports: dict[str, Port]) -> list[BaseGeometry]:
    half, water = _trap_width(device) / 2, device.junction.water_width_um / 2
    y, tolerance = _arm_y(device), device.mask.chord_tolerance_um
    arms = [(at.expansion, y), (at.arms, y), (at.arms, -y), (at.expansion, -y)]
    funnel = at.water_trap + half - water
    return [
        box(ports["oil"].x_um, -half, at.arms, half),
        channel(arms, device.inlets.arm_width_um, tolerance),
        box(at.water_port, -half, at.water_trap, half),
        Polygon(
            [
                (at.water_trap, -half),
                (funnel, -water),
                (funnel, water),
                (at.water_trap, half),
            ]
        ),
        box(funnel, -water, at.cross, water),
    ]


def _junction_shapes(device: Device, at: Stations) -> list[BaseGeometry]:
    junction, y = device.junction, _arm_y(device)
    cross, orifice = junction.cross_width_um / 2, junction.orifice_width_um / 2
    half = junction.channel_width_um / 2
    taper = at.channel - junction.taper_length_um
    return [
        box(at.cross - cross, -y, at.cross + cross, y),
        box(at.cross, -orifice, taper, orifice),
        Polygon([(taper, -orifice), (at.channel, -half), (at.channel, half), (taper, orifice)]),
        box(at.channel, -half, at.imaging, half),
    ]


def _side_shape(device: Device, at: Stations) -> Polygon:
    """Return the side channel at y > 0, from where it widens to the imaging area."""
    y, half = _arm_y(device), device.inlets.arm_width_um / 2
    inner = device.junction.channel_width_um / 2 + device.expansion.divider_um
    outer = device.width_um / 2
    return Polygon(
        [
            (at.expansion, y - half),
            (at.straight, inner),
            (at.imaging, inner),
            (at.imaging, outer),
            (at.straight, outer),
            *_mouth(device, at),
            (at.expansion, y + half),
        ]
    )


def _extra_shape(device: Device, at: Stations, port: Port) -> BaseGeometry:
    """Return the channel from an extra oil inlet to where it meets the wall that widens."""
    half = device.oil_inputs.channel_width_um / 2
    high, low = _mouth(device, at)
    side = port.y_um - half
    start = [(port.x_um, port.y_um + half), (port.x_um, side)]
    return Polygon([*start, (low[0], side), low, high])


def _mouth(device: Device, at: Stations) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return where the outer wall of the side channel is open to extra oil, its upper end first.

    The solid between the two channels ends in a face as wide as the thinnest wall that can be
    made, not in an edge. Both shapes have these very points as corners, so that no sliver is left
    between them on the grid.
    """
    y = _ports(device, at)["extra_oil_left"].y_um
    half = device.oil_inputs.channel_width_um / 2
    narrow = _arm_y(device) + device.inlets.arm_width_um / 2
    slope = device.expansion.length_um / (device.width_um / 2 - narrow)
    ends = y + half, max(y - half - device.least_wall_um, narrow)
    high, low = ((round(at.expansion + slope * (e - narrow), 3), round(e, 3)) for e in ends)
    return high, low


def _exit_shape(device: Device, at: Stations) -> Polygon:
    wide, narrow = device.width_um / 2, device.exit.width_um / 2
    return Polygon([(at.exit, -wide), (at.outlet, -narrow), (at.outlet, narrow), (at.exit, wide)])


def _zones(device: Device, at: Stations) -> dict[str, BaseGeometry]:
    """Return shapes that divide the plane, where there is fluid, into the regions."""
    far = 2 * (at.end + device.width_um)
    half = device.junction.channel_width_um / 2
    area = device.imaging.rows * device.imaging.pitch_um / 2
    outer = _arm_y(device) + device.inlets.arm_width_um / 2
    side = mirrored(_side_shape(device, at))
    taper = shapely.intersection(side, box(-far, -far, at.straight, far))
    inlets = box(-far, -outer, at.water_trap, outer)
    junction = shapely.union(
        box(at.water_trap, -outer, at.expansion, outer),
        box(at.expansion, -half, at.imaging, half),
    )
    sides = box(at.straight, half, at.imaging, far)
    flanks = box(at.imaging, area, at.exit, far)
    return {
        "inlets": inlets,
        "junction": junction,
        "oil_inputs": shapely.difference(mirrored(box(-far, outer, at.straight, far)), taper),
        "expansion": taper,
        "supports": mirrored(shapely.union(sides, flanks)),
        "imaging": box(at.imaging, -area, at.exit, area),
        "exit": box(at.exit, -far, far, far),
    }


def _pillars(device: Device, at: Stations, zones: dict[str, BaseGeometry]) -> list[Pillar]:
    radius = device.imaging.obstacle_radius_um
    structural = device.supports.radius_um
    groups = (
        ("inlets", _posts(device, at), device.inlets.post_diameter_um / 2),
        ("imaging", _obstacles(device, at, zones["imaging"]), radius),
        ("exit", _exit_obstacles(device, at), radius),
        ("supports", _supports(device, at), structural),
    )
    pillars = [
        Pillar(x, y, size, name)
        for name, points, size in groups
        for x, y in np.round(points, 3).tolist()
    ]
    taper = [p.region == "supports" and p.x_um < at.straight for p in pillars]
    named = [
        p._replace(region="expansion") if t else p for p, t in zip(pillars, taper, strict=True)
    ]
    return sorted(named, key=lambda p: (REGIONS.index(p.region), p.x_um, p.y_um))


def _posts(device: Device, at: Stations) -> NDArray[np.float64]:
    """Return where posts stand behind the oil and the water port."""
    inlets = device.inlets
    pitch = inlets.post_diameter_um + inlets.post_gap_um
    across = _trap_width(device)
    count = round((across - inlets.post_gap_um) / pitch)
    spacing = pitch * math.sqrt(3) / 2
    fields = []
    for end in (at.oil_trap, at.water_trap):
        room = inlets.trap_length_um - pitch
        columns = max(1, int(room / spacing) + 1)
        x = end - pitch / 2 - spacing * np.arange(columns)[::-1]
        field = staggered(x, pitch, count, 0.5)
        fields.append(field[np.abs(field[:, 1]) <= (across - pitch) / 2])
    return np.concatenate(fields)


def _obstacles(device: Device, at: Stations, area: BaseGeometry) -> NDArray[np.float64]:
    """Return the lattice of the imaging area, without what its edge would cut."""
    imaging = device.imaging
    x = at.imaging + (np.arange(imaging.columns) + 0.5) * imaging.pitch_um
    points = staggered(x, imaging.pitch_um, imaging.rows, imaging.stagger)
    return inside(points, area.buffer(-imaging.obstacle_radius_um - device.least_gap_um / 2))


def _exit_obstacles(device: Device, at: Stations) -> NDArray[np.float64]:
    """Return where the lattice goes on between the walls that converge."""
    imaging = device.imaging
    count = math.ceil(device.width_um / imaging.pitch_um) + 1
    count += (count - imaging.rows) % 2  # so that rows go on as rows
    columns = math.ceil(device.exit.length_um / imaging.pitch_um)
    first = imaging.columns % 2
    x = at.exit + (np.arange(-first, columns) + 0.5) * imaging.pitch_um
    points = staggered(x, imaging.pitch_um, count, imaging.stagger)
    before = box(at.exit - imaging.pitch_um, -device.width_um / 2, at.exit, device.width_um / 2)
    walls = shapely.union(before, _exit_shape(device, at))
    kept = inside(points, walls.buffer(-imaging.pitch_um / 3, join_style="mitre"))
    return kept[kept[:, 0] > at.exit]


def _supports(device: Device, at: Stations) -> NDArray[np.float64]:
    """Return where structural pillars stand: a lattice before the imaging area, rows beside it."""
    pitch, flank = device.supports.pitch_um, device.supports.flank_um
    side = _side_shape(device, at)
    count = 2 * math.ceil(device.width_um / 2 / pitch) + 1
    columns = int((at.imaging - at.expansion) / pitch)
    x = at.imaging - (np.arange(columns) + 0.5) * pitch
    lattice = staggered(x, pitch, count, 0.5)
    room = side.buffer(-device.supports.radius_um - pitch / 5, join_style="mitre")
    before = inside(lattice, room)
    columns = int((at.exit - at.imaging) / pitch)
    x = (at.imaging + at.exit) / 2 + (np.arange(columns) - (columns - 1) / 2) * pitch
    middle = device.width_um / 2 - (1.0 - FLANK_SHARE) * flank
    # Nearer to the imaging area, where the lattice leaves room at its edge.
    beside = np.column_stack([x, np.full(columns, middle)])
    left = np.concatenate([before, beside])
    return np.concatenate([left, left * [1.0, -1.0]])
