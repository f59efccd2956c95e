"""``pinchoff virtual``: a synthetic table of collisions, as the paper's experiments would give."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pinchoff.cli.options import OUTPUT
from pinchoff.support.errors import InputError

_FLAGS = {"n": "--rows", "seed": "--seed", "symmetry_noise": "--symmetry-noise"}


def virtual(
    out: Annotated[
        Path,
        typer.Option(metavar="FILE", help="The table, .parquet or .csv.", rich_help_panel=OUTPUT),
    ] = Path("virtual.parquet"),
    rows: Annotated[int, typer.Option(help="Collisions.")] = 5056,
    seed: Annotated[int, typer.Option(help="The same seed gives the same table.")] = 1,
    engine: Annotated[
        bool,
        typer.Option(
            "--engine", metavar="", help="Simulate every collision instead of drawing from the law."
        ),
    ] = False,
    symmetry_noise: Annotated[
        float, typer.Option(help="Standard error of the measured S.")
    ] = 0.088,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", metavar="", help="Replace FILE.", rich_help_panel=OUTPUT)
    ] = False,
) -> None:
    """Make a synthetic table of collisions under the paper's five conditions.

    Speeds, diameters and impact parameters are drawn; whether a droplet
    breaks is drawn from the paper's law, or with --engine simulated, which
    gives daughters and necks too. The source of every row says "synthetic".

    [bold]Examples[/bold]

    pinchoff virtual --out virtual.parquet

    pinchoff fit virtual.parquet --free area --free thickness --out law
    """
    from pinchoff.collisions.parquet import require_table_name, write_collisions
    from pinchoff.studies.virtual import TRUE_SYMMETRY, virtual_experiment

    require_table_name("--out", out)
    if out.exists() and not overwrite:
        advice = "add --overwrite, or choose another name"
        raise InputError.of("--out", "a new file", f"{out}, which exists", advice)
    if not out.parent.is_dir():
        advice = "make it, or choose another"
        raise InputError.of("--out", "in an existing folder", str(out), advice)
    try:
        table = virtual_experiment(
            seed, rows, outcomes="engine" if engine else "law", symmetry_noise=symmetry_noise
        )
    except InputError as error:
        name = _FLAGS.get(error.argument, error.argument)
        raise InputError.of(name, error.rule, error.got, error.advice) from None
    write_collisions(table, out, [TRUE_SYMMETRY])
    broke = int(table["broke"].sum())
    print(f"wrote {out}: {len(table)} synthetic collisions, {broke} of which broke")
    print(f"see pinchoff fit {out}")
