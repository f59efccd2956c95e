"""Measure the numbers and draw the figures of the page "What the model explains".

    python examples/what_the_model_explains.py [PART ...]

prints what the named parts measure, all of them by default, each with springs and with front
tracking; seed 1. `readings` and `wetting` write a figure beside that, into the current folder. All
of it takes some ten minutes of one core, of which front tracking takes most.
"""

from __future__ import annotations

import math
import sys
import time
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

import pinchoff as po

if TYPE_CHECKING:
    import pandas as pd

MODELS = ("deformable-particle", "front-tracking")
COUNTS = {"deformable-particle": 1000, "front-tracking": 400}
# c at D0 = 481 µm with a fixed film: springs by the onset of break-up; front tracking, whose onset
# lies off the line, by the paper's 9.8e-5 over its speed at contact there, 0.97
FILM = {"deformable-particle": 7.1e-5, "front-tracking": 1.0e-4}
READINGS = [(c, speed) for c in ("constant", "fixed-film") for speed in ("far", "contact")]
SIZES = [2.5, 3.0, 4.0, 5.0, 5.66, 6.5, 8.0]


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


def reading_of(model: str, conversion: str, speed: str) -> dict[str, Any]:
    """Return the parameters that say what Ca stands for."""
    constant = FILM[model] if conversion == "fixed-film" else 9.8e-5
    return {"ca_conversion": conversion, "ca_speed": speed, "conversion_constant": constant}


def collided(model: str, conversion: str = "constant", speed: str = "far") -> pd.DataFrame:
    """Return the collisions that touched, in one reading."""
    reading = reading_of(model, conversion, speed)
    runs = [
        po.Parameters(model=model, follow_daughters=False, **reading, **drawn)
        for drawn in draws(COUNTS[model])
    ]
    table = po.simulate_many(runs, progress=False)
    return table[table["accepted"]]


def paper_says(table: pd.DataFrame) -> Any:
    """Return which collisions break by the paper's line of its simulations."""
    bk = po.breakup_number(
        table["capillary_number"],
        normalized_area=table["normalized_area"],
        symmetry=table["symmetry"],
        normalized_thickness=table["normalized_thickness"],
        line="paper-simulation",
    )
    return bk > 1


def readings() -> None:
    """The exponent p of Ã in each reading of Ca, and S against Ca Ã z̃ in two of them."""
    shown = {}
    for model in MODELS:
        for reading in READINGS:
            table, name = collided(model, *reading), ", ".join(reading)
            broke = table["broke"].astype(bool)
            free, held = po.fit_law(table, free="area"), po.fit_law(table)
            wrong = (held.breakup_number(table) > 1) != broke
            unfitted = paper_says(table) != broke
            p = free.estimates["epsilon_1"]
            print(
                f"{model}, {name}: p {p.value:.2f} ({p.low:.2f} to {p.high:.2f}), "
                f"w {held.w.value:.2f}, misclassified {wrong.mean():.1%}, "
                f"by the paper's line {unfitted.mean():.1%}, n {len(table)}"
            )
            shown[model, name] = table
    draw_readings(shown)


def draw_readings(tables: dict[tuple[str, str], pd.DataFrame]) -> None:
    """Write readings.png."""
    import matplotlib.pyplot as plt

    columns = ("constant, far", "fixed-film, contact")
    shared = {"sharex": True, "sharey": True, "layout": "constrained"}
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), **shared)
    for row, model in zip(axes, MODELS, strict=True):
        for axis, reading in zip(row, columns, strict=True):
            table = tables[model, reading]
            groups = ["capillary_number", "normalized_area", "normalized_thickness"]
            control = table[groups].prod(axis="columns")
            broke = table["broke"].astype(bool).to_numpy()
            for which, marker in ((broke, "o"), (~broke, "x")):
                dots = axis.scatter(
                    control[which],
                    table["symmetry"][which],
                    c=table["size_ratio"][which],
                    marker=marker,
                    s=18,
                    vmin=2,
                    vmax=8,
                    cmap="viridis",
                    label="broke" if marker == "o" else "did not",
                )
            line = np.geomspace(0.01, 1, 50)
            axis.plot(line, 0.089 * line**-0.72, "k", lw=1, label="paper's line, not fitted")
            axis.set(xscale="log", yscale="log", xlim=(0.008, 1), ylim=(0.05, 1.05))
            wrong = (paper_says(table) != broke).mean()
            axis.set_title(f"{model}\nCa {reading}: {wrong:.1%} on the wrong side", fontsize=10)
    for axis in axes[1]:
        axis.set_xlabel(r"$\mathrm{Ca}\,\tilde A\,\tilde z$")
    for axis in axes[:, 0]:
        axis.set_ylabel("symmetry $S$")
    marks = axes[0, 0].get_legend_handles_labels()
    figure.legend(*marks, loc="outside lower center", ncols=3, frameon=False)
    figure.colorbar(dots, ax=axes, label="$D_0/R$")
    figure.savefig("readings.png", dpi=130)


def radii() -> None:
    """The exponents of A and R where the pillar's radius varies, with z = R as in the model."""
    for model in MODELS:
        rng, rows = np.random.default_rng(1), []
        for drawn in draws(COUNTS[model]):
            radius = float(rng.choice([60.0, 85.0, 120.0]))
            diameter = drawn["size_ratio"] * radius
            capillary = FILM[model] * (481 / diameter) ** 2 * drawn["simulation_capillary_number"]
            scale = po.PhysicalScale(
                diameter_um=diameter,
                obstacle_radius_um=radius,
                thickness_um=radius,  # as in all of this model
                speed_mm_s=capillary * 20 / 48 * 1e3,
                viscosity_mPa_s=48.0,
                surface_tension_mN_m=20.0,
            )
            rows.append(
                po.Parameters.of_scale(
                    scale,
                    offset_um=drawn["offset"] * diameter,
                    model=model,
                    follow_daughters=False,
                    **reading_of(model, "fixed-film", "contact"),
                )
            )
        table = po.simulate_many(rows, progress=False)
        table = table[table["accepted"]]
        fit = po.fit_law(table, free="radius")
        area, radius_alone = fit.estimates["epsilon_1"], fit.estimates["epsilon_2"]
        low, high = radius_alone.low + 1, radius_alone.high + 1  # z = R, and z has the exponent 1
        print(
            f"{model}, R 60, 85, 120 µm, fixed film, contact: A^{area.value:.2f} "
            f"({area.low:.2f} to {area.high:.2f}), R^{radius_alone.value + 1:.2f} ({low:.2f} to "
            f"{high:.2f}) for R and z together, which is -2 in the paper's law; n {len(table)}"
        )


def exponents() -> None:
    """Exponent p of Ã from S_c alone, at several S_c: -dlnCa/dlnÃ along lines of equal S_c."""
    for model in MODELS:
        vary = {
            "size_ratio": SIZES,
            "simulation_capillary_number": np.geomspace(12, 128, 9).round(1).tolist(),
        }
        base = po.Parameters(model=model, time_limit=100)
        table = po.boundary(base, vary, width=0.01, progress=False).table
        table = table[table["status"] == "found"]
        for speed in ("far", "contact"):
            found = []
            for level in (0.85, 0.7, 0.55, 0.4, 0.3):
                points = [at_level(part, level, speed) for _, part in table.groupby("size_ratio")]
                area, ca = np.log([point for point in points if point]).T
                found.append(f"{level}: {-np.polyfit(area, ca, 1)[0]:.2f} ({len(area)} sizes)")
            print(f"{model}, p at S_c, {speed} speed: {', '.join(found)}")


def at_level(part: pd.DataFrame, level: float, speed: str) -> tuple[float, float] | None:
    """Return Ã and Ca_sim, times the speed, at which one size has this S_c."""
    part = part.sort_values("critical_symmetry")
    symmetry = np.log(part["critical_symmetry"].to_numpy())
    own = part["contact_speed"].to_numpy() if speed == "contact" else 1.0
    ca = np.log(part["simulation_capillary_number"].to_numpy() * own)
    if len(part) < 2 or not symmetry[0] <= math.log(level) <= symmetry[-1]:
        return None
    return part["normalized_area"].iloc[0], float(np.exp(np.interp(math.log(level), symmetry, ca)))


def springs() -> None:
    """The tension of the springs over line tension, and S_c of the two presets."""
    for preset in ("default", "soft-edges"):
        for ca in (20, 25, 40):
            run = po.simulate(
                po.Parameters.preset(
                    preset, simulation_capillary_number=ca, offset=0.002, follow_daughters=False
                )
            )
            print(f"{preset}, Ca_sim {ca}: {run.outcome}, springs {run.spring_tension_ratio:.2f} γ")


def areas() -> None:
    """How far the area leaves A_eq while a droplet is wrapped: from contact until it breaks."""
    for model in MODELS:
        for size, ca in ((5.66, 16), (5.66, 25), (2.0, 100)):
            for offset in (0.002, 0.02):
                run = po.simulate(
                    po.Parameters(
                        model=model,
                        size_ratio=size,
                        simulation_capillary_number=ca,
                        offset=offset,
                        follow_daughters=False,
                    ),
                    outlines=0.01,
                )
                measured = run.outlines.measure()
                whole = measured.groupby("time")["area"].transform("count") == 1
                area = measured["area"][whole & (measured["time"] >= run.contact_time)]
                off, swing = 1 - 4 / math.pi * area.min(), 4 / math.pi * (area.max() - area.min())
                print(
                    f"{model}, D0/R {size}, Ca_sim {ca}, offset {offset}: least area {off:.2%} "
                    f"below A_eq, between least and largest {swing:.2%}; {run.outcome}"
                )


def necks() -> None:
    """How many unbroken droplets have had a neck thinner than the experiment's thinnest."""
    for model in MODELS:
        table = collided(model)
        whole = table[~table["broke"].astype(bool)]
        thin = (whole["neck_thickness"] < 0.29).mean()
        print(f"{model}: {thin:.0%} of {len(whole)} unbroken have had a neck below 0.29 D0")


def heights() -> None:
    """The exponents of Ca and z: in the flow of a gap, and with a neck in z, at equal Ca_sim."""
    heights_over_radius = [0.5, 1.0, 2.0]
    for model in MODELS:
        base = po.Parameters(model=model, time_limit=100)
        radius = base.obstacle_radius
        capillary = {"simulation_capillary_number": [40.0, 64.0, 100.0]}
        rows = []
        for ratio in heights_over_radius:
            flow = po.flow.brinkman(radius, ratio * radius)
            line = po.boundary(base, capillary, flow=flow, width=0.005, progress=False).table
            rows += [(ratio, *row) for row in ca_and_symmetry(line)]
        report_height(f"{model}, flow of a gap z", rows)
        rows = []
        for ratio in (0.8, 1.0, 1.2):
            neck = 0.945 * ratio * radius  # of z = ratio R
            thick = base.replace(neck_thickness=neck)
            vary = {"simulation_capillary_number": [20.0, 32.0, 50.0]}
            line = po.boundary(thick, vary, width=0.005, progress=False).table
            rows += [(ratio, *row) for row in ca_and_symmetry(line)]
        report_height(f"{model}, neck 0.945 z", rows)


def ca_and_symmetry(table: pd.DataFrame) -> list[tuple[float, float]]:
    """Return Ca_sim and S_c of the points that were found."""
    found = table[table["status"] == "found"]
    return list(zip(found["simulation_capillary_number"], found["critical_symmetry"], strict=True))


def report_height(name: str, rows: list[tuple[float, float, float]]) -> None:
    """Fit ln S_c = a + β (ln Ca + q ln z) and print β and q."""
    height, ca, symmetry = np.log(rows).T
    design = np.column_stack((np.ones(len(ca)), ca, height))
    (_, beta, slope), residual, *_ = np.linalg.lstsq(design, symmetry, rcond=None)
    rms = math.sqrt(float(residual[0]) / len(ca)) if len(residual) else math.nan
    print(
        f"{name}: Ca^{beta:.2f} of S_c, z^{slope / beta:.2f} beside Ca, rms {rms:.1%}; "
        f"{[tuple(round(v, 3) for v in row) for row in rows]}"
    )


def costs() -> None:
    """CPU time of collisions in the flow of a gap over that in Stokes' flow."""
    for model in MODELS:
        runs = [po.Parameters(model=model, **drawn, follow_daughters=False) for drawn in draws(20)]
        runs = [run.replace(size_ratio=5.66) for run in runs]
        radius = runs[0].obstacle_radius
        flows = {"stokes": po.flow.stokes(radius), "gap": po.flow.brinkman(radius, radius)}
        ratios = []
        for _ in range(9):
            cost = {}
            for name, flow in flows.items():
                began = time.process_time()
                table = po.simulate_many(runs, flow=flow, threads=1, progress=False)
                cost[name] = (time.process_time() - began) / float(table["vertex_updates"].sum())
            ratios.append(cost["gap"] / cost["stokes"])
        print(f"{model}: a vertex costs {np.median(ratios):.2f} of one in Stokes' flow")


def wetting() -> None:
    """S_c against the contact angle of the pillar."""
    import matplotlib.pyplot as plt

    angles = [180.0, 165.0, 150.0, 135.0, 120.0, 105.0, 90.0, 75.0, 60.0]
    figure, axis = plt.subplots(figsize=(5.5, 4), layout="tight")
    for model, style in zip(MODELS, ("--", "-"), strict=True):
        vary = {"simulation_capillary_number": [25.0, 40.0], "contact_angle": angles}
        table = po.boundary(po.Parameters(model=model), vary, width=0.005, progress=False).table
        for k, (ca, part) in enumerate(table.groupby("simulation_capillary_number")):
            found = part.set_index("contact_angle")["critical_symmetry"].round(3)
            print(f"{model}, Ca_sim {ca}: S_c by angle {found.to_dict()}")
            axis.plot(
                part["contact_angle"],
                part["critical_symmetry"],
                style,
                marker="o",
                color=f"C{k}",
                label=f"{model}, Ca_sim = {ca:g}",
            )
    axis.set(xlabel="contact angle θ at the pillar (°)", ylabel="S_c", ylim=(0, 0.75))
    axis.legend(fontsize=8)
    figure.savefig("wetting.png", dpi=130)


def guards() -> None:
    """Random collisions with front tracking that guards stop, and with twice the vertices."""
    rng = np.random.default_rng(7)
    runs = [
        po.Parameters(
            model="front-tracking",
            vertex_count=int(rng.integers(48, 129)),
            size_ratio=float(rng.uniform(1.5, 14)),
            simulation_capillary_number=float(np.exp(rng.uniform(np.log(6), np.log(150)))),
            offset=float(rng.uniform(0, 0.6)),
        )
        for _ in range(1000)
    ]
    table = po.simulate_many(runs, progress=False)
    stopped = np.flatnonzero(table["outcome"] == "failed")
    sizes = [round(runs[k].size_ratio, 1) for k in stopped]
    print(f"{len(stopped)} of {len(runs)} stopped, at D0/R from {min(sizes)}")
    print(table["reject_reason"].iloc[stopped].str[:40].value_counts().to_dict())
    finer = [runs[k].replace(vertex_count=2 * runs[k].vertex_count) for k in stopped]
    again = po.simulate_many(finer, progress=False)["outcome"].value_counts()
    print(f"with twice the vertices: {again[again > 0].to_dict()}")


PARTS = {
    part.__name__: part
    for part in (
        readings, radii, exponents, springs, areas, necks, heights, costs, wetting, guards,
    )
}  # fmt: skip

if __name__ == "__main__":
    warnings.simplefilter("ignore")
    for wanted in sys.argv[1:] or PARTS:
        print(f"# {wanted}", flush=True)
        PARTS[wanted]()
