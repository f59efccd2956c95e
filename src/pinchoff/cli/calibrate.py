"""``pinchoff calibrate``: constants with which a given separating line comes out."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.folders import ResumableResults, remove_results
from pinchoff.cli.model_options import ModelFileOptions
from pinchoff.cli.options import OUTPUT, argument, grouped, named_as_options, option
from pinchoff.cli.output import print_table, versioned
from pinchoff.support.errors import InputError
from pinchoff.support.files import write_csv
from pinchoff.support.numerals import counted
from pinchoff.support.records import write_json

if TYPE_CHECKING:
    from pinchoff.studies.calibration.fitting import Calibration
    from pinchoff.studies.calibration.targets import Target

RESULT = "calibration.json"
LINE = "line.png"
SENSITIVITY = "sensitivity.csv"
_FILES = (RESULT, LINE, SENSITIVITY, "landscape_*.png", "evaluations.jsonl")

_SEARCH = "Search"


def _search(takes: str, meaning: str, panel: str = _SEARCH) -> Any:
    return option(takes, meaning, panel=panel)


@grouped(out="calibration")
def calibrate(
    target: Annotated[
        str,
        argument(
            "TARGET",
            "paper-simulation, paper-experiment, ALPHA,BETA[,LOW,HIGH] of a line over a "
            "range of Ca Ã z̃, or a Parquet or CSV file of collisions",
        ),
    ],
    model: ModelFileOptions,
    *,
    free: Annotated[
        list[str] | None,
        option(
            "NAME[=LOW,HIGH]",
            "A constant to fit: edge_stiffness, neck_separation, neck_thickness, "
            "line_tension or conversion (c in Ca = c Ca_sim); may be repeated",
            default="edge_stiffness, with front-tracking neck_separation, and neck_thickness",
            panel=_SEARCH,
        ),
    ] = None,
    points: Annotated[int, _search("INTEGER", "Places in Ca Ã z̃")] = 6,
    width: Annotated[float, _search("NUMBER", "Largest width of a bracket, in S")] = 0.005,
    scan: Annotated[int, _search("INTEGER", "Intervals of the scan over the offset")] = 16,
    evaluations: Annotated[
        int, _search("INTEGER", "The most evaluations of the search; a search needs about 20")
    ] = 80,
    grid: Annotated[
        int, _search("INTEGER", "Values of each constant for the landscapes; 0: none", OUTPUT)
    ] = 6,
    results: ResumableResults,
) -> None:
    r"""Choose constants so that droplets break where a target says.

    Every evaluation is a simulated separating line, which takes seconds; a
    search needs about 20. DIR keeps them: if the command is stopped, the same
    command goes on, and other settings are refused. DIR gets

    - calibration.json: the best constants, sensitivities, the conversion Ca =
      c Ca_sim
    - line.png: the line before and after, and the target
    - landscape_*.png: the objective over pairs of constants
    - sensitivity.csv: how strongly S_c depends on each constant
    - evaluations.jsonl: every evaluation

    [bold]Examples[/bold]

    pinchoff calibrate paper-simulation --free edge_stiffness \
    --free neck_thickness --out fit

    pinchoff calibrate 0.083,-0.74,0.04,0.2 --free edge_stiffness=1,6 --grid 0 \
    --out fit

    pinchoff calibrate collisions.parquet --free conversion \
    --free edge_stiffness --out mine
    """
    from pinchoff.studies.calibration.fitting import calibrate as fit

    aim, constants = _target(target), _bounds(free) if free else None
    base, _ = model.parameters()
    with results.resumed() as folder:
        if results.overwrite:
            remove_results(folder, _FILES)
        started = time.perf_counter()
        with named_as_options("free", "points", "width", "scan", "evaluations", "grid"):
            found = fit(
                aim,
                constants,
                base,
                points=points,
                width=width,
                scan=scan,
                evaluations=evaluations,
                grid=grid,
                out=folder,
            )
        seconds = round(time.perf_counter() - started, 3)
        report = versioned({**found.to_dict(), "seconds": seconds})
        paths = _write(found, report, folder)
        results.announce(report, lambda: _print(found, report), paths)


def _target(text: str) -> Target:
    """Read numbers between commas as a line; the library reads anything else."""
    from pinchoff.studies.calibration.targets import LineTarget, as_target

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if numbers and len(numbers) not in (2, 4):
        rule = "a preset, a file, or ALPHA,BETA or ALPHA,BETA,LOW,HIGH"
        raise InputError.of("TARGET", rule, text, "write it like 0.089,-0.72,0.04,0.2")
    line = {name: f"TARGET: {name}" for name in ("alpha", "beta", "control_range")}
    with named_as_options(target="TARGET", **line):
        if len(numbers) == 2:
            return LineTarget(numbers[0], numbers[1])
        if numbers:
            return LineTarget(numbers[0], numbers[1], (numbers[2], numbers[3]))
        return as_target(text)


def _bounds(free: Sequence[str]) -> dict[str, tuple[float, float] | None]:
    constants: dict[str, tuple[float, float] | None] = {}
    for text in free:
        name, equals, ends = (part.strip() for part in text.partition("="))
        if name in constants:
            raise InputError.of("--free", "given once for each constant", text, "drop one of them")
        constants[name] = None
        if equals:
            try:
                low, high = map(float, ends.split(","))
            except ValueError:
                advice = "write it like edge_stiffness=1,6"
                raise InputError.of("--free", "NAME or NAME=LOW,HIGH", text, advice) from None
            constants[name] = low, high
    return constants


def _write(found: Calibration, report: Mapping[str, Any], out: Path) -> list[Path]:
    from pinchoff.figures import style
    from pinchoff.figures.calibrated_line import calibrated_line, objective_landscape
    from pinchoff.studies.calibration.fitting import LOG

    paths = [out / RESULT, out / SENSITIVITY, out / LINE]
    write_json(paths[0], report)
    write_csv(paths[1], found.sensitivity)
    style.save(paths[2], calibrated_line(found))
    relative = found.parameters.neck_separation_unit == "perimeter"
    unit = "(perimeter)" if relative else "($D_0$)"
    for surface in found.landscapes:
        paths.append(out / f"landscape_{'_'.join(surface.names)}.png")
        label = found.target.objective_name
        style.save(paths[-1], objective_landscape(surface, label, unit))
    return [*paths, out / LOG]


def _print(found: Calibration, report: Mapping[str, Any]) -> None:
    start, best = found.start, found.best
    for name, value in best.changes.items():
        bound = ", at its bound" if name in found.at_bound else ""
        print(f"{name} = {value:.4g} (base: {start.changes[name]:.4g}{bound})")
    print(
        f"{found.target.objective_name}: {best.objective:.4f} (base: {start.objective:.4f}); "
        f"{counted(report['evaluations'], 'evaluation')} in {report['seconds']:.1f} s"
        + ("" if found.converged else "; the search was not at its end, raise --evaluations")
    )
    _print_sensitivity(found)
    c = found.conversion
    if c is None:
        print("conversion: target or simulation have no onset to match")
    else:
        print(f"conversion Ca = c Ca_sim from the onset: c = {c.value:.3g}, ", end="")
        print(f"from {c.low:.3g} to {c.high:.3g} over vertex counts, brackets and target")


def _print_sensitivity(found: Calibration) -> None:
    rows = []
    for row in found.sensitivity.to_dict("records"):
        slopes = [f"{k:+.2f}" if math.isfinite(k) else "" for k in (row["mean"], row["largest"])]
        rows.append((row["constant"], f"{row['value']:.4g}", *slopes))
    print_table(("constant", "value", "d ln S_c / d ln constant", "largest"), rows)
