"""Speed, memory and convergence of the chamber's design and of its flow check.

The flow's reference is a direct solution (SuperLU) of the same equations on the same mesh, which
also says how exact the iteration is. Each size of the flow check runs in a process of its own, for
its peak memory.

    python benchmarks/chamber.py [--quick]

Prints tables.
"""

import argparse
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy import sparse
from scipy.sparse.linalg import splu
from shapely import MultiPolygon, box

from pinchoff import chamber as po_chamber
from pinchoff.chamber import brinkman, flow_check
from pinchoff.chamber.mesh import TriangleMesh, build_mesh
from pinchoff.figures import style
from pinchoff.figures.chamber_design import chamber_design

THICKNESS_UM = 85.0
MESHES = (6, 8, 12, 16, 20, 28)  # elements across the narrowest gap
QUICK_MESHES = (4,)
CONVERGED = {  # heading of what should not depend on the mesh, or say how fine it is
    "imaging_speed_mm_s": "imaging mm/s",
    "droplet_channel_over_imaging_speed": "channel over it",
    "pressure_drop_Pa": "drop Pa",
    "mass_error": "mass error",
    "elements_across_gap": "across gap",
}


def design_seconds(rounds: int) -> dict[str, float]:
    """Return the median time of each step from the parameters to the files."""
    with tempfile.TemporaryDirectory() as folder:
        samples = [steps(po_chamber.Chamber(), Path(folder)) for _ in range(rounds)]
    return {name: statistics.median(each[name] for each in samples) for name in samples[0]}


def steps(design: po_chamber.Chamber, folder: Path) -> dict[str, float]:
    work = {
        "geometry": lambda: design.layout,
        "rules": lambda: po_chamber.check_rules(design),
        "GDSII": lambda: po_chamber.write_gds(design, folder / "chamber.gds"),
        "OASIS": lambda: po_chamber.write_oasis(design, folder / "chamber.oas"),
        "DXF": lambda: po_chamber.write_dxf(design, folder / "chamber.dxf"),
        "OpenSCAD": lambda: po_chamber.write_scad(design, folder / "chamber.scad"),
        "STL": lambda: po_chamber.write_stl(design, folder / "chamber.stl"),
        "SVG and PNG": lambda: draw(design, folder),
    }
    taken = {}
    for name, step in work.items():
        start = time.perf_counter()
        step()
        taken[name] = time.perf_counter() - start
    return taken


def draw(design: po_chamber.Chamber, folder: Path) -> None:
    axes = chamber_design(design)
    for name in ("chamber.svg", "chamber.png"):
        style.save(folder / name, axes)


class Problem(NamedTuple):
    mesh: TriangleMesh
    ends: list[brinkman.Source]


def slit() -> Problem:
    """Return a flow between two walls, small enough for a smoke test."""
    mesh = build_mesh(MultiPolygon([box(0, 0, 3000, 600)]), lambda at: np.full(len(at), 40.0), 64.0)
    ends = [
        brinkman.Source(lambda points: points[:, 0] < 400, 1.0),
        brinkman.Source(lambda points: points[:, 0] > 2600, -1.0),
    ]
    return Problem(mesh, ends)


def device() -> Problem:
    """Return the paper's device on the coarsest of the meshes."""
    design = po_chamber.Chamber(operation={"elements_across_gap": MESHES[0]})
    checked = po_chamber.check_flow(design)
    return Problem(checked.field.mesh, flow_check._sources(design))


def iteration_beside_direct(problem: Problem, rounds: int) -> tuple[list[float], float]:
    """Return times of the direct solution over the iteration's, and their difference."""
    ratios, apart = [], math.nan
    for _ in range(rounds):
        start = time.perf_counter()
        field = brinkman.solve(problem.mesh, THICKNESS_UM, sources=problem.ends)
        between = time.perf_counter()
        velocity = direct(problem.mesh, problem.ends)
        ratios.append((time.perf_counter() - between) / (between - start))
        apart = float(np.abs(field.velocity - velocity).max() / np.abs(velocity).max())
    return ratios, apart


def direct(mesh: TriangleMesh, ends: list[brinkman.Source]) -> np.ndarray:
    system = brinkman._assembled(mesh, THICKNESS_UM, ends)
    inner = np.setdiff1d(np.arange(len(system.nodes)), system.wall)
    momentum = system.momentum[inner][:, inner]
    bx, by = (each[:, inner] for each in system.divergence)
    # The pressure's constant is free: its first value is set to zero.
    pinned = sparse.csr_matrix(([1e-12], ([0], [0])), shape=(bx.shape[0],) * 2)
    whole = sparse.block_array(
        [[momentum, None, -bx.T], [None, momentum, -by.T], [-bx, -by, -pinned]], format="csc"
    )
    right = np.concatenate([np.zeros(2 * len(inner)), -system.source])
    solution = splu(whole).solve(right)
    velocity = np.zeros((len(system.nodes), 2))
    velocity[inner] = solution[: 2 * len(inner)].reshape(2, -1).T
    return velocity


def checked_flow(elements: int) -> dict[str, Any]:
    """Check the paper's device, in this process, with its peak memory."""
    design = po_chamber.Chamber(operation={"elements_across_gap": elements})
    before = time.process_time()
    checked = po_chamber.check_flow(design)
    busy = time.process_time() - before
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return {**checked.summary, "cpu_s": busy, "peak_GB": peak}


def in_own_process(elements: int) -> dict[str, Any]:
    command = [sys.executable, __file__, "--flow", str(elements)]
    answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    result: dict[str, Any] = json.loads(answer)
    return result


def convergence_table(results: dict[int, dict[str, Any]]) -> Table:
    table = Table(title="Flow check of the paper's device, by elements across the narrowest gap")
    for heading in (
        "asked",
        *CONVERGED.values(),
        "triangles",
        "iterations",
        "seconds",
        "CPU s",
        "peak GB",
    ):
        table.add_column(heading, justify="right")
    for elements, row in results.items():
        shown = [f"{row[name]:.4g}" for name in CONVERGED]
        counts = [f"{row[name]:.0f}" for name in ("triangles", "iterations")]
        cost = [f"{row[name]:.3g}" for name in ("seconds", "cpu_s", "peak_GB")]
        table.add_row(str(elements), *shown, *counts, *cost)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--quick", action="store_true", help="a minute's smoke test, no figures")
    parser.add_argument("--flow", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.flow:
        print(json.dumps(checked_flow(arguments.flow)))
        return
    console = Console(width=130)
    seconds = design_seconds(1 if arguments.quick else 5)
    table = Table(title="Design and files, seconds")
    table.add_column("step")
    table.add_column("median", justify="right")
    for name, taken in {**seconds, "all": sum(seconds.values())}.items():
        table.add_row(name, f"{taken:.3f}")
    console.print(table)
    # Before anything large is held here: a process begins with its parent's peak.
    meshes = QUICK_MESHES if arguments.quick else MESHES
    console.print(convergence_table({n: in_own_process(n) for n in meshes}))
    problem = slit() if arguments.quick else device()
    ratios, apart = iteration_beside_direct(problem, 1 if arguments.quick else 3)
    console.print(
        f"{len(problem.mesh.triangles)} triangles: the direct solution takes "
        f"{statistics.median(ratios):.1f} times as long ({min(ratios):.1f} to {max(ratios):.1f}); "
        f"they differ by {apart:.0e} of the greatest speed"
    )


if __name__ == "__main__":
    main()
