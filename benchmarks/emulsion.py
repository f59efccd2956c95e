"""Cost of many droplets, beside a single collision and beside comparing everybody with everybody.

Each figure is from CPU time of this process, the best of several rounds in which the contestants
take turns; ratios are between contestants of one run. Wall time is used for two threads only, and
means nothing on a busy machine: then look at the share of work that runs on one thread.

    python benchmarks/emulsion.py [--quick] [--rows]

Prints tables and writes them to benchmarks/results/.
"""

import argparse
import json
import math
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import pinchoff as po
from pinchoff import _core
from pinchoff.model.emulsion_result import flat_frame
from pinchoff.model.emulsion_scene import WINDOW
from pinchoff.model.gsd import OutlineWriter

HERE = Path(__file__).parent
MODELS = ("deformable-particle", "front-tracking")
NOBODY, NOTHING = np.zeros((0, 3)), np.zeros(0)
BECAME = ("entered", "left", "breakups", "merges", "touches", "retired", "respaced")
MERGING = (6.0, 0.3, 0.0)  # K = 0.3 at Ca_sim 20


def run_of(
    model: str,
    droplets: Any,
    flow: po.flow.Flow | None = None,
    *,
    obstacles: Any = NOBODY,
    cell: Any = (0.0, 0.0, 0.0, 0.0),
    periodic: str = "",
    inlet: Any = (0.0, 0.0, 0.0, 0.0),
    diameters: Any = NOTHING,
    outlet: float = math.inf,
    coalescence: Any = NOTHING,
    threads: int = 1,
    capillary: float = 20.0,
    exhaustive: bool = False,
) -> _core.Emulsion:
    """Return a run of droplets with 64 vertices, ready to start."""
    row = po.Parameters(
        model=model, simulation_capillary_number=capillary, vertex_count=64
    ).model_row()
    return _core.Emulsion(
        row,
        po.flow.uniform() if flow is None else flow,
        np.asarray(obstacles, dtype=float),
        np.asarray(droplets, dtype=float).reshape(-1, 3),
        np.asarray(cell, dtype=float),
        "x" in periodic,
        "y" in periodic,
        WINDOW,
        0.3,
        np.asarray(inlet, dtype=float),
        np.asarray(diameters, dtype=float),
        outlet,
        np.asarray(coalescence, dtype=float),
        1,
        threads,
        exhaustive=exhaustive,
    )


def balance(run: _core.Emulsion) -> dict[str, float]:
    return dict(zip(_core.BALANCE_FIELDS, np.asarray(run.balance()).tolist(), strict=True))


def lattice(count: int, pitch: float, diameter: float = 1.0) -> list[list[float]]:
    side = math.ceil(math.sqrt(count))
    return [[pitch * (i % side), pitch * (i // side), diameter] for i in range(count)]


def update_rate(run: _core.Emulsion, windows: int) -> float:
    """Vertex updates per second of CPU time."""
    before, start = balance(run)["vertex_updates"], time.process_time()
    run.advance(windows)
    seconds = time.process_time() - start
    return (balance(run)["vertex_updates"] - before) / seconds


def best(sample: Callable[[], float], rounds: int) -> float:
    return max(sample() for _ in range(rounds))


# ---------------------------------------------------------------- scenes


def free_droplets(model: str, counts: list[int], rounds: int) -> dict[str, float]:
    """Rates of N droplets that never meet."""
    rates = {}
    for count in counts:
        run = run_of(model, lattice(count, 2.0))
        run.advance(2)
        windows = max(2, 400 // count)
        rates[str(count)] = best(lambda run=run, w=windows: update_rate(run, w), rounds)
    return rates


def compared_with_everybody(model: str, counts: list[int], rounds: int) -> dict[str, float]:
    """The same where everybody is compared with everybody, in one island."""
    rates = {}
    for count in counts:
        run = run_of(model, lattice(count, 2.0), exhaustive=True)
        run.advance(1)
        windows = max(1, 40 // count)
        rates[str(count)] = best(lambda run=run, w=windows: update_rate(run, w), rounds)
    return rates


def single_collision(model: str, rounds: int) -> float:
    """Whole breaking collisions of `simulate_many`, automatic step."""
    row = po.Parameters(
        model=model,
        simulation_capillary_number=20,
        offset=0.03,
        follow_daughters=False,
        vertex_count=64,
    ).model_row()
    rows = np.tile(row, (20, 1))

    def sample() -> float:
        start = time.process_time()
        results = _core.run_many(rows, None, 1, None)
        updates = results[:, _core.RESULT_FIELDS.index("vertex_updates")].sum()
        return float(updates) / (time.process_time() - start)

    return best(sample, rounds)


def bare_step(model: str, rounds: int) -> float:
    """One droplet in the same Stokes flow with nothing to look at: no obstacle, long windows."""
    run = run_of(model, [[-3.0, 0.03, 1.0]], po.flow.stokes(1 / 5.66))
    return best(lambda: update_rate(run, 20), rounds)


def crowded(model: str, count: int) -> _core.Emulsion:
    """Droplets that take up 0.8 of a periodic cell, in eddies."""
    side = math.isqrt(count)
    pitch = math.sqrt(math.pi / 4 * 0.97**2 / 0.8)
    length = side * pitch
    nodes = np.arange(160) * length / 160
    x, y = np.meshgrid(2 * np.pi * nodes / length, 2 * np.pi * nodes / length)
    flow = po.flow.sampled(nodes, nodes, 1 + 0.5 * np.sin(y), 0.5 * np.sin(x), periodic="xy")
    starts = [
        [pitch * (i % side + 0.5), pitch * (i // side + 0.5), 0.97] for i in range(side * side)
    ]
    return run_of(model, starts, flow, cell=(0, length, 0, length), periodic="xy")


def array_scene(rows: int, columns: int) -> tuple[po.arrays.PillarArray, po.flow.Flow]:
    """A staggered array with free fluid before and behind it, and the flow through it."""
    from pinchoff.chamber.periodic_flow import array_flow

    array = po.arrays.staggered(rows=rows, columns=columns, radius=0.2, gap=1.2)
    array = array.with_margins(before=3.0, behind=3.0)
    return array, array_flow(array, thickness=0.5).sampled(pad=3.0, spacing=0.04)


def masked_flow(array: po.arrays.PillarArray) -> po.flow.Flow:
    """A smooth flow that is at rest on the pillars, periodic both ways; it is no solution."""
    x = np.arange(round(array.length / 0.05)) * array.length / round(array.length / 0.05)
    y = np.arange(round(array.width / 0.05)) * array.width / round(array.width / 0.05)
    still = np.ones((y.size, x.size))
    for px, py, radius in array.circles:
        dx = (x - px + array.length / 2) % array.length - array.length / 2
        dy = (y - py + array.width / 2) % array.width - array.width / 2
        near_x, near_y = np.flatnonzero(np.abs(dx) < 2), np.flatnonzero(np.abs(dy) < 2)
        away = np.hypot(dx[near_x], dy[near_y, None]) - radius
        still[np.ix_(near_y, near_x)] *= 1 - np.exp(-((np.maximum(away, 0) / 0.3) ** 2))
    return po.flow.sampled(x, y, still, 0.0 * still, periodic="xy")


def dilute(model: str, count: int) -> _core.Emulsion:
    """Droplets of area fraction 0.1 among 0.4 times as many pillars, periodic both ways."""
    columns = 2 * math.ceil(math.sqrt(0.1 * count))
    rows = round(0.4 * count / columns)
    pitch = math.sqrt(math.pi / 4 * count / 0.1 / (rows * columns))
    array = po.arrays.staggered(rows=rows, columns=columns, radius=0.2, gap=pitch - 0.4)
    rng, starts = np.random.default_rng(0), []
    size = np.array([array.length, array.width])
    discs = array.circles.copy()
    while len(starts) < count:
        place = rng.uniform(0, size)
        away = np.abs(discs[:, :2] - place)
        away = np.minimum(away, size - away)
        if (np.hypot(*away.T) > discs[:, 2] + 0.5 + 0.07).all():
            starts.append([*place, 1.0])
            discs = np.vstack((discs, [*place, 0.5]))
    cell = (0, array.length, 0, array.width)
    flow = masked_flow(array)
    return run_of(model, starts, flow, obstacles=array.circles, cell=cell, periodic="xy")


def through_twenty_rows(
    model: str,
    count: int,
    array: po.arrays.PillarArray,
    flow: po.flow.Flow,
    coalescence: Any = NOTHING,
) -> dict[str, float]:
    """Droplets enter until so many have passed all rows and left; CPU seconds, what happened.

    At each quarter of the way also CPU time so far and resident memory. `coalescence`: K Ca_sim, s
    and whether 1/t_d is a rate; nothing where droplets do not merge.
    """
    run = run_of(
        model,
        NOBODY,
        flow,
        obstacles=array.circles,
        cell=(0, array.length, 0, array.width),
        periodic="y",
        inlet=(0.0, 0.0, array.width, 0.15),
        diameters=[0.9],
        outlet=array.length,
        coalescence=coalescence,
        threads=2,
    )
    start, wall = time.process_time(), time.perf_counter()
    quarters: dict[str, float] = {}
    while (left := balance(run)["left"]) < count:
        run.advance(5)
        run.take_events()
        reached = int(4 * left / count)
        if reached and f"rss_mb_{reached}" not in quarters:
            quarters[f"cpu_s_{reached}"] = time.process_time() - start
            quarters[f"rss_mb_{reached}"] = resident() / 1e6
    done = balance(run)
    return {
        "cpu_s": time.process_time() - start,
        "wall_s": time.perf_counter() - wall,
        "rss_mb": resident() / 1e6,
        **quarters,
        **{name: done[name] for name in BECAME},
        "rate": done["vertex_updates"] / (time.process_time() - start),
    }


def with_a_daughter(model: str, rounds: int) -> float:
    """Cost of 100 droplets and one of 0.3 D0 over that of the 100 alone."""
    costs = []
    for more in ([], [[40.0, 40.0, 0.3]]):
        run = run_of(model, [*lattice(100, 2.0), *more])
        run.advance(2)

        def sample(run: _core.Emulsion = run) -> float:
            start = time.process_time()
            run.advance(6)
            return 1.0 / (time.process_time() - start)

        costs.append(1.0 / best(sample, rounds))
    return costs[1] / costs[0]


def two_threads(model: str, count: int, rounds: int) -> dict[str, float]:
    """Wall time of one thread over that of two, and CPU time of two over that of one."""
    wall, cpu = [], []
    for threads in (1, 2):
        run = run_of(model, lattice(count, 2.0), threads=threads)
        run.advance(2)
        walls, cpus = [], []
        for _ in range(rounds):
            start, used = time.perf_counter(), time.process_time()
            run.advance(max(4, 2000 // count))
            walls.append(time.perf_counter() - start)
            cpus.append(time.process_time() - used)
        wall.append(min(walls))
        cpu.append(min(cpus))
    return {"speedup": wall[0] / wall[1], "cpu_2_over_1": cpu[1] / cpu[0]}


def frame_cost(folder: Path) -> dict[str, float]:
    """Milliseconds of CPU time to read a frame of 1000 droplets, and to write it as GSD."""
    run = run_of(MODELS[0], lattice(1000, 2.0))
    writer = OutlineWriter(folder / "frame.gsd", NOBODY, {}, flush_every=None)
    costs = {}
    frame = flat_frame(run.frame())
    for name, do in (
        ("read_ms", lambda: flat_frame(run.frame())),
        ("write_ms", lambda: writer.append_flat(0.0, *frame)),
    ):
        start = time.process_time()
        for _ in range(20):
            do()
        costs[name] = 50 * (time.process_time() - start)
    writer.close()
    return costs


def resident() -> int:
    """Bytes of resident memory of this process, where the system tells."""
    status = Path("/proc/self/status")
    return int(status.read_text().split("VmRSS:")[1].split()[0]) * 1024 if status.exists() else 0


def memory_per_droplet() -> float:
    """Bytes of resident memory that a droplet of 64 vertices takes, outlines and lists."""
    before = resident()
    run = run_of(MODELS[0], lattice(10_000, 2.0))
    run.advance(2)
    return (resident() - before) / 10_000


# ---------------------------------------------------------------- report


def print_rates(console: Console, title: str, rates: dict[str, dict[str, float]]) -> None:
    table = Table(title=title)
    table.add_column("model")
    for name in next(iter(rates.values())):
        table.add_column(name, justify="right")
    for model, values in rates.items():
        table.add_row(model, *(f"{value:.3g}" for value in values.values()))
    console.print(table)


def measure_rows(quick: bool, console: Console) -> dict[str, Any]:
    """Droplets through twenty rows of pillars, with both models, without and with merging."""
    results: dict[str, Any] = {"instruction set": _core.instruction_set()}
    array, flow = array_scene(*((2, 4) if quick else (10, 20)))
    count = 10 if quick else 1000
    for title, how in (("through the rows", NOTHING), ("the same, merging", MERGING)):
        results[title] = {m: through_twenty_rows(m, count, array, flow, how) for m in MODELS}
        for model, values in results[title].items():
            console.print(f"{title}, {model}:", {k: round(v, 1) for k, v in values.items()})
    return results


def measure(quick: bool, console: Console) -> dict[str, Any]:
    import tempfile

    rounds = 2 if quick else 5
    counts = [1, 10, 100] if quick else [1, 10, 100, 1000, 10_000]
    results: dict[str, Any] = {"instruction set": _core.instruction_set()}

    def table(title: str, by_model: Callable[[str], dict[str, float]]) -> None:
        results[title] = {model: by_model(model) for model in MODELS}
        print_rates(console, title, results[title])

    table("free droplets, vertex updates/s", lambda m: free_droplets(m, counts, rounds))
    few = [c for c in counts if c <= 1000]
    table("the same, everybody compared", lambda m: compared_with_everybody(m, few, 2))
    table(
        "single collision, vertex updates/s",
        lambda m: {
            "whole, breaking": single_collision(m, rounds),
            "no obstacle": bare_step(m, rounds),
        },
    )
    table(
        "one of 0.3 D0 among 100: cost over that without",
        lambda m: {"ratio": with_a_daughter(m, rounds)},
    )
    sizes = [25] if quick else [25, 100, 400]

    def crowds(model: str) -> dict[str, float]:
        rates = {}
        for size in sizes:
            run = crowded(model, size)
            run.advance(10)
            rates[str(size)] = best(
                lambda run=run, size=size: update_rate(run, max(2, 200 // size)), rounds
            )
        return rates

    table("pressed together, area fraction 0.8, updates/s", crowds)
    table("two threads", lambda m: two_threads(m, 100 if quick else 400, rounds))

    def dilutes(model: str) -> dict[str, float]:
        run = dilute(model, 20 if quick else 500)
        run.advance(40)
        rate = best(lambda: update_rate(run, 4), rounds)
        return {"updates/s": rate, "retired": balance(run)["retired"]}

    table("500 droplets, area fraction 0.1, 200 pillars, sampled flow", dilutes)
    results |= measure_rows(quick, console)
    with tempfile.TemporaryDirectory() as folder:
        results["frame of 1000"] = frame_cost(Path(folder))
    console.print("frame of 1000 droplets:", results["frame of 1000"])
    if resident():
        results["bytes a droplet"] = memory_per_droplet()
        console.print(f"memory: {results['bytes a droplet']:.0f} bytes a droplet of 64 vertices")
    return results


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="a minute's smoke test, no figures")
    parser.add_argument("--rows", action="store_true", help="droplets through 20 rows alone")
    arguments = parser.parse_args()
    console = Console(width=100)
    measured = measure_rows if arguments.rows else measure
    results = measured(arguments.quick, console)
    folder = HERE / "results"
    folder.mkdir(exist_ok=True)
    path = folder / f"emulsion-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.json"
    aside = path.with_suffix(".part")
    aside.write_text(json.dumps(results, indent=1))
    aside.replace(path)
    console.print(f"wrote {path}", highlight=False, soft_wrap=True)


if __name__ == "__main__":
    main()
