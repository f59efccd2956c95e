"""The direction of imports: between the rooms strictly downwards, between files no circle.

Besides, no file sees two others of one name, and the library does not speak of the command line.

Every import counts, those for type checkers and those inside functions too: they say which file
knows of which.
"""

from __future__ import annotations

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOMS = (
    "support",
    "collisions",
    "model",
    "fits",
    "studies",
    "video",
    "chamber",
    "explorer",
    "figures",
    "explorer",
    "paper",
    "cli",
)
"""From the bottom: a file imports from its own room and from those before it."""

PACKAGE = Path(__file__).parents[1] / "src" / "pinchoff"
ROOT = "pinchoff"
FROM_ROOT = {"_core", "__version__"}
"""What a file may take from the root, which is above all rooms and loads lazily."""


def module_of(path):
    parts = [ROOT, *path.relative_to(PACKAGE).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in PACKAGE.rglob("*.py")}


def imports(source, module, package):
    """Yield (module, name) of every import of the package's own files; name is "" for a module."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name.startswith(ROOT))
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*(above if node.level else ()), *filter(None, [node.module])])
            if base.split(".")[0] != ROOT:
                continue
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield (inner, "") if inner in MODULES else (base, alias.name)


def all_imports():
    for module, path in MODULES.items():
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        for target, name in imports(path.read_text(encoding="utf-8"), module, package):
            yield module, target, name


def room_of(module):
    return (*module.split("."), "")[1]


def wrong_way(found):
    """Return the imports that do not go downwards."""
    wrong = []
    for module, target, name in found:
        if module == ROOT:  # above all rooms
            continue
        below = room_of(target)
        if target == ROOT:
            allowed = name in FROM_ROOT
        else:
            allowed = ROOMS.index(below) <= ROOMS.index(room_of(module))
        if not allowed:
            wrong.append(f"{module} imports {target} {name}".strip())
    return wrong


def circle(found):
    """Return a circle of files that import each other, or None."""
    graph = {}
    for module, target, _ in found:
        if target not in (ROOT, module):
            graph.setdefault(module, set()).add(target)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return None


def test_every_file_is_in_a_room():
    rooms = {room_of(module) for module in MODULES} - {""}
    assert rooms == {*ROOMS}


def test_rooms_import_only_from_below():
    assert wrong_way(all_imports()) == []


def test_no_files_import_each_other_in_a_circle():
    assert circle(all_imports()) is None


@pytest.mark.parametrize(
    ("source", "module", "upwards"),
    [
        ("from pinchoff.cli import main", "pinchoff.model.flow", True),
        ("from pinchoff.figures import style", "pinchoff.video.overlay", True),
        ("def f():\n    import pinchoff.paper.make", "pinchoff.figures.html_page", True),
        ("from ..figures.style import save", "pinchoff.video.overlay", True),
        ("from pinchoff import simulate", "pinchoff.video.overlay", True),
        ("from pinchoff import _core", "pinchoff.video.overlay", False),
        ("from pinchoff.support import palette", "pinchoff.video.overlay", False),
    ],
)
def test_an_arrow_upwards_is_seen(source, module, upwards):
    found = [(module, *pair) for pair in imports(source, module, module.rpartition(".")[0])]
    assert bool(wrong_way(found)) == upwards


def test_a_circle_is_seen():
    pairs = [("pinchoff.a", "pinchoff.b", ""), ("pinchoff.b", "pinchoff.a", "")]
    assert circle(pairs)
    assert circle(pairs[:1]) is None


def test_no_file_sees_two_of_one_name():
    seen = {}
    for module, target, _ in all_imports():
        if not MODULES.get(target, PACKAGE / "__init__.py").name.startswith("__init__"):
            seen.setdefault(module, set()).add(target)
    for module, targets in seen.items():
        names = [target.rpartition(".")[2] for target in {*targets, module} if "." in target]
        # A command is called as users call it, whatever the file below it is called.
        own = module.rpartition(".")[2] if room_of(module) == "cli" else None
        assert len({*names}) == len(names) - (names.count(own) > 1), (module, sorted(targets))


def test_the_library_does_not_speak_of_options():
    option = re.compile(r"(?<![-\w])--[a-z]{2,}")
    for module, path in MODULES.items():
        if room_of(module) not in ("cli", ""):
            found = option.findall(path.read_text(encoding="utf-8"))
            assert not found, f"{module} says {found}"
