"""The device's parameters: defaults of the paper, variants, files, refusals."""

from __future__ import annotations

import pytest

import pinchoff as po
from pinchoff.chamber import Chamber, read_design
from pinchoff.chamber.record import design_record
from pinchoff.support.records import json_text

PARTS = [field.annotation for field in Chamber.model_fields.values() if field.default_factory]


def test_the_defaults_are_the_papers_device(paper):
    assert paper.length_um == pytest.approx(22_000)
    assert (paper.thickness_um, paper.imaging.obstacle_radius_um) == (85, 85)
    operation = paper.operation
    assert (operation.viscosity_mPa_s, operation.density_kg_m3) == (48, 960)
    assert 20 <= operation.oil_rate_uL_min <= 60


def test_it_loads_with_the_package_on_first_use():
    assert po.chamber.Chamber is Chamber
    with pytest.raises(AttributeError, match="chember"):
        po.chamber.chember  # noqa: B018


@pytest.mark.parametrize("model", [po.PhysicalScale, *PARTS])
def test_every_parameter_is_documented_with_what_it_must_be(model):
    for name, field in model.model_fields.items():
        assert f"    {name} : " in model.__doc__
        said = " ".join(model.__doc__.partition(f"{name} : ")[2].split())
        assert f"{field.json_schema_extra.meaning[1:]}: {field.json_schema_extra.rule}" in said


@pytest.mark.parametrize("radius", [60, 85, 120])
@pytest.mark.parametrize("thickness", [45, 85])
def test_the_papers_variants_can_be_made(radius, thickness):
    chamber = Chamber(thickness_um=thickness, imaging={"obstacle_radius_um": radius})
    assert po.chamber.check_rules(chamber) == []
    assert chamber.length_um == pytest.approx(22_000)
    imaging = chamber.obstacles.query("region == 'imaging'")
    assert set(imaging["obstacle_radius_um"]) == {radius}


def test_a_toml_file_has_a_table_for_each_part(tmp_path):
    config = tmp_path / "device.toml"
    text = "thickness_um = 45\n[imaging]\nrows = 6\nstagger = 0\n[rules]\non_violation = 'warn'\n"
    config.write_text(text, encoding="utf-8")
    chamber = Chamber.from_toml(config)
    assert chamber == Chamber(
        thickness_um=45, imaging={"rows": 6, "stagger": 0}, rules={"on_violation": "warn"}
    )


def test_a_design_comes_back_from_its_record(tmp_path):
    chamber = Chamber(imaging={"pitch_um": 777.5}, mask={"label": "no 7"})
    path = tmp_path / "design.json"
    path.write_text(json_text(design_record(chamber)), encoding="utf-8")
    assert read_design(path) == chamber


@pytest.mark.parametrize("text", ["{}", "[1]", "nonsense", '{"parameters": 3}'])
def test_a_file_that_is_no_design_is_refused(tmp_path, refused, text):
    path = tmp_path / "design.json"
    path.write_text(text, encoding="utf-8")
    refused(str(path), read_design, path)
    refused(str(tmp_path / "none"), read_design, tmp_path / "none")


@pytest.mark.parametrize(
    ("argument", "values"),
    [
        ("thickness_um", {"thickness_um": -85}),
        ("thickness_um", {"thickness_um": float("nan")}),
        ("imagin", {"imagin": {}}),
        ("imaging", {"imaging": 85}),
        ("imaging.pitch", {"imaging": {"pitch": 900}}),
        ("imaging.pitch_um", {"imaging": {"pitch_um": -900}}),
        ("imaging.pitch_um", {"imaging": {"pitch_um": 169}}),  # less than a diameter
        ("imaging.pitch_um", {"imaging": {"pitch_um": 180}}),  # a gap the rules forbid
        ("imaging.rows", {"imaging": {"rows": 2.5}}),
        ("imaging.rows", {"imaging": {"rows": 1, "pitch_um": 300}}),  # narrower than the inlets
        ("imaging.stagger", {"imaging": {"stagger": 1.5}}),
        ("supports.pitch_um", {"supports": {"radius_um": 440}}),
        ("supports.flank_um", {"supports": {"flank_um": 400}}),
        ("inlets.post_gap_um", {"inlets": {"post_gap_um": 10}}),
        ("inlets.arm_width_um", {"inlets": {"arm_width_um": 20}}),
        ("junction.orifice_width_um", {"junction": {"orifice_width_um": 12}}),
        ("inlets.post_gap_um", {"thickness_um": 400}),  # too deep for its width
        ("junction.channel_width_um", {"junction": {"channel_width_um": 70}}),
        ("expansion.divider_um", {"expansion": {"divider_um": 10}}),
        ("junction.taper_length_um", {"junction": {"taper_length_um": 4000}}),
        ("imaging.rows", {"imaging": {"rows": 2}}),  # the extra inlets' channels meet no wall
        ("imaging.rows", {"oil_inputs": {"port_diameter_um": 5000}}),
        ("oil_inputs.channel_width_um", {"oil_inputs": {"channel_width_um": 1300}}),
        ("inlets.port_diameter_um", {"junction": {"water_width_um": 1150}}),
        ("inlets.port_diameter_um", {"inlets": {"post_diameter_um": 1500}}),
        ("inlets.trap_length_um", {"inlets": {"trap_length_um": 100}}),
        ("inlets.wall_um", {"junction": {"channel_width_um": 1900}}),
        ("exit.width_um", {"exit": {"width_um": 7000, "port_diameter_um": 8000}}),
        ("exit.width_um", {"exit": {"port_diameter_um": 500}}),
        ("mask.polarity", {"mask": {"polarity": "dark"}}),
        ("mask.chord_tolerance_um", {"mask": {"chord_tolerance_um": 0.6}}),
        ("mask.label", {"mask": {"label": "µ"}}),
        ("rules.on_violation", {"rules": {"on_violation": "ignore"}}),
        ("operation.oil_rate_uL_min", {"operation": {"oil_rate_uL_min": 0}}),
        ("operation.elements_across_gap", {"operation": {"elements_across_gap": 2}}),
    ],
)
def test_bad_parameters_are_refused_by_name(refused, argument, values):
    refused(argument, Chamber, **values)


def test_rules_that_only_warn_let_narrow_channels_through_but_not_overlaps(refused):
    warn = {"on_violation": "warn"}
    assert Chamber(rules=warn, junction={"orifice_width_um": 12}).layout
    refused("imaging.pitch_um", Chamber, rules=warn, imaging={"pitch_um": 160})
