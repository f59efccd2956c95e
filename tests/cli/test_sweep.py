"""``pinchoff sweep`` and ``pinchoff summary``: what they print, draw and refuse."""

from __future__ import annotations

import re
import signal
import subprocess
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb

import pinchoff as po
import pinchoff.cli
from pinchoff.cli import main
from pinchoff.figures.phase_diagram import phase_diagram
from pinchoff.studies.sweep import summary
from pinchoff.support import palette

EXAMPLES = Path(pinchoff.cli.__file__).parent / "example_files"
CONFIG = """
follow_daughters = false
start_distance = 1.5
[vary]
simulation_capillary_number = [12, 25, 60]
offset = { min = 0.0, max = 0.9, count = 20 }
"""


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "config.toml"
    path.write_text(CONFIG)
    return path


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return the folder of a finished sweep, for tests that only read it."""
    folder = tmp_path_factory.mktemp("cli")
    (folder / "config.toml").write_text(CONFIG)
    arguments = [str(folder / "config.toml"), "--out", str(folder / "out"), "--threads", "2"]
    assert main(["sweep", *arguments]) == 0
    return folder / "out"


def test_sweep_writes_a_table_and_goes_on_with_it(config, done, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", str(config), "--out", str(out)]) == 0
    assert capsys.readouterr().out.startswith(f"wrote {out}: 60 collisions\n")
    (out / "part-000002.parquet").unlink()
    assert main(["sweep", str(config), "--out", str(out), "--threads", "1"]) == 0
    assert f"wrote {out}: 60 collisions, 44 of them from before" in capsys.readouterr().out
    one, other = po.read_collisions(out), po.read_collisions(done)
    pd.testing.assert_frame_equal(one, other, check_exact=True)


@pytest.mark.parametrize("name", ["phase-diagram", "speed-and-offset"])
def test_examples_run(name, tmp_path):
    assert main(["sweep", str(EXAMPLES / f"{name}.toml"), "--out", str(tmp_path / "out")]) == 0
    frame = po.read_collisions(tmp_path / "out")
    assert frame["broke"].any()
    assert not frame["broke"].all()


def test_refusals_are_one_line_with_the_name_of_the_option(config, done, tmp_path, capsys):
    def said(*arguments):
        assert main(["sweep", *map(str, arguments)]) == 2
        message = capsys.readouterr().err
        assert re.fullmatch(r"error: .+ must be .+; got .+; .+\n", message), message
        return message

    out = tmp_path / "out"
    assert said(config, "--out", out, "--workers", "0").startswith("error: --workers must be")
    beside = said(config, "--out", out, "--threads", "1", "--scheduler", "tcp://127.0.0.1:1")
    assert beside.startswith("error: --workers must be left out")  # its earlier name
    assert said(tmp_path / "no.toml", "--out", out).startswith(f"error: {tmp_path / 'no.toml'}")
    config.write_text(CONFIG.replace("count", "cuont"))
    assert "did you mean 'count'?" in said(config, "--out", out)
    config.write_text(CONFIG.replace("0.9", "0.8"))
    changed = said(config, "--out", done)
    assert changed.startswith("error: --out must be ")
    assert "vary.offset.max = 0.8, there 0.9" in changed
    assert not out.exists()


def test_failed_runs_are_warned_of(tmp_path, capsys):
    config = tmp_path / "config.toml"
    config.write_text("vary.area_stiffness = [1, 200000]\n")
    assert main(["sweep", str(config), "--out", str(tmp_path / "out")]) == 0
    assert "warning: guards stopped 1 of 2 runs" in capsys.readouterr().err


def test_ctrl_c_ends_with_a_hint_and_without_a_traceback(config, tmp_path, program):
    config.write_text(CONFIG.replace("count = 20", "count = 2000"))
    out = tmp_path / "out"
    process = subprocess.Popen(
        [*program, "sweep", str(config), "--out", str(out)], stderr=subprocess.PIPE, text=True
    )
    while not list(out.glob("part-*")):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 1
    assert said == f"stopped; the same command goes on with {out}\nerror: interrupted\n"


def test_summary_counts_measures_and_draws(done, tmp_path, capsys):
    picture = tmp_path / "picture.png"
    assert main(["summary", str(done), "--picture", str(picture)]) == 0
    said = capsys.readouterr().out
    frame = po.read_collisions(done)
    assert said.startswith("60 collisions\n")
    counted = frame.loc[frame["accepted"], "outcome"].value_counts()
    for outcome, count in counted.items():
        if count:
            assert re.search(rf"{outcome} +{count}\b", said)
    missed = int((~frame["accepted"]).sum())
    assert missed > 0
    assert re.search(rf"  no contact +{missed}\b", said)
    assert sum(summary.summarize(done).outcomes.values()) == 60  # every row once
    assert re.search(r"contact_time +[\d.]+ +[\d.]+ +t0 +\d+ rows", said)
    assert "area_um2" not in said  # never measured
    assert matplotlib.image.imread(picture).shape[2] >= 3
    assert main(["summary", str(done)]) == 0
    assert (done / "_summary.png").exists()
    assert len(pd.read_parquet(done)) == 60  # the folder still opens as it is


def test_summary_of_an_unfinished_sweep_says_so(config, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", str(config), "--out", str(out)]) == 0
    (out / "part-000001.parquet").unlink()
    capsys.readouterr()
    assert main(["summary", str(out)]) == 0
    assert capsys.readouterr().out.startswith("44 collisions of 60: not finished\n")


def test_summary_without_collisions_draws_nothing(tmp_path, capsys):
    config = tmp_path / "config.toml"
    config.write_text("vary.offset = [2, 3]\n")
    assert main(["sweep", str(config), "--out", str(tmp_path / "out")]) == 0
    assert main(["summary", str(tmp_path / "out")]) == 0
    assert "no picture" in capsys.readouterr().out


def test_summary_of_what_is_no_table_is_refused(tmp_path, capsys):
    assert main(["summary", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(f"error: {tmp_path} must be a collisions table")


def test_summary_agrees_with_the_table(done):
    found = summary.summarize(done)
    frame = po.read_collisions(done)
    for name, (low, high, measured) in found.ranges.items():
        values = frame[name].dropna()
        assert (low, high, measured) == (values.min(), values.max(), len(values))
    accepted = frame[frame["accepted"]]
    forcing = accepted["capillary_number"] * accepted["normalized_area"]
    np.testing.assert_allclose(np.sort(found.points.forcing), np.sort(forcing))
    assert found.points.population == len(accepted)
    assert found.points.broke.sum() == accepted["broke"].sum()


def test_reasons_are_counted_without_their_numbers(tmp_path):
    with pytest.warns(RuntimeWarning, match="stopped 3 of 3"):
        po.sweep({"vary": {"area_stiffness": [1, 2, 3]}}, tmp_path)
    reasons = summary.summarize(tmp_path).reasons
    assert list(reasons.values()) == [3]
    assert next(iter(reasons)).endswith("; raise area_stiffness, or lower time_step")


def test_large_table_is_drawn_as_a_sample_and_the_picture_says_so(done, monkeypatch):
    monkeypatch.setattr(summary, "MOST_DRAWN", 20)
    points = summary.summarize(done).points
    assert 5 < len(points.symmetry) < 40
    everything = points.population
    axes = phase_diagram(points)
    assert axes.get_title("right").startswith(f"random {len(points.symmetry)} of {everything}")
    again = summary.summarize(done).points
    np.testing.assert_array_equal(points.symmetry, again.symmetry)


def test_phase_diagram_shows_every_point_once_and_the_papers_lines(done):
    points = summary.summarize(done).points
    axes = phase_diagram(points)
    lines = {line.get_label(): line for line in axes.lines}
    for name, alpha, beta in (("simulations", 0.089, -0.72), ("experiments", 0.083, -0.74)):
        x, y = lines[f"paper, {name}"].get_data()
        np.testing.assert_allclose(y, alpha * x**beta)
    (marks,) = axes.collections
    edges, heights = marks.get_edgecolors()[:, :3], marks.get_offsets()[:, 1]
    for broke, colour in ((True, palette.BROKE), (False, palette.UNBROKEN)):
        drawn = heights[np.all(edges == to_rgb(colour), axis=1)]
        np.testing.assert_array_equal(
            np.sort(drawn), np.sort(points.symmetry[points.broke == broke])
        )
    assert axes.get_xscale() == axes.get_yscale() == "log"
