"""Speed of pinchoff beside three plain programs of the same collision, in one run.

The reference programs in benchmarks/reference/ hold the same physics, written the way a researcher
writes it alone: a C++ loop (built here with -O2), numba and NumPy. Each figure is the median over
rounds in which the contestants take turns, so that a busy machine slows them all; a ratio is the
median of the rounds' ratios, with the least and the greatest.

    python benchmarks/speed.py [--quick]

Prints tables and writes every sample to benchmarks/results/.
"""

import argparse
import importlib.util
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import pinchoff as po
from pinchoff import _core

HERE = Path(__file__).parent
CAPILLARY, OFFSET, SIZE_RATIO, TIME_STEP = 20.0, 0.03, 5.66, 1e-4
Contestant = Callable[[], float]  # takes one sample: a rate per second


@dataclass(frozen=True)
class Effort:
    """How much work one sample is, and how many rounds of samples there are."""

    rounds: int
    reference_steps: int  # C++ and numba
    numpy_steps: int
    collisions: int  # of pinchoff, on one thread
    rows: tuple[int, int]  # of the two tables whose memory is compared


FULL = Effort(7, 300_000, 3_000, 120, (1_000, 10_000))
QUICK = Effort(3, 40_000, 500, 12, (500, 2_000))
INSTRUCTION_SETS = ("generic", "x86_64_v3", "x86_64_v4")  # from the narrowest on


def parameters(vertices: int, **changes: Any) -> po.Parameters:
    """Return the collision that everyone runs; it breaks, and ends there."""
    model: dict[str, Any] = {
        "size_ratio": SIZE_RATIO,
        "simulation_capillary_number": CAPILLARY,
        "offset": OFFSET,
        "vertex_count": vertices,
        "time_step": TIME_STEP,
        "line_tension": 80.0,
        "edge_stiffness": 3.0,
        "area_stiffness": 5e3 * 80.0,
        "wall_stiffness": 1.25 * 80.0,
        "follow_daughters": False,
    }
    return po.Parameters(**(model | changes))


# ---------------------------------------------------------------- contestants


def build_reference(folder: Path) -> Path:
    """Compile the C++ reference with `-O2` and nothing else."""
    program = folder / "collision"
    source = HERE / "reference" / "collision.cpp"
    subprocess.run([compiler(), "-O2", "-o", program, source], check=True)
    return program


def run_reference(program: Path, vertices: int, steps: int) -> dict[str, Any]:
    model = (CAPILLARY, OFFSET, SIZE_RATIO, TIME_STEP)
    command = [str(program), *map(str, (vertices, steps, *model))]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    result: dict[str, Any] = json.loads(answer)
    return result


def load_reference(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, HERE / "reference" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def engine_rate(vertices: int, collisions: int) -> float:
    """Vertex updates per second of whole collisions on one thread."""
    rows = np.tile(parameters(vertices).model_row(), (collisions, 1))
    start = time.perf_counter()
    results = _core.run_many(rows, None, 1, None)
    seconds = time.perf_counter() - start
    return float(results[:, _core.RESULT_FIELDS.index("vertex_updates")].sum()) / seconds


def narrower_engine_rate(instruction_set: str, vertices: int, collisions: int) -> float:
    """Return the same in a process of its own, held to a narrower instruction set."""
    command = [sys.executable, str(Path(__file__).resolve()), "--engine"]
    answer = subprocess.run(
        [*command, str(vertices), str(collisions)],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"PINCHOFF_INSTRUCTION_SET": instruction_set},
    ).stdout
    used, rate = json.loads(answer)
    assert used == instruction_set, f"asked for {instruction_set}, ran {used}"
    return float(rate)


def numba_rate(module: Any, vertices: int, steps: int) -> float:
    taken, start = 0, time.perf_counter()
    while taken < steps:
        taken += module.collide(vertices, CAPILLARY, OFFSET, SIZE_RATIO, TIME_STEP)[-1]
    return taken * vertices / (time.perf_counter() - start)


def numpy_rate(module: Any, vertices: int, steps: int) -> float:
    start = time.perf_counter()
    module.collide(vertices, CAPILLARY, OFFSET, SIZE_RATIO, TIME_STEP, steps)
    return steps * vertices / (time.perf_counter() - start)


def contestants(program: Path, vertices: int, effort: Effort) -> dict[str, Contestant]:
    numba, plain = load_reference("collision_numba"), load_reference("collision_numpy")
    numba.collide(vertices, CAPILLARY, OFFSET, SIZE_RATIO, TIME_STEP)  # compile
    steps, collisions = effort.reference_steps, effort.collisions
    narrower = INSTRUCTION_SETS[: INSTRUCTION_SETS.index(_core.instruction_set())]
    return {
        "pinchoff": lambda: engine_rate(vertices, collisions),
        **{
            f"pinchoff as {name}": lambda name=name: narrower_engine_rate(
                name, vertices, collisions
            )
            for name in narrower
        },
        "C++ -O2": lambda: run_reference(program, vertices, steps)["vertex_updates_per_s"],
        "numba": lambda: numba_rate(numba, vertices, steps),
        "NumPy": lambda: numpy_rate(plain, vertices, effort.numpy_steps),
    }


def collision_rate(threads: int, count: int, **changes: Any) -> float:
    """Collisions per second of the public function, with the table it returns."""
    one = parameters(64, **changes)
    start = time.perf_counter()
    po.simulate_many([one] * count, threads=threads, progress=False)
    return count / (time.perf_counter() - start)


# ---------------------------------------------------------------- measurement


def take_turns(players: dict[str, Contestant], rounds: int) -> dict[str, list[float]]:
    samples: dict[str, list[float]] = {name: [] for name in players}
    for _ in range(rounds):
        for name, sample in players.items():
            samples[name].append(sample())
    return samples


def ratio(above: list[float], below: list[float]) -> str:
    each = [a / b for a, b in zip(above, below, strict=True)]
    return f"{statistics.median(each):.3g} ({min(each):.3g} to {max(each):.3g})"


def memory_growth(rows: tuple[int, int]) -> float | None:
    """Bytes by which the peak memory grows per further row; None where /proc is missing.

    In a process of its own: a first table of `rows[0]` short runs, then one of `rows[1]`.
    """
    if not Path("/proc/self/status").exists():
        return None
    command = [sys.executable, str(Path(__file__).resolve()), "--memory", *map(str, rows)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    few, many = json.loads(answer)
    return float(many - few) / (rows[1] - rows[0])


def peak_memory_after(rows: list[int]) -> list[int]:
    """Peak resident bytes of this process after one table of each length."""
    one = parameters(16, time_step="auto", time_limit=0.01)
    peaks = []
    for count in rows:
        po.simulate_many((one for _ in range(count)), progress=False)
        status = Path("/proc/self/status").read_text()
        peaks.append(int(status.split("VmHWM:")[1].split()[0]) * 1024)
    return peaks


def check_agreement(program: Path) -> str:
    """Compare the engine with the C++ reference on this collision; SystemExit if they differ."""
    theirs, ours = run_reference(program, 64, 0), po.simulate(parameters(64))
    line = (
        f"C++ reference {theirs['outcome']}, S = {theirs['symmetry']:.4f}, contact at "
        f"{theirs['contact_time']:.4f}; pinchoff {ours.outcome}, S = {ours.symmetry:.4f}, "
        f"contact at {ours.contact_time:.4f}"
    )
    if ours.outcome != theirs["outcome"] or abs(ours.symmetry - theirs["symmetry"]) > 0.005:
        raise SystemExit(f"the two programs do not compute the same collision: {line}")
    return line


# ---------------------------------------------------------------- report


def compiler() -> str:
    return os.environ.get("CXX", "g++")


def machine() -> dict[str, str]:
    cpuinfo = Path("/proc/cpuinfo")
    models = [
        line.split(":", 1)[1].strip()
        for line in (cpuinfo.read_text().splitlines() if cpuinfo.exists() else [])
        if line.startswith("model name")
    ]
    version = subprocess.run([compiler(), "--version"], capture_output=True, text=True, check=True)
    return {
        "processor": models[0] if models else platform.processor(),
        "cores": str(os.cpu_count()),
        "instruction set used": _core.instruction_set(),
        "reference compiler": version.stdout.splitlines()[0],
        "Python": platform.python_version(),
        "pinchoff": po.__version__,
    }


def updates_table(samples: dict[int, dict[str, list[float]]]) -> Table:
    table = Table(title="Vertex updates per second, one core")
    for heading in ("N_v", "program", "median", "over C++ -O2 (least to greatest)"):
        table.add_column(heading, justify="left" if heading == "program" else "right")
    for vertices, by_name in samples.items():
        for name, rates in by_name.items():
            above = ratio(rates, by_name["C++ -O2"])
            table.add_row(str(vertices), name, f"{statistics.median(rates):.3g}", above)
    return table


def collisions_table(samples: dict[str, list[float]], threads: int) -> Table:
    table = Table(title="Collisions per second of simulate_many, N_v = 64")
    table.add_column("run")
    table.add_column("median", justify="right")
    for name, rates in samples.items():
        table.add_row(name, f"{statistics.median(rates):.4g}")
    for step in ("step of the paper", "automatic step"):
        one, every = samples[f"{step}, 1 thread"], samples[f"{step}, {threads} threads"]
        table.add_row(f"{step}: {threads} threads over 1", ratio(every, one))
    return table


def save(results: dict[str, Any]) -> Path:
    """Write aside, then rename: a killed run leaves no half a file."""
    folder = HERE / "results"
    folder.mkdir(exist_ok=True)
    path = folder / f"speed-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.json"
    aside = path.with_suffix(".part")
    aside.write_text(json.dumps(results, indent=1))
    aside.replace(path)
    return path


def measure(effort: Effort, console: Console) -> dict[str, Any]:
    facts, threads = machine(), os.cpu_count() or 1
    for name, fact in facts.items():
        console.print(f"{name}: {fact}", highlight=False)
    with tempfile.TemporaryDirectory() as folder:
        program = build_reference(Path(folder))
        console.print(check_agreement(program), highlight=False)
        updates = {n: take_turns(contestants(program, n, effort), effort.rounds) for n in (64, 128)}
    console.print(updates_table(updates))
    collision_rate(threads, 1)  # loads what is loaded on first use
    counts = {1: effort.collisions, threads: threads * effort.collisions}
    collisions = take_turns(
        {
            f"{name}, {many} thread{'s' if many > 1 else ''}": (
                lambda many=many, count=count, step=step: collision_rate(
                    many, count, time_step=step
                )
            )
            for name, step in (("step of the paper", TIME_STEP), ("automatic step", "auto"))
            for many, count in counts.items()
        },
        effort.rounds,
    )
    console.print(collisions_table(collisions, threads))
    growth = memory_growth(effort.rows)
    if growth is not None:
        few, many = effort.rows
        console.print(f"Memory: {growth:.0f} bytes a row more from {few} to {many} rows")
    return {
        "machine": facts,
        "vertex_updates_per_s": updates,
        "collisions_per_s": collisions,
        "bytes_per_row": growth,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="a minute's smoke test, no figures")
    parser.add_argument("--engine", nargs=2, type=int, help=argparse.SUPPRESS)
    parser.add_argument("--memory", nargs=2, type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.memory:
        print(json.dumps(peak_memory_after(arguments.memory)))
        return
    if arguments.engine:
        print(json.dumps([_core.instruction_set(), engine_rate(*arguments.engine)]))
        return
    console = Console(width=max(80, min(120, shutil.get_terminal_size().columns)))
    if shutil.which(compiler()) is None:
        sys.exit(f"error: CXX must be a C++ compiler; got {compiler()!r}; install g++ or set CXX")
    results = measure(QUICK if arguments.quick else FULL, console)
    console.print(f"wrote {save(results)}", highlight=False, soft_wrap=True)


if __name__ == "__main__":
    main()
