"""Masks read back measure the same as the design."""

from __future__ import annotations

import ezdxf
import gdstk
import numpy as np
import pytest
import shapely
from shapely import Polygon

from pinchoff.chamber import Chamber, write_dxf, write_gds, write_oasis
from pinchoff.chamber.masks import LAYERS, layers, mask_clear

READERS = {"gds": (write_gds, gdstk.read_gds), "oas": (write_oasis, gdstk.read_oas)}


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("polarity", ["dark-field", "bright-field"])
def test_every_layer_read_back_has_its_shape(tmp_path, kind, polarity):
    chamber = Chamber(mask={"polarity": polarity})
    write, read = READERS[kind]
    path = tmp_path / f"chamber.{kind}"
    write(chamber, path)
    library = read(path)
    assert (library.unit, library.precision) == (1e-6, 1e-9)
    (cell,) = library.cells
    drawn = layers(chamber)
    assert {polygon.layer for polygon in cell.polygons} == set(LAYERS.values())
    for name, number in LAYERS.items():
        found = [Polygon(p.points).buffer(0) for p in cell.polygons if p.layer == number]
        shape = shapely.union_all(found)
        # Cuts that take the holes out of polygons meet walls on the grid of 1 nm.
        assert shape.area == pytest.approx(drawn[name].area, rel=1e-6), name
        assert shapely.symmetric_difference(shape, drawn[name]).area < 1e-5 * drawn[name].area
    low, high = cell.bounding_box()
    np.testing.assert_allclose([*low, *high], chamber.layout.outline.bounds, atol=1e-3)


def test_polygons_have_no_more_points_than_readers_take(tmp_path, paper):
    write_gds(paper, tmp_path / "chamber.gds")
    (cell,) = gdstk.read_gds(tmp_path / "chamber.gds").cells
    assert max(len(polygon.points) for polygon in cell.polygons) <= 8190


def test_what_is_clear_on_one_field_is_dark_on_the_other(paper):
    dark = mask_clear(paper.layout, "dark-field")
    bright = mask_clear(paper.layout, "bright-field")
    assert dark.area + bright.area == pytest.approx(paper.layout.outline.area)
    assert shapely.intersection(dark, bright).area < 1e-3
    assert shapely.intersection(dark, paper.layout.fluid).area == pytest.approx(
        paper.layout.fluid.area
    )


def test_dxf_is_in_microns_with_a_layer_for_each_region(tmp_path, paper):
    path = tmp_path / "chamber.dxf"
    write_dxf(paper, path)
    document = ezdxf.readfile(path)
    assert not document.audit().has_errors
    assert document.units == ezdxf.units.InsertUnits.Microns
    for name, shape in layers(paper).items():
        rings = document.modelspace().query(f'LWPOLYLINE[layer=="{name}"]')
        assert all(ring.closed for ring in rings)
        area = sum(Polygon(ring.get_points("xy")).area for ring in rings)
        assert area == pytest.approx(shape.area, rel=1e-6), name


def test_the_same_design_is_the_same_file(tmp_path, paper):
    for name, write in (("a.gds", write_gds), ("b.gds", write_gds)):
        write(paper, tmp_path / name)
    assert (tmp_path / "a.gds").read_bytes() == (tmp_path / "b.gds").read_bytes()
