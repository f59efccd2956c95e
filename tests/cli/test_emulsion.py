"""``pinchoff emulsion``: the page it writes, going on after a stop, and what it refuses."""

from __future__ import annotations

import json

import pytest

from pinchoff.cli import main

pytest.importorskip("skfem", reason="its extra is not installed")

CONFIG = """
time = 12
smallest_breaking = 0.3
[parameters]
simulation_capillary_number = 60
vertex_count = 32
[array]
kind = "staggered"
rows = 2
columns = 2
radius = 0.3
gap = 1.0
before = 3
behind = 2
[flow]
thickness = 0.5
[inlet]
area_fraction = 0.3
"""


def run(folder, text):
    (folder / "config.toml").write_text(text)
    return main(["emulsion", str(folder / "config.toml"), "--out", str(folder / "out")])


def test_the_page_has_every_figure_and_a_second_run_goes_on(tmp_path):
    assert run(tmp_path, CONFIG) == 0
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.count("<figure>") == 7
    report = json.loads((tmp_path / "out" / "emulsion.json").read_text())
    assert report["balance"]["entered"] > 5
    assert report["trust"]["slip"] > 0
    assert run(tmp_path, CONFIG.replace("time = 12", "time = 14")) == 0
    assert json.loads((tmp_path / "out" / "emulsion.json").read_text())["time"] == 14


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('kind = "staggered"', 'kind = "stagered"', "array.kind must be"),
        ("rows = 2", "rows = 0", "array.rows must be"),
        ("radius = 0.3", 'radius = "85 um"', "array.radius must be"),
        ("thickness = 0.5", "thickness = -1", "flow.thickness must be"),
        ("area_fraction = 0.3", "area_fraction = 2", "inlet.area_fraction must be"),
        ("before = 3", "before = 0", "array.before must be"),
        ("time = 12", "times = 12", "times must be"),
        ("vertex_count = 32", "vertex_cout = 32", "parameters.vertex_cout must be"),
    ],
)
def test_a_wrong_key_is_named(tmp_path, capsys, old, new, named):
    assert run(tmp_path, CONFIG.replace(old, new)) == 2
    assert f"error: {named}" in capsys.readouterr().err


def test_physical_units_give_the_same_run(tmp_path):
    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.support.files import read_toml

    (tmp_path / "c.toml").write_text(CONFIG)
    table = read_toml(tmp_path / "c.toml")
    plain = EmulsionDesign.from_config(table)
    del table["parameters"]["simulation_capillary_number"]
    table["array"] |= {"radius": "150 um", "gap": "0.5 mm"}
    table["physical"] = {
        "diameter": "500 um",
        "speed": "1 mm/s",
        "viscosity": "117.6 mPa s",
        "surface_tension": "20 mN/m",
    }
    physical = EmulsionDesign.from_config(table)
    assert physical.array.circles == pytest.approx(plain.array.circles)
    number = physical.parameters.simulation_capillary_number
    assert number == pytest.approx(plain.parameters.simulation_capillary_number)
