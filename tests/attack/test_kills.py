"""Commands that are killed at random moments, and given again.

``--attacks N`` sets how many kills. One in three is SIGTERM, which leaves nothing half written by
itself; the others are SIGKILL, after which the next run removes what is left.
"""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no signals"),
]

PROGRAM = [sys.executable, "-c", "import sys; from pinchoff.cli import main; sys.exit(main())"]
NAMES = (
    *("run", "sweep", "boundary", "calibrate", "emulsion", "video", "compare", "export", "fit"),
    *("examples", "chamber", "reproduce", "film", "virtual"),
)
ONE_FILE = ("film", "virtual")
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
        elif path.suffix in (".html", ".png", ".pdf", ".svg", ".mp4", ".zip"):
            assert path.stat().st_size > 0
            found[name] = "there"
        else:
            found[name] = path.read_bytes()
    return found


def timeless(value: object) -> object:
    if isinstance(value, dict):
        return {k: timeless(v) for k, v in value.items() if k not in TIMED}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def finished(arguments: list[str]) -> tuple[int, str]:
    done = subprocess.run(
        [*PROGRAM, *arguments], capture_output=True, text=True, check=False, timeout=300
    )
    return done.returncode, done.stderr


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


@pytest.mark.parametrize("name", NAMES)
def test_killed_commands_end_as_others_do(writing, attacks, tmp_path, name):
    draw = random.Random(name)
    whole, out = tmp_path / "whole", tmp_path / "out"
    for folder in (whole, out):
        if name in ONE_FILE:
            folder.mkdir()
    began = time.monotonic()
    assert finished(writing(name, whole))[0] == 0
    length = time.monotonic() - began
    wanted = contents(whole)
    for _ in range(max(1, round(attacks / len(NAMES)))):
        number = draw.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM])
        process = subprocess.Popen(
            [*PROGRAM, *writing(name, out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(draw.uniform(0.3, 1.0) * length)
        workers = children_of(process.pid)
        process.send_signal(number)
        code = process.wait(timeout=60)
        # 2: the results of an earlier, whole run were there.
        assert code in (0, 2, -number, 128 + number), code
        deadline = time.monotonic() + 20
        while any(map(alive, workers)):
            assert time.monotonic() < deadline, "workers that outlive their parent"
            time.sleep(0.05)
        if number == signal.SIGTERM and out.exists():
            assert [p for p in out.rglob("*") if p.name.startswith(".pinchoff")] == []
        code, said = finished(writing(name, out))
        if code == 2:
            assert "add --overwrite" in said
            code, said = finished([*writing(name, out), "--overwrite"])
        assert code == 0, said
        assert contents(out) == wanted
