"""``pinchoff chamber``: what it writes, what it prints, and how it refuses."""

from __future__ import annotations

import json

import pytest

from pinchoff.cli import main

gdstk = pytest.importorskip("gdstk", reason="the extra 'chamber' is not installed")

ALWAYS = [
    *("chamber.dxf", "chamber.gds", "chamber.oas", "chamber.png", "chamber.scad"),
    *("chamber.stl", "chamber.svg", "design.json"),
]
SMALL = """
[inlets]
port_diameter_um = 600
trap_length_um = 300
wall_um = 200
post_gap_um = 80
[oil_inputs]
port_diameter_um = 400
[expansion]
length_um = 700
straight_um = 500
[supports]
radius_um = 120
flank_um = 600
pitch_um = 700
[imaging]
pitch_um = 800
rows = 3
columns = 3
[exit]
length_um = 1800
width_um = 700
port_diameter_um = 900
[operation]
elements_across_gap = 4
"""


def chamber(*arguments):
    return main(["chamber", *map(str, arguments)])


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def design_in(folder):
    return json.loads((folder / "design.json").read_text(encoding="utf-8"))


def test_the_papers_device_by_default(tmp_path, capsys):
    out = tmp_path / "new" / "device"
    assert chamber("--out", out) == 0
    assert files_in(out) == ALWAYS
    design = design_in(out)
    assert design["derived"]["length_um"] == 22_000
    assert [region["number"] for region in design["regions"]] == [1, 2, 3, 4, 5, 6, 7]
    assert design["violations"] == []
    assert len(design["pillars"]) == sum(region["pillars"] for region in design["regions"])
    printed = capsys.readouterr()
    assert printed.err == ""
    assert [f"wrote {out / name}" in printed.out for name in ALWAYS] == [True] * len(ALWAYS)
    svg = (out / "chamber.svg").read_text(encoding="utf-8")
    assert "flow-focusing junction" in svg


@pytest.mark.usefixtures("unrendered")
def test_quantities_settings_and_a_file_agree(tmp_path):
    config = tmp_path / "device.toml"
    config.write_text("[imaging]\nrows = 4\npitch_um = 700\n", encoding="utf-8")
    options = ["--obstacle-radius", "0.06 mm", "--thickness", "45 um", "--set", "imaging.rows=6"]
    assert chamber(config, *options, "--out", tmp_path / "a") == 0
    parameters = design_in(tmp_path / "a")["parameters"]
    assert parameters["thickness_um"] == pytest.approx(45)
    imaging = parameters["imaging"]
    assert (imaging["rows"], imaging["pitch_um"]) == (6, 700)
    assert imaging["obstacle_radius_um"] == pytest.approx(60)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A device of few pillars, for what does not depend on them."""
    config = tmp_path_factory.mktemp("small") / "small.toml"
    config.write_text(SMALL, encoding="utf-8")
    return config


@pytest.mark.usefixtures("unrendered")
def test_json_is_all_of_stdout(small, tmp_path, capsys):
    assert chamber(small, "--out", tmp_path / "a", "--json") == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out) == design_in(tmp_path / "a")
    assert "wrote" in printed.err


def test_a_design_that_breaks_a_rule_is_drawn_and_refused(tmp_path, capsys):
    options = ["--set", "supports.pitch_um=2700", "--out", tmp_path / "a"]
    assert chamber(*options) == 2
    printed = capsys.readouterr()
    assert files_in(tmp_path / "a") == ["chamber.rules.png"]
    wrote, error = printed.err.splitlines(keepends=True)
    assert wrote.startswith("wrote ")
    assert error.startswith("error: the chamber must be within its design rules; got ")
    assert "span at (" in error


def test_with_warn_the_same_design_is_written(tmp_path, capsys):
    options = ["--set", "supports.pitch_um=2700", "--out", tmp_path / "a"]
    assert chamber(*options, "--warn") == 0
    assert files_in(tmp_path / "a") == sorted([*ALWAYS, "chamber.rules.png"])
    assert {each["rule"] for each in design_in(tmp_path / "a")["violations"]} == {"span"}
    printed = capsys.readouterr()
    assert all(line.startswith("warning: ") for line in printed.err.splitlines())


@pytest.mark.usefixtures("unrendered")
def test_results_are_kept_unless_overwritten(small, tmp_path, capsys, refusal):
    out = tmp_path / "a"
    assert chamber(small, "--out", out) == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    capsys.readouterr()
    assert refusal("chamber", small, "--out", out)["argument"] == "--out"
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    assert chamber(small, "--out", out, "--overwrite") == 0
    after = {path.name: path.read_bytes() for path in out.iterdir()}
    again = [name for name in before if after[name] == before[name]]
    assert set(again) >= {"chamber.gds", "chamber.scad", "chamber.stl", "chamber.svg"}


@pytest.mark.parametrize(
    ("argument", "options"),
    [
        ("--thickness", ["--thickness", "85"]),
        ("--thickness", ["--thickness", "-85 um"]),
        ("--obstacle-radius", ["--obstacle-radius", "85 mPa s"]),
        ("thickness_um", ["--thickness", "1 m"]),
        ("--set", ["--set", "imaging.pitch_um"]),
        ("--set thickness_um", ["--set", "thickness_um=45", "--thickness", "45 um"]),
        ("--set imaging.rows", ["--set", "imaging.rows=3", "--set", "imaging.rows=5"]),
        ("imaging", ["--set", "imaging=3"]),
        ("imaging", ["--set", "imaging=3", "--set", "imaging.rows=3"]),
        ("imaging.row", ["--set", "imaging.row=3"]),
        ("imagin", ["--set", "imagin.rows=3"]),
        ("mask.", ["--set", "mask.=3"]),
        ("imaging.pitch_um", ["--set", "imaging.pitch_um=160"]),
        ("imaging.pitch_um", ["--obstacle-radius", "500 um"]),
        ("nowhere.toml", ["nowhere.toml"]),
    ],
)
def test_wrong_input_is_refused(tmp_path, refusal, argument, options):
    assert refusal("chamber", *options, "--out", tmp_path / "a")["argument"] == argument
    assert not (tmp_path / "a").exists()


@pytest.mark.slow
def test_the_flow_and_a_collision_in_it(small, tmp_path, capsys):
    out = tmp_path / "a"
    assert chamber(small, "--flow", "--out", out) == 0
    assert files_in(out) == sorted([*ALWAYS, "chamber.collision.png", "chamber.flow.png"])
    flow = design_in(out)["flow"]
    assert flow["mass_error"] < 0.01
    assert [row["oil_rate_uL_min"] for row in flow["at_oil_rates"]] == [20, 40, 60]
    assert flow["collision"]["stokes"]["outcome"] == "broke"
    printed = capsys.readouterr().out
    assert "one collision in the chamber flow" in printed
