"""Every command that writes, where it must not or cannot: refused in our form, nothing left."""

from __future__ import annotations

import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import pinchoff as po
from pinchoff.cli import app, main
from pinchoff.support.locks import held_file, held_folder

pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.slow]

FORM = re.compile(r"error: .+ must be .+; got .*; .+", re.S)
PROGRAM = [sys.executable, "-c", "import sys; from pinchoff.cli import main; sys.exit(main())"]
FOLDERS = (
    *("run", "sweep", "boundary", "calibrate", "emulsion", "video", "compare", "export", "fit"),
    *("examples", "chamber", "reproduce"),
)
FILES = ("film", "virtual", "summary", "explore")

HOLDS = """
import sys
from pathlib import Path
from pinchoff.support.locks import held_file, held_folder
held = {"folder": held_folder, "file": held_file}[sys.argv[1]]
with held(Path(sys.argv[2])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_these_are_all_commands():
    names = {command.callback.__name__ for command in app.registered_commands}
    assert names == {*FOLDERS, *FILES}


@pytest.mark.parametrize("name", [*FOLDERS, "film"])
def test_a_place_that_another_process_writes_to_is_refused(writing, tmp_path, capsys, name):
    kind, place = ("file", tmp_path / "film.mp4") if name == "film" else ("folder", tmp_path / "o")
    arguments = writing(name, tmp_path if name == "film" else place)
    other = subprocess.Popen(
        [sys.executable, "-c", HOLDS, kind, str(place)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert other.stdout.readline() == "held\n"
        before = sorted(tmp_path.rglob("*"))
        assert main(arguments) == 2
        assert sorted(tmp_path.rglob("*")) == before
    finally:
        other.kill()
        other.communicate()
    said = capsys.readouterr().err
    assert FORM.search(said)
    assert f"{place}, in use" in said


WRONG = {
    "run": ["--set", "start_distance=0.01"],
    "boundary": ["--width", "-1"],
    "calibrate": ["--points", "1"],
    "fit": ["--samples", "0"],
    "reproduce": ["--only", "99"],
    "compare": ["--collision", "99"],
}


@pytest.mark.parametrize("name", WRONG)
def test_a_refused_command_leaves_no_folder(writing, tmp_path, capsys, name):
    assert main([*writing(name, tmp_path / "a" / "b"), *WRONG[name]]) == 2
    assert FORM.search(capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", FOLDERS)
def test_a_command_whose_library_fails_leaves_no_folder(
    writing, tmp_path, capsys, monkeypatch, name
):
    class UnforeseenError(Exception):
        pass

    def fail(*_, **__):
        raise UnforeseenError

    places = {
        "run": "pinchoff.model.gsd.OutlineWriter.__init__",
        "sweep": "pinchoff.studies.sweep.execution.opened",
        "boundary": "pinchoff.studies.boundary.search.boundary",
        "calibrate": "pinchoff.studies.calibration.fitting._base",
        "emulsion": "pinchoff.chamber.emulsion_design.EmulsionDesign.flow",
        "video": "pinchoff.video.batch.all_done",
        "compare": "pinchoff.video.comparison.compare_collision",
        "export": "pinchoff.video.export.export_clip",
        "fit": "pinchoff.fits.law_study.study_law",
        "examples": "pinchoff.cli.examples.write_examples",
        "chamber": "pinchoff.cli.chamber._write",
        "reproduce": "pinchoff.paper.reproduce",
    }
    arguments = writing(name, tmp_path / "a" / "b")
    module, _, attribute = places[name].rpartition(".")
    if module in sys.modules:  # where the package has the command by the name of its module
        monkeypatch.setattr(sys.modules[module], attribute, fail)
    else:
        monkeypatch.setattr(places[name], fail)
    assert main(arguments) == 1
    assert "nobody foresaw (UnforeseenError)" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no files")
@pytest.mark.parametrize("name", [*FOLDERS, *FILES])
def test_a_full_disk_is_said_in_our_form_and_leaves_nothing(writing, tmp_path, capsys, name):
    """No file may grow: what writes meet on a full disk, save for the number of the error."""
    if name == "explore" and not (Path(po.__file__).parent / "explorer" / "page.html").exists():
        pytest.skip("the explorer's page is not built")
    out = tmp_path if name in FILES else tmp_path / "out"
    arguments = writing(name, out)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
    try:
        code = main(arguments)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    said = capsys.readouterr().err
    assert code in (1, 2), said
    assert FORM.search(said), said
    assert "make room" in said, said
    assert [path for path in tmp_path.rglob("*") if path.name.startswith(".")] == []
    assert [
        path for path in tmp_path.rglob("*") if path.is_file() and not path.stat().st_size
    ] == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals")
@pytest.mark.parametrize("name", ["run", "sweep", "boundary", "video", "emulsion"])
def test_sigterm_ends_as_ctrl_c_does(writing, tmp_path, name):
    process = subprocess.Popen(
        [*PROGRAM, *writing(name, tmp_path / "out")], stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "out").exists():
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    assert said.endswith("error: stopped by SIGTERM\n")
    assert "Traceback" not in said
    assert [path for path in tmp_path.rglob("*") if path.name.startswith(".pinchoff")] == []
    held = held_file if name in FILES else held_folder
    with held(tmp_path / "out"):
        pass
