"""From one pillar alone to an array: where does a droplet break, by the distance of the pillars?

One droplet of 1 D0 meets a pillar of 0.3 D0 in a chamber of 0.5 D0, at Ca_sim = 60. Prints Bk on
the separating line for every step from the paper's isolated collision to the array, and writes
pillar_distance.png into the folder it runs in; takes about a minute.
"""

from __future__ import annotations

import math
import warnings

import matplotlib.pyplot as plt
import numpy as np

import pinchoff as po
from pinchoff.figures import style
from pinchoff.support.palette import BLACK, BLUE, VERMILION

RADIUS, THICKNESS, CAPILLARY, VERTICES = 0.3, 0.5, 60.0, 64
GAPS = (0.4, 0.7, 1.0, 1.5, 2.0, 4.0, 8.0)
PARAMETERS = po.Parameters(
    model="front-tracking",
    size_ratio=1 / RADIUS,
    simulation_capillary_number=CAPILLARY,
    vertex_count=VERTICES,
    time_limit=30,
)


def number(symmetry, speed=1.0, radius=RADIUS):
    """Return Bk of a droplet of 1 D0."""
    area = math.pi / 4 / radius**2
    return po.breakup_number(9.8e-5 * CAPILLARY * speed, normalized_area=area, symmetry=symmetry)


def alone(flow, radius=RADIUS):
    """Return S_c and the speed at contact of a pillar alone."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        base = PARAMETERS.replace(size_ratio=1 / radius)
        found = po.boundary(base, flow=flow, progress=False).table.iloc[0]
    return found["critical_symmetry"], found["contact_speed"]


def in_array(array):
    """Return S_c and the speed at contact on the first pillar of an array, by bisection."""
    flow = po.chamber.array_flow(array, thickness=THICKNESS)
    width = array.width
    sampled = flow.sampled(pad=max(2.5, 1.01 * width))
    shifts = [[0, k * width, 0] for k in (-2, -1, 0, 1, 2)]
    pillars = np.concatenate([array.circles + shift for shift in shifts])
    first = array.circles[np.argmin(array.circles[:, 0])]
    start = first[0] - RADIUS - 1.5
    low, high, ends = 0.0, min(0.5 * width, 0.8), {}
    for _ in range(9):
        middle = 0.5 * (low + high)
        droplet = [[start, first[1] + middle, 1.0]]
        run = po.simulate(PARAMETERS, flow=sampled, obstacles=pillars, droplets=droplet)
        ends[run.outcome == "broke"] = run
        low, high = (middle, high) if run.outcome == "broke" else (low, middle)
    if len(ends) < 2:
        return math.nan, math.nan
    return 0.5 * (ends[True].symmetry + ends[False].symmetry), ends[True].contact_speed


def main() -> None:
    """Print the steps and draw them."""
    steps = [
        ("paper's flow and size, D0/R 5.66", alone(None, 1 / 5.66), 1 / 5.66),
        ("D0/R 3.33", alone(None), RADIUS),
        ("and the chamber's flow", alone(po.flow.brinkman(RADIUS, THICKNESS)), RADIUS),
    ]
    for name, (symmetry, speed), radius in steps:
        print(
            f"{name:34s} S_c {symmetry:.3f}, Bk with v_f∞ {number(symmetry, 1, radius):.3f}, with "
            f"the speed at contact ({speed:.2f}) {number(symmetry, speed, radius):.3f}"
        )
    symmetry, speed = steps[-1][1]
    with style.journal_style():
        figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 2.7), layout="constrained")
        for columns, marker, said in ((1, "o", "one column"), (3, "s", "square lattice")):
            rows = []
            for gap in GAPS if columns == 1 else GAPS[:5]:
                lattice = po.arrays.square(rows=1, columns=columns, radius=RADIUS, gap=gap)
                found = in_array(lattice.with_margins(3, 3))
                rows.append((gap, number(found[0]), number(*found)))
                print(f"{said}, gap {gap:g}: S_c {found[0]:.3f}, speed {found[1]:.3f}, Bk", end=" ")
                print(f"{rows[-1][1]:.3f} with v_f∞, {rows[-1][2]:.3f} with it", flush=True)
            gap, far, contact = np.array(rows).T
            style_of = {"marker": marker, "ms": 3.5, "lw": 0.8}
            axes.plot(
                gap, far, color=VERMILION, mfc="none", label=f"{said}, $v_{{f∞}}$", **style_of
            )
            axes.plot(gap, contact, color=BLACK, label=f"{said}, at contact", **style_of)
        axes.axhline(number(symmetry), color=VERMILION, lw=0.8, ls="--")
        axes.axhline(number(symmetry, speed), color=BLUE, lw=0.8, ls="--", label="a pillar alone")
        axes.set(xscale="log", xlabel="gap between pillars ($D_0$)", ylabel="Bk where it breaks")
        axes.set_xticks(GAPS, [f"{gap:g}" for gap in GAPS])
        axes.minorticks_off()
        axes.set_ylim(0, 0.4)
        axes.legend(loc="lower right")
        figure.savefig("pillar_distance.png", dpi=300)


if __name__ == "__main__":
    main()
