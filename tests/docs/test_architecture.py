"""ARCHITECTURE.md names files that exist."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_every_file_that_is_named_exists():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`(?:[\w./-]+/)?(\w+\.(?:py|pyi|hpp|cpp|js|css|html|toml|md))`", text))
    made = {"page.html"}  # when the explorer is built
    rooms = ("include", "src", "tests", "docs")
    present = {path.name for room in rooms for path in (ROOT / room).rglob("*.*")}
    present |= {path.name for path in ROOT.iterdir()}
    assert len(named) > 100
    assert named - present - made == set()
