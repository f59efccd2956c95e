"""Every command that writes, small, with what it needs to read; and how an attack is made."""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import pinchoff as po
from pinchoff.cli import main

FORM = re.compile(r"error: .+ must be .+; got .*; .+", re.S)
LONGEST_S = 20
"""CPU time that an input may take."""
MOST_BYTES = 1_000_000_000
"""Memory that an input may take, with what the process of the tests has."""

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
    (folder / "coarse.toml").write_text("vertex_count = 32\nstart_distance = 2.0\n")
    small = SWEEP.replace("samples = 96", "samples = 4")
    (folder / "small.toml").write_text(small.replace("start_distance = 1.5\ntime_limit = 6\n", ""))
    with pytest.MonkeyPatch.context() as patch:
        module = importlib.import_module("pinchoff.cli.examples")  # the command has the same name
        patch.setattr(module, "_DROPLETS", ((60, 4.4, 0.02), (80, 5.2, 0.1)))  # a short clip
        assert main(["examples", str(folder / "examples")]) == 0
    for command in (
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
            *("calibrate", "paper-simulation", str(given / "coarse.toml"), "--points", "3"),
            *("--free", "edge_stiffness"),
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


def begun(
    arguments: list[str], said: int, longest_s: int = 10 * LONGEST_S, *, draws: bool = True
) -> int:
    """Begin a command in a copy of this process, and return the copy's number.

    Nothing is imported again, and neither a crash nor memory that is never given back reaches the
    next attack.

    Parameters
    ----------
    arguments : list of str
    said : int
        Descriptor of the file for what it says on stderr.
    longest_s : int, optional
        CPU time, after which it is ended, as after twenty times as much of waiting.
    draws : bool, optional
        Whether its figures are drawn, which takes longest, or empty.
    """
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        signal.alarm(20 * longest_s)
        resource.setrlimit(resource.RLIMIT_CPU, (longest_s + 1, longest_s + 1))
        resource.setrlimit(resource.RLIMIT_DATA, (4 * MOST_BYTES, 4 * MOST_BYTES))
        warnings.resetwarnings()
        sys.stdout = open(os.devnull, "w")  # noqa: PTH123, SIM115
        sys.stderr = os.fdopen(said, "w", encoding="utf-8", errors="replace")
        os.dup2(said, 2)
        if not draws:
            save, empty = Figure.savefig, Figure(figsize=(1, 1))
            Figure.savefig = lambda _, *given, **more: save(empty, *given, **more)
        code = main(["--debug", *arguments])
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(code)


_STOPPED = re.compile("^stopped; .* holds the run until then$", re.M)


def attacked(
    arguments: list[str], out: Path, longest_s: int = LONGEST_S, *, draws: bool = True
) -> list[str]:
    """Run a command, as `begun` does, to its end; return what is wrong with how it ended."""
    with tempfile.TemporaryFile() as file:
        _, status, used = os.wait4(begun(arguments, file.fileno(), longest_s, draws=draws), 0)
        file.seek(0)
        said = file.read().decode(errors="replace")
    code, wrong = os.waitstatus_to_exitcode(status), []
    if code not in (0, 2) and not (code == 1 and _STOPPED.search(said)):  # by a guard
        wrong.append(f"exit code {code}: {said[-2000:]}")
    elif "Traceback" in said:
        wrong.append(f"a traceback: {said[-2000:]}")
    errors = [said[found.start() :] for found in re.finditer("^error: ", said, re.M)]
    if not all(map(FORM.match, errors)) or (code == 2 and not errors):
        wrong.append(f"not in our form: {said[-500:]}")
    if (seconds := used.ru_utime + used.ru_stime) > longest_s:
        wrong.append(f"CPU time: {seconds:.0f} s")
    if used.ru_maxrss * 1024 > MOST_BYTES:
        wrong.append(f"memory: {used.ru_maxrss / 1024:.0f} MiB")
    if code != 0 and out.is_dir() and not any(out.iterdir()):
        wrong.append("an empty folder is left")
    if next(out.parent.rglob(".pinchoff*"), None) is not None:
        wrong.append("an unfinished file is left")
    return wrong


@pytest.fixture(scope="session")
def begin() -> Callable[..., int]:
    """Return the function that begins; all that commands import is imported once, here."""
    if not hasattr(os, "fork"):
        pytest.skip("this system copies no processes")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for module in pkgutil.walk_packages(po.__path__, "pinchoff."):
            with suppress(ImportError):  # of an extra that is not installed
                importlib.import_module(module.name)
    with suppress(ImportError):
        importlib.import_module("cv2").setNumThreads(1)  # its threads do not survive a copy
    return begun


@pytest.fixture(scope="session")
def attack(begin: Callable[..., int]) -> Callable[..., list[str]]:
    """Return the function that attacks."""
    return attacked
