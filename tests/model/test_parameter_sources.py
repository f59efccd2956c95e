"""Where parameters come from: physical quantities, presets and TOML files."""

from __future__ import annotations

import math
from pathlib import Path

import pint
import pytest

import pinchoff as po
from pinchoff.model.parameters import CA_PER_CA_SIM, preset_description, preset_names

SCALE = {
    "diameter_um": 481.0,
    "speed_mm_s": 1.0,
    "obstacle_radius_um": 85.0,
    "thickness_um": 85.0,
    "viscosity_mPa_s": 48.0,
    "surface_tension_mN_m": 20.0,
}


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


# Physical quantities


def test_numbers_and_texts_describe_the_same_experiment(experiment):
    p = po.Parameters.from_physical(**experiment, line_tension=60)
    offset_um = p.offset * p.scale.diameter_um
    again = po.Parameters.of_scale(p.scale, offset_um=offset_um, line_tension=60)
    assert again.replace(offset=p.offset) == p
    assert again.offset == pytest.approx(p.offset, rel=1e-15)
    with pytest.raises(po.InputError, match="size_ratio must be left out"):
        po.Parameters.of_scale(p.scale, size_ratio=4.0)


def test_physical_quantities_become_groups_and_come_back(experiment):
    p = po.Parameters.from_physical(**experiment)
    assert p.size_ratio == pytest.approx(481 / 85, rel=1e-12)
    assert p.capillary_number == pytest.approx(48e-3 * 1e-3 / 20e-3, rel=1e-12)
    assert p.simulation_capillary_number == pytest.approx(2.4e-3 / CA_PER_CA_SIM, rel=1e-12)
    assert p.offset == pytest.approx(20 / 481, rel=1e-12)
    assert p.scale is not None
    assert p.scale.model_dump() == pytest.approx(SCALE, rel=1e-12)
    assert p.scale.time_unit_s == pytest.approx(0.481, rel=1e-12)
    again = po.Parameters.from_physical(
        diameter=f"{p.scale.diameter_um} um",
        obstacle_radius=f"{p.scale.obstacle_radius_um} um",
        speed=f"{p.scale.speed_mm_s} mm/s",
        viscosity=f"{p.scale.viscosity_mPa_s} mPa s",
        surface_tension=f"{p.scale.surface_tension_mN_m} mN/m",
        thickness=f"{p.scale.thickness_um} um",
        offset=f"{p.offset * p.scale.diameter_um} um",
    )
    assert again.model_dump(exclude={"offset"}) == p.model_dump(exclude={"offset"})
    assert again.offset == pytest.approx(p.offset, rel=1e-12)


def test_units_do_not_matter(experiment):
    other = {
        "diameter": "0.481 mm",
        "obstacle_radius": "8.5e-5 m",
        "speed": "3.6 m/hour",
        "viscosity": "+.048 kg/(m*s)",
        "surface_tension": "20. N m^-1 * m/km",
        "thickness": "85 µm",
        "offset": "2e4nm",
    }
    ours, theirs = (po.Parameters.from_physical(**each) for each in (experiment, other))
    for name in ("size_ratio", "simulation_capillary_number", "offset"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), rel=1e-12)


def test_pint_quantities_are_taken_from_any_registry(experiment):
    registry = pint.UnitRegistry()
    quantities = {name: registry.Quantity(text) for name, text in experiment.items()}
    assert po.Parameters.from_physical(**quantities) == po.Parameters.from_physical(**experiment)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("diameter", "481"),
        ("diameter", 481),
        ("diameter", None),
        ("diameter", ""),
        ("diameter", "481 umm"),
        ("diameter", "481 um)"),
        ("diameter", "1/0 um"),
        ("diameter", "481 s"),
        ("diameter", "481 um^2"),
        ("diameter", "20 °C"),
        ("diameter", "nan um"),
        ("diameter", "1e400 um"),
        ("diameter", "0 um"),
        ("diameter", "-481 um"),
        ("obstacle_radius", "85 um/s"),
        ("obstacle_radius", "0 um"),
        ("speed", "1 mm"),
        ("speed", "-1 mm/s"),
        ("viscosity", "50 cSt"),
        ("viscosity", "inf Pa s"),
        ("surface_tension", "20 mN"),
        ("thickness", "85"),
        ("offset", "20 mm/s"),
        ("offset", "nan um"),
        ("diameter", "9**9**9 um"),
        ("diameter", "9^9^9 um"),
        ("diameter", "9⁹⁹⁹⁹⁹⁹⁹⁹⁹ um"),
        ("diameter", "481 um**9**9**9"),
        ("diameter", "481 um^9^9^9"),
        ("diameter", "481 hour⁹⁹⁹⁹⁹⁹⁹⁹⁹"),
        ("diameter", "481 um^(9^9)"),
        ("diameter", "480 + 1 um"),
        ("diameter", "2 * 240 um"),
        ("diameter", "(481) um"),
        ("diameter", "481 " + "(" * 1000 + "um"),
    ],
)
def test_wrong_quantity_is_refused_by_name(refused, experiment, name, value):
    refused(name, po.Parameters.from_physical, **{**experiment, name: value})


def test_offset_may_be_negative_or_missing(experiment):
    left_out = {name: value for name, value in experiment.items() if name != "offset"}
    assert po.Parameters.from_physical(**left_out).offset == po.Parameters().offset
    assert po.Parameters.from_physical(**left_out, offset="-20 um").offset < 0


@pytest.mark.parametrize("thickness", ["87 um", "83 um"])
def test_thickness_that_cannot_act_is_warned_of(experiment, thickness):
    with pytest.warns(UserWarning, match="thickness does not act") as caught:
        p = po.Parameters.from_physical(**{**experiment, "thickness": thickness})
    assert caught[0].filename == __file__
    assert p.normalized_thickness == 1


def test_thickness_near_the_radius_passes_silently(experiment):
    po.Parameters.from_physical(**{**experiment, "thickness": "85.5 um"})


@pytest.mark.parametrize(
    ("name", "value", "blamed"),
    [
        ("viscosity", "480 Pa s", "viscosity * speed / surface_tension"),
        ("diameter", "481 mm", "diameter / obstacle_radius"),
        ("offset", "20 mm", "offset"),
    ],
)
def test_group_out_of_range_blames_its_quantities(refused, experiment, name, value, blamed):
    refused(blamed, po.Parameters.from_physical, **{**experiment, name: value})


@pytest.mark.parametrize("name", ["size_ratio", "simulation_capillary_number", "scale"])
def test_group_beside_physical_quantities_is_refused(refused, experiment, name):
    refused(name, po.Parameters.from_physical, **experiment, **{name: 5.0})


def test_scale_and_groups_must_agree(refused, experiment):
    p = po.Parameters.from_physical(**experiment)
    assert p.replace(offset=0.2).scale == p.scale
    refused("size_ratio", p.replace, size_ratio=5)
    refused("simulation_capillary_number", p.replace, simulation_capillary_number=5)
    assert p.replace(size_ratio=5, scale=None).scale is None


def test_scale_is_checked(refused):
    refused(
        "surface_tension_mN_m",
        po.PhysicalScale,
        diameter_um=1.0,
        **{name: 1.0 for name in SCALE if name not in ("diameter_um", "surface_tension_mN_m")},
    )
    refused("speed_mm_s", po.PhysicalScale, **{**SCALE, "speed_mm_s": math.nan})
    refused("scale.speed_mm_s", po.Parameters, scale={**SCALE, "speed_mm_s": -1})
    refused("scale", po.Parameters, scale=3)


# Presets


def test_presets_are_documented_and_sound():
    assert preset_names()[0] == "default"
    for name in preset_names():
        assert len(preset_description(name)) > 20
        po.Parameters.preset(name).model_row()


def test_presets_differ_as_they_say():
    default = po.Parameters.preset("default")
    assert default == po.Parameters()
    assert po.Parameters.preset("paper-step") == default.replace(time_step=1e-4)
    literal = po.Parameters.preset("literal-separation", offset=0.2)
    assert literal == default.replace(neck_separation_unit="diameter", offset=0.2)


@pytest.mark.parametrize("name", ["defualt", "", 3, None, ["default"]])
def test_unknown_preset_is_refused(refused, name):
    refused("preset", po.Parameters.preset, name)


def test_misspelt_preset_suggests_the_nearest(refused):
    assert "'paper-step'" in refused("preset", po.Parameters.preset, "paper_step").advice


# TOML


def test_toml_gives_the_same_as_the_constructor(tmp_path):
    path = write(tmp_path / "c.toml", 'offset = 0.1\nvertex_count = 96\npreset = "paper-step"\n')
    assert po.Parameters.from_toml(path) == po.Parameters(
        offset=0.1, vertex_count=96, time_step=1e-4
    )
    assert po.Parameters.from_toml(str(write(tmp_path / "empty.toml", ""))) == po.Parameters()


def test_toml_takes_physical_quantities_beside_constants(tmp_path, experiment):
    lines = [f'{name} = "{value}"' for name, value in experiment.items()]
    text = "\n".join(["line_tension = 60", "[physical]", *lines])
    expected = po.Parameters.from_physical(**experiment, line_tension=60)
    assert po.Parameters.from_toml(write(tmp_path / "c.toml", text)) == expected


@pytest.mark.parametrize(
    ("argument", "text"),
    [
        ("size_ration", "size_ration = 5"),
        ("physicl", "[physicl]\ndiameter = '481 um'"),
        ("offset", "offset = nan"),
        ("offset", "offset = -inf"),
        ("offset", "offset = '20 um'"),
        ("offset", "offset = true"),
        ("vertex_count", "vertex_count = 8"),
        ("time_step", "time_step = 1979-05-27"),
        ("preset", "preset = 'unheard-of'"),
        ("preset", "preset = 3"),
        ("physical", "physical = 3"),
        ("physical.diametre", "[physical]\ndiametre = '481 um'"),
        ("physical.diameter", "[physical]\nspeed = '1 mm/s'"),
        ("physical.diameter", "[physical]\ndiameter = 481.0"),
        ("size_ratio", "size_ratio = 5\n[physical]\ndiameter = '481 um'"),
        ("offset", "offset = 0\n[physical]\ndiameter = '481 um'"),
    ],
)
def test_wrong_key_in_toml_is_refused_by_name(refused, tmp_path, argument, text):
    refused(argument, po.Parameters.from_toml, write(tmp_path / "c.toml", text))


def test_misspelt_key_in_toml_suggests_the_nearest(refused, tmp_path):
    path = write(tmp_path / "c.toml", "[physicl]")
    assert "'physical'" in refused("physicl", po.Parameters.from_toml, path).advice
    path = write(tmp_path / "c.toml", "[physical]\nviscocity = '1 Pa s'")
    assert "'viscosity'" in refused("physical.viscocity", po.Parameters.from_toml, path).advice


@pytest.mark.parametrize(
    "content",
    [b"offset = ", b"offset = 1\noffset = 2", b"\xff\xfe", b"a = " + b"9" * 5000, b"\x00"],
)
def test_what_is_not_toml_is_refused(refused, tmp_path, content):
    path = tmp_path / "c.toml"
    path.write_bytes(content)
    refused(str(path), po.Parameters.from_toml, path)


def test_deep_nesting_is_refused(refused, tmp_path):
    path = write(tmp_path / "c.toml", "a = " + "[" * 100_000)
    refused(str(path), po.Parameters.from_toml, path)


def test_byte_order_mark_is_passed_over(tmp_path):
    path = tmp_path / "c.toml"
    path.write_bytes(b"\xef\xbb\xbfoffset = 0.1\r\n")
    assert po.Parameters.from_toml(path) == po.Parameters(offset=0.1)


def test_validated_mapping_is_refused_in_our_form(refused):
    assert po.Parameters.model_validate({"offset": 0.1}) == po.Parameters(offset=0.1)
    refused("offset", po.Parameters.model_validate, {"offset": 99})
    refused("ofset", po.Parameters.model_validate, {"ofset": 0.1})
    refused("Parameters", po.Parameters.model_validate, 3)


def test_unreadable_file_is_refused(refused, tmp_path):
    refused(str(tmp_path / "absent.toml"), po.Parameters.from_toml, tmp_path / "absent.toml")
    refused(str(tmp_path), po.Parameters.from_toml, tmp_path)
