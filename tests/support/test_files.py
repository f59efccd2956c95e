"""The atomic writer: whole files or none, names that cannot be foreseen, nothing left over."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pinchoff.support import files
from pinchoff.support.files import read_toml, remove_unfinished, written_aside

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows locks no files this way")

WRITES = """
import sys
from pathlib import Path
from pinchoff.support.files import written_aside
with written_aside(Path(sys.argv[1])) as unfinished:
    unfinished.write_text("half")
    print(unfinished, flush=True)
    sys.stdin.read()
    unfinished.write_text("whole")
"""


def writer(path):
    """Start a process that is in the middle of a file; return it and its hidden file."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITES, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    return process, Path(process.stdout.readline().strip())


def test_the_file_appears_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), written_aside(path) as unfinished:
        unfinished.write_text("new")
        assert path.read_text() == "old"
        _ = 1 / 0
    assert path.read_text() == "old"
    with written_aside(path) as unfinished:
        unfinished.write_text("new")
    assert path.read_text() == "new"
    assert [each.name for each in tmp_path.iterdir()] == ["a.txt"]


def test_it_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    path, synced = tmp_path / "a.txt", []
    sync = os.fsync

    def fsync(descriptor):
        sync(descriptor)
        synced.append((os.fstat(descriptor).st_ino, path.exists()))

    monkeypatch.setattr(os, "fsync", fsync)
    with written_aside(path) as unfinished:
        unfinished.write_text("new")
    assert synced == [(path.stat().st_ino, False)]


@pytest.mark.skipif(sys.platform == "win32", reason="files are not locked there")
def test_an_interruption_as_a_file_is_made_leaves_none(tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(files.fcntl, "flock", interrupt)
    with pytest.raises(KeyboardInterrupt), written_aside(tmp_path / "a.txt"):
        pass
    with pytest.raises(KeyboardInterrupt):
        files.require_writable(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_names_differ_and_keep_their_suffix_and_their_length(tmp_path):
    path = tmp_path / f"{'x' * 250}.png"
    with written_aside(path) as one, written_aside(path) as other:
        assert one != other
        assert {one.suffix, other.suffix} == {".png"}
    assert path.exists()


def test_what_stands_in_the_way_is_neither_followed_nor_replaced(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    names = iter(["foreseen", "free"])
    monkeypatch.setattr(files.secrets, "token_hex", lambda: next(names))
    trap = tmp_path / files.hidden_name("foreseen", ".txt")
    trap.symlink_to(victim)
    with pytest.raises(FileExistsError), written_aside(tmp_path / "a.txt"):
        pass
    assert victim.read_text() == "mine"
    assert trap.is_symlink()


def test_of_a_dead_process_nothing_stays_and_of_a_living_one_everything(tmp_path):
    dead, half = writer(tmp_path / "dead.txt")
    living, other = writer(tmp_path / "living.txt")
    dead.kill()
    dead.communicate()
    assert half.read_text() == "half"
    mine = tmp_path / ".pinchoff-notes"
    mine.write_text("a user's")
    with written_aside(tmp_path / "a.txt") as unfinished:
        unfinished.write_text("a")
    assert not half.exists()
    assert other.exists()
    assert mine.exists()
    living.communicate("")
    assert (tmp_path / "living.txt").read_text() == "whole"
    assert not other.exists()


def test_a_folder_that_is_not_there_has_nothing_to_remove(tmp_path):
    remove_unfinished(tmp_path / "no")


def test_a_refusal_names_the_file_that_was_meant(tmp_path):
    with pytest.raises(OSError, match="No space") as caught, written_aside(tmp_path / "a.txt"):
        raise OSError(28, "No space left on device")
    assert caught.value.filename == str(tmp_path / "a.txt")


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no endless file")
def test_a_file_without_an_end_is_refused(refused):
    refused("/dev/zero", read_toml, Path("/dev/zero"))
