"""The design-rule check: finds where mask, SU-8 or PDMS could not hold a layout."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import shapely
from shapely import MultiPolygon, Point, Polygon, STRtree
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.shapes import polygons
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.layout import Layout

_MITRE = 2.0  # sharper corners than 2 asin(1/2) = 60° count as too narrow
_SPECK = 0.02  # of the least width squared: what the chords of a curve leave over is smaller
_SLIVER = 0.02  # of the least width: as exact as offsets of a long wall are
_OVERLAP_UM2 = 0.01


class Violation(NamedTuple):
    """A rule that a layout breaks, and where.

    Attributes
    ----------
    rule : str
        ``gap``, ``wall``, ``span``, ``overlap``, ``cut pillar``, ``island`` or ``path``.
    x_um, y_um : float
        Where, in the design's coordinates.
    says : str
        What is wrong, with the limit.
    shape : BaseGeometry
        What to mark in a picture, µm.
    """

    rule: str
    x_um: float
    y_um: float
    says: str
    shape: BaseGeometry

    def __str__(self) -> str:
        return f"{self.rule} at ({self.x_um:.0f}, {self.y_um:.0f}) µm: {self.says}"


def check_rules(chamber: Chamber, layout: Layout | None = None) -> list[Violation]:
    """Return every place where a layout breaks the rules of a device.

    Parameters
    ----------
    chamber : Chamber
        Its rules and its thickness set the limits.
    layout : Layout, optional
        By default the chamber's own.

    Returns
    -------
    list of Violation
        Empty for a layout that can be made.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber
    >>> check_rules(Chamber())
    []
    >>> narrow = Chamber(rules={"on_violation": "warn"}, junction={"orifice_width_um": 18})
    >>> print(*check_rules(narrow))
    gap at (5774, 0) µm: the fluid is narrower than 21.25 µm
    """
    layout = chamber.layout if layout is None else layout
    gap, wall = chamber.least_gap_um, chamber.least_wall_um
    span = chamber.rules.largest_span_ratio * chamber.thickness_um
    solid = shapely.difference(layout.outline, layout.fluid)
    return [
        *_narrower("gap", layout.fluid, gap, f"the fluid is narrower than {gap:g} µm"),
        *_narrower("wall", solid, wall, f"the solid is thinner than {wall:g} µm"),
        *_too_wide(layout, span),
        *_overlapping(layout),
        *_cut_pillars(layout),
        *_islands(layout),
        *_blocked(layout, gap),
    ]


def broken_rules(violations: Iterable[Violation]) -> dict[str, list[Violation]]:
    """Return the violations of each limit by a line of text, which names the first place.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber
    >>> narrow = Chamber(rules={"on_violation": "warn"}, oil_inputs={"channel_width_um": 15})
    >>> print(next(iter(broken_rules(check_rules(narrow)))))
    gap at (6580, 2400) µm and at 1 other place: the fluid is narrower than 21.25 µm
    """
    limits: dict[tuple[str, str], list[Violation]] = {}
    for violation in violations:
        limits.setdefault((violation.rule, violation.says), []).append(violation)
    return {_line(places): places for places in limits.values()}


def _line(places: list[Violation]) -> str:
    first, *others = places
    if not others:
        return str(first)
    where, says = str(first).split(": ", 1)
    return f"{where} and at {counted(len(others), 'other place')}: {says}"


def require_rules(violations: list[Violation]) -> None:
    """Refuse a layout that breaks rules.

    Raises
    ------
    InputError
        There is a violation; says how many and names the first.
    """
    if violations:
        more = f" and {len(violations) - 1} more" if len(violations) > 1 else ""
        raise InputError.of(
            "the chamber",
            "within its design rules",
            f"{violations[0]}{more}",
            "change the design or its rules, or set rules.on_violation = 'warn'",
        )


def _violation(rule: str, shape: BaseGeometry, says: str) -> Violation:
    place = shape.representative_point()
    return Violation(rule, round(place.x) + 0.0, round(place.y) + 0.0, says, shape)


def _opened(shape: BaseGeometry, width: float) -> BaseGeometry:
    """Return the parts of a shape that are at least this wide, with their corners."""
    half = width / 2
    kept = shape.buffer(-half, join_style="mitre", mitre_limit=_MITRE)
    return kept.buffer(half, join_style="mitre", mitre_limit=_MITRE)


def _narrower(rule: str, shape: BaseGeometry, width: float, says: str) -> Iterator[Violation]:
    """Yield the parts of a shape that are narrower than a width."""
    rest = shapely.difference(shape, _opened(shape, width * (1.0 - 1e-6)))
    sliver = _SLIVER * width
    real = rest.buffer(-sliver).buffer(sliver, join_style="mitre")
    for part in polygons(real):
        if part.area > _SPECK * width**2:
            yield _violation(rule, part, says)


def _too_wide(layout: Layout, most: float) -> Iterator[Violation]:
    """Yield fluid whose ceiling would sag: farther from any solid than half the largest span.

    Ports are left out, where there is a hole in the ceiling.
    """
    holes = [Point(port.x_um, port.y_um).buffer(port.radius_um) for port in layout.ports.values()]
    says = f"nothing holds the ceiling over more than {most:g} µm"
    middle = layout.fluid.buffer(-most / 2)
    for part in polygons(shapely.difference(middle, shapely.union_all(holes))):
        yield _violation("span", part, says)


def _overlapping(layout: Layout) -> Iterator[Violation]:
    regions = [part for shape in layout.regions.values() for part in polygons(shape)]
    yield from _pairs(regions, "two regions overlap")
    yield from _pairs(layout.discs, "two pillars overlap")
    for name, mark in layout.marks.items():
        shared = shapely.intersection(mark, layout.fluid)
        if shared.area > _OVERLAP_UM2:
            yield _violation("overlap", shared, f"{name} lies over the fluid")


def _pairs(shapes: list[BaseGeometry], says: str) -> Iterator[Violation]:
    first, second = STRtree(shapes).query(shapes, predicate="intersects")
    for i, j in zip(first, second, strict=True):
        shared = shapely.intersection(shapes[i], shapes[j]) if i < j else None
        if shared is not None and shared.area > _OVERLAP_UM2:
            yield _violation("overlap", shared, says)


def _cut_pillars(layout: Layout) -> Iterator[Violation]:
    """Yield pillars that are not a hole of their own in the fluid."""
    holes = _solid_in_fluid(layout)
    tree = STRtree(holes)
    for pillar, drawn in zip(layout.pillars, layout.discs, strict=True):
        near = tree.query(Point(pillar.x_um, pillar.y_um), predicate="intersects")
        whole = any(abs(holes[k].area - drawn.area) < 1e-3 * drawn.area for k in near)
        if not whole:
            says = f"the pillar of radius {pillar.radius_um:g} µm is cut by a wall or another"
            yield _violation("cut pillar", drawn, says)


def _islands(layout: Layout) -> Iterator[Violation]:
    """Yield fluid that no port reaches, and solid in the fluid that is no pillar."""
    ports = [Point(port.x_um, port.y_um) for port in layout.ports.values()]
    for part in layout.fluid.geoms:
        if not any(part.intersects(point) for point in ports):
            yield _violation("island", part, "no port reaches this fluid")
    pillars = shapely.union_all(layout.discs)
    least = min((disc.area for disc in layout.discs), default=0.0)
    for part in _solid_in_fluid(layout):
        if not part.intersects(pillars) and part.area < least:
            yield _violation("island", part, "this solid in the fluid is no pillar")


def _solid_in_fluid(layout: Layout) -> list[Polygon]:
    return [Polygon(ring) for part in layout.fluid.geoms for ring in part.interiors]


def _blocked(layout: Layout, least: float) -> Iterator[Violation]:
    """Yield inlets from which no path of the least width leads to the outlet."""
    open_fluid = layout.fluid.buffer(-least / 2 * (1.0 - 1e-6))
    parts = MultiPolygon(polygons(open_fluid)).geoms
    places = {name: Point(port.x_um, port.y_um) for name, port in layout.ports.items()}
    reached = [part for part in parts if part.intersects(places["outlet"])]
    for name, place in places.items():
        if not any(part.intersects(place) for part in reached):
            says = f"no path {least:g} µm wide leads from port {name} to the outlet"
            yield _violation("path", place.buffer(layout.ports[name].radius_um), says)
