"""Commands that are killed at random moments, and given again.

``--attacks N`` sets how many kills. One in three is SIGTERM, which leaves nothing half written by
itself; the others are SIGKILL, after which the next run removes what is left.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals"),
    pytest.mark.filterwarnings("ignore"),
]

NAMES = (
    *("run", "sweep", "boundary", "calibrate", "emulsion", "video", "compare", "export", "fit"),
    *("examples", "chamber", "reproduce", "film", "virtual", "summary"),
)
ONE_FILE = ("film", "virtual", "summary")
TIMED = ("seconds", "fingerprint")
"""Entries of JSON that differ from run to run."""


def contents(folder: Path) -> dict[str, object]:
    """Return what a folder holds: the bytes of data, JSON without its times, names of the rest."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_dir():
            found[name] = "folder"
        elif path.suffix == ".json":
            found[name] = timeless(json.loads(path.read_text()))
        elif path.suffix in (".html", ".png", ".pdf", ".svg", ".mp4", ".zip", ".dxf"):  # dated
            assert path.stat().st_size > 0
            found[name] = "there"
        else:
            found[name] = path.read_bytes()
    return found


def timeless(value: object) -> object:
    if isinstance(value, dict):
        return {k: timeless(v) for k, v in value.items() if k not in TIMED}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def finished(begin: Callable[..., int], arguments: list[str]) -> tuple[int, str]:
    with tempfile.TemporaryFile() as said:
        _, status = os.waitpid(begin(arguments, said.fileno()), 0)
        said.seek(0)
        return os.waitstatus_to_exitcode(status), said.read().decode()


def children_of(pid: int) -> list[int]:
    try:
        return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def alive(pid: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False


def killed(
    begin: Callable[..., int], arguments: list[str], after_s: float, number: int
) -> tuple[int, str]:
    """Send a command a signal; return the code it ends with, and what it said."""
    with tempfile.TemporaryFile() as said:
        process = begin(arguments, said.fileno())
        time.sleep(after_s)
        workers = children_of(process)
        os.kill(process, number)
        _, status = os.waitpid(process, 0)
        deadline = time.monotonic() + 60
        while any(map(alive, workers)):
            assert time.monotonic() < deadline, "workers that outlive their parent"
            time.sleep(0.05)
        said.seek(0)
        return os.waitstatus_to_exitcode(status), said.read().decode()


@pytest.mark.parametrize("name", NAMES)
def test_killed_commands_end_as_others_do(begin, writing, attacks, tmp_path, name):
    draw = random.Random(name)
    whole, out = tmp_path / "whole", tmp_path / "out"
    for folder in (whole, out):
        if name in ONE_FILE:
            folder.mkdir()
    began = time.monotonic()
    code, said = finished(begin, writing(name, whole))
    assert code == 0, said
    length = time.monotonic() - began
    wanted = contents(whole)
    for _ in range(max(1, -(-attacks // len(NAMES)))):
        number = draw.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM])
        code, said = killed(begin, writing(name, out), draw.random() * length, number)
        # 0, 2: it was faster, or the results of an earlier, whole run were there.
        assert code in (0, 2, -number, 128 + number), said
        if number == signal.SIGTERM and out.exists():
            assert [p for p in out.rglob("*") if p.name.startswith(".pinchoff")] == []
        print(f"{name}: {number.name}, ended with {code}")
        code, said = finished(begin, writing(name, out))
        if code == 2:
            assert "add --overwrite" in said
            code, said = finished(begin, [*writing(name, out), "--overwrite"])
        assert code == 0, said
        found = contents(out)
        different = sorted(k for k in {*found, *wanted} if found.get(k) != wanted.get(k))
        if different:
            kept = Path(tempfile.mkdtemp(prefix="pinchoff-killed-"))
            shutil.copytree(tmp_path, kept, dirs_exist_ok=True)
            pytest.fail(f"{different} differ from those of a run that was not killed; see {kept}")
        if draw.random() < 0.8:  # else the next one finds whole results
            shutil.rmtree(out)
            if name in ONE_FILE:
                out.mkdir()
