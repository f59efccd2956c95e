"""ARCHITECTURE.md names files that exist, and each file says in its first line what is in it."""

import ast
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
    assert len(named) > 80
    assert named - present - made == set()


def test_every_file_says_in_its_first_line_what_is_in_it():
    first = {}
    for path in (ROOT / "src" / "pinchoff").rglob("*.py"):
        docstring = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        first[path] = docstring.partition("\n")[0]
    assert [path for path, line in first.items() if not line.endswith((".", "]"))] == []
    assert len(set(first.values())) == len(first)
    for path in (ROOT / "include" / "pinchoff").glob("*.hpp"):
        assert path.read_text(encoding="utf-8").startswith("// "), path
