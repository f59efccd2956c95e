"""The design-rule check finds each kind of fault, says where, and passes what can be made."""

from __future__ import annotations

import dataclasses

import pytest
import shapely
from shapely import MultiPolygon, Point, box

from pinchoff.chamber import Chamber, check_rules
from pinchoff.chamber.pillars import Pillar
from pinchoff.chamber.rules import require_rules

WARN = {"on_violation": "warn"}


def changed(layout, **changes):
    return dataclasses.replace(layout, **changes)


def with_fluid(layout, region, change):
    """Return a layout with the fluid of one region changed."""
    shape = change(layout.regions[region])
    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon"]
    return changed(layout, regions={**layout.regions, region: MultiPolygon(parts)})


def found(chamber, layout=None, rule=None):
    violations = check_rules(chamber, layout)
    return [each for each in violations if rule is None or each.rule == rule]


def test_the_default_device_passes(paper):
    assert check_rules(paper) == []
    require_rules([])


def test_a_narrow_orifice_is_a_gap_at_the_orifice():
    chamber = Chamber(rules=WARN, junction={"orifice_width_um": 18})
    (violation,) = found(chamber, rule="gap")
    at = chamber.layout.stations
    assert at.cross < violation.x_um < at.channel
    assert abs(violation.y_um) < 9
    assert "narrower than 21.25" in str(violation)


@pytest.mark.parametrize(("width", "count"), [(21.0, 1), (21.5, 0)])
def test_the_limit_of_a_gap_is_the_aspect_ratios(width, count):
    chamber = Chamber(rules=WARN, junction={"orifice_width_um": width})
    assert len(found(chamber, rule="gap")) == count


@pytest.mark.parametrize(("width", "count"), [(21.0, 2), (21.5, 0)])
def test_the_limit_of_a_wall_is_the_aspect_ratios(width, count):
    chamber = Chamber(rules=WARN, expansion={"divider_um": width})
    assert len(found(chamber, rule="wall")) == count


@pytest.mark.parametrize(("share", "count"), [(0.99, 1), (1.01, 0)])
def test_the_limit_of_a_span_is_the_width_that_nothing_holds(paper, share, count):
    """A pond without pillars: its largest circle has the pond's width."""
    pond = box(0.0, 10_000.0, 6_000.0, 12_000.0)
    doctored = with_fluid(paper.layout, "supports", lambda shape: shape.union(pond))
    outline = doctored.outline.union(pond.buffer(500.0))
    chamber = paper.replace(rules={**WARN, "largest_span_ratio": share * 2_000.0 / 85.0})
    assert len(found(chamber, changed(doctored, outline=outline), "span")) == count


@pytest.mark.parametrize(("width", "blocked"), [(21.0, 2), (21.5, 0)])
def test_the_limit_of_a_path_is_that_of_a_gap(width, blocked):
    chamber = Chamber(rules=WARN, oil_inputs={"channel_width_um": width})
    assert len(found(chamber, rule="path")) == blocked


def test_the_photomasks_own_limit_counts_in_a_shallow_device():
    rules = {**WARN, "least_gap_um": 30}
    chamber = Chamber(rules=rules, thickness_um=45, junction={"orifice_width_um": 25})
    assert len(found(chamber, rule="gap")) == 1


def test_thin_solid_is_a_wall():
    chamber = Chamber(rules=WARN, expansion={"divider_um": 12})
    walls = found(chamber, rule="wall")
    at = chamber.layout.stations
    assert len(walls) == 2  # one on either side of the droplets' channel
    for wall in walls:
        assert at.expansion < wall.x_um < at.imaging
        assert 300 < abs(wall.y_um) < 330


def test_a_wide_ceiling_is_a_span():
    chamber = Chamber(rules=WARN, supports={"pitch_um": 2700})
    spans = found(chamber, rule="span")
    assert spans
    for span in spans:
        place = Point(span.x_um, span.y_um)
        solid = chamber.layout.outline.difference(chamber.layout.fluid)
        assert place.distance(solid) >= 25 * 85 / 2 - 1.5  # places are rounded to 1 µm
    assert found(chamber.replace(rules={**WARN, "largest_span_ratio": 60})) == []


def test_pillars_that_overlap_are_found_where_they_do(paper):
    layout = paper.layout
    first = next(p for p in layout.pillars if p.region == "imaging")
    near = Pillar(first.x_um + 100, first.y_um, first.radius_um, "imaging")
    doctored = changed(layout, pillars=[*layout.pillars, near])
    (overlap,) = found(paper, doctored, "overlap")
    assert overlap.x_um == pytest.approx(first.x_um + 50, abs=2)
    assert [v.rule for v in found(paper, doctored)] == ["overlap", "cut pillar"]


def test_regions_and_marks_that_overlap_the_fluid_are_found(paper):
    layout = paper.layout
    at = layout.stations
    regions = {**layout.regions, "exit": MultiPolygon([box(at.exit - 50, 0, at.end, 50)])}
    assert found(paper, changed(layout, regions=regions), "overlap")
    marks = {"label": MultiPolygon([box(at.exit - 50, 0, at.end, 50)])}
    (overlap,) = found(paper, changed(layout, marks=marks), "overlap")
    assert overlap.says == "label lies over the fluid"


def test_a_pillar_cut_by_a_wall_is_found(paper):
    layout = paper.layout
    wall = paper.width_um / 2
    cut = Pillar(layout.stations.exit - 100, wall - 20, 85.0, "supports")
    disc = Point(cut.x_um, cut.y_um).buffer(85)
    doctored = with_fluid(layout, "supports", lambda shape: shape.difference(disc))
    doctored = changed(doctored, pillars=[*layout.pillars, cut])
    (violation,) = found(paper, doctored, "cut pillar")
    assert Point(violation.x_um, violation.y_um).distance(disc) < 1


def test_fluid_that_no_port_reaches_is_an_island(paper):
    at = paper.layout.stations
    pond = box(at.imaging, 3500, at.imaging + 500, 4000)
    doctored = with_fluid(paper.layout, "supports", lambda shape: shape.union(pond))
    (island,) = found(paper, doctored, "island")
    assert pond.contains(Point(island.x_um, island.y_um))


def test_a_speck_of_solid_is_an_island(paper):
    port = paper.layout.ports["outlet"]
    speck = Point(port.x_um, port.y_um + 100).buffer(30)
    doctored = with_fluid(paper.layout, "exit", lambda shape: shape.difference(speck))
    assert [v.rule for v in found(paper, doctored)] == ["island"]


def test_a_dam_blocks_the_path_of_every_inlet(paper):
    at = paper.layout.stations
    dam = box(at.exit + 500, -4000, at.exit + 550, 4000)
    doctored = with_fluid(paper.layout, "exit", lambda shape: shape.difference(dam))
    blocked = {v.says.split("port ")[1].split(" ")[0] for v in found(paper, doctored, "path")}
    assert blocked == {"oil", "water", "extra_oil_left", "extra_oil_right"}


def test_one_extra_inlet_that_is_too_narrow_is_blocked_alone():
    chamber = Chamber(rules=WARN, oil_inputs={"channel_width_um": 15})
    blocked = {v.says.split("port ")[1].split(" ")[0] for v in found(chamber, rule="path")}
    assert blocked == {"extra_oil_left", "extra_oil_right"}


def test_a_refusal_names_the_first_and_counts_the_others(refused):
    chamber = Chamber(rules=WARN, oil_inputs={"channel_width_um": 15})
    violations = check_rules(chamber)
    error = refused("the chamber", require_rules, violations)
    assert f"{violations[0]} and 3 more" in error.got
