"""What is on the mask beside the channels: alignment marks, scale bar, text, the chip's edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import gdstk
import shapely
from shapely import MultiPolygon, Polygon, box
from shapely.geometry.base import BaseGeometry

from pinchoff.chamber.shapes import on_grid

if TYPE_CHECKING:
    from pinchoff.chamber.device import Device

_ARM_UM = 300.0  # length of an arm of an alignment cross, from its middle
_CROSS_UM = 50.0  # width of an arm
_BAR_UM = 1000.0
_BAR_HEIGHT_UM = 80.0
_TEXT_UM = 350.0
_EDGE_UM = 50.0


def build_marks(device: Device, outline: Polygon) -> dict[str, MultiPolygon]:
    """Return the marks by name, µm: ``alignment``, ``scale_bar``, ``label`` and ``chip_edge``."""
    left, low, right, high = outline.bounds
    inset = device.mask.margin_um / 2
    corners = [(x, y) for x in (left + inset, right - inset) for y in (low + inset, high - inset)]
    start, base = left + 2 * inset, low + inset - _TEXT_UM / 2
    bar = box(right - 2 * inset - _BAR_UM, base, right - 2 * inset, base + _BAR_HEIGHT_UM)
    length = _text("1 mm", right - 2 * inset - _BAR_UM, base + 2 * _BAR_HEIGHT_UM)
    edge = shapely.difference(outline, outline.buffer(-_EDGE_UM, join_style="mitre"))
    return {
        "alignment": on_grid(shapely.union_all([_cross(x, y) for x, y in corners])),
        "scale_bar": on_grid(shapely.union(bar, length)),
        "label": on_grid(_text(label_of(device), start, base)),
        "chip_edge": on_grid(edge),
    }


def label_of(device: Device) -> str:
    """Return what is written on the chip."""
    if device.mask.label is not None:
        return device.mask.label
    return f"pinchoff R={device.imaging.obstacle_radius_um:g} z={device.thickness_um:g} um"


def _cross(x_um: float, y_um: float) -> BaseGeometry:
    half = _CROSS_UM / 2
    return shapely.union(
        box(x_um - _ARM_UM, y_um - half, x_um + _ARM_UM, y_um + half),
        box(x_um - half, y_um - _ARM_UM, x_um + half, y_um + _ARM_UM),
    )


def _text(text: str, x_um: float, y_um: float) -> BaseGeometry:
    letters = gdstk.text(text, _TEXT_UM, (x_um, y_um))
    return shapely.union_all([Polygon(letter.points) for letter in letters])
