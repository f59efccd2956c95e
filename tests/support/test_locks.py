"""One writer for each folder, and none left empty."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

import pinchoff as po
from pinchoff.support.locks import held_file, held_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows locks no folders")

HOLDS = """
import sys
from pathlib import Path
from pinchoff.support.locks import held_file, held_folder
held = {"folder": held_folder, "file": held_file}[sys.argv[1]]
with held(Path(sys.argv[2])):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def other():
    """Start other processes that hold something, and end them."""
    started = []

    def hold(kind, path):
        process = subprocess.Popen(
            [sys.executable, "-c", HOLDS, kind, str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        assert process.stdout.readline() == "held\n"
        return process

    yield hold
    for process in started:
        process.kill()
        process.communicate()


def take(held, path):
    with held(path):
        pass


@pytest.mark.parametrize(("kind", "held"), [("folder", held_folder), ("file", held_file)])
def test_a_second_process_is_refused_until_the_first_ends(tmp_path, refused, other, kind, held):
    path = tmp_path / "out"
    process = other(kind, path)
    assert f"{path}, in use" in refused("out", take, held, path).got
    process.communicate("")
    take(held, path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("kind", "held"), [("folder", held_folder), ("file", held_file)])
def test_a_killed_process_lets_go(tmp_path, other, kind, held):
    process = other(kind, tmp_path / "out")
    process.kill()
    process.communicate()
    take(held, tmp_path / "out")
    if kind == "file":
        assert list(tmp_path.iterdir()) == []


def test_what_a_holder_calls_may_hold_it_too_but_no_other_thread(tmp_path, refused):
    with held_folder(tmp_path), held_folder(tmp_path), ThreadPoolExecutor(1) as thread:
        thread.submit(refused, "out", take, held_folder, tmp_path).result()
    take(held_folder, tmp_path)


def test_many_threads_want_one_new_folder(tmp_path):
    """Each makes, locks and removes it; one that is removed under another is made anew."""
    path = tmp_path / "out"

    def attempt(_):
        try:
            with held_folder(path):
                (path / "file").write_text("1")
                (path / "file").unlink()
        except po.InputError as error:
            return error.got
        return ""

    with ThreadPoolExecutor(8) as threads:
        ends = set(threads.map(attempt, range(400)))
    assert "" in ends
    assert ends <= {"", f"{path}, in use"}
    # One that was made by a loser and locked by another first may stay, but empty.
    assert list(path.glob("*")) == []


def test_only_what_was_made_and_is_empty_is_removed(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(ZeroDivisionError), held_folder(tmp_path / "there" / "new" / "inner"):
        _ = 1 / 0
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]
    with held_folder(tmp_path / "kept"):
        (tmp_path / "kept" / "file").write_text("1")
    assert (tmp_path / "kept" / "file").exists()


def test_a_file_in_the_way_is_refused(tmp_path, refused):
    (tmp_path / "file").write_text("1")
    assert "File exists" in refused("out", take, held_folder, tmp_path / "file").got
    assert "Not a directory" in refused("out", take, held_folder, tmp_path / "file" / "in").got
    assert "too long" in refused("out", take, held_folder, tmp_path / ("x" * 300)).got
