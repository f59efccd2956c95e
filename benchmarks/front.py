"""Front tracking beside the springs' model: vertex updates, and the line brought to 1 %.

CPU time on one thread, both models in turns in one run, so that a busy machine slows them alike.
The line is that of the table in docs/front_tracking.md; each model has the fewest vertices (of
those listed) with which every point is within 1 % of its own line at 384 vertices.

    python benchmarks/front.py
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import pinchoff as po
from pinchoff import _core

CAPILLARY = (16, 20, 25, 32, 40, 50, 64, 80)
CONVERGED = {"deformable-particle": 192, "front-tracking": 128}
INSTRUCTION_SETS = ("generic", "x86_64_v3", "x86_64_v4")
WIDTH = 5e-4  # of the brackets, in S


def column(name: str) -> int:
    return _core.RESULT_FIELDS.index(name)


def update_rate(model: str, vertices: int, collisions: int = 20) -> float:
    """Vertex updates per second of CPU time, over whole collisions with the paper's step."""
    p = po.Parameters(
        model=model,
        simulation_capillary_number=20,
        offset=0.03,
        vertex_count=vertices,
        time_step=1e-4,
        follow_daughters=False,
    )
    rows = np.tile(p.model_row(), (collisions, 1))
    start = time.process_time()
    results = _core.run_many(rows, None, 1, None)
    return float(results[:, column("vertex_updates")].sum() / (time.process_time() - start))


def seconds_for_line(model: str, vertices: int) -> float:
    """CPU seconds to bracket S_c at every point, eight offsets at a time."""
    start = time.process_time()
    for capillary in CAPILLARY:
        bracket(model, vertices, capillary)
    return time.process_time() - start


def bracket(model: str, vertices: int, capillary: float) -> None:
    low, high, broke, unbroken = 0.0, 0.6, np.inf, -np.inf
    while broke - unbroken > WIDTH:
        offsets = np.linspace(low, high, 10)
        rows = [
            po.Parameters(
                model=model,
                simulation_capillary_number=capillary,
                offset=float(offset),
                vertex_count=vertices,
                follow_daughters=False,
            ).model_row()
            for offset in offsets
        ]
        results = _core.run_many(np.array(rows), None, 1, None)
        breaks = results[:, column("outcome")] == 1
        last = int(np.flatnonzero(breaks).max())
        low, high = offsets[last], offsets[last + 1]
        symmetry = np.nan_to_num(results[:, column("symmetry")])
        broke, unbroken = symmetry[last], symmetry[last + 1]


def rates() -> dict[str, Any]:
    return {
        f"{model}, N = {n}": update_rate(model, n) for n in (64, 128) for model in CONVERGED
    } | {"instruction_set": _core.instruction_set()}


def main() -> None:
    if sys.argv[1:] == ["--rates"]:
        print(json.dumps(rates()))
        return
    for name in INSTRUCTION_SETS:
        answer = subprocess.run(
            [sys.executable, str(Path(__file__).resolve()), "--rates"],
            check=True,
            capture_output=True,
            text=True,
            env=os.environ | {"PINCHOFF_INSTRUCTION_SET": name},
        )
        found = json.loads(answer.stdout)
        print(found.pop("instruction_set"), {key: f"{rate:.3g}" for key, rate in found.items()})
    seconds = {model: seconds_for_line(model, n) for model, n in CONVERGED.items()}
    ratio = seconds["deformable-particle"] / seconds["front-tracking"]
    print("line to 1 %, CPU seconds:", {key: round(value, 2) for key, value in seconds.items()})
    print(f"front tracking is {ratio:.1f} times as fast")


if __name__ == "__main__":
    main()
