"""What users install: built, looked into, and used in an environment of its own."""

import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LARGEST_SDIST = 5_000_000  # bytes

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def dist(tmp_path_factory):
    """A folder with the sdist and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    run([sys.executable, "-m", "build", "--outdir", folder, ROOT], folder)
    return folder


@pytest.fixture(scope="module")
def wheel(dist):
    (path,) = dist.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def bare(wheel, tmp_path_factory):
    """The programs of an environment that holds the wheel and what it asks for, nothing else."""
    folder = tmp_path_factory.mktemp("bare")
    venv.create(folder, with_pip=True)
    programs = folder / ("Scripts" if sys.platform == "win32" else "bin")
    run([programs / "python", "-m", "pip", "install", "--quiet", wheel], folder)
    return programs


def run(command, folder):
    """Run a command in a folder and return what it printed."""
    done = subprocess.run(
        list(map(str, command)), cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def test_descriptions_are_fit_for_the_package_index(dist):
    run([sys.executable, "-m", "twine", "check", "--strict", *dist.iterdir()], dist)


def test_wheel_holds_every_file_of_the_package(wheel):
    source = ROOT / "src"
    ours = {
        path.relative_to(source).as_posix()
        for path in (source / "pinchoff").rglob("*")
        if path.is_file() and path.suffix not in (".pyc", ".so")
    }
    held = set(zipfile.ZipFile(wheel).namelist())
    # An empty search would hold in everything.
    assert {"pinchoff/model/presets.toml", "pinchoff/py.typed"} <= ours
    assert ours <= held
    assert "pinchoff/_core.pyi" in held
    assert any(name.endswith("/licenses/LICENSE") for name in held)
    assert {name.split("/")[0].partition("-")[0] for name in held} == {"pinchoff"}


def test_sdist_holds_what_a_build_and_the_tests_need(dist):
    (path,) = dist.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    needed = ("pyproject.toml", "CMakeLists.txt", "LICENSE", "include/pinchoff/forces.hpp")
    assert {*needed, "src/core/kernels.cpp", "tests/conftest.py"} <= held
    assert not [name for name in held if name.startswith((".venv", "build", "demo", "dist"))]
    assert path.stat().st_size < LARGEST_SDIST


def test_installed_package_works_far_from_its_source(bare, tmp_path):
    place = run([bare / "python", "-c", "import pinchoff; print(pinchoff.__file__)"], tmp_path)
    assert Path(place.strip()).is_relative_to(bare.parent)
    run([bare / "pinchoff", "run", "--out", "one"], tmp_path)
    run([bare / "pinchoff", "virtual", "--rows", "500", "--out", "virtual.parquet"], tmp_path)
    run([bare / "pinchoff", "fit", "virtual.parquet", "--out", "law"], tmp_path)
    assert (tmp_path / "one" / "snapshots.png").stat().st_size > 10_000
    assert "<html" in (tmp_path / "law" / "report.html").read_text(encoding="utf-8")


def test_what_needs_an_extra_says_which(bare, tmp_path):
    """Without the extra a film is refused with what to install, and nothing else breaks."""
    done = subprocess.run(
        [bare / "pinchoff", "run", "--out", "film", "--movie"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (1, 2)
    assert "pinchoff[video]" in done.stderr
    assert "Traceback" not in done.stderr
