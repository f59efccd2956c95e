"""The geometry: regions that fit without gap or overlap, pillars whole, curves within tolerance."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from shapely import Point

from pinchoff.chamber import Chamber
from pinchoff.chamber.layout import REGIONS
from pinchoff.chamber.shapes import disc, quarter_segments, staggered

VARIANTS = [
    {},
    {"thickness_um": 45, "imaging": {"obstacle_radius_um": 120}},
    {"imaging": {"pitch_um": 500, "rows": 8, "columns": 11, "stagger": 0.25}},
    {"mask": {"chord_tolerance_um": 0.02}},
]


@pytest.mark.parametrize("values", VARIANTS)
def test_regions_make_up_the_fluid_without_overlap(values):
    layout = Chamber(**values).layout
    assert list(layout.regions) == list(REGIONS)
    assert layout.fluid.is_valid
    assert len(layout.fluid.geoms) == 1
    assert sum(each.area for each in layout.regions.values()) == pytest.approx(
        layout.fluid.area, rel=1e-9
    )
    walls = sum(each.area for each in layout.walls.values())
    pillars = sum(each.area for each in layout.discs)
    assert layout.fluid.area == pytest.approx(walls - pillars, rel=1e-7)


@pytest.mark.parametrize("values", VARIANTS)
def test_every_pillar_is_a_hole_of_its_own_in_its_region(values):
    layout = Chamber(**values).layout
    for pillar, drawn in zip(layout.pillars, layout.discs, strict=True):
        assert layout.walls[pillar.region].contains(drawn)
    filled = shapely.union_all(list(layout.walls.values()))  # its holes are between channels
    holes = sum(len(part.interiors) for part in layout.fluid.geoms)
    assert holes == len(layout.pillars) + len(filled.interiors)


def test_the_device_is_symmetric(paper):
    turned = shapely.transform(paper.layout.fluid, lambda xy: xy * [1, -1])
    assert shapely.symmetric_difference(paper.layout.fluid, turned).area < 1.0  # µm²


def test_the_lattice_has_its_pitch_rows_and_stagger(paper):
    imaging, at = paper.imaging, paper.layout.stations
    table = paper.obstacles.query("region == 'imaging'")
    columns = table.groupby("obstacle_x_um")["obstacle_y_um"].apply(sorted)
    np.testing.assert_allclose(np.diff(columns.index), imaging.pitch_um)
    assert columns.index[0] == at.imaging + imaging.pitch_um / 2
    assert list(columns.map(len)) == [5, 4, 5, 4, 5, 4, 5]
    for k, y in enumerate(columns):
        np.testing.assert_allclose(np.diff(y), imaging.pitch_um)
        assert y[0] == pytest.approx(-1800 if k % 2 == 0 else -1350)


def test_staggered_points_stay_within_their_width():
    points = staggered([0.0, 1.0, 2.0], 10.0, 4, 0.25)
    assert points[points[:, 0] == 0][:, 1].tolist() == [-15, -5, 5, 15]
    assert points[points[:, 0] == 1][:, 1].tolist() == [-12.5, -2.5, 7.5, 17.5]
    assert (np.abs(points[:, 1]) <= 20).all()


@pytest.mark.parametrize("radius", [30.0, 85.0, 750.0])
@pytest.mark.parametrize("tolerance", [0.5, 0.1, 0.01])
def test_chords_keep_the_tolerance_and_no_more(radius, tolerance):
    shape = disc(3.0, -4.0, radius, tolerance)
    corners = np.asarray(shape.exterior.coords)
    np.testing.assert_allclose(np.hypot(*(corners - [3, -4]).T), radius, rtol=1e-12)
    middles = 0.5 * (corners[1:] + corners[:-1])
    stand_off = radius - np.hypot(*(middles - [3, -4]).T)
    assert stand_off.max() <= tolerance
    coarser = 4 * (quarter_segments(radius, tolerance) - 1)
    assert radius * (1 - math.cos(math.pi / coarser)) > tolerance


def test_vertices_lie_on_the_grid(paper):
    xy = shapely.get_coordinates(list(paper.layout.regions.values()))
    np.testing.assert_allclose(xy * 1000, np.round(xy * 1000), atol=1e-6)


def test_ports_and_marks_lie_where_they_should(paper):
    layout = paper.layout
    assert set(layout.ports) == {"oil", "water", "extra_oil_left", "extra_oil_right", "outlet"}
    for port in layout.ports.values():
        assert layout.fluid.contains(Point(port.x_um, port.y_um))
    for name, mark in layout.marks.items():
        assert not mark.intersects(layout.fluid), name
        assert layout.outline.covers(mark), name
    bar = max(shapely.get_parts(layout.marks["scale_bar"]), key=lambda part: part.area)
    assert bar.bounds[2] - bar.bounds[0] == pytest.approx(1000)
    assert len(layout.marks["alignment"].geoms) == 4


def test_the_channels_are_as_wide_as_asked(paper):
    """Cuts across: the orifice, the droplets' channel, the chamber."""
    at = paper.layout.stations
    orifice = at.channel - paper.junction.taper_length_um - 50
    for x, width in (
        (orifice, paper.junction.orifice_width_um),
        ((at.channel + at.imaging) / 2, paper.junction.channel_width_um),
        (at.imaging + 10, paper.width_um),
    ):
        cut = shapely.intersection(paper.layout.fluid, shapely.LineString([(x, -1e5), (x, 1e5)]))
        middle = [part for part in shapely.get_parts(cut) if part.distance(Point(x, 0)) == 0]
        assert middle[0].length == pytest.approx(width)


def test_marks_have_their_shapes_and_lie_between_channels_and_edge(paper):
    marks, (left, low, right, high) = paper.layout.marks, paper.layout.outline.bounds
    crosses = marks["alignment"].geoms
    assert len(crosses) == 4
    for cross in crosses:
        assert cross.area == pytest.approx(2 * 600 * 50 - 50**2)  # two bars, their middle once
        assert cross.bounds[2] - cross.bounds[0] == cross.bounds[3] - cross.bounds[1] == 600
    inset = paper.mask.margin_um / 2
    corners = shapely.box(left + inset, low + inset, right - inset, high - inset).exterior
    for cross in crosses:
        assert min(math.dist(cross.centroid.coords[0], xy) for xy in corners.coords) < 1.0
    bar = max(marks["scale_bar"].geoms, key=lambda part: part.bounds[2] - part.bounds[0])
    assert (bar.area, bar.bounds[2] - bar.bounds[0]) == (1000 * 80, 1000)
    for name in ("alignment", "scale_bar", "label"):
        assert paper.layout.outline.contains(marks[name])
        assert not marks[name].intersects(paper.layout.fluid)
