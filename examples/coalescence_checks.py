"""Figures and numbers of docs/coalescence.md: a head-on pair, its clock, and K.

    python examples/coalescence_checks.py [folder for the figures]

Takes about ten seconds on one core.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter

import pinchoff as po
from pinchoff.figures import style
from pinchoff.figures.scene import smooth_outline
from pinchoff.studies.head_on import head_on_pair
from pinchoff.support import palette

OBSERVED = 0.005
VERTICES = 64


def model(ca: float, vertices: int = VERTICES) -> po.Parameters:
    return po.Parameters(simulation_capillary_number=ca / 9.8e-5, vertex_count=vertices)


def pair(ca: float, coalescence: po.Coalescence) -> tuple[Any, list[tuple[float, Any]]]:
    frames: list[tuple[float, Any]] = []
    run = head_on_pair(
        model(ca), coalescence, interval=0.05, on_frame=lambda t, d: frames.append((t, d))
    )
    return run, frames


def sequence(folder: Path, found: po.Drainage) -> None:
    """Draw a pair below the critical number, which merges, and one above, which parts."""
    with style.journal_style():
        figure = Figure(figsize=(style.TWO_COLUMNS, 2.3), layout="constrained")
        rows = figure.subplots(2, 6, sharex=True, sharey=True)
        for axes, ca in zip(rows, (0.9 * OBSERVED, 1.2 * OBSERVED), strict=True):
            run, frames = pair(ca, found.coalescence)
            ends = run.events[run.events["kind"].isin(("merge", "parted"))]
            event = ends.iloc[0]
            kind, end, clock = event[["kind", "time", "clock"]]
            print(f"Ca = {ca:.4g}: {kind} at t = {end:.3f}, C = {clock:.3f}")
            for panel, after in zip(axes, (-3.0, -1.0, -0.05, 0.05, 0.2, 0.8), strict=True):
                time, droplets = min(frames, key=lambda f: abs(f[0] - end - after))
                middle = np.mean([d[2].mean(axis=0)[0] for d in droplets])
                for d in droplets:
                    shape = smooth_outline(d[2]) - np.array([middle, 0.0])
                    panel.fill(*shape.T, fc=palette.DROPLET, ec=palette.DROPLET_RIM, lw=0.7)
                panel.set(aspect="equal", xticks=[], yticks=[], xlim=(-1.5, 1.5), ylim=(-0.8, 0.8))
                panel.set_title(f"{time - end:+.2f} $t_0$", fontsize=7)
            axes[0].set_ylabel(f"Ca = {ca:.4g}")
        figure.savefig(folder / "coalescence_pair.png", dpi=150)


def clocks(folder: Path, found: po.Drainage) -> None:
    """Draw the clock at parting against Ca, and K against what it is fitted with."""
    numbers = OBSERVED * np.geomspace(0.3, 2.0, 12)
    never = po.Coalescence(1e9)
    with style.journal_style():
        figure = Figure(figsize=(style.TWO_COLUMNS, 2.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        for vertices, color in ((32, palette.BLUE), (64, palette.BLACK), (128, palette.VERMILION)):
            clock = []
            for ca in numbers:
                run = head_on_pair(model(float(ca), vertices), never)
                parted = run.events[run.events["kind"] == "parted"]
                clock.append(1e9 * parted["clock"].sum() / found.drainage)
            left.plot(numbers, clock, "o-", ms=2, lw=0.8, color=color, label=f"$N_v$ = {vertices}")
        left.axhline(1.0, color=palette.INK, lw=0.8, ls=":")
        left.set(xscale="log", yscale="log", xlabel="Ca", ylabel="clock $C$ at parting")
        left.set_title(f"K = {found.drainage:.3g}")
        for axis, ticks in ((left.xaxis, (0.002, 0.005, 0.01)), (left.yaxis, (0.5, 1, 2, 5))):
            axis.set_major_locator(FixedLocator(ticks))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
        left.legend()
        spacings = np.linspace(1.15, 1.6, 8)
        for widening, color in (
            (1.9, palette.BLUE),
            (2.0, palette.BLACK),
            (2.5, palette.VERMILION),
        ):
            k = [
                po.calibrate_drainage(
                    OBSERVED, model(OBSERVED), widening=widening, spacing=float(one)
                ).drainage
                for one in spacings
            ]
            print(f"widening {widening}: K from {min(k):.3g} to {max(k):.3g}")
            right.plot(spacings, k, "o-", ms=2, lw=0.8, color=color, label=f"widening {widening:g}")
        right.set(
            xlabel="spacing of the pair ($D_0$)", ylabel="K fitted to Ca* = 0.005", ylim=(0, 0.5)
        )
        right.legend()
        figure.savefig(folder / "coalescence_clock.png", dpi=150)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    for vertices in (32, 64, 128):
        one = po.calibrate_drainage(OBSERVED, model(OBSERVED, vertices))
        print(
            f"N_v = {vertices}: K = {one.drainage:.4f}, contact of {one.contact_time:.2f} t0, "
            f"L at most {one.facing_length:.2f} D0"
        )
    found = po.calibrate_drainage(OBSERVED, model(OBSERVED))
    sequence(folder, found)
    clocks(folder, found)


if __name__ == "__main__":
    main()
