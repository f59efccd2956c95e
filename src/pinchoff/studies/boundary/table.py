"""The table of a boundary: its columns, how it is filled, and how tables with units are written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.studies.boundary.bracketing import Bracket, Interval
from pinchoff.support.files import written_aside

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.parameters import Parameters

COLUMNS: dict[str, tuple[str, str]] = {
    "point": ("1", "number of the point, from 0"),
    "size_ratio": ("1", "D0/R"),
    "simulation_capillary_number": ("1", "Ca_sim = μ̃/γ̃"),
    "line_tension": ("M v_f∞²/D0", "γ̃"),
    "drag": ("M/t0", "μ̃"),
    "capillary_number": ("1", "Ca = 9.8e-5 Ca_sim, with v_f∞"),
    "normalized_area": ("1", "Ã of the undeformed droplet"),
    "normalized_thickness": ("1", "z̃"),
    "control_parameter": ("1", "Ca Ã z̃"),
    "status": ("", "what the search ended with, see pinchoff.studies.boundary.bracketing.STATUSES"),
    "critical_symmetry": ("1", "S_c, middle of the bracket; missing unless found"),
    "symmetry_unbroken": ("1", "largest S that does not break"),
    "symmetry_broke": ("1", "smallest S that breaks"),
    "width": ("1", "symmetry_broke - symmetry_unbroken"),
    "offset_unbroken": ("D0", "start y of the run with symmetry_unbroken"),
    "offset_broke": ("D0", "start y of the run with symmetry_broke"),
    "contact_speed": ("v_f∞", "speed at first contact, mean of these two runs"),
    "runs": ("1", "collisions that were run"),
    "captured_runs": ("1", "those that had not left the obstacle at the time limit: not broken"),
    "failed_runs": ("1", "those without an outcome, see Boundary.failures"),
    "intervals": ("", "outcomes among the runs that touched, by S, from head-on outwards"),
}
"""Columns of the table: unit ("1": pure number) and meaning. Further varied constants stand
behind ``line_tension``."""

_POINT_COLUMNS = (
    "size_ratio",
    "simulation_capillary_number",
    "line_tension",
    "drag",
    "capillary_number",
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

    Parameters
    ----------
    points : sequence of n Parameters
    varied : sequence of str
        Names of parameters; those that are no column yet become one.
    brackets : sequence of n Bracket
    runs : DataFrame
        What was run for them, with the column ``point``.
    """
    import pandas as pd

    further = [name for name in varied if name not in COLUMNS]
    places = zip(runs["point"], runs["offset"], strict=True)
    speeds = dict(zip(places, runs["contact_speed"], strict=True))
    captured = (runs["outcome"] == "captured").groupby(runs["point"]).sum()
    rows = [
        {
            "point": k,
            **{name: getattr(point, name) for name in [*_POINT_COLUMNS, *further]},
            "control_parameter": point.capillary_number
            * point.normalized_area
            * point.normalized_thickness,
            **_bracket_columns(k, bracket, speeds),
            "captured_runs": int(captured[k]),
        }
        for k, (point, bracket) in enumerate(zip(points, brackets, strict=True))
    ]
    names = list(COLUMNS)
    names[names.index("line_tension") + 1 : names.index("line_tension") + 1] = further
    table = pd.DataFrame(rows, columns=names)
    table.attrs["units"] = {name: COLUMNS[name][0] if name in COLUMNS else "" for name in names}
    return table


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
        "intervals": ", ".join(map(_said, bracket.intervals)),
    }


def _said(interval: Interval) -> str:
    outcome = "broke" if interval.broke else "not"
    return f"{outcome} {interval.first_symmetry:.4f} to {interval.last_symmetry:.4f}"


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table with units in its ``attrs`` as Parquet, or as CSV, by the suffix.

    Parquet keeps the unit of each column in the column's metadata, key ``unit``. The file is
    written aside and then renamed.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with written_aside(path) as unfinished:
        if path.suffix == ".csv":
            table.to_csv(unfinished, index=False)
            return
        content = pa.Table.from_pandas(table, preserve_index=False)
        for k, column in enumerate(content.schema):
            unit = table.attrs["units"].get(column.name, "")
            content = content.cast(content.schema.set(k, column.with_metadata({"unit": unit})))
        pq.write_table(content, unfinished)
