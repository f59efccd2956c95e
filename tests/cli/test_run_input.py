"""``pinchoff run``: where parameters come from, and whom a refusal blames."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from pinchoff.cli import main

SHORT = ["--set", "time_limit=0.5"]
PHYSICAL = {
    "--diameter": "481 um",
    "--obstacle-radius": "85 um",
    "--speed": "1 mm/s",
    "--viscosity": "48 mPa s",
    "--surface-tension": "20 mN/m",
    "--thickness": "85 um",
}


def physical(**changes):
    given = PHYSICAL | {f"--{name.replace('_', '-')}": value for name, value in changes.items()}
    return [part for pair in given.items() for part in pair]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def physical_config(tmp_path):
    lines = [
        f'{flag.removeprefix("--").replace("-", "_")} = "{text}"' for flag, text in PHYSICAL.items()
    ]
    path = tmp_path / "physical.toml"
    path.write_text("\n".join(["[physical]", *lines]))
    return str(path)


def test_configuration_is_read_once(tmp_path, program):
    """A pipe gives its contents once; the preset's name is known after the run all the same."""
    done = subprocess.run(
        [*program, "run", "/dev/stdin", *SHORT, "--out", str(tmp_path / "out")],
        input='preset = "literal-separation"\noffset = 0.3\n',
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "out" / "collision.json").read_text(encoding="utf-8"))
    assert report["preset"] == "literal-separation"
    assert report["parameters"]["neck_separation_unit"] == "diameter"
    assert report["parameters"]["offset"] == 0.3


def test_interval_longer_than_any_run(tmp_path):
    out = str(tmp_path / "out")
    assert main(["run", *SHORT, "--frames-every", "1e308", "--out", out]) == 0


@pytest.mark.parametrize("command", [["run"], ["boundary"], ["sweep", "c.toml"]])
@pytest.mark.parametrize("folder", ["", "\udcff"])
def test_name_that_is_none_is_refused(refusal, tmp_path, command, folder):
    assert refusal(*command, "--out", folder)["argument"] == "--out"
    assert list(tmp_path.iterdir()) == []


def test_deep_nesting_is_refused(refusal):
    assert refusal("run", "--set", "offset=" + "[" * 100_000)["argument"] == "--set offset"
    assert refusal("boundary", "--set", "offset=" + "[" * 100_000)["argument"] == "--set offset"


def test_missing_quantity_is_named_as_its_option(refusal):
    assert refusal("run", "--diameter", "481 um")["argument"] == "--obstacle-radius"


@pytest.mark.parametrize("offset", ["abc", "20 um"])
def test_offset_alone_is_blamed_itself(refusal, offset):
    assert refusal("run", "--offset", offset)["argument"] == "--offset"


def test_group_out_of_range_blames_its_quantities(refusal):
    error = refusal("run", *physical(viscosity="480 Pa s"))
    assert error["argument"] == "--viscosity * --speed / --surface-tension"
    assert "mPa s" in error["advice"]
    error = refusal("run", *physical(diameter="481 mm"))
    assert error["argument"] == "--diameter / --obstacle-radius"


@pytest.mark.parametrize(
    ("option", "advice"),
    [("--capillary", "--viscosity"), ("--size-ratio", "--diameter")],
)
def test_group_beside_a_physical_file_is_explained(refusal, physical_config, option, advice):
    error = refusal("run", physical_config, option, "12")
    assert error["argument"] == option
    assert "physical" in error["rule"]
    assert advice in error["advice"]
    assert "from_physical" not in error["advice"]


def test_offset_changes_in_a_physical_file(physical_config, tmp_path):
    for number, offset in enumerate(("0.2", "96.2 um")):
        out = tmp_path / f"out{number}"
        arguments = [physical_config, "--offset", offset, *SHORT, "--out", str(out)]
        assert main(["run", *arguments]) == 0
        report = json.loads(Path(out, "collision.json").read_text(encoding="utf-8"))
        assert report["parameters"]["offset"] == pytest.approx(0.2)


def test_offset_of_a_file_stays_beside_physical_options(tmp_path):
    config, out = tmp_path / "config.toml", tmp_path / "out"
    config.write_text("offset = 0.2\n")
    assert main(["run", str(config), *physical(), *SHORT, "--out", str(out)]) == 0
    report = json.loads(Path(out, "collision.json").read_text(encoding="utf-8"))
    assert report["parameters"]["offset"] == 0.2


@pytest.mark.parametrize("command", ["run", "sweep", "summary", "boundary"])
def test_usage_error_points_to_its_own_help(capsys, command):
    assert main([command, "--no-such-option-at-all"]) == 2
    assert capsys.readouterr().err.endswith(f"; see pinchoff {command} --help\n")


def test_usage_error_without_a_command_points_to_the_help(capsys):
    assert main(["frobnicate", "run"]) == 2
    assert capsys.readouterr().err.endswith("; see pinchoff --help\n")
