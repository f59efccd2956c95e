"""``pinchoff chamber``: the device as masks, solids and drawings, its rules and its flow."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pinchoff.cli.folders import prepare_folder, remove_results, results_folder
from pinchoff.cli.options import OUTPUT, OutFolder, Overwrite, value_of
from pinchoff.cli.output import json_text, jsonable
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml, written_aside
from pinchoff.support.progress import progress_bar

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
_NAMED = 10  # violations that are printed
_RATE_COLUMNS = {
    "oil_rate_uL_min": "oil (µL/min)",
    "speed_mm_s": "speed (mm/s)",
    "capillary_number": "Ca",
    "reynolds_number": "Re",
    "pressure_drop_Pa": "pressure (Pa)",
}
_QUANTITIES = {  # option: its key, and how it is read
    "--obstacle-radius": ("imaging.obstacle_radius_um", "obstacle_radius"),
    "--thickness": ("thickness_um", "thickness"),
}


def chamber(
    config: Annotated[
        Path | None,
        typer.Argument(
            metavar="CONFIG.toml",
            help="A table for each part of the device; all may be left out.",
        ),
    ] = None,
    obstacle_radius: Annotated[
        str | None,
        typer.Option(
            metavar="QUANTITY",
            help="R of the obstacles, as '60 um'.",
            rich_help_panel=_DEVICE,
        ),
    ] = None,
    thickness: Annotated[
        str | None,
        typer.Option(
            metavar="QUANTITY", help="z of the channels, as '45 um'.", rich_help_panel=_DEVICE
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PART.NAME=VALUE",
            help="Any other parameter, as imaging.pitch_um=800; may be repeated.",
            rich_help_panel=_DEVICE,
        ),
    ] = None,
    warn: Annotated[
        bool,
        typer.Option(
            "--warn",
            metavar="",
            help="Write a design that breaks rules all the same.",
            rich_help_panel=_DEVICE,
        ),
    ] = False,
    flow: Annotated[
        bool,
        typer.Option(
            "--flow",
            metavar="",
            help="Compute the flow too, and what it makes of a collision.",
            rich_help_panel=_DEVICE,
        ),
    ] = False,
    out: OutFolder = "chamber",
    as_json: Annotated[
        bool,
        typer.Option("--json", metavar="", help="Print design.json too.", rich_help_panel=OUTPUT),
    ] = False,
    overwrite: Overwrite = False,
) -> None:
    """Design the microfluidic device, and check that it can be made and used.

    Without options it is the paper's device. DIR gets

    - chamber.gds, chamber.oas, chamber.dxf: the photomask, a layer for each region
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
    folder = results_folder(out)
    quantities = {"--obstacle-radius": obstacle_radius, "--thickness": thickness}
    design = _design(config, quantities, settings or [], warn)
    from pinchoff import chamber as po_chamber

    violations = po_chamber.check_rules(design)
    prepare_folder(folder, _FILES, overwrite=overwrite)
    _report_violations(design, violations, folder)
    remove_results(folder, [name for name in _FILES if not (violations and name == RULES)])
    paths = _write(design, violations, folder)
    checked = _flow(design, violations, folder) if flow else None
    record = _record(design, violations, checked, folder / RECORD)
    if as_json:
        print(json_text(record), end="")
    else:
        _print(record, checked)
    paths += [folder / name for name in (RECORD, RULES, FLOW, COLLISION)]
    for path in paths:
        if path.exists():
            print(f"wrote {path}", file=sys.stderr if as_json else sys.stdout)


def _design(
    config: Path | None, quantities: dict[str, str | None], settings: Sequence[str], warn: bool
) -> Chamber:
    """Return the device of a file, with what the command line says in place of it.

    Raises
    ------
    InputError
        Something is wrong; names the option or the key.
    """
    from pinchoff.chamber import Chamber
    from pinchoff.support.quantities import physical_magnitude

    table: dict[str, Any] = {} if config is None else read_toml(config)
    given: set[str] = set()
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not (key and equals and text):
            advice = "write it like imaging.pitch_um=800"
            raise InputError.of("--set", "PART.NAME=VALUE", setting, advice)
        if key in given:
            raise InputError.of(f"--set {key}", "given once", text, "drop one of them")
        given.add(key)
        _place(table, key, value_of(f"--set {key}", text))
    for flag, quantity in quantities.items():
        if quantity is None:
            continue
        key, name = _QUANTITIES[flag]
        if key in given:
            raise InputError.of(f"--set {key}", "given once", quantity, f"drop it or {flag}")
        try:
            _place(table, key, physical_magnitude(name, quantity))
        except InputError as error:
            raise InputError.of(flag, error.rule, error.got, error.advice) from None
    if warn:
        _place(table, "rules.on_violation", "warn")
    return Chamber(**table)


def _place(table: dict[str, Any], key: str, value: Any) -> None:
    """Put a value where its dotted key says, leaving other values of the part alone."""
    part, dot, name = key.partition(".")
    if not dot:
        table[part] = value
        return
    inside = table.setdefault(part, {})
    if not isinstance(inside, dict):
        raise InputError.of(part, "a table", inside, f"write it as [{part}]")
    inside[name] = value


def _report_violations(design: Chamber, violations: list[Violation], folder: Path) -> None:
    """Draw and name the violations, and refuse them where the rules say so."""
    if not violations:
        return
    from pinchoff.chamber.rules import require_rules
    from pinchoff.figures import style
    from pinchoff.figures.chamber_design import chamber_design

    style.save(folder / RULES, chamber_design(design, violations))
    if design.rules.on_violation == "refuse":
        print(f"wrote {folder / RULES}", file=sys.stderr)
        require_rules(violations)
    for violation in violations[:_NAMED]:
        print(f"warning: {violation}", file=sys.stderr)
    if len(violations) > _NAMED:
        more = len(violations) - _NAMED
        print(f"warning: and {more} more, in {folder / RULES}", file=sys.stderr)


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

    The flow's are written before collisions are run.
    """
    from pinchoff.chamber import check_flow, compare_with_stokes
    from pinchoff.figures import style
    from pinchoff.figures.chamber_flow import chamber_flow, flow_comparison

    with progress_bar(sys.stderr.isatty(), "flow", None, unit="iterations") as show:
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
    with written_aside(path) as unfinished:
        unfinished.write_text(json_text(record), encoding="utf-8")
    return record


def _print(record: dict[str, Any], flow: dict[str, Any] | None) -> None:
    """Print what a look at the design has to say first."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD)
    table.add_column("result")
    table.add_column("value", justify="right")
    derived = record["derived"]
    rows = {name: derived[name] for name in ("length_um", "width_um", "fluid_volume_uL")}
    rows["pillars"] = len(record["pillars"])
    rows["violations"] = len(record["violations"])
    if flow is not None:
        rows |= {name: value for name, value in flow.items() if isinstance(value, float)}
    for name, value in rows.items():
        table.add_row(name, f"{value:.5g}")
    console = Console()
    console.print(table)
    if flow is not None:
        console.print(_rates(flow["at_oil_rates"]))
        _print_lines(flow["collision"])


def _rates(rows: list[dict[str, float]]) -> Any:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD)
    for heading in _RATE_COLUMNS.values():
        table.add_column(heading, justify="right")
    for row in rows:
        table.add_row(*(f"{row[name]:.4g}" for name in _RATE_COLUMNS))
    return table


def _print_lines(collision: dict[str, Any]) -> None:
    for name in ("chamber", "stokes"):
        line = collision[name]["line"]
        outcome = f"{collision[name]['outcome']} at S = {collision[name]['symmetry']:.3f}"
        fitted = "no line" if line is None else f"S_c = {line[0]:.4f} (Ca Ã z̃)^{line[1]:.3f}"
        print(f"one collision in the {name} flow: {outcome}; {fitted}")
