"""The examples of the site's tutorials and how-to pages run, one after the other, as they stand.

A page's blocks share a folder with the clone's headers. ``sh`` is run by a shell, and our own
commands without a process of their own. ``python`` is run in one session. A block that begins with
the name of a file is written to it. ``text`` is what the block above it prints, its last expression
included, with ... for what differs from run to run. ``console`` shows what to type elsewhere and is
not run.
"""

import ast
import contextlib
import doctest
import importlib
import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pinchoff.cli import main

EXAMPLES = importlib.import_module("pinchoff.cli.examples")  # the command has the same name
ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    path.relative_to(DOCS).as_posix()
    for folder in ("tutorials", "how-to", "theory")
    for path in (DOCS / folder).glob("*.md")
)
SLOW = ("how-to/calibrate.md", "how-to/reproduce.md", "tutorials/film-to-law.md")
NEEDS = {
    "how-to/arrays.md": "skfem",
    "how-to/cluster.md": "distributed",
    "how-to/export.md": "roifile",
    "tutorials/film-to-law.md": "cv2",
    "tutorials/porous-medium.md": "skfem",
}

_PRINTS = doctest.OutputChecker()
_LOOSELY = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
_BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", flags=re.M | re.S)
_FILE = re.compile(r"(?:#|//) ([\w.-]+\.\w+)\n")


# trackpy, which a page shows, still uses what pandas is about to take away.
@pytest.mark.filterwarnings("ignore:The inplace keyword in DataFrame.set_index")
@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize(
    "page", [pytest.param(p, marks=pytest.mark.slow if p in SLOW else ()) for p in PAGES]
)
def test_examples_run(page, tmp_path, monkeypatch):
    pytest.importorskip(NEEDS.get(page, "pinchoff"), reason="its extra is not installed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(EXAMPLES, "_DROPLETS", ((60, 4.4, 0.02), (80, 5.2, 0.1)))  # a short clip
    (tmp_path / "include").symlink_to(ROOT / "include")
    session: dict[str, object] = {}
    printed = io.StringIO()
    for language, text in _BLOCK.findall((DOCS / page).read_text(encoding="utf-8")):
        if named := _FILE.match(text):
            (tmp_path / named[1]).write_text(text, encoding="utf-8")
        elif language == "text":
            assert _PRINTS.check_output(text, printed.getvalue(), _LOOSELY), printed.getvalue()
        elif language in ("sh", "python"):
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                run_block(language, text, session)


def run_block(language, text, session):
    if language == "sh":
        for line in text.replace("\\\n", " ").splitlines():
            run(line)
        return
    tree = ast.parse(text)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "page", "exec"), session)
    if last is not None:
        value = eval(compile(ast.Expression(last.value), "page", "eval"), session)
        if value is not None:
            print(repr(value))


def run(line):
    """Run a line of a shell, with the commands of this environment."""
    words = shlex.split(line, comments=True)
    if words[:1] == ["pinchoff"]:
        assert main(words[1:]) == 0, line
        return
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-eu", "-c", line],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PATH": path},
    )
    assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
    print(done.stdout)


def test_every_tutorial_and_how_to_has_examples():
    for page in PAGES:
        if not page.startswith("theory/"):
            languages = {language for language, _ in _BLOCK.findall((DOCS / page).read_text())}
            assert languages & {"sh", "python"}, page
