"""Remake the numbers of docs/law.md: coverage of intervals, the bootstrap's spread, noise in S.

Usage: python law_study.py [REPEATS]. Each repeat is a virtual experiment of the paper's size;
200 of them take about five minutes.
"""

import sys
import time

import numpy as np
from scipy.stats import binomtest

import pinchoff as po
from pinchoff.support.paper_constants import SYMMETRY_NOISE

FREE = ("area", "thickness", "viscosity")
TRUTH = {
    "alpha": 0.083,
    "beta": -0.74,
    "w": 0.098,
    "epsilon_1": 1.0,
    "epsilon_2": -3.0,
    "epsilon_3": 1.0,
    "epsilon_mu": 1.0,
}


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    started = time.perf_counter()
    for part in (coverage, free_coverage, noise):
        print(f"\n## {part.__name__}, {repeats} virtual experiments")
        part(range(1000, 1000 + repeats))
        print(f"({time.perf_counter() - started:.0f} s so far)", flush=True)


def coverage(seeds: range) -> None:
    """α, β, w: three kinds of interval, their coverage, and the spread of the bootstrap."""
    found, values, spreads = {}, [], []
    for seed in seeds:
        fit = po.fit_law(po.virtual_experiment(seed, symmetry_noise=0))
        parts = fit.bootstrap(seed=seed)
        note(found, "delta", fit.delta())
        note(found, "profile", fit.profile())
        note(found, "bootstrap", parts.estimates)
        values.append([fit.estimates[name].value for name in ("alpha", "beta", "w")])
        spreads.append([parts.spread[name] for name in ("alpha", "beta", "w")])
    report(found)
    print("mean of the fits", np.mean(values, axis=0), "standard deviation", np.std(values, axis=0))
    print("mean spread of half of the collisions", np.mean(spreads, axis=0), "paper .006 .03 .006")


def free_coverage(seeds: range) -> None:
    """Four exponents free too."""
    found = {}
    for seed in seeds:
        fit = po.fit_law(po.virtual_experiment(seed, symmetry_noise=0), free=FREE)
        note(found, "delta", fit.delta())
        note(found, "profile", fit.profile())
    report(found)


def noise(seeds: range) -> None:
    """Errors of 0.088 in S: ignored, and accounted for."""
    found, means = {}, {"ignored": [], "accounted for": []}
    for seed in seeds:
        table = po.virtual_experiment(seed, symmetry_noise=SYMMETRY_NOISE)
        for name, error in (("ignored", 0.0), ("accounted for", SYMMETRY_NOISE)):
            fit = po.fit_law(table, symmetry_noise=error)
            note(found, name, fit.estimates)
            means[name].append([fit.estimates[key].value for key in ("alpha", "beta", "w")])
    report(found)
    for name, values in means.items():
        error = np.std(values, axis=0, ddof=1) / np.sqrt(len(values))
        print(name, "mean", np.mean(values, axis=0).round(4), "±", error.round(4))


def note(found: dict, kind: str, estimates: dict) -> None:
    for name, estimate in estimates.items():
        inside = estimate.low <= TRUTH[name] <= estimate.high
        found.setdefault((kind, name), []).append(inside)


def report(found: dict) -> None:
    for (kind, name), inside in found.items():
        count, total = sum(inside), len(inside)
        p = binomtest(count, total, 0.95).pvalue
        print(f"{kind:14} {name:12} {count}/{total} = {count / total:.1%}, binomial p {p:.2f}")


if __name__ == "__main__":
    main()
