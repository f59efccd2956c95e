"""The moulded channels as a solid: OpenSCAD source and STL, in mm as those programs expect."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.layout import REGIONS
from pinchoff.chamber.shapes import polygons, quarter_segments
from pinchoff.support.files import write_text, written_aside

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = b"pinchoff chamber, relief of the mould, mm"
_COLORS = ("Gold", "LightGreen", "Green", "LightSkyBlue", "DarkBlue", "Violet", "Orange")


def write_stl(chamber: Chamber, path: Path) -> None:
    """Write the relief of the mould, the fluid at its height, as binary STL in mm.

    Examples
    --------
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> write_stl(Chamber(), Path("mould.stl"))
    >>> Path("mould.stl").exists()
    True
    """
    corners = _triangles(chamber) * 1e-3
    records = np.zeros(len(corners), dtype=_TRIANGLE)
    records["corners"] = corners
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    records["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    with written_aside(path) as unfinished, unfinished.open("wb") as file:
        file.write(_HEADER.ljust(80, b" "))
        file.write(np.uint32(len(records)).tobytes())
        file.write(records.tobytes())


def _triangles(chamber: Chamber) -> NDArray[np.float64]:
    """Return the surface of the relief, shape (n, 3, 3), µm, normals outwards."""
    height = chamber.thickness_um
    parts = []
    for polygon in polygons(chamber.layout.fluid):
        polygon = shapely.orient_polygons(polygon)  # outside anticlockwise, holes clockwise
        flat = _flat_triangles(polygon)
        parts += [_raised(flat, height), _raised(flat[:, ::-1], 0.0)]
        for ring in (polygon.exterior, *polygon.interiors):
            parts.append(_side(np.asarray(ring.coords), height))
    return np.concatenate(parts)


def _flat_triangles(polygon: Polygon) -> NDArray[np.float64]:
    """Return triangles that fill a polygon without new vertices, anticlockwise, (n, 3, 2)."""
    found = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turned = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0
    corners[turned] = corners[turned][:, ::-1]
    return np.asarray(corners)


def _raised(flat: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    return np.concatenate([flat, np.full((*flat.shape[:2], 1), height)], axis=2)


def _side(ring: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    """Return the wall over a closed ring, whose solid lies to its left."""
    low = np.column_stack([ring, np.zeros(len(ring))])
    high = np.column_stack([ring, np.full(len(ring), height)])
    first = np.stack([low[:-1], low[1:], high[1:]], axis=1)
    second = np.stack([low[:-1], high[1:], high[:-1]], axis=1)
    return np.concatenate([first, second])


def write_scad(chamber: Chamber, path: Path) -> None:
    """Write OpenSCAD source in mm: a module for each region, pillars as lists of their places.

    Examples
    --------
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> write_scad(Chamber(), Path("mould.scad"))
    >>> Path("mould.scad").exists()
    True
    """
    write_text(path, scad_source(chamber))


def scad_source(chamber: Chamber) -> str:
    """Return the OpenSCAD source."""
    layout, tolerance = chamber.layout, chamber.mask.chord_tolerance_um
    present = [name for name in REGIONS if any(p.region == name for p in layout.pillars)]
    lines = [
        "// The microfluidic chamber, written by pinchoff. Lengths in mm.",
        "// mould(): the relief in SU-8 on its wafer, from which the PDMS is cast.",
        "// device(): the PDMS that comes off it, channels down.",
        "// relief(): what stands on the wafer, the fluid at its height.",
        'show = "mould"; // [mould, device, relief]',
        f"z = {_mm(chamber.thickness_um)}; // height of the channels",
        "base = 0.5; // thickness of the wafer that is drawn",
        "roof = 5; // thickness of the PDMS over the channels",
        "",
    ]
    for name in present:
        some = [p for p in layout.pillars if p.region == name]
        places = ", ".join(f"[{_mm(p.x_um)}, {_mm(p.y_um)}]" for p in some)
        lines += [
            f"{name}_pillar_radius = {_mm(some[0].radius_um)};",
            f"{name}_pillar_sides = {4 * quarter_segments(some[0].radius_um, tolerance)};",
            f"{name}_pillars = [{places}];",
        ]
    for name, shape in layout.walls.items():
        lines += ["", f"module {name}() {{", "  difference() {", _polygon(shape)]
        if name in present:
            circle = f"circle(r = {name}_pillar_radius, $fn = {name}_pillar_sides)"
            lines.append(f"    for (p = {name}_pillars) translate(p) {circle};")
        lines += ["  }", "}"]
    lines += ["", *_scad_assembly(layout.outline.bounds)]
    return "\n".join(lines) + "\n"


def _scad_assembly(bounds: tuple[float, float, float, float]) -> list[str]:
    left, low, right, high = map(_mm, bounds)
    colored = [
        f'  color("{color}") linear_extrude(z) {name}();'
        for name, color in zip(REGIONS, _COLORS, strict=True)
    ]
    together = " ".join(f"{name}();" for name in REGIONS)
    chip = f"translate([{left}, {low}]) square([{right} - {left}, {high} - {low}]);"
    return [
        f"module fluid() {{ {together} }}",
        "module relief() {",
        "  if ($preview) parts(); else linear_extrude(z) fluid();  // one solid is built at once",
        "}",
        "module parts() {",
        *colored,
        "}",
        f"module chip() {{ {chip} }}",
        "module mould() { translate([0, 0, -base]) linear_extrude(base) chip(); relief(); }",
        "module device() {",
        "  linear_extrude(z) difference() { chip(); fluid(); }",
        "  translate([0, 0, z]) linear_extrude(roof) chip();",
        "}",
        'if (show == "mould") mould();',
        'else if (show == "device") device();',
        "else relief();",
    ]


def _polygon(shape: BaseGeometry) -> str:
    """Return OpenSCAD's polygon of a shape without pillars; paths are its rings."""
    points, paths, start = [], [], 0
    for polygon in polygons(shape):
        for ring in (polygon.exterior, *polygon.interiors):
            corners = ring.coords[:-1]
            points += [f"[{_mm(x)}, {_mm(y)}]" for x, y in corners]
            paths.append(str(list(range(start, start + len(corners)))))
            start += len(corners)
    return f"    polygon(points = [{', '.join(points)}], paths = [{', '.join(paths)}]);"


def _mm(value_um: float) -> str:
    text = f"{value_um * 1e-3:.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
