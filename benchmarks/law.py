"""Speed and memory of the law's fit, beside statsmodels' logistic regression in the same run.

Usage: python benchmarks/law.py [--quick]. Absolute times are those of this machine as it is; the
ratios are what to compare.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import time
import warnings
from collections.abc import Callable

import numpy as np
import statsmodels.api as sm

import pinchoff as po
from pinchoff.collisions.importing import import_collisions


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer repeats, no million rows")
    quick = parser.parse_args().quick
    table = po.virtual_experiment(1, symmetry_noise=0)
    po.fit_law(table)  # imports
    report(table, repeats=3 if quick else 15, parts=not quick)
    print(f"largest memory of the process: {peak_mib():.0f} MiB, statsmodels with it")
    if not quick:
        report(po.virtual_experiment(2, 1_000_000, symmetry_noise=0), repeats=3, parts=False)
        print(f"largest memory of the process: {peak_mib():.0f} MiB")


def report(table, repeats: int, parts: bool) -> None:
    print(f"\n{len(table):,} rows")
    ours = timed("fit_law: check, fit, delta intervals", lambda: estimates(table), repeats)
    checked = import_collisions(table)
    fit = timed("  of that fit and intervals", lambda: estimates(checked), repeats)
    design, broke = logistic(checked.table)
    theirs = timed(
        "statsmodels Logit.fit of the same rows", lambda: library(design, broke), repeats
    )
    print(
        f"fit and intervals / statsmodels: {fit / theirs:.2f}; with the checks {ours / theirs:.2f}"
    )
    if parts:
        law = po.fit_law(checked)
        timed("bootstrap, 100 parts of half", lambda: law.bootstrap(samples=100), repeats)
        timed("profile likelihood of α, β, w", law.profile, repeats)
        free = po.fit_law(checked, free=("area", "thickness", "viscosity"))
        timed("profile likelihood of seven numbers", free.profile, repeats)
        timed("fit with noise in S", lambda: estimates(checked, symmetry_noise=0.088), repeats)


def estimates(table, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return po.fit_law(table, **options).estimates


def library(design, broke):
    return sm.Logit(broke, design).fit(disp=False).params


def logistic(table):
    used = table[table["symmetry"] > 0]
    forcing = used["capillary_number"] * used["normalized_area"] * used["normalized_thickness"]
    logs = np.log(np.stack([forcing, used["symmetry"]], axis=1))
    return sm.add_constant(logs), used["broke"].to_numpy(dtype=float)


def timed(name: str, work: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        started = time.perf_counter()
        work()
        times.append(time.perf_counter() - started)
    middle = statistics.median(times)
    print(f"{name:42} {1e3 * middle:9.1f} ms ({1e3 * min(times):.1f} to {1e3 * max(times):.1f})")
    return middle


def peak_mib() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
