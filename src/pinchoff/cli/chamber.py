"""``pinchoff chamber``: the device as masks, solids and drawings, its rules and its flow."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.assignments import read_values
from pinchoff.cli.folders import Results, remove_results
from pinchoff.cli.options import argument, flag_of, grouped, named_as_options, option, switch
from pinchoff.cli.output import bar, print_table, warn
from pinchoff.support.errors import InputError
from pinchoff.support.files import put_in_table, read_toml
from pinchoff.support.quantities import physical_magnitude
from pinchoff.support.records import jsonable, write_json

if TYPE_CHECKING:
    from pinchoff.chamber import Chamber, Violation

RECORD = "design.json"
RULES = "chamber.rules.png"
FLOW = "chamber.flow.png"
COLLISION = "chamber.collision.png"
_WRITERS = {
    "chamber.gds": "write_gds",
    "chamber.oas": "write_oasis",
    "chamber.dxf": "write_dxf",
    "chamber.scad": "write_scad",
    "chamber.stl": "write_stl",
}
_DRAWINGS = ("chamber.svg", "chamber.png")
_FILES = (*_WRITERS, *_DRAWINGS, RECORD, RULES, FLOW, COLLISION)

_DEVICE = "Device"
_RATE_COLUMNS = {
    "oil_rate_uL_min": "oil (µL/min)",
    "speed_mm_s": "speed (mm/s)",
    "capillary_number": "Ca",
    "reynolds_number": "Re",
    "pressure_drop_Pa": "pressure (Pa)",
}


@grouped(out="chamber")
def chamber(
    *,
    config: Annotated[
        Path | None,
        argument(
            "CONFIG.toml",
            "A table for each part of the device; all may be left out",
            show_default=False,
        ),
    ] = None,
    obstacle_radius: Annotated[
        str | None,
        option("QUANTITY", "R of the obstacles, as '60 um'", default="85 um", panel=_DEVICE),
    ] = None,
    thickness: Annotated[
        str | None,
        option("QUANTITY", "z of the channels, as '45 um'", default="85 um", panel=_DEVICE),
    ] = None,
    settings: Annotated[
        list[str] | None,
        option(
            "PART.NAME=VALUE",
            "Any other parameter, as imaging.pitch_um=800; may be repeated. PART is "
            "inlets, junction, oil_inputs, expansion, supports, imaging, exit, mask, rules or "
            "operation",
            "--set",
            panel=_DEVICE,
        ),
    ] = None,
    warn: Annotated[
        bool, switch("--warn", "Write a design that breaks rules all the same", panel=_DEVICE)
    ] = False,
    flow: Annotated[
        bool,
        switch("--flow", "Compute the flow and a collision in it; takes a minute", panel=_DEVICE),
    ] = False,
    results: Results,
) -> None:
    """Design the microfluidic device, and check that it can be made and used.

    Without options it is the paper's device. DIR gets

    - chamber.gds, chamber.oas, chamber.dxf: the photomask, a layer for each
      region
    - chamber.scad, chamber.stl: the relief of the mould
    - chamber.svg, chamber.png: the regions, coloured and numbered
    - design.json: parameters, pillar positions, areas, layers
    - chamber.rules.png, where rules are broken: the places
    - chamber.flow.png and chamber.collision.png, with --flow

    [bold]Examples[/bold]

    pinchoff chamber --out device

    pinchoff chamber --obstacle-radius '60 um' --thickness '45 um' --out thin

    pinchoff chamber examples/chamber.toml --flow --out dense
    """
    quantities = {"imaging.obstacle_radius_um": obstacle_radius, "thickness_um": thickness}
    design = _design(config, quantities, settings or [], warn)
    from pinchoff import chamber as po_chamber

    violations = po_chamber.check_rules(design)
    with results.held_for(_FILES) as folder:
        _report_violations(design, violations, folder)
        remove_results(folder, [name for name in _FILES if not (violations and name == RULES)])
        paths = _write(design, violations, folder)
        checked = _flow(design, violations, folder) if flow else None
        record = _record(design, violations, checked, folder / RECORD)
        paths += [folder / name for name in (RECORD, RULES, FLOW, COLLISION)]
        results.announce(record, lambda: _print(record, checked), paths)


def _design(
    config: Path | None, quantities: dict[str, str | None], settings: Sequence[str], warn: bool
) -> Chamber:
    """Return the device of a file; the command line, quantities by their keys, overrides it."""
    from pinchoff.chamber import Chamber

    table: dict[str, Any] = {} if config is None else read_toml(config)
    given = read_values("--set", settings, "imaging.pitch_um=800")
    for key, value in given.items():
        put_in_table(table, key, value)
    for key, text in quantities.items():
        if text is None:
            continue
        name = key.removeprefix("imaging.").removesuffix("_um")
        if key in given:
            advice = f"drop it or {flag_of(name)}"
            raise InputError.of(f"--set {key}", "given once", text, advice)
        with named_as_options(name):
            put_in_table(table, key, physical_magnitude(name, text))
    if warn:
        put_in_table(table, "rules.on_violation", "warn")
    return Chamber(**table)


def _report_violations(design: Chamber, violations: list[Violation], folder: Path) -> None:
    """Draw and name the violations, and refuse them where the rules say so."""
    if not violations:
        return
    from pinchoff.chamber.rules import broken_rules, require_rules
    from pinchoff.figures import style
    from pinchoff.figures.chamber_design import chamber_design

    style.save(folder / RULES, chamber_design(design, violations))
    if design.rules.on_violation == "refuse":
        print(f"wrote {folder / RULES}", file=sys.stderr)
        require_rules(violations)
    for line in broken_rules(violations):
        warn(line)


def _write(design: Chamber, violations: list[Violation], folder: Path) -> list[Path]:
    """Write masks, solids and drawings, and return the files."""
    from pinchoff import chamber as po_chamber
    from pinchoff.figures import style
    from pinchoff.figures.chamber_design import chamber_design

    for name, writer in _WRITERS.items():
        getattr(po_chamber, writer)(design, folder / name)
    axes = chamber_design(design)
    for name in _DRAWINGS:
        style.save(folder / name, axes)
    _record(design, violations, None, folder / RECORD)
    return [folder / name for name in (*_WRITERS, *_DRAWINGS)]


def _flow(design: Chamber, violations: list[Violation], folder: Path) -> dict[str, Any]:
    """Compute the flow, draw it and a collision in it, and return the numbers.

    Those of the flow are written before a collision is run.
    """
    from pinchoff.chamber import check_flow, compare_with_stokes
    from pinchoff.figures import style
    from pinchoff.figures.chamber_flow import chamber_flow, flow_comparison

    with bar("flow", unit="iterations") as show:
        check = check_flow(design, show=show)
    style.save(folder / FLOW, chamber_flow(check)[0])
    numbers = {**check.summary, "at_oil_rates": check.table().to_dict("records")}
    _record(design, violations, numbers, folder / RECORD)
    compared = compare_with_stokes(check, progress=None)
    style.save(folder / COLLISION, flow_comparison(compared)[0])
    return {**numbers, "collision": compared.to_dict()}


def _record(
    design: Chamber, violations: list[Violation], flow: dict[str, Any] | None, path: Path
) -> dict[str, Any]:
    from pinchoff.chamber.record import design_record

    record = design_record(design, violations)
    if flow is not None:
        record["flow"] = jsonable(flow)
    write_json(path, record)
    return record


def _print(record: dict[str, Any], flow: dict[str, Any] | None) -> None:
    """Print the sizes of the design, and the results of the flow check."""
    derived = record["derived"]
    numbers = {name: derived[name] for name in ("length_um", "width_um", "fluid_volume_uL")}
    numbers["pillars"] = len(record["pillars"])
    numbers["violations"] = len(record["violations"])
    if flow is not None:
        numbers |= {name: value for name, value in flow.items() if isinstance(value, float)}
    print_table(("result", "value"), ((name, f"{value:.5g}") for name, value in numbers.items()))
    if flow is not None:
        rates = [[f"{row[name]:.4g}" for name in _RATE_COLUMNS] for row in flow["at_oil_rates"]]
        print_table(tuple(_RATE_COLUMNS.values()), rates, left=())
        _print_lines(flow["collision"])


def _print_lines(collision: dict[str, Any]) -> None:
    for name in ("chamber", "stokes"):
        line = collision[name]["line"]
        outcome = f"{collision[name]['outcome']} at S = {collision[name]['symmetry']:.3f}"
        fitted = "no line" if line is None else f"S_c = {line[0]:.4f} (Ca Ã z̃)^{line[1]:.3f}"
        print(f"one collision in the {name} flow: {outcome}; {fitted}")
