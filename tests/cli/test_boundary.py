"""``pinchoff boundary``: what it writes, what it prints, and how it refuses."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from pinchoff.cli import main

QUICK = ["--scan", "8", "--width", "0.05"]
ALWAYS = ["boundary.csv", "boundary.parquet", "fit.json", "runs.parquet", "separating_line.png"]


def boundary(*arguments):
    return main(["boundary", *map(str, arguments)])


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def report_in(folder):
    return json.loads((folder / "fit.json").read_text(encoding="utf-8"))


def test_the_papers_line_by_default(tmp_path, capsys):
    out = tmp_path / "new" / "line"
    assert boundary("--out", out) == 0
    assert files_in(out) == ALWAYS
    table = pd.read_parquet(out / "boundary.parquet")
    assert table["simulation_capillary_number"].tolist() == [16, 20, 25, 32, 40, 50, 64, 80]
    assert (table["status"] == "found").all()
    assert (table["width"] <= 0.005).all()
    report = report_in(out)
    assert report["fit"]["beta"]["low"] < report["fit"]["beta"]["value"] < 0
    assert report["runs"] == len(pd.read_parquet(out / "runs.parquet")) == table["runs"].sum()
    assert report["fit"]["control_range"] == [
        table["control_parameter"].min(),
        table["control_parameter"].max(),
    ]
    printed = capsys.readouterr()
    assert printed.err == ""
    assert [f"wrote {out / name}" in printed.out for name in ALWAYS] == [True] * 5
    assert "S_c = 0.0" in printed.out
    assert "95% intervals" in printed.out
    assert "0 captured at the time limit, which counts as not broken" in printed.out


def test_several_sizes_and_line_tensions_draw_their_figures(tmp_path):
    out = tmp_path / "line"
    lists = ["--capillary", "20, 40", "--size-ratio", "[5.66,8]", "--set", "line_tension=60,190"]
    assert boundary(*lists, *QUICK, "--out", out) == 0
    assert files_in(out) == sorted([*ALWAYS, "appendix_c.png", "area_collapse.png"])
    report = report_in(out)
    assert report["varied"]["line_tension"] == [60, 190]
    assert set(report["fits_free_area_exponent"]) == {"flow", "contact"}
    assert set(report["appendix_c"]["slopes"]) == {"60", "190"}


@pytest.mark.usefixtures("unrendered")
def test_json_is_all_of_stdout(tmp_path, capsys):
    assert boundary("--capillary", "25,40,64", *QUICK, "--out", tmp_path / "a", "--json") == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out) == report_in(tmp_path / "a")
    assert "wrote" in printed.err


@pytest.mark.usefixtures("unrendered")
def test_a_config_and_a_preset(tmp_path):
    config = tmp_path / "config.toml"
    config.write_text('preset = "paper-step"\nedge_stiffness = 2\n', encoding="utf-8")
    assert boundary(config, "--capillary", 40, *QUICK, "--out", tmp_path / "a") == 0
    base = report_in(tmp_path / "a")["base"]
    assert (base["time_step"], base["edge_stiffness"]) == (1e-4, 2)


@pytest.mark.usefixtures("unrendered")
def test_one_point_has_no_line_and_says_why(tmp_path, capsys):
    assert boundary("--capillary", 40, *QUICK, "--out", tmp_path / "a") == 0
    report = report_in(tmp_path / "a")
    assert report["fit"] is None
    assert "3 or more points" in report["why_no_fit"]
    assert "3 or more points" in capsys.readouterr().out


@pytest.mark.usefixtures("unrendered")
def test_captured_droplets_are_said_to_count_as_not_broken(tmp_path, capsys):
    """Head-on the droplet stays; near it others break: the outcome changes twice."""
    out = tmp_path / "a"
    assert boundary("--size-ratio", 2.5, "--capillary", 64, "--out", out) == 0
    printed = capsys.readouterr().out
    assert "1 captured at the time limit, which counts as not broken" in printed
    assert "a larger time_limit" in printed
    assert "point 0, non-monotonic in S: not 1.0000 to 1.0000, broke 0.9" in printed
    assert report_in(out)["captured_runs"] == 1


@pytest.mark.usefixtures("unrendered")
def test_failed_runs_are_named_on_stderr(tmp_path, capsys):
    failing = ["--capillary", 40, "--set", "area_stiffness=1", "--scan", 4]
    assert boundary(*failing, "--out", tmp_path / "a") == 0
    printed = capsys.readouterr()
    begin = "warning: 5 of 5 runs of point 0 have no outcome, at offsets from 0.00000 to 0."
    assert printed.err.startswith(begin)
    assert printed.err.count("\n") == 1
    assert "unresolved" in printed.out


@pytest.mark.usefixtures("unrendered")
def test_results_are_kept_unless_overwritten(tmp_path, capsys, refusal):
    out = tmp_path / "a"
    command = ["--capillary", 40, *QUICK, "--out", out]
    assert boundary(*command) == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    capsys.readouterr()
    assert refusal("boundary", *command)["argument"] == "--out"
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    assert boundary(*command, "--overwrite") == 0


@pytest.mark.parametrize(
    ("argument", "options"),
    [
        ("--capillary", ["--capillary", "16,,20"]),
        ("--capillary", ["--capillary", "16,fast"]),
        ("--capillary", ["--capillary", "-1,20"]),
        ("--size-ratio", ["--size-ratio", "0"]),
        ("--set", ["--set", "line_tension"]),
        ("--set", ["--set", "size_ratio=4"]),
        ("--set line_tension", ["--set", "line_tension=60", "--set", "line_tension=80"]),
        ("line_tension", ["--set", "line_tension=0"]),
        ("vary", ["--set", "line_tensoin=60"]),
        ("vary", ["--set", "offset=0.1"]),
        ("--width", ["--width", "thin"]),
        ("--width", ["--width", "0"]),
        ("--scan", ["--scan", "4.5"]),
        ("--scan", ["--scan", "2"]),
        ("--preset", ["--preset", "defautl"]),
        ("nowhere.toml", ["nowhere.toml"]),
    ],
)
def test_wrong_input_is_refused(tmp_path, refusal, argument, options):
    assert refusal("boundary", *options, "--out", tmp_path / "a")["argument"] == argument
    assert not (tmp_path / "a").exists() or files_in(tmp_path / "a") == []
