"""``pinchoff boundary``: the separating line, its fit and its figures."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.assignments import read_list, read_pairs
from pinchoff.cli.folders import Results, remove_results
from pinchoff.cli.model_options import ModelFileOptions, set_option
from pinchoff.cli.options import flag_of, grouped, named_as_options, option
from pinchoff.cli.output import print_table
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted
from pinchoff.support.records import write_json

if TYPE_CHECKING:
    from pinchoff.studies.boundary.line_fit import LineFit
    from pinchoff.studies.boundary.search import Boundary

TABLE = "boundary.parquet"
TABLE_TEXT = "boundary.csv"
RUNS = "runs.parquet"
FIT = "fit.json"
LINE = "separating_line.png"
COLLAPSE = "area_collapse.png"
APPENDIX_C = "appendix_c.png"
_FILES = (TABLE, TABLE_TEXT, RUNS, FIT, LINE, COLLAPSE, APPENDIX_C)

_PAPER_RANGE = "16,20,25,32,40,50,64,80"
_SYMBOLS = {"simulation_capillary_number": "Ca_sim", "size_ratio": "D0/R", "line_tension": "γ̃"}
_OWN = ("simulation_capillary_number", "size_ratio")  # parameters with an option of their own
_POINTS = "Points"


@grouped(out="boundary")
def boundary(
    model: ModelFileOptions,
    *,
    capillary: Annotated[str, option("LIST", "Values of Ca_sim", panel=_POINTS)] = _PAPER_RANGE,
    size_ratio: Annotated[
        str | None, option("LIST", "Values of D0/R", default="5.66", panel=_POINTS)
    ] = None,
    constants: Annotated[
        list[str] | None,
        set_option("NAME=LIST", "Values of any other parameter, as line_tension=60,190", _POINTS),
    ] = None,
    width: Annotated[
        float, option("NUMBER", "Largest width of a bracket, in S", panel=_POINTS)
    ] = 0.005,
    scan: Annotated[
        int, option("INTEGER", "Intervals of the scan over the offset", panel=_POINTS)
    ] = 24,
    results: Results,
) -> None:
    r"""Find the symmetry at which droplets begin to break.

    The points are all combinations of the lists; at each the droplet's offset
    is varied. Without options it is the paper's separating line. DIR gets

    - boundary.parquet, boundary.csv: a bracket for each point, and what was
      found there
    - runs.parquet: every collision
    - fit.json: α and β with their intervals
    - separating_line.png: runs and lines
    - area_collapse.png, with several D0/R: how far one line serves them
    - appendix_c.png, with several line_tension: the collapse with μ̃/γ̃

    [bold]Examples[/bold]

    pinchoff boundary --out line

    pinchoff boundary --size-ratio 4,5.66,8 --out sizes

    pinchoff boundary --model front-tracking --out front

    pinchoff boundary --set line_tension=60,190,600,1900 --width 0.002 \
    --out appendix-c
    """
    from pinchoff.studies.boundary.report import boundary_report
    from pinchoff.studies.boundary.search import boundary as find

    given = dict(zip(_OWN, (capillary, size_ratio), strict=True))
    vary = _lists({name: text for name, text in given.items() if text}, constants or [])
    base, _ = model.parameters()
    with results.held_for(_FILES) as folder:
        started = time.perf_counter()
        with named_as_options(*_OWN, "width", "scan"):
            line = find(base, vary, width=width, scan=scan)
        report, fit = boundary_report(line, time.perf_counter() - started)
        remove_results(folder, _FILES)
        paths = _write(line, fit, report, folder)
        results.announce(report, lambda: _print(line, report, fit), paths)


def _lists(options: Mapping[str, str], assignments: Sequence[str]) -> dict[str, list[Any]]:
    lists = {name: read_list(flag_of(name), text) for name, text in options.items()}
    pairs = read_pairs("--set", assignments, "line_tension=60,190", "NAME=LIST")
    for name, text in pairs.items():
        if name in _OWN:
            raise InputError.of("--set", "another parameter", name, f"use {flag_of(name)}")
        lists[name] = read_list(f"--set {name}", text)
    return lists


def _write(line: Boundary, fit: LineFit | None, report: Mapping[str, Any], out: Path) -> list[Path]:
    """Write tables, fit and figures, and return their names."""
    from pinchoff.figures import style
    from pinchoff.figures.appendix_c import appendix_c
    from pinchoff.figures.area_collapse import area_collapse
    from pinchoff.figures.phase_diagram import separating_line
    from pinchoff.studies.boundary.search import write_table

    write_table(line.table, out / TABLE)
    write_table(line.table, out / TABLE_TEXT)
    write_table(line.runs, out / RUNS)
    write_json(out / FIT, report)
    if line.runs["symmetry"].notna().any():
        style.save(out / LINE, separating_line(line, fit))
    if "fits_free_area_exponent" in report:
        style.save(out / COLLAPSE, area_collapse(line)[0])
    if report.get("appendix_c"):
        style.save(out / APPENDIX_C, appendix_c(line)[0])
    return [out / name for name in _FILES]


def _print(line: Boundary, report: Mapping[str, Any], fit: LineFit | None) -> None:
    _print_points(line)
    for row in line.table[line.table["status"] == "non-monotonic"].to_dict("records"):
        print(f"point {row['point']}, non-monotonic in S: {row['intervals']}")
    print(fit if fit is not None else f"no line is fitted: {report['why_no_fit']}")
    for speed, free in report.get("fits_free_area_exponent", {}).items():
        p, beta = free["area_exponent"], free["beta"]
        print(
            f"with Ã^p, Ca from the {speed} speed: p = {p['value']:.3f} ({p['low']:.3f} to "
            f"{p['high']:.3f}), β = {beta['value']:.3f} ({beta['low']:.3f} to {beta['high']:.3f})"
        )
    captured = report["captured_runs"]
    print(
        f"{counted(report['runs'], 'collision')} in {report['seconds']:.1f} s; "
        f"{captured} captured at the time limit, which counts as not broken; "
        f"{report['failed_runs']} without an outcome"
    )
    if captured:
        print("a larger time_limit (--set time_limit=100) shows what becomes of the captured ones")


def _print_points(line: Boundary) -> None:
    from pinchoff.collisions.law import PAPER_SIMULATION_LINE

    names = [str(name) for name in line.table if name in line.varied]
    symbols = [_SYMBOLS.get(name, name) for name in names]
    rows = []
    for row in line.table.to_dict("records"):
        control = row["control_parameter"]
        paper = PAPER_SIMULATION_LINE.alpha * control**PAPER_SIMULATION_LINE.beta
        varied = [row[name] for name in names]
        ends = (row["symmetry_unbroken"], row["symmetry_broke"])
        rows.append(
            (
                *(f"{value:g}" if isinstance(value, float) else str(value) for value in varied),
                f"{control:.4f}",
                *("" if math.isnan(end) else f"{end:.4f}" for end in ends),
                f"{paper:.3f}" if paper < 1 else "",
                row["status"],
            )
        )
    headings = (*symbols, "Ca Ã z̃", "S unbroken", "S broke", "paper", "status")
    print_table(headings, rows, left=(len(headings) - 1,))
