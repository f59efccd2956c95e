"""``pinchoff run``: what it writes, what it prints, and how it refuses."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import pinchoff as po
from pinchoff.cli import main

FORM = re.compile(r"error: (?P<argument>.+?) must be .+?; got .+?; .+\n")
COARSE = ["--frames-every", "0.2"]
PHYSICAL = [
    *("--diameter", "481 um", "--obstacle-radius", "85 um", "--speed", "1 mm/s"),
    *("--viscosity", "48 mPa s", "--surface-tension", "20 mN/m", "--thickness", "85 um"),
    *("--offset", "10 um"),
]


@pytest.fixture
def run(program):
    """Function (*arguments, **options) -> the program's end, in a process of its own."""

    def call(*arguments, **options):
        return subprocess.run(
            [*program, "run", *map(str, arguments)],
            capture_output=True,
            text=True,
            encoding="utf-8",
            timeout=120,
            check=False,
            **options,
        )

    return call


def strict_json(text):
    """Read JSON as the standard has it, without NaN and Infinity."""

    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return a folder with a finished run, for tests that only read it."""
    out = tmp_path_factory.mktemp("run") / "collision"
    assert main(["run", "--out", str(out), *COARSE]) == 0
    return out


def test_every_option_at_once(tmp_path, run):
    av = pytest.importorskip("av")
    out = tmp_path / "new" / "folder"
    done = run(
        *("--preset", "paper-step", *PHYSICAL, "--set", "line_tension=60"),
        *("--set", "neck_separation_unit=perimeter", "--set", "follow_daughters=false"),
        *("--frames-every", "0.1", "--out", out, "--movie"),
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""  # no progress bar where stderr is no terminal
    names = ["collision.json", "movie.mp4", "outlines.gsd", "snapshots.png"]
    assert files_in(out) == names
    lines = done.stdout.splitlines()
    assert sorted(lines[-4:]) == [f"wrote {out / name}" for name in names]
    assert re.search(r"contact_time +\d\.\d+ +t0 *\n", done.stdout)
    assert re.search(r"contact_time_s +1\.\d+ +s *\n", done.stdout)

    report = strict_json((out / "collision.json").read_text(encoding="utf-8"))
    assert report["preset"] == "paper-step"
    assert report["pinchoff_version"] == po.__version__
    assert report["parameters"]["line_tension"] == 60
    assert report["parameters"]["time_step"] == 1e-4
    assert report["parameters"]["follow_daughters"] is False
    assert report["parameters"]["scale"]["diameter_um"] == pytest.approx(481)
    assert report["parameters"]["offset"] == pytest.approx(10 / 481)
    results = report["results"]
    assert results["contact_time_s"] == pytest.approx(0.481 * results["contact_time"])

    outlines = po.Outlines.load(out / "outlines.gsd")
    assert outlines.times[1] - outlines.times[0] == pytest.approx(0.1, rel=0.01)
    assert outlines.parameters == report["parameters"]
    assert (out / "snapshots.png").read_bytes().startswith(b"\x89PNG")
    with av.open(str(out / "movie.mp4")) as film:
        stream = film.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]
    assert 10 < len(frames) <= len(outlines)
    assert {frame.shape for frame in frames} == {(540, 960, 3)}
    assert any((frame != frames[0]).any() for frame in frames)


def test_formats_films_and_streamlines(tmp_path, capsys):
    out = tmp_path / "out"
    chosen = ["--format", "pdf, .SVG", "--gif", "--streamlines"]
    assert main(["run", "--out", str(out), *COARSE, *chosen]) == 0
    pictures = ["snapshots.pdf", "snapshots.svg"]
    assert files_in(out) == ["collision.json", "movie.gif", "outlines.gsd", *pictures]
    assert (out / "movie.gif").read_bytes().startswith(b"GIF8")
    assert (out / "snapshots.pdf").read_bytes().startswith(b"%PDF")
    assert "<svg" in (out / "snapshots.svg").read_text(encoding="utf-8")
    assert main(["run", "--format", "gif", "--out", str(tmp_path / "no")]) == 2
    assert "--format must be of png, pdf, svg" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_same_collision_as_the_library(finished):
    collision = po.simulate(po.Parameters())
    report = strict_json((finished / "collision.json").read_text(encoding="utf-8"))
    expected = collision.to_dict()
    assert report["parameters"] == expected.pop("parameters")
    results = report["results"]
    assert report["row"]["vertex_updates"] > 1000  # the row of the table, whole
    assert results == json.loads(json.dumps(expected))
    assert report["preset"] == "default"
    assert report["units"]["contact_time"] == "t0"
    assert report["derived"]["capillary_number"] == pytest.approx(9.8e-5 * 25)


@pytest.mark.usefixtures("unrendered")
def test_json_goes_alone_to_stdout(tmp_path, capfd):
    assert main(["run", "--json", "--out", str(tmp_path / "out"), *COARSE]) == 0
    written = (tmp_path / "out" / "collision.json").read_text(encoding="utf-8")
    printed = capfd.readouterr()
    assert strict_json(printed.out) == strict_json(written)
    assert f"wrote {tmp_path / 'out' / 'collision.json'}" in printed.err


@pytest.mark.usefixtures("unrendered")
def test_options_change_what_the_file_says(tmp_path, capsys):
    config = tmp_path / "config.toml"
    config.write_text('preset = "literal-separation"\noffset = 0.3\nline_tension = 60\n')
    out = tmp_path / "out"
    arguments = [str(config), "--offset", "0.4", "--size-ratio", "5", "--capillary", "12"]
    assert main(["run", *arguments, "--out", str(out), "--json", *COARSE]) == 0
    report = strict_json(capsys.readouterr().out)
    assert report["preset"] == "literal-separation"
    parameters = report["parameters"]
    assert parameters["neck_separation_unit"] == "diameter"
    assert parameters["offset"] == 0.4
    assert parameters["size_ratio"] == 5
    assert parameters["simulation_capillary_number"] == 12
    assert parameters["line_tension"] == 60
    assert parameters["area_stiffness"] == 5000 * 60


@pytest.mark.usefixtures("unrendered")
def test_one_quantity_changes_in_a_physical_file(tmp_path, capsys):
    config = tmp_path / "config.toml"
    config.write_text(
        "line_tension = 60\n[physical]\n"
        'diameter = "481 um"\nobstacle_radius = "85 um"\nspeed = "1 mm/s"\noffset = "20 um"\n'
        'viscosity = "48 mPa s"\nsurface_tension = "20 mN/m"\nthickness = "85 um"\n'
    )
    reports = []
    for number, options in enumerate(([], ["--speed", "0.5 mm/s"])):
        out = str(tmp_path / f"out{number}")
        assert main(["run", str(config), *options, "--out", out, "--json", *COARSE]) == 0
        reports.append(strict_json(capsys.readouterr().out)["parameters"])
    first, second = reports
    assert first["scale"].pop("speed_mm_s") == pytest.approx(1.0)
    assert second["scale"].pop("speed_mm_s") == pytest.approx(0.5)
    assert first.pop("simulation_capillary_number") == pytest.approx(
        2 * second.pop("simulation_capillary_number")
    )
    assert first.pop("offset") == pytest.approx(20 / 481)
    assert second.pop("offset") == pytest.approx(20 / 481)
    assert first.pop("size_ratio") == pytest.approx(second.pop("size_ratio"))
    assert first.pop("scale") == pytest.approx(second.pop("scale"))
    assert first == second
    assert first["line_tension"] == 60


@pytest.mark.usefixtures("unrendered")
def test_warning_is_one_line(tmp_path, capsys):
    thin = [*PHYSICAL, "--out", str(tmp_path / "out"), *COARSE]
    thin[thin.index("--thickness") + 1] = "45 um"
    assert main(["run", *thin]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("warning: thickness")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--size-ratio", "abc"], "--size-ratio"),
        (["--size-ratio", "nan"], "--size-ratio"),
        (["--size-ratio", "-1"], "--size-ratio"),
        (["--capillary", "inf"], "--capillary"),
        (["--offset", "7"], "--offset"),
        (["--offset", "nan"], "--offset"),
        ([*PHYSICAL, "--offset", "20 ms"], "--offset"),
        (["--preset", "defualt"], "--preset"),
        (["--set", "line_tensoin=60"], "line_tensoin"),
        (["--set", "line_tension=lots"], "line_tension"),
        (["--set", "line_tension=nan"], "line_tension"),
        (["--set", "vertex_count=12"], "vertex_count"),
        (["--set", "time_step=0.05"], "time_step"),
        (["--set", "line_tension"], "--set"),
        (["--set", "=60"], "--set"),
        (["--set", "offset=0.1", "--offset", "0.2"], "--set offset"),
        (["--set", "offset=0.1", "--set", "offset=0.2"], "--set offset"),
        ([*PHYSICAL, "--speed", "1 mm"], "--speed"),
        ([*PHYSICAL, "--speed", "1"], "--speed"),
        ([*PHYSICAL, "--speed", "-1 mm/s"], "--speed"),
        ([*PHYSICAL, "--speed", "fast"], "--speed"),
        (["--diameter", "481 um"], "--obstacle-radius"),
        ([*PHYSICAL, "--size-ratio", "5"], "--size-ratio"),
        (["--frames-every", "0"], "--frames-every"),
        (["--frames-every", "often"], "--frames-every"),
        (["--sizeratio", "5"], "--sizeratio"),
        (["missing.toml"], "missing.toml"),
    ],
)
def test_wrong_argument_is_refused_by_name(tmp_path, monkeypatch, refusal, arguments, named):
    monkeypatch.chdir(tmp_path)
    assert refusal("run", *arguments)["argument"] == named
    assert files_in(tmp_path) == []


@pytest.mark.parametrize("arguments", [["--size-ratio"], ["--movie=3"], ["a.toml", "b.toml"]])
def test_unparsable_line_is_refused(tmp_path, monkeypatch, capsys, arguments):
    monkeypatch.chdir(tmp_path)
    assert main(["run", *arguments]) == 2
    printed = capsys.readouterr().err
    assert printed.startswith("error: ")
    assert printed.endswith("; see pinchoff run --help\n")
    assert files_in(tmp_path) == []


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("size_ration = 5\n", "size_ration"),
        ("size_ratio = nan\n", "size_ratio"),
        ("size_ratio = 1e9\n", "size_ratio"),
        ('size_ratio = "large"\n', "size_ratio"),
        ('preset = "defualt"\n', "preset"),
        ('[physical]\ndiameter = "481 s"\n', "physical.diameter"),
        ('[physical]\ndiametre = "481 um"\n', "physical.diametre"),
        ("size_ratio = \n", None),
    ],
)
def test_wrong_file_is_refused(tmp_path, refusal, text, named):
    config = tmp_path / "config.toml"
    config.write_text(text)
    error = refusal("run", config, "--out", tmp_path / "out")
    assert error["argument"] == (named or str(config))
    assert not (tmp_path / "out").exists()


def test_wrong_file_is_refused_in_a_fresh_process(tmp_path, run):
    config = tmp_path / "config.toml"
    config.write_text('[physical]\ndiameter = "481 s"\n')
    done = run(config, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert FORM.fullmatch(done.stderr)["argument"] == "physical.diameter"
    assert done.stdout == ""


def test_preset_beside_a_file_is_refused(tmp_path, refusal):
    config = tmp_path / "config.toml"
    config.write_text("offset = 0.1\n")
    error = refusal("run", config, "--preset", "default", "--out", tmp_path / "out")
    assert error["argument"] == "--preset"


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/pinchoff/out"])
def test_folder_that_cannot_be_written_is_refused(tmp_path, refusal, place):
    (tmp_path / "file").write_text("in the way")
    assert refusal("run", "--out", tmp_path / place)["argument"] == "--out"
    assert (tmp_path / "file").read_text() == "in the way"


@pytest.mark.parametrize(
    ("options", "reason"),
    [([], "it holds this very run"), (["--offset", "0.3"], "it holds a run with other parameters")],
)
def test_results_are_not_overwritten_unasked(finished, capsys, options, reason):
    before = contents(finished)
    assert main(["run", *options, "--out", str(finished)]) == 2
    message = capsys.readouterr().err
    assert FORM.fullmatch(message)["argument"] == "--out"
    assert reason in message
    assert "--overwrite" in message
    assert contents(finished) == before


@pytest.mark.usefixtures("unrendered")
def test_overwriting_replaces_every_result_and_nothing_else(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", "--out", str(out), *COARSE]) == 0
    (out / "movie.mp4").write_bytes(b"film of the old run")
    (out / "notes.txt").write_text("mine")
    again = ["run", "--offset", "0.3", "--out", str(out), "--overwrite", *COARSE]
    assert main([*again, "--set", "time_step=0.05"]) == 2  # refused before anything is removed
    assert (out / "movie.mp4").exists()
    assert main(again) == 0
    assert files_in(out) == ["collision.json", "notes.txt", "outlines.gsd", "snapshots.png"]
    report = strict_json((out / "collision.json").read_text(encoding="utf-8"))
    assert report["parameters"]["offset"] == 0.3
    assert po.Outlines.load(out / "outlines.gsd").parameters["offset"] == 0.3
    assert "movie.mp4" not in capsys.readouterr().out.splitlines()[-1]


@pytest.mark.usefixtures("unrendered")
def test_folder_with_other_files_is_used(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert main(["run", "--out", str(tmp_path), *COARSE]) == 0
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.usefixtures("unrendered")
def test_a_droplet_that_touches_nothing_is_said_to(tmp_path, capsys):
    assert main(["run", "--offset", "1.5", "--out", str(tmp_path), *COARSE]) == 0
    assert "slipped, without a contact" in capsys.readouterr().out


@pytest.mark.usefixtures("unrendered")
def test_default_folder_is_collision(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["run", *COARSE]) == 0
    assert files_in(tmp_path) == ["collision"]
    assert files_in(tmp_path / "collision") == ["collision.json", "outlines.gsd", "snapshots.png"]


def test_stopped_run_exits_with_1_and_keeps_its_outlines(tmp_path, capsys):
    """Weak springs: the obstacle passes between two vertices, or the outline tears."""
    out = tmp_path / "out"
    weak = ["--set", "edge_stiffness=1e-4", "--set", "line_tension=2"]
    assert main(["run", *weak, "--out", str(out)]) == 1
    stopped, error = capsys.readouterr().err.splitlines()
    assert stopped == f"stopped; {out / 'outlines.gsd'} holds the run until then"
    assert FORM.fullmatch(error + "\n"), error
    assert files_in(out) == ["outlines.gsd"]
    assert len(po.Outlines.load(out / "outlines.gsd")) > 10


def started_slow_run(program, out):
    """Start a run that takes long, and wait until it has written some frames."""
    process = subprocess.Popen(
        [*program, "run", "--set", "vertex_count=1024", "--frames-every", "0.01", "--out", out],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and process.poll() is None:
        if Path(out, "outlines.gsd").exists() and frames_in(out) > 5:
            return process
        time.sleep(0.02)
    process.kill()
    _, errors = process.communicate()
    raise AssertionError(f"it ended or wrote nothing: {errors}")


def frames_in(out):
    try:
        return len(po.Outlines.load(Path(out, "outlines.gsd")))
    except po.InputError:  # it has no frame yet
        return 0


def test_killed_run_leaves_readable_outlines(program, tmp_path, capsys):
    out = tmp_path / "out"
    process = started_slow_run(program, out)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    outlines = po.Outlines.load(out / "outlines.gsd")
    assert len(outlines) > 5
    assert outlines.parameters["vertex_count"] == 1024
    assert outlines.measure()["area"].between(0.78, 0.79).all()
    assert files_in(out) == ["outlines.gsd"]
    assert main(["run", "--out", str(out)]) == 2
    assert "it holds an unfinished run" in capsys.readouterr().err


def test_interrupted_run_says_so(program, tmp_path):
    out = tmp_path / "out"
    process = started_slow_run(program, out)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 1
    assert errors.splitlines() == [
        f"stopped; {out / 'outlines.gsd'} holds the run until then",
        "error: interrupted",
    ]
    assert len(po.Outlines.load(out / "outlines.gsd")) > 5


def test_movie_without_pyav_is_refused_before_the_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "av", None)
    assert main(["run", "--movie", "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert FORM.fullmatch(message)
    assert "pip install 'pinchoff[video]'" in message
    assert not (tmp_path / "out").exists()


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"pinchoff {po.__version__}\n"


def test_unknown_command_is_refused(capsys):
    assert main(["rnu"]) == 2
    assert capsys.readouterr().err.endswith("; got rnu; did you mean run?\n")


def test_what_stands_behind_the_configuration_is_refused(capsys):
    assert main(["run", "a.toml", "b", "c"]) == 2
    assert capsys.readouterr().err == (
        "error: arguments must be those of pinchoff run; got b c besides; see pinchoff run --help\n"
    )


def test_console_without_greek_letters(tmp_path, run):
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = run("--out", tmp_path / "out", *COARSE, env=ascii_only)
    assert done.returncode == 0, done.stderr
    assert "v_f?" in done.stdout


def test_what_nobody_foresaw_ends_in_one_line(monkeypatch, tmp_path, capsys):
    def broken(*_, **__):
        raise ZeroDivisionError("of what?\nsecond line")

    monkeypatch.setattr("pinchoff.model.simulation._core.System", broken)
    arguments = ["run", "--out", str(tmp_path / "out")]
    assert main(arguments) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: this failed in a way that nobody foresaw (ZeroDivisionError: of")
    assert said.count("\n") == 1
    assert "--debug" in said
    with pytest.raises(ZeroDivisionError):
        main(["--debug", "run", "--out", str(tmp_path / "again")])


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (OSError(errno.ENOSPC, "No space left", "x.gsd"), 1, "x.gsd must be on a disk with room"),
        (OSError(errno.EFBIG, "File too large"), 1, "make room and give the same command again"),
        (OSError(errno.ENAMETOOLONG, "File name too long"), 2, "'File name too long'; choose a"),
        (OSError(errno.EROFS, "Read-only file system", "a"), 2, "a must be one that you may write"),
        (OSError(errno.EIO, "Input/output error", "a"), 1, "see whether its disk is in order"),
        (RuntimeError("can't start new thread"), 1, "(ulimit -u), or run fewer threads"),
    ],
)
def test_what_the_system_refuses_comes_with_advice(
    monkeypatch, tmp_path, capsys, error, code, said
):
    def refusing(*_, **__):
        raise error

    monkeypatch.setattr("pinchoff.model.simulation._core.System", refusing)
    assert main(["run", "--out", str(tmp_path / "out")]) == code
    message = capsys.readouterr().err
    assert said in message
    assert FORM.search(message)


def test_no_memory_is_said(monkeypatch, tmp_path, capsys):
    def refusing(*_, **__):
        raise MemoryError

    monkeypatch.setattr("pinchoff.model.simulation._core.System", refusing)
    assert main(["run", "--out", str(tmp_path / "out")]) == 1
    assert "no memory is left" in capsys.readouterr().err
