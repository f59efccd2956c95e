"""``pinchoff film`` and ``pinchoff video``: what they write, resume and refuse."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
from importlib.resources import files

import pyarrow.parquet as pq
import pytest

import pinchoff as po
from pinchoff.cli import main
from pinchoff.explorer.page import is_built
from pinchoff.video.batch import clip_sources, measure_videos

LABORATORY = [
    *("--pixel-size", "5.28um", "--obstacle-radius", "85um", "--thickness", "85um"),
    *("--viscosity", "48mPa.s", "--surface-tension", "20mN/m"),
]
RINGS = ["--set", "method=rings"]
"""The method that the clip itself chooses, for tests of other things: choosing takes longest."""
ALONE = ["--no-overlay", "--workers", "1"]
PLAIN = {"overlay": False, "processes": 1}
"""No overlay and no further process, for tests of other things, in words and from Python."""

DESIGN = """
simulation_capillary_number = 55
size_ratio = 4.0
[vary]
offset = [0.03, 0.2]
"""


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """A small clip with its truth, from a sweep of two runs: one breaks, one slips past."""
    folder = tmp_path_factory.mktemp("film")
    (folder / "design.toml").write_text(DESIGN)
    (folder / "look.toml").write_text("width = 480\nheight = 360\nnoise = 3\n")
    assert main(["sweep", str(folder / "design.toml"), "--out", str(folder / "sweep")]) == 0
    clip = folder / "clip.mp4"
    look = ["--look", str(folder / "look.toml")]
    assert main(["film", str(folder / "sweep"), "--out", str(clip), *look]) == 0
    return clip


@pytest.fixture(scope="module")
def done(filmed, tmp_path_factory):
    out = tmp_path_factory.mktemp("video") / "out"
    assert main(["video", str(filmed), *LABORATORY, "--out", str(out), "--workers", "1"]) == 0
    return out


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_film_and_measurement_agree(filmed, done):
    truth = po.read_collisions(filmed.with_suffix(".truth.parquet"))
    table = po.read_collisions(done / "collisions.parquet")
    assert set(truth["source"]) == {"film"}
    assert set(table["source"]) == {"video"}
    assert list(table["outcome"]) == list(truth["outcome"])
    assert sorted(table["outcome"]) == ["broke", "slipped"]
    assert table["accepted"].all()
    assert table["symmetry"].to_numpy() == pytest.approx(truth["symmetry"].to_numpy(), abs=0.03)
    assert table.attrs["units"]["breakup_neck_um"] == "µm"


def test_results(done):
    folder = done / "clips" / "clip"
    names = {path.name for path in done.iterdir()}
    assert names == {
        *("clips", "collisions.parquet", "contact_sheet.png", "events.parquet", "index.html"),
        *("plugs.parquet", "tracks.parquet"),
        *(["explore.html"] if is_built() else []),
    }
    assert {path.name for path in folder.iterdir()} >= {
        *("clip.json", "collisions.parquet", "obstacles.toml", "outlines.gsd", "overlay.mp4"),
        *("tracks.parquet", "events.parquet", "collisions"),
    }
    result = json.loads((folder / "clip.json").read_text(encoding="utf-8"))
    tracks = pq.read_table(done / "tracks.parquet")
    assert tracks.column("frame").to_pylist()[-1] < result["frames"]
    assert tracks.schema.field("x_um").metadata[b"unit"] == "µm".encode()
    kinds = pq.read_table(done / "events.parquet").column("kind").to_pylist()
    assert kinds.count("break-up") == 1
    outlines = po.Outlines.load(folder / "outlines.gsd")
    assert outlines.units == "um"
    assert len(outlines.measure()) > result["frames"]
    page = (done / "index.html").read_text(encoding="utf-8")
    assert "2 collisions in 1 clip" in page
    # A frame and two figures; the collisions stand in the gallery.
    assert page.count('class="picture"') == 3


def test_annotated_clip_shows_every_frame(done):
    from pinchoff.video.reading import Clip

    result = json.loads((done / "clips" / "clip" / "clip.json").read_text(encoding="utf-8"))
    found = list(Clip(done / "clips" / "clip" / "overlay.mp4").frames())
    assert len(found) == result["frames"]
    assert found[0].luma.shape == (720 + 24, 960)  # with the legend below


def test_second_run_reuses(filmed, done, capsys):
    before = contents(done / "clips")
    assert main(["video", str(filmed), *LABORATORY, "--out", str(done)]) == 0
    assert "1 of them measured before" in capsys.readouterr().out
    assert contents(done / "clips") == before


def test_other_settings_measure_again(filmed, tmp_path, capsys):
    settings = po.VideoSettings(pixel_size_um=5.28, method="rings")
    first = measure_videos([filmed], tmp_path, settings, **PLAIN)
    again = measure_videos([filmed], tmp_path, settings, **PLAIN)
    other = measure_videos([filmed], tmp_path, settings.replace(fps=30.0), **PLAIN)
    assert [each.clips[0].reused for each in (first, again, other)] == [False, True, False]
    ratio = other.collisions["speed_mm_s"] / first.collisions["speed_mm_s"]
    assert ratio.to_numpy() == pytest.approx(0.5, rel=1e-6)


def test_corrected_obstacles_are_read_back(filmed, tmp_path):
    settings = po.VideoSettings(
        pixel_size_um=5.28, method="rings", laboratory={"obstacle_radius_um": 85}
    )
    first = measure_videos([filmed], tmp_path, settings, **PLAIN)
    path = first.clips[0].folder / "obstacles.toml"
    lines = path.read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("  [") for line in lines) == 2
    kept = [line for k, line in enumerate(lines) if not line.startswith("  [") or k == 3]
    path.write_text("\n".join(kept), encoding="utf-8")
    second = measure_videos([filmed], tmp_path, settings, **PLAIN)
    assert len(first.collisions) == 2
    assert len(second.collisions) == 1
    assert path.read_text(encoding="utf-8") == "\n".join(kept)
    third = measure_videos([filmed], tmp_path, settings, **PLAIN)
    assert third.clips[0].reused


@pytest.mark.usefixtures("unrendered")
def test_bad_files_do_not_stop_the_batch(filmed, tmp_path, capsys):
    (tmp_path / "text.mp4").write_text("no video")
    out = tmp_path / "out"
    files = [str(tmp_path / "text.mp4"), str(filmed)]
    told = [*LABORATORY, *RINGS, "--no-overlay", "--workers", "1"]
    assert main(["video", *files, *told, "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert re.search(r"error: .*text.mp4 must be a readable film; got .+; .+\n", said.err)
    assert "2 collisions, 2 accepted, in 1 clip" in said.out
    assert "text.mp4 must be a readable film" in (out / "index.html").read_text(encoding="utf-8")
    assert not (out / "clips" / "text").exists()


def test_only_bad_files_are_an_error(tmp_path, capsys):
    (tmp_path / "text.mp4").write_text("no video")
    out = tmp_path / "out"
    assert main(["video", str(tmp_path / "text.mp4"), *LABORATORY, "--out", str(out)]) == 2
    assert "FILES must be measurable" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "argument"),
    [
        ([], "--pixel-size"),
        (["--pixel-size", "5.28"], "--pixel-size"),
        (["--pixel-size", "5 mm/s"], "--pixel-size"),
        (["--pixel-size", "-5 um"], "--pixel-size"),
        (["--pixel-size", "5 um", "--viscosity", "48"], "--viscosity"),
        (["--pixel-size", "5 um", "--fps", "fast"], "--fps"),
        (["--pixel-size", "5 um", "--set", "fps=fast"], "fps"),
        (["--pixel-size", "5 um", "--method", "circles"], "--method"),
        (["--pixel-size", "5 um", "--crop", "1,2"], "--crop"),
        (["--pixel-size", "5 um", "--set", "edge_level=3"], "edge_level"),
        (["--pixel-size", "5 um", "--set", "colour=3"], "colour"),
        (["--pixel-size", "5 um", "--set", "interior=[300, 0, 0]"], "interior"),
        (["--pixel-size", "5 um", "--set", "edge_level"], "--set"),
        (["--pixel-size", "5 um", "--set", "maximum_diameter_um=50"], "maximum_diameter_um"),
        (
            ["--pixel-size", "9 um", "--packed", "--minimum-diameter", "30 um"],
            "minimum_diameter_um",
        ),
        (["--pixel-size", "5 um", "--out", ""], "--out"),
    ],
)
def test_refuses(filmed, tmp_path, monkeypatch, capsys, arguments, argument):
    monkeypatch.chdir(tmp_path)
    assert main(["video", str(filmed), *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {argument} must be ")
    assert "Traceback" not in error
    assert not list(tmp_path.iterdir())


def test_film_refuses_what_is_no_sweep(tmp_path, capsys):
    assert main(["film", str(tmp_path), "--out", str(tmp_path / "clip.mp4")]) == 2
    assert "must be the folder of a sweep" in capsys.readouterr().err


def test_names(tmp_path, refused):
    (tmp_path / "one").mkdir()
    for name in ("b.mp4", "a.mp4", "notes.txt"):
        (tmp_path / "one" / name).touch()
    assert list(clip_sources([tmp_path / "one"])) == ["a", "b"]
    (tmp_path / "a.avi").touch()
    refused("clips", clip_sources, [tmp_path / "one", tmp_path / "a.avi"])
    refused("clips", clip_sources, [])


@pytest.mark.usefixtures("unrendered")
def test_settings_from_a_file(filmed, tmp_path):
    config = tmp_path / "settings.toml"
    config.write_text("pixel_size_um = 5.28\n[laboratory]\nobstacle_radius_um = 85.0\n")
    out = tmp_path / "out"
    arguments = ["--config", str(config), "--fps", "30", "--out", str(out), *ALONE]
    assert main(["video", str(filmed), *arguments, *RINGS]) == 0
    result = json.loads((out / "clips" / "clip" / "clip.json").read_text(encoding="utf-8"))
    assert result["settings"]["fps"] == 30.0
    assert result["settings"]["laboratory"]["obstacle_radius_um"] == 85.0


def test_packed_scene(filmed, tmp_path):
    out = tmp_path / "out"
    told = [*LABORATORY, "--packed", "--frames", "0:40", "--no-overlay"]
    assert main(["video", str(filmed), *told, "--out", str(out)]) == 0
    result = json.loads((out / "clips" / "clip" / "clip.json").read_text(encoding="utf-8"))
    assert result["method"] == "packed"
    assert len(result["obstacles"]) == 2  # a radius is given: they are looked for, and no droplets
    tracks = pq.read_table(out / "tracks.parquet").to_pandas()
    first = tracks[(tracks["frame"] == 20) & ~tracks["cut"]]
    assert len(first) == 1


def test_a_preview_shows_each_method_and_passes_over_a_damaged_clip(filmed, tmp_path, capsys):
    damaged = tmp_path / "damaged.mp4"
    damaged.write_bytes(filmed.read_bytes()[:3000])
    out = tmp_path / "out"
    options = ["--pixel-size", "5.28um", "--preview", "--out", str(out)]
    assert main(["video", str(damaged), str(filmed), *options]) == 0
    said = capsys.readouterr()
    assert f"error: {damaged} must be" in said.err
    assert "clip: rings is used (rings 1.00, enclosed" in said.out
    assert [path.name for path in out.iterdir()] == ["preview-clip.png"]
    assert main(["video", str(damaged), *options]) == 2


def begun(folder):
    return folder.is_dir() and any(folder.iterdir())


def test_interrupted_run_goes_on(filmed, tmp_path, program):
    """A run that is killed leaves whole files or none, and the next one does what is missing."""
    for name in ("one", "two", "three"):
        (tmp_path / f"{name}.mp4").write_bytes(filmed.read_bytes())
    out = tmp_path / "out"
    files = [str(tmp_path / f"{name}.mp4") for name in ("one", "two", "three")]
    command = [*program, "video", *files, *LABORATORY, *RINGS, *ALONE, "--out", str(out)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    marker = out / "clips" / "one" / "clip.json"
    deadline = time.monotonic() + 120
    while not (marker.exists() and begun(out / "clips" / "two")) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert marker.exists()
    assert not (out / "clips" / "three" / "clip.json").exists()
    assert not (out / "collisions.parquet").exists()
    settings = po.VideoSettings(
        pixel_size_um=5.28,
        method="rings",
        laboratory={
            "obstacle_radius_um": 85.0,
            "thickness_um": 85.0,
            "viscosity_mPa_s": 48.0,
            "surface_tension_mN_m": 20.0,
        },
    )
    result = measure_videos(files, out, settings, **PLAIN)
    assert [each.reused for each in result.clips] == [True, False, False]
    assert len(result.collisions) == 6
    assert os.listdir(out / "clips" / "two")  # noqa: PTH208


@pytest.mark.parametrize("number", [0, 1])
def test_comparison_with_the_simulation(done, tmp_path, number):
    """A filmed run of the engine, simulated again from what was measured of it."""
    folder = done / "clips" / "clip"
    out = tmp_path / "comparison"
    assert main(["compare", str(folder), "--collision", str(number), "--out", str(out)]) == 0
    assert {path.name for path in out.iterdir()} == {"comparison.png", "comparison.json"}
    found = json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert found["simulated_outcome"] == found["measured_outcome"]
    assert found["simulated"]["symmetry"] == pytest.approx(found["measured"]["symmetry"], abs=0.01)
    row = po.read_collisions(folder / "collisions.parquet").iloc[number]
    assert abs(found["simulated"]["offset"]) == pytest.approx(
        0.03 if row["broke"] else 0.2, abs=0.05
    )
    assert found["position_rms_um"] < 5 * 5.28
    assert found["shape_rms"] < 0.1  # of a shape parameter that goes from 1 to about 3
    assert found["frames"] > 15


def test_comparison_refuses(done, tmp_path, capsys):
    out = ["--out", str(tmp_path / "out")]
    assert main(["compare", str(done / "clips" / "clip"), "--collision", "9", *out]) == 2
    assert "--collision must be from 0 to 1" in capsys.readouterr().err
    assert main(["compare", str(done), "--collision", "0", *out]) == 2
    assert "must be the folder of a measured clip" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("unrendered")
def test_comparison_wants_the_same_clip(filmed, tmp_path, capsys):
    clip = tmp_path / "clip.mp4"
    clip.write_bytes(filmed.read_bytes())
    out = tmp_path / "out"
    told = [*LABORATORY, *RINGS, *ALONE]
    assert main(["video", str(clip), *told, "--out", str(out)]) == 0
    compare = ["compare", str(out / "clips" / "clip"), "--collision", "0"]
    assert main([*compare, "--out", str(tmp_path / "one")]) == 0
    assert main([*compare, "--out", str(tmp_path / "one")]) == 2
    assert "--out must be a folder without results" in capsys.readouterr().err
    clip.write_bytes(filmed.read_bytes()[:-1000])
    assert main([*compare, "--out", str(tmp_path / "two")]) == 2
    assert "the clip that was measured; got one that has changed" in capsys.readouterr().err
    clip.unlink()
    assert main([*compare, "--out", str(tmp_path / "two")]) == 2
    assert "the clip that was measured; got nothing there" in capsys.readouterr().err
    assert not (tmp_path / "two").exists()


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("video", "collisions.parquet"),
        ("emulsion", "collisions.parquet"),
        ("reproduce", "report.html"),
    ],
)
def test_results_of_another_command_are_not_replaced(filmed, tmp_path, capsys, command, name):
    """Such commands go on in a folder that holds results, if the results are theirs."""
    (tmp_path / name).write_text("precious")
    config = files("pinchoff.cli") / "example_files" / "emulsion.toml"
    given = {"video": [str(filmed), *LABORATORY], "emulsion": [str(config)]}.get(command, [])
    assert main([command, *given, "--out", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert "--out must be a new folder, or one that this command wrote; got" in error
    assert f"(it holds another's {name})" in error
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "precious"


def test_pillars_that_are_not_found_are_missed(filmed, tmp_path, capsys):
    small = ["--pixel-size", "5.28um", "--obstacle-radius", "30um", *RINGS, "--no-overlay"]
    assert main(["video", str(filmed), *small, "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    advice = "0 pillars: if there are some, write their circles into clips/clip/obstacles.toml"
    assert advice in said
    assert (tmp_path / "out" / "clips" / "clip" / "obstacles.toml").exists()


def test_film_has_the_name_of_its_option(filmed, tmp_path, capsys):
    out = ["--most", "1", "--out", str(tmp_path / "clip.avi")]
    assert main(["film", str(filmed.parent / "sweep"), *out]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: --out must be a name ending in .mp4; got {tmp_path}")


def test_film_overwrites_nothing_unasked(filmed, tmp_path, capsys):
    sweep, clip = filmed.parent / "sweep", tmp_path / "clip.mp4"
    clip.write_text("precious")
    assert main(["film", str(sweep), "--out", str(clip)]) == 2
    assert f"--out must be a new file; got {clip}, which exists" in capsys.readouterr().err
    assert clip.read_text() == "precious"
    small = ["--most", "1", "--look", str(filmed.parent / "look.toml")]
    assert main(["film", str(sweep), "--out", str(clip), *small, "--overwrite"]) == 0
    assert clip.stat().st_size > 1000


def test_film_follows_daughters_of_runs_that_did_not(tmp_path, filmed, capsys):
    """The truth is that of the whole runs; runs that end too early are left out with a word."""
    (tmp_path / "design.toml").write_text(f"follow_daughters = false\n{DESIGN}")
    assert main(["sweep", str(tmp_path / "design.toml"), "--out", str(tmp_path / "sweep")]) == 0
    look = ["--look", str(filmed.parent / "look.toml")]
    clip = tmp_path / "clip.mp4"
    assert main(["film", str(tmp_path / "sweep"), "--out", str(clip), *look]) == 0
    truth, whole = (
        po.read_collisions(path.with_suffix(".truth.parquet")) for path in (clip, filmed)
    )
    assert truth["daughter_area_ratio"].equals(whole["daughter_area_ratio"])
    assert truth["end_frame"].equals(whole["end_frame"])
    (tmp_path / "short.toml").write_text(f"time_limit = 2\n{DESIGN}")
    assert main(["sweep", str(tmp_path / "short.toml"), "--out", str(tmp_path / "short")]) == 0
    capsys.readouterr()
    assert main(["film", str(tmp_path / "short"), "--out", str(tmp_path / "none.mp4")]) == 2
    said = capsys.readouterr().err
    assert "2 of 2 runs are left out: time_limit must be long enough" in said
    assert not (tmp_path / "none.mp4").exists()


def test_summary_overwrites_nothing_unasked(filmed, tmp_path, capsys):
    picture = tmp_path / "mine.png"
    picture.write_text("precious")
    summary = ["summary", str(filmed.parent / "sweep"), "--picture", str(picture)]
    assert main(summary) == 2
    assert "--picture must be a new file" in capsys.readouterr().err
    assert picture.read_text() == "precious"
    assert main([*summary, "--overwrite"]) == 0
