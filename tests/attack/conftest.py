"""Every command that writes, small, with what it needs to read."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pinchoff.cli import main

PROGRAM = [sys.executable, "-c", "import sys; from pinchoff.cli import main; sys.exit(main())"]

SWEEP = """\
design = "sobol"
samples = 96
start_distance = 1.5
time_limit = 6
vertex_count = 32
neck_separation_unit = "perimeter"
follow_daughters = true

[vary]
offset = { min = 0.0, max = 0.3 }
"""
EMULSION = """\
time = 10
interval = 0.5
seed = 1

[parameters]
simulation_capillary_number = 60
vertex_count = 24

[array]
kind = "square"
rows = 2
columns = 2
radius = 0.3
gap = 1.0
before = 2
behind = 2

[flow]
thickness = 0.5

[inlet]
area_fraction = 0.2
diameters = [1.0]
"""
_LABORATORY = (
    *("--pixel-size", "5.28um", "--obstacle-radius", "85um", "--thickness", "85um"),
    *("--viscosity", "48mPa.s", "--surface-tension", "20mN/m"),
)


def prepared(folder: Path) -> Path:
    """Write what the commands read."""
    folder.mkdir()
    (folder / "sweep.toml").write_text(SWEEP)
    (folder / "emulsion.toml").write_text(EMULSION)
    small = SWEEP.replace("samples = 96", "samples = 4")
    (folder / "small.toml").write_text(small.replace("start_distance = 1.5\ntime_limit = 6\n", ""))
    for command in (
        ["examples", str(folder / "examples")],
        ["sweep", str(folder / "small.toml"), "--out", str(folder / "sweep")],
        ["virtual", "--rows", "300", "--out", str(folder / "mine.parquet")],
        [
            *("video", str(folder / "examples" / "clip.mp4"), *_LABORATORY, "--frames", "0:60"),
            *("--no-overlay", "--workers", "1", "--out", str(folder / "measured")),
        ],
    ):
        assert main(command) == 0, command
    return folder


def commands(given: Path, out: Path) -> dict[str, list[str]]:
    """Return the arguments of every command that writes to a folder, by the command's name."""
    films = given / "examples"
    return {
        "run": ["run", "--set", "time_limit=4", "--out", str(out)],
        "sweep": ["sweep", str(given / "sweep.toml"), "--out", str(out)],
        "boundary": [
            *("boundary", "--capillary", "40", "--scan", "8", "--width", "0.05"),
            *("--out", str(out)),
        ],
        "calibrate": [
            *("calibrate", "paper-simulation", "--free", "edge_stiffness", "--points", "3"),
            *("--scan", "6", "--width", "0.1", "--evaluations", "2", "--grid", "0"),
            *("--out", str(out)),
        ],
        "emulsion": ["emulsion", str(given / "emulsion.toml"), "--out", str(out)],
        "video": [
            *("video", str(films / "clip.mp4"), *_LABORATORY, "--frames", "0:40"),
            *("--workers", "2", "--out", str(out)),
        ],
        "compare": [
            *("compare", str(given / "measured" / "clips" / "clip"), "--collision", "0"),
            *("--out", str(out)),
        ],
        "export": ["export", str(given / "measured"), "--out", str(out)],
        "fit": ["fit", str(given / "mine.parquet"), "--samples", "4", "--out", str(out)],
        "examples": ["examples", str(out)],
        "chamber": ["chamber", "--out", str(out)],
        "reproduce": ["reproduce", "--only", "2,3", "--quick", "--out", str(out)],
    }


def files_of(given: Path, out: Path) -> dict[str, list[str]]:
    """Return the arguments of every command that writes files by their names."""
    return {
        "film": ["film", str(given / "sweep"), "--most", "1", "--out", str(out / "film.mp4")],
        "virtual": ["virtual", "--rows", "200", "--out", str(out / "virtual.parquet")],
        "summary": ["summary", str(given / "sweep"), "--picture", str(out / "picture.png")],
        "explore": ["explore", str(given / "mine.parquet"), "--out", str(out / "page.html")],
    }


@pytest.fixture(scope="session")
def given(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of what the commands read."""
    pytest.importorskip("cv2", reason="the extra 'video' is not installed")
    pytest.importorskip("gdstk", reason="the extra 'chamber' is not installed")
    return prepared(tmp_path_factory.mktemp("attack") / "given")


@pytest.fixture(scope="session")
def writing(given: Path) -> Callable[[str, Path], list[str]]:
    """Return the function that gives the arguments of a command that writes to a folder."""
    return lambda name, out: {**commands(given, out), **files_of(given, out)}[name]
