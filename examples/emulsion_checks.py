"""Does what comes of an emulsion depend on resolution, time step, size of the array, or the start?

And what do gaps do to sizes, and disorder to daughters? Prints a table for each and writes
emulsion_checks.png into the folder it runs in; some minutes on two cores. Names of checks as
arguments run these alone.
"""

from __future__ import annotations

import itertools
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from pinchoff.chamber.emulsion_design import EmulsionDesign
from pinchoff.figures import style

INLET = {
    "time": 100,
    "smallest_breaking": 0.2,
    "seed": 1,
    "outlines": False,
    "parameters": {"simulation_capillary_number": 60, "vertex_count": 64},
    "array": {
        "kind": "staggered",
        **{"rows": 4, "columns": 8, "radius": 0.3, "gap": 1.0, "before": 3, "behind": 2},
    },
    "flow": {"thickness": 0.5},
    "inlet": {"area_fraction": 0.2, "diameters": [1.0, 1.3]},
}
DISORDERED = {
    "kind": "disordered",
    **{"length": 10, "width": 8, "radius": 0.3, "porosity": 0.85, "least_gap": 0.4, "seed": 2},
}


def changed(table, **changes):
    """Return the design with keys of its tables changed, as ``array_gap=0.5``."""
    new = {name: dict(v) if isinstance(v, dict) else v for name, v in table.items()}
    for name, value in changes.items():
        place, _, key = name.partition("_")
        if place in new and key and isinstance(new[place], dict):
            new[place][key] = value
        else:
            new[name] = value
    return new


def run(config):
    """Return run and study."""
    design = EmulsionDesign.from_config(config)
    flow = design.flow()
    with tempfile.TemporaryDirectory() as folder:
        result = design.run(flow, Path(folder))
        return result.balance, result.events, design.study(result, flow)


def tried(name, config):
    """Run, print a row of a table, and return the sizes."""
    balance, _, study = run(config)
    retired = 100 * balance["area_retired"] / balance["area_in"]
    started = balance["entered"] + balance["start"]
    print(
        f"{name:24s} {started:5.0f} droplets  mean {study.mean_diameter}  "
        f"by area {study.weighted_diameter}  break-ups/t0 {study.rates['breakup']}  "
        f"retired {balance['retired']} with {retired:.2g} % of the area",
        flush=True,
    )
    return study


def convergence():
    """Vertices, and the time step."""
    for count in (48, 64, 96, 128):
        tried(f"{count} vertices", changed(INLET, parameters_vertex_count=count))
    for step in (2e-3, 1e-3, 5e-4):
        tried(f"time step {step:g}", changed(INLET, parameters_time_step=step))


def width():
    """Rows of the array: is the cell wide enough?"""
    for rows in (2, 4, 8):
        tried(f"{rows} rows", changed(INLET, array_rows=rows, time=100 * 4 / rows))


def length():
    """Columns of the array: how sizes fall on the way."""
    for columns in (4, 8, 16, 32):
        tried(f"{columns} columns", changed(INLET, array_columns=columns, time=60 + 2 * columns))


def starts():
    """A cell that repeats itself, from droplets of several sizes."""
    base = {name: value for name, value in INLET.items() if name != "inlet"}
    for size in (0.6, 0.8, 1.0, 1.2):
        config = {**base, "array": DISORDERED, "time": 80, "droplets": {"area_fraction": 0.15}}
        tried(f"from {size} D0", changed(config, droplets_diameters=size))


def gaps(axes):
    """Sizes behind a lattice against its gap."""
    found = []
    for gap in (0.5, 0.7, 1.0, 1.4, 2.0):
        study = tried(f"gap {gap}", changed(INLET, array_gap=gap, array_columns=16, time=90))
        found.append((gap, *study.weighted_diameter, *study.mean_diameter))
    gap, weighted, error, mean, mean_error = np.array(found).T
    axes.errorbar(gap, weighted, np.nan_to_num(error), fmt="o-", ms=3, label="weighted by area")
    axes.errorbar(gap, mean, np.nan_to_num(mean_error), fmt="s-", ms=3, label="mean")
    axes.set(xlabel="gap ($D_0$)", ylabel="diameter ($D_0$)")
    axes.set_ylim(bottom=0)
    axes.legend()


def daughters(axes):
    """Daughters in a disordered array, by the mother's diameter over the mean nearest gap."""
    config = changed({**INLET, "array": {**DISORDERED, "before": 3, "behind": 2}}, time=150)
    design = EmulsionDesign.from_config(config)
    gap = float(np.mean(design.array.gaps))
    _, events, _ = run(config)
    broke = events[events["kind"].astype(str) == "breakup"]
    mother = np.sqrt(4 / np.pi * broke["area"].to_numpy()) / gap
    areas = np.sort(broke[["area_1", "area_2"]].to_numpy(), axis=1)
    ratio = areas[:, 0] / areas[:, 1]
    print(f"mean gap to the nearest pillar {gap:.3f} D0, {len(ratio)} break-ups")
    edges = [0.0, 1.0, 1.5, 2.0, 2.5, 5.0]
    for low, high in itertools.pairwise(edges):
        here = ratio[(mother >= low) & (mother < high)]
        if len(here):
            quarters = np.quantile(here, [0.25, 0.5, 0.75]).round(2).tolist()
            print(f"D/gap {low} to {high}: {len(here)} break-ups, ratio quartiles {quarters}")
    axes.plot(mother, ratio, ".", ms=2, alpha=0.6)
    axes.set(xlabel="mother's diameter / mean gap", ylabel="smaller / larger daughter")
    axes.set_ylim(0, 1)


def main():
    """Run the checks that are named, or all."""
    wanted = sys.argv[1:]
    for check in (convergence, width, length, starts):
        if not wanted or check.__name__ in wanted:
            print(f"\n{check.__doc__}")
            check()
    if not wanted or {"gaps", "daughters"} & set(wanted):
        with style.journal_style():
            figure, axes = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.6))
            for check, place in zip((gaps, daughters), axes, strict=True):
                print(f"\n{check.__doc__}")
                check(place)
            figure.tight_layout()
            figure.savefig("emulsion_checks.png", dpi=200)


if __name__ == "__main__":
    main()
