"""Masks: GDSII, OASIS and DXF, one layer a region, and one with what is clear on the mask.

Coordinates are in µm, on a database unit of 1 nm.
"""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import gdstk
import shapely
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.layout import REGIONS
from pinchoff.chamber.shapes import GRID_UM, polygons
from pinchoff.support.errors import PinchoffError
from pinchoff.support.files import written_aside

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.layout import Layout

LAYERS = {
    **{name: number for number, name in enumerate(REGIONS, start=1)},
    "pillars": 10,
    "alignment": 20,
    "scale_bar": 21,
    "label": 22,
    "chip_edge": 23,
    "mask_clear": 100,
}
"""Number of each layer; DXF uses the names. ``mask_clear`` is what light passes through."""

_MOST_POINTS = 4000  # of a GDSII polygon; some readers take no more than 8190
_ENDLIB = b"\0\4\4\0"  # the last record of GDSII
_END, _END_SIZE = b"\2", 256  # of OASIS, and its length in bytes
_DATE = datetime(2000, 1, 1)  # a fixed date, so that the same design gives the same file
_COLORS = {  # DXF's colour numbers, near those of the appendix
    "inlets": 2,
    "junction": 60,
    "oil_inputs": 3,
    "expansion": 4,
    "supports": 5,
    "imaging": 6,
    "exit": 30,
}


def layers(chamber: Chamber) -> dict[str, BaseGeometry]:
    """Return what is drawn on each of `LAYERS`, µm."""
    layout = chamber.layout
    return {
        **layout.regions,
        "pillars": shapely.MultiPolygon(layout.discs),
        **layout.marks,
        "mask_clear": mask_clear(layout, chamber.mask.polarity),
    }


def mask_clear(layout: Layout, polarity: str) -> BaseGeometry:
    """Return the clear part of the mask: channels and marks, or all but these."""
    drawn = shapely.union_all([layout.fluid, *layout.marks.values()])
    if polarity == "dark-field":
        return drawn
    return shapely.difference(layout.outline, drawn)


def write_gds(chamber: Chamber, path: Path) -> None:
    """Write the mask as GDSII, complete or not at all.

    Examples
    --------
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> write_gds(Chamber(), Path("mask.gds"))
    >>> Path("mask.gds").exists()
    True
    """
    with written_aside(path) as unfinished:
        _library(chamber).write_gds(unfinished, max_points=_MOST_POINTS, timestamp=_DATE)
        _require_whole(path, unfinished.read_bytes().endswith(_ENDLIB))


def write_oasis(chamber: Chamber, path: Path) -> None:
    """Write the mask as OASIS, complete or not at all.

    Examples
    --------
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> write_oasis(Chamber(), Path("mask.oas"))
    >>> Path("mask.oas").exists()
    True
    """
    with written_aside(path) as unfinished:
        _library(chamber).write_oas(unfinished)
        _require_whole(path, unfinished.read_bytes()[-_END_SIZE:].startswith(_END))


def _require_whole(path: Path, whole: bool) -> None:
    """Refuse a file that the library could not finish, of which it says nothing.

    Raises
    ------
    PinchoffError
        It does not end as its format does.
    """
    if not whole:
        advice = "make room and give the same command again"
        raise PinchoffError(f"{path} must be written whole; got only a part of it; {advice}")


def _library(chamber: Chamber) -> gdstk.Library:
    library = gdstk.Library("chamber", unit=1e-6, precision=1e-6 * GRID_UM)
    cell = library.new_cell("CHAMBER")
    for name, shape in layers(chamber).items():
        cell.add(*_without_holes(shape, LAYERS[name]))
    return library


def _without_holes(shape: BaseGeometry, layer: int) -> list[gdstk.Polygon]:
    """Return a shape as polygons without holes, which the mask formats do not have."""
    pieces = []
    for polygon in polygons(shape):
        outer = gdstk.Polygon(polygon.exterior.coords[:-1], layer=layer)
        inner = [gdstk.Polygon(ring.coords[:-1]) for ring in polygon.interiors]
        if inner:
            pieces += gdstk.boolean(outer, inner, "not", precision=GRID_UM, layer=layer)
        else:
            pieces.append(outer)
    return pieces


def write_dxf(chamber: Chamber, path: Path) -> None:
    """Write the mask as DXF in µm, complete or not at all.

    Every shape is a closed polyline on the layer of its region. Holes are joined to the outside by
    cuts, as in GDSII: programs that fill closed polylines, nested ones too, would close them.

    Examples
    --------
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> write_dxf(Chamber(), Path("mask.dxf"))
    >>> Path("mask.dxf").exists()
    True
    """
    from ezdxf.enums import InsertUnits
    from ezdxf.filemanagement import new

    document = new("R2010")
    document.units = InsertUnits.Microns
    document.header["$MEASUREMENT"] = 1
    space = document.modelspace()
    for name, shape in layers(chamber).items():
        document.layers.add(name, color=_COLORS.get(name, 7))
        for piece in _without_holes(shape, LAYERS[name]):
            space.add_lwpolyline(piece.points, close=True, dxfattribs={"layer": name})
    with written_aside(path) as unfinished:
        document.saveas(unfinished)
