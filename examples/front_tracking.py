"""The paper's model beside its limit without springs: lines, sizes, daughters and necks.

Writes front_line.png, front_sizes.png and front_daughters.png into the folder it runs in, and
prints the numbers of docs/front_tracking.md; takes about two minutes on two cores.
"""

import math
import time

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.ticker import FixedLocator, NullFormatter

import pinchoff as po
from pinchoff.collisions.circle_segments import area_ratio_bound
from pinchoff.figures import style

MODELS = {"springs": "deformable-particle", "line tension alone": "front-tracking"}
CAPILLARY = [12, 16, 20, 25, 32, 40, 50, 64, 80]
SIZES = [2.5, 3.2, 4.0, 5.0, 5.66, 6.5, 8.0]
PAPER = (0.089, -0.72)  # [paper, the line of its simulations]


def control(rows: pd.DataFrame) -> pd.Series:
    return rows["capillary_number"] * rows["normalized_area"]


def lines() -> dict[str, po.Boundary]:
    """S_c over Ca_sim at the paper's size, with the printed conversion and nothing fitted."""
    found = {}
    for name, model in MODELS.items():
        base = po.Parameters(model=model)
        found[name] = po.boundary(
            base, {"simulation_capillary_number": CAPILLARY}, width=0.002, progress=False
        )
        rows = found[name].found
        rows = rows[rows["critical_symmetry"] < 0.95]
        beta, start = np.polyfit(np.log(control(rows)), np.log(rows["critical_symmetry"]), 1)
        away = np.log(rows["critical_symmetry"] / (PAPER[0] * control(rows) ** PAPER[1]))
        print(f"{name}: S_c {rows['critical_symmetry'].round(4).tolist()}")
        print(f"  alpha {math.exp(start):.4f}, beta {beta:.3f}, rms from the paper's line", end=" ")
        print(f"{np.sqrt(np.mean(away**2)):.3f}")
    return found


def sizes() -> dict[str, po.Boundary]:
    """Lines over D0/R, the law with a free exponent of the area, and how far one line serves."""
    found = {}
    for name, model in MODELS.items():
        vary = {"size_ratio": SIZES, "simulation_capillary_number": CAPILLARY}
        found[name] = po.boundary(po.Parameters(model=model), vary, progress=False)
        for speed in ("flow", "contact"):
            print(name, speed, found[name].fit(free_area=True, speed=speed))
        print(name, found[name].table["status"].value_counts().to_dict())
    return found


def collisions(model: str, count: int = 3000) -> pd.DataFrame:
    """Random collisions near and above the line, at the sizes of the paper."""
    rng = np.random.default_rng(5)
    runs = [
        po.Parameters(
            model=model,
            size_ratio=float(rng.uniform(4, 8)),
            simulation_capillary_number=float(np.exp(rng.uniform(math.log(16), math.log(90)))),
            offset=float(rng.uniform(0, 0.25)),
            follow_daughters=False,
        )
        for _ in range(count)
    ]
    return po.simulate_many(runs, progress=False)


def logarithmic(axes: plt.Axes) -> None:
    axes.set(xscale="log", yscale="log", xlabel=r"$Ca\,\tilde A\,\tilde z$")
    for axis, ticks in ((axes.xaxis, (0.02, 0.05, 0.1, 0.2, 0.4)), (axes.yaxis, (0.3, 0.5, 1))):
        axis.set_major_locator(FixedLocator(ticks))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())


def draw_lines(found: dict[str, po.Boundary]) -> None:
    with style.journal_style():
        _, axes = plt.subplots(figsize=(style.ONE_COLUMN, 2.6), layout="constrained")
        x = np.geomspace(0.027, 0.22, 50)
        axes.plot(x, PAPER[0] * x ** PAPER[1], "k--", label="the paper's line")
        for (name, line), mark in zip(found.items(), style.MARKERS, strict=False):
            axes.plot(control(line.found), line.found["critical_symmetry"], mark, label=name, ms=4)
        axes.set_ylabel("$S_c$")
        logarithmic(axes)
        axes.legend()
        style.save("front_line.png", axes)


def draw_sizes(found: dict[str, po.Boundary]) -> None:
    with style.journal_style():
        _, row = plt.subplots(
            1, 2, figsize=(style.TWO_COLUMNS, 2.6), sharey=True, layout="constrained"
        )
        for (name, line), axes in zip(found.items(), row, strict=True):
            for size, rows in line.found.groupby("size_ratio"):
                axes.plot(control(rows), rows["critical_symmetry"], "o-", ms=2, label=f"{size:g}")
            axes.set_title(name)
            logarithmic(axes)
        row[0].set_ylabel("$S_c$")
        row[1].legend(title="$D_0/R$")
        style.save("front_sizes.png", row[0])


def draw_daughters(tables: dict[str, pd.DataFrame]) -> None:
    with style.journal_style():
        _, row = plt.subplots(
            1, 2, figsize=(style.TWO_COLUMNS, 2.6), sharey=True, layout="constrained"
        )
        s = np.linspace(0, 1, 100)
        for (name, table), axes in zip(tables.items(), row, strict=True):
            broke = table[table["outcome"] == "broke"]
            axes.scatter(
                broke["symmetry"], broke["daughter_area_ratio"], c=broke["capillary_number"], s=2
            )
            axes.plot(s, [area_ratio_bound(value) for value in s], "k-", lw=0.8, label="S/(2 - S)")
            axes.set(xlabel="symmetry S", title=name, xlim=(0.2, 1), ylim=(0, 1))
        row[0].set_ylabel("ratio of the daughters' areas")
        row[0].legend()
        style.save("front_daughters.png", row[0])


def say_daughters_and_necks(name: str, table: pd.DataFrame) -> None:
    broke = table[table["outcome"] == "broke"]
    part = broke["daughter_area_ratio"] / (broke["symmetry"] / (2 - broke["symmetry"]))
    unbroken = table[(table["outcome"] == "slipped") & table["minimum_neck"].notna()]
    print(f"{name}: {len(broke)} broke; ratio over S/(2-S): median {part.median():.2f}, ", end="")
    print(f"10 % to 90 % {part.quantile(0.1):.2f} to {part.quantile(0.9):.2f}")
    strong = broke["capillary_number"] > 0.004
    weak = broke["capillary_number"] < 0.003
    print(f"  Ca above 0.004: {part[strong].median():.2f}, below 0.003: {part[weak].median():.2f}")
    print(f"  unbroken with a neck below 0.29 D0: {(unbroken['minimum_neck'] < 0.29).mean():.2f}")
    print(f"  stopped by guards: {(table['outcome'] == 'failed').sum()} of {len(table)}")


def main() -> None:
    start = time.perf_counter()
    draw_lines(lines())
    draw_sizes(sizes())
    tables = {name: collisions(model) for name, model in MODELS.items()}
    for name, table in tables.items():
        say_daughters_and_necks(name, table)
    draw_daughters(tables)
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
