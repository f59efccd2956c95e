"""Remake the numbers and pictures of docs/calibration.md; takes minutes.

Usage: python calibration_study.py [FOLDER]. The folder gets the pictures and, below it, the
evaluations of every calibration, which a second run takes up; the numbers are printed.
"""

import sys
import time
from pathlib import Path

import numpy as np

import pinchoff as po
from pinchoff.figures import style
from pinchoff.figures.calibrated_line import calibrated_line, objective_landscape
from pinchoff.studies.calibration.conversions import head_on_onset, match_onset
from pinchoff.studies.calibration.targets import as_target

CAPILLARY = [16, 20, 25, 32, 40, 50, 64, 80]
TARGET = "paper-simulation"


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "calibration-study")
    started = time.perf_counter()
    parts = (default_preset, other_searches, literal_reading, fixed_arc, onsets)
    for part in parts:
        print(f"\n## {part.__name__}")
        part(folder)
        print(f"({time.perf_counter() - started:.0f} s so far)", flush=True)


def default_preset(folder: Path) -> None:
    """The best set beside the default, its landscape and its sensitivity."""
    found = search(folder, "two-free", TARGET, ("edge_stiffness", "neck_thickness"), grid=6)
    style.save(folder / "calibration_line.png", calibrated_line(found))
    for k, surface in enumerate(found.landscapes):
        axes = objective_landscape(surface, found.target.objective_name, "/ perimeter")
        style.save(folder / f"calibration_landscape_{k + 1}.png", axes)
        low = np.unravel_index(np.argmin(surface.objective), surface.objective.shape)
        print(surface.names, "least", surface.objective.min(), surface.x[low[1]], surface.y[low[0]])
    print("conversion of the default preset", match_onset(found.target, po.Parameters()))


def other_searches(folder: Path) -> None:
    three = ("edge_stiffness", "neck_separation", "neck_thickness")
    search(folder, "three-free", TARGET, three)
    search(folder, "experiment", "paper-experiment", three[::2])
    search(folder, "conversion", TARGET, ("conversion",))


def literal_reading(folder: Path) -> None:
    """The arc threshold in D0, for several edge stiffnesses, and calibrated."""
    literal = po.Parameters.preset("literal-separation")
    vary = {"edge_stiffness": [1, 2, 3, 5], "simulation_capillary_number": CAPILLARY}
    describe(po.boundary(literal, vary, progress=False))
    del vary["edge_stiffness"]
    describe(po.boundary(literal.replace(vertex_count=128, edge_stiffness=3), vary, progress=False))
    two = ("edge_stiffness", "neck_thickness")
    found = search(folder, "literal", TARGET, two, base=literal)
    style.save(folder / "calibration_literal.png", calibrated_line(found))
    search(folder, "literal-arc", TARGET, ("neck_separation", "edge_stiffness"), base=literal)


def fixed_arc(folder: Path) -> None:
    """The calibrated length as arc threshold, beside the default: line, vertices, sizes."""
    length = {"neck_separation_unit": "diameter", "neck_separation": 1.384, "edge_stiffness": 2.559}
    ca = {"simulation_capillary_number": CAPILLARY}
    sizes = {"size_ratio": [3, 4, 5, 5.66, 6.5, 8]}
    for constants in ({}, length):
        for count in (64, 128):
            line = po.boundary(po.Parameters(vertex_count=count, **constants), ca, progress=False)
            print(constants, count, line.table["critical_symmetry"].round(3).tolist(), line.fit())
        line = po.boundary(
            po.Parameters(time_limit=100, **constants), {**sizes, **ca}, width=0.01, progress=False
        )
        print(line, line.fit().scatter)
        for speed in ("flow", "contact"):
            fit = line.fit(free_area=True, speed=speed)
            print(speed, fit, fit.scatter)


def onsets(folder: Path) -> None:
    """The conversion by vertex count, time step, edge stiffness and size."""
    aim = as_target(TARGET).onset()[0]
    changes = [{"vertex_count": n} for n in (48, 64, 96, 128, 192)]
    changes += [{"time_step": 1e-4}, {"edge_stiffness": 2.75}, {"edge_stiffness": 3.3}]
    changes += [{"size_ratio": ratio} for ratio in (2.5, 3.5, 4, 5, 6.5, 8)]
    for change in changes:
        model = po.Parameters(**change)
        bracket = head_on_onset(model)
        if bracket is None:
            print(change, "no onset")
            continue
        onset = float(np.sqrt(np.prod(bracket)))
        print(change, f"onset Ca_sim {onset:.3f}, c {aim / (onset * model.normalized_area):.4g}")


def search(folder: Path, name: str, target: str, free: tuple[str, ...], **options: object):
    """Calibrate, print what came of it, and return it."""
    found = po.calibrate(
        target, free, evaluations=45, out=made(folder / name), progress=False, **options
    )
    print(f"\n### {name}: {found!r}")
    for line in (found.start, found.best):
        print(line.objective, line.critical_symmetry.round(3).tolist(), line.status)
    print("evaluations", len(found.evaluations), "converged", found.converged, found.at_bound)
    print(found.sensitivity.round(3).to_string(index=False))
    print("conversion", found.conversion)
    return found


def describe(line: po.Boundary) -> None:
    """Print the critical symmetries, the slope and the daughters of a boundary."""
    stiffness = line.table.get("edge_stiffness", line.base.edge_stiffness)
    table = line.table.assign(edge_stiffness=stiffness)
    broke = line.runs[line.runs["broke"].fillna(False).astype(bool)]
    ratio = broke.groupby("point")["daughter_area_ratio"].median()
    for value, rows in table.groupby("edge_stiffness"):
        found = rows[rows["status"] == "found"]
        logs = np.log(found[["control_parameter", "critical_symmetry"]].astype(float))
        slope = np.polyfit(*logs.to_numpy().T, 1)[0] if len(found) > 2 else np.nan
        print(f"k_l {value:g}, N_v {line.base.vertex_count}: slope {slope:.3f}")
        print("  S_c", rows["critical_symmetry"].astype(float).round(3).tolist())
        print("  daughters A1/A2, median", ratio.reindex(rows["point"]).round(3).tolist())
        print("  status", rows["status"].value_counts().to_dict())


def made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


if __name__ == "__main__":
    main()
