"""``pinchoff virtual``: a synthetic table of collisions, as the paper's experiments would give."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pinchoff.cli.folders import require_new_file
from pinchoff.cli.model_options import ModelOptions, changed, set_option
from pinchoff.cli.options import (
    OUTPUT,
    AsJson,
    Overwrite,
    Seed,
    grouped,
    named_as_options,
    option,
    switch,
)
from pinchoff.cli.output import announce
from pinchoff.support.errors import InputError


@grouped()
def virtual(
    model: ModelOptions,
    out: Annotated[Path, option("FILE", "The table, .parquet or .csv", panel=OUTPUT)] = Path(
        "virtual.parquet"
    ),
    rows: Annotated[int, option("INTEGER", "Collisions")] = 5056,
    seed: Seed = 1,
    engine: Annotated[
        bool, switch("--engine", "Simulate every collision instead of drawing from the law")
    ] = False,
    symmetry_noise: Annotated[float, option("NUMBER", "Standard error of the measured S")] = 0.088,
    constants: Annotated[
        list[str] | None,
        set_option("NAME=VALUE", "Any other parameter of the engine, as ca_speed=contact"),
    ] = None,
    as_json: AsJson = False,
    overwrite: Overwrite = False,
) -> None:
    r"""Make a synthetic table of collisions under the paper's five conditions.

    Speeds, diameters and impact parameters are drawn at random. Whether a
    droplet breaks is drawn from the paper's law. With --engine it is
    simulated, which gives daughters and necks too. What Ca stands for there
    is an assumption: ca_conversion, conversion_constant and ca_speed. The
    source of every row says "synthetic".

    [bold]Examples[/bold]

    pinchoff virtual --out virtual.parquet

    pinchoff fit virtual.parquet --free area --free thickness --out law

    pinchoff virtual --engine --set ca_conversion=fixed-film \
    --set ca_speed=contact
    """
    from pinchoff.collisions.parquet import require_table_name, write_collisions
    from pinchoff.studies.virtual import TRUE_SYMMETRY, virtual_experiment

    require_table_name("--out", out)
    require_new_file("--out", out, overwrite=overwrite)
    given = {"--preset": model.preset, "--model": model.model, "--set": constants}
    for flag, value in given.items():
        if value and not engine:
            shown = value if isinstance(value, str) else value[0]
            advice = "add --engine: without it nothing is simulated"
            raise InputError.of(flag, "left out without --engine", shown, advice)
    base = changed(model.parameters()[0], {}, constants or [], {})
    with named_as_options("seed", "symmetry_noise", n="--rows", base="--set"):
        table = virtual_experiment(
            seed,
            rows,
            outcomes="engine" if engine else "law",
            symmetry_noise=symmetry_noise,
            base=base,
        )
    write_collisions(table, out, [TRUE_SYMMETRY])
    broke = int(table["broke"].sum())
    announce(
        {"rows": len(table), "broke": broke, "seed": seed, "path": str(out)},
        lambda: print(f"{len(table)} synthetic collisions, {broke} of which broke"),
        [out],
        as_json=as_json,
    )
    if not as_json:
        print(f"see pinchoff fit {out}")
