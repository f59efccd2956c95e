"""Measure the numbers of the page "What the model explains": springs and front tracking.

    python examples/what_the_model_explains.py

prints each of them. Some 2,000 collisions; a minute of one core, seed 1.
"""

from __future__ import annotations

import warnings

import numpy as np

import pinchoff as po

READINGS = [(c, s) for c in ("constant", "fixed-film") for s in ("far", "contact")]


def draws(count: int, seed: int = 1) -> list[dict[str, float]]:
    """Return sizes from 2 to 8, Ca_sim from 8 to 90 and offsets, at random."""
    rng = np.random.default_rng(seed)
    return [
        {
            "size_ratio": rng.uniform(2, 8),
            "simulation_capillary_number": float(np.exp(rng.uniform(np.log(8), np.log(90)))),
            "offset": rng.uniform(0.01, 0.5),
        }
        for _ in range(count)
    ]


def readings(model: str, count: int) -> None:
    """Print the free exponent p of Ã, w and the misclassified share at p = 1, for each reading."""
    for conversion, speed in READINGS:
        reading = {
            "ca_conversion": conversion,
            "ca_speed": speed,
            "conversion_constant": 7.1e-5 if conversion == "fixed-film" else 9.8e-5,
        }
        runs = [
            po.Parameters(model=model, follow_daughters=False, **reading, **d) for d in draws(count)
        ]
        table = po.simulate_many(runs, progress=False)
        table = table[table["accepted"]]
        free, held = po.fit_law(table, free="area"), po.fit_law(table)
        wrong = (held.breakup_number(table) > 1) != table["broke"].astype(bool)
        paper = po.breakup_number(
            table["capillary_number"],
            normalized_area=table["normalized_area"],
            symmetry=table["symmetry"],
            line="paper-simulation",
        )
        unfitted = (paper > 1) != table["broke"].astype(bool)
        p = free.estimates["epsilon_1"]
        print(
            f"{model}, {conversion}, {speed}: p {p.value:.2f} ({p.low:.2f} to {p.high:.2f}), "
            f"w {held.w.value:.2f}, misclassified {wrong.mean():.1%}, "
            f"by the paper's line {unfitted.mean():.1%}, n {len(table)}"
        )


def springs() -> None:
    """Print the tension of the springs over line tension, and how far the area leaves A_eq."""
    for preset in ("default", "soft-edges"):
        for ca in (20, 25, 40):
            run = po.simulate(
                po.Parameters.preset(
                    preset, simulation_capillary_number=ca, offset=0.002, follow_daughters=False
                )
            )
            print(f"{preset}, Ca_sim {ca}: {run.outcome}, springs {run.spring_tension_ratio:.2f} γ")


def flows() -> None:
    """Print S_c in Stokes' flow and in that of a gap, with springs and with front tracking."""
    vary = {"simulation_capillary_number": [40, 64, 100, 160]}
    for model in ("deformable-particle", "front-tracking"):
        base = po.Parameters(model=model)
        radius = base.obstacle_radius
        for name, flow in (("Stokes", None), ("gap", po.flow.brinkman(radius, radius))):
            line = po.boundary(base, vary, flow=flow, width=0.01, progress=False)
            print(f"{model}, {name}: S_c {line.table['critical_symmetry'].round(3).tolist()}")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    springs()
    readings("deformable-particle", 800)
    flows()
    readings("front-tracking", 250)
