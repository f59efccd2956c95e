"""The table of a boundary: its columns, how it is filled and written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.collisions import parquet, schema
from pinchoff.collisions.schema import Column, count_column, measure_column
from pinchoff.model.parameters import PARAMETERS
from pinchoff.studies.boundary.bracketing import Bracket, Interval

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.parameters import Parameters

COLUMNS: dict[str, Column] = {
    column.name: column
    for column in (
        count_column("point", "number of the point, from 0"),
        measure_column("size_ratio", "1", "D0/R"),
        measure_column("simulation_capillary_number", "1", "Ca_sim = μ̃/γ̃"),
        measure_column("line_tension", "M v_f∞²/D0", "γ̃"),
        measure_column("drag", "M/t0", "μ̃"),
        measure_column("capillary_number", "1", "Ca, with the speed of ca_speed"),
        measure_column("ca_per_ca_sim", "1", "Ca/Ca_sim that was assumed"),
        Column("ca_speed", "", "str", "speed in Ca: far, v_f∞; or contact, contact_speed"),
        measure_column("normalized_area", "1", "Ã of the undeformed droplet"),
        measure_column("normalized_thickness", "1", "z̃"),
        measure_column("control_parameter", "1", "Ca Ã z̃"),
        Column(
            "status",
            "",
            "str",
            "what the search ended with, see pinchoff.studies.boundary.bracketing.STATUSES",
        ),
        measure_column("critical_symmetry", "1", "S_c, middle of a bracket that was found"),
        measure_column("symmetry_unbroken", "1", "largest S that does not break"),
        measure_column("symmetry_broke", "1", "smallest S that breaks"),
        measure_column("width", "1", "symmetry_broke - symmetry_unbroken"),
        measure_column("offset_unbroken", "D0", "start y of the run with symmetry_unbroken"),
        measure_column("offset_broke", "D0", "start y of the run with symmetry_broke"),
        measure_column("contact_speed", "v_f∞", "speed at first contact, mean of these two runs"),
        count_column("runs", "collisions that were run"),
        count_column(
            "captured_runs", "of them not broken, but at the obstacle until the time limit"
        ),
        count_column("failed_runs", "of them without an outcome, see Boundary.failures"),
        Column(
            "intervals", "", "str", "outcomes of the runs that touched, by S, from head-on outwards"
        ),
    )
}
"""Columns of the table. Further varied constants stand behind ``line_tension``."""

_POINT_COLUMNS = (
    "size_ratio",
    "simulation_capillary_number",
    "line_tension",
    "drag",
    "capillary_number",
    "ca_per_ca_sim",
    "ca_speed",
    "normalized_area",
    "normalized_thickness",
)


def boundary_table(
    points: Sequence[Parameters],
    varied: Sequence[str],
    brackets: Sequence[Bracket],
    runs: pd.DataFrame,
) -> pd.DataFrame:
    """Return one row per point, with `COLUMNS` and the units in ``attrs["units"]``.

    Varied parameters that are no column yet become one; `runs` has the column ``point``.
    """
    import pandas as pd

    further = [name for name in varied if name not in COLUMNS]
    places = zip(runs["point"], runs["offset"], strict=True)
    speeds = dict(zip(places, runs["contact_speed"], strict=True))
    captured = (runs["outcome"] == "captured").groupby(runs["point"]).sum()
    rows = []
    for k, (point, bracket) in enumerate(zip(points, brackets, strict=True)):
        row = {"point": k, **{name: _value(point, name) for name in [*_POINT_COLUMNS, *further]}}
        row |= _bracket_columns(k, bracket, speeds)
        if point.ca_speed == "contact":
            row["capillary_number"] *= row["contact_speed"]
        groups = ("capillary_number", "normalized_area", "normalized_thickness")
        row["control_parameter"] = math.prod(row[name] for name in groups)
        row["captured_runs"] = int(captured[k])
        rows.append(row)
    names = list(COLUMNS)
    names[names.index("line_tension") + 1 : names.index("line_tension") + 1] = further
    table = pd.DataFrame(rows, columns=names)
    table.attrs["units"] = {name: _column(name).unit for name in names}
    return table


def _value(point: Parameters, name: str) -> Any:
    """Return what stands in a column: for "auto" the time step that runs take."""
    return point.effective_time_step if name == "time_step" else getattr(point, name)


def _bracket_columns(
    point: int, bracket: Bracket, speeds: Mapping[tuple[int, float], float]
) -> dict[str, Any]:
    ends = {"broke": bracket.broke, "unbroken": bracket.unbroken}
    symmetry = {name: end.symmetry if end else math.nan for name, end in ends.items()}
    speed = [speeds[point, end.offset] for end in ends.values() if end]
    middle = (symmetry["broke"] + symmetry["unbroken"]) / 2
    return {
        "status": bracket.status,
        "critical_symmetry": middle if bracket.status == "found" else math.nan,
        **{f"symmetry_{name}": value for name, value in symmetry.items()},
        **{f"offset_{name}": end.offset if end else math.nan for name, end in ends.items()},
        "width": bracket.width,
        "contact_speed": math.fsum(speed) / len(speed) if speed else math.nan,
        "runs": bracket.trials,
        "failed_runs": bracket.failures,
        "intervals": ", ".join(map(_interval_text, bracket.intervals)),
    }


def _interval_text(interval: Interval) -> str:
    outcome = "broke" if interval.broke else "not"
    return f"{outcome} {interval.first_symmetry:.4f} to {interval.last_symmetry:.4f}"


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write `Boundary.table` or `Boundary.runs` as Parquet or CSV, by the suffix."""
    if "outcome" in table:
        parquet.write_table(table, path, (COLUMNS["point"], *schema.COLUMNS))
    else:
        parquet.write_table(table, path, [_column(name) for name in table.columns])


def _column(name: str) -> Column:
    return COLUMNS[name] if name in COLUMNS else PARAMETERS[name].as_column()._replace(name=name)
