"""``pinchoff calibrate``: what it writes, that it resumes, and how it refuses."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from pinchoff.cli import main
from pinchoff.studies.calibration import evaluation

QUICK = ["--points", 3, "--width", 0.1, "--scan", 6, "--evaluations", 3]
LANDSCAPES = [
    "landscape_edge_stiffness_neck_separation.png",
    "landscape_neck_separation_neck_thickness.png",
]
ALWAYS = ["calibration.json", "evaluations.jsonl", "line.png", "sensitivity.csv"]


def calibrate(*arguments):
    return main(["calibrate", *map(str, arguments)])


@pytest.fixture(scope="module")
def coarse(tmp_path_factory):
    """Fewer vertices, a small part of the work."""
    path = tmp_path_factory.mktemp("config") / "coarse.toml"
    path.write_text("vertex_count = 32\n")
    return path


@pytest.fixture(scope="module")
def out(coarse, tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrate") / "new" / "fit"
    assert calibrate("paper-simulation", coarse, *QUICK, "--grid", 3, "--out", folder) == 0
    return folder


def test_the_report(out):
    assert sorted(path.name for path in out.iterdir()) == sorted([*ALWAYS, *LANDSCAPES])
    report = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    assert set(report["best"]) == {"edge_stiffness", "neck_thickness"}
    assert report["objective"] <= report["objective_of_base"]
    assert report["parameters"]["edge_stiffness"] == report["best"]["edge_stiffness"]
    c = report["conversion"]
    assert 5e-5 < c["low"] <= c["value"] <= c["high"] < 2e-4
    lines = (out / "evaluations.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + report["evaluations"]
    # More edge stiffness pulls the droplet together, a thicker limit lets it break.
    mean = pd.read_csv(out / "sensitivity.csv").set_index("constant")["mean"]
    assert mean["edge_stiffness"] > 0 > mean["neck_thickness"]
    assert abs(mean["line_tension"]) < 0.1


@pytest.mark.usefixtures("unrendered")
def test_the_same_command_takes_up_the_evaluations(out, coarse, monkeypatch, capsys):
    before = (out / "evaluations.jsonl").read_bytes()
    monkeypatch.setattr(evaluation, "boundary", None)  # nothing is left to simulate
    again = ["paper-simulation", coarse, *QUICK, "--grid", 3, "--out", out]
    assert calibrate(*again, "--json") == 0
    report = json.loads((out / "calibration.json").read_text(encoding="utf-8"))
    assert json.loads(capsys.readouterr().out) == report
    assert (out / "evaluations.jsonl").read_bytes() == before


def test_another_calibration_in_its_folder_is_refused(out, coarse, refusal):
    error = refusal("calibrate", "paper-experiment", coarse, *QUICK, "--out", out)
    assert error["argument"] == str(out / "evaluations.jsonl")
    assert "target" in error["rule"] + error["advice"] + error["got"]


@pytest.mark.parametrize(
    ("argument", "options"),
    [
        ("TARGET", ["paper"]),
        ("TARGET: beta", ["0.1,0.7"]),
        ("TARGET: control_range", ["0.1,-0.7,0.2,0.1"]),
        ("TARGET", ["0.1,-0.7,0.2"]),
        ("nowhere.csv", ["nowhere.csv"]),
        ("--free", ["paper-simulation", "--free", "edge_stifness"]),
        ("--free", ["paper-simulation", "--free", "vertex_count"]),
        ("--free", ["paper-simulation", "--free", "edge_stiffness=2"]),
        ("--free", ["paper-simulation", "--free", "edge_stiffness", "--free", "edge_stiffness"]),
        ("--free edge_stiffness", ["paper-simulation", "--free", "edge_stiffness=5,2"]),
        ("--points", ["paper-simulation", "--points", 1]),
        ("--width", ["paper-simulation", "--width", 0]),
        ("--evaluations", ["paper-simulation", "--evaluations", 0]),
        ("--preset", ["paper-simulation", "--preset", "defautl"]),
    ],
)
def test_wrong_input_is_refused(tmp_path, refusal, argument, options):
    assert refusal("calibrate", *options, "--out", tmp_path / "a")["argument"] == argument
