"""A force is added by the diffs of docs/how-to/new-force.md, and what comes of it is used."""

import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "new-force.md"
SOURCES = ("CMakeLists.txt", "README.md", "LICENSE", "pyproject.toml", "include", "src", "tests")

USE = """
import numpy as np
import pinchoff as po
from pinchoff import _core
from pinchoff.cli import main

assert "tilt_x : float" in po.Parameters.__doc__
assert po.Parameters.model_json_schema()["properties"]["tilt_x"]["unit"] == "v_f∞²/D0"
assert po.Parameters(tilt_x=2.5).model_row()[_core.MODEL_FIELDS.index("tilt_x")] == 2.5
try:
    po.Parameters(tilt_x=1e9)
except po.InputError as error:
    assert "tilted chamber" in str(error) and "-1000 to 1000" in str(error)
else:
    raise AssertionError("not refused")

angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
circle = np.column_stack([np.cos(angle) - 4, np.sin(angle)]) / 2
energy = po.total_energy(po.Parameters(tilt_x=2.5), circle)
assert abs(energy["tilt"] - 5.0) < 1e-12, energy

vary = {"tilt_x": [0.0, 300.0], "tilt_y": {"min": -10, "max": 10, "count": 2}}
po.sweep({"vertex_count": 32, "follow_daughters": False, "vary": vary}, "sweep")
table = po.read_collisions("sweep")
assert table["tilt_x"].tolist() == [0, 0, 300, 300]
assert table.attrs["units"]["tilt_y"] == "v_f∞²/D0"
assert (table["contact_time"][2:].to_numpy() < table["contact_time"][:2].to_numpy()).all()
assert main(["run", "--set", "tilt_x=300", "--out", "run"]) == 0
"""


def diffs() -> str:
    return "".join(re.findall(r"^```diff\n(.*?)^```$", PAGE.read_text("utf-8"), flags=re.M | re.S))


@pytest.fixture
def tree(tmp_path):
    """The sources with the page's diffs applied."""
    if shutil.which("git") is None:
        pytest.skip("git applies the diffs, and it is not here")
    folder = tmp_path / "tree"
    folder.mkdir()
    for name in SOURCES:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, folder / name)
    run(["git", "init", "--quiet"], folder)  # or git would take the paths from a folder above
    done = subprocess.run(
        ["git", "apply", "-"],
        cwd=folder,
        input=diffs(),
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, f"bring the page's diffs up to date:\n{done.stderr}"
    return folder


def run(command, folder):
    done = subprocess.run(
        list(map(str, command)), cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"


def test_diffs_apply_to_five_files_at_most(tree):
    changed = re.findall(r"^\+\+\+ b/(\S+)", diffs(), flags=re.M)
    assert len({*changed, "CHANGELOG.md"}) <= 5


@pytest.mark.slow
def test_force_added_by_the_page_is_found_everywhere(tree, tmp_path):
    """It is built, its tests pass, and parameter, row, energy, sweep, table and command know it."""
    venv.create(tmp_path / "venv")
    programs = tmp_path / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
    site = next((tmp_path / "venv").rglob("site-packages"))
    # What the tests need comes from this environment, the package from the new one.
    (site / "outer.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    install = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
    ]
    run([*install, "--target", site, tree], tmp_path)
    python = programs / "python"
    run([python, "-m", "pytest", "-q", "tests/model/physics/test_forces.py"], tree)
    (tmp_path / "use.py").write_text(USE, encoding="utf-8")
    run([python, "use.py"], tmp_path)
