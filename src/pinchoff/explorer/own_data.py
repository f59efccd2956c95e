"""A user's collisions as the page takes them: points with their columns, outlines, pictures."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

MOST_ROWS = 20_000
"""Collisions that one page takes: more make it slow to open and to draw."""

_DIGITS = 6  # significant digits of a number in the page

#: Columns that repeat others, or tell of the computation.
_HIDDEN = ("minimum_neck", "contact_speed", "steps", "vertex_updates")

LAW = "law.json"
RUN = "collision.json"
TABLE = "collisions.parquet"
"""What tells one folder of results from another."""


def own_data(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return a user's collisions, fit for JSON.

    Parameters
    ----------
    path : path
        The folder of a sweep, of `pinchoff video`, `fit` or `run`; or a table of collisions, as
        `pinchoff.collisions.importing.import_collisions` takes it.
    columns, units, constants : mapping of str to str, optional
        As of `import_collisions`, for a table that is not ours.

    Returns
    -------
    dict
        ``title``; ``words``, what was left out and why; ``columns`` with name, unit, meaning and
        kind; ``values`` by column, None where not measured; ``films`` and ``thumbnails`` by row;
        ``lines``, fitted ones.

    Raises
    ------
    InputError
        The path is none of these, or the table cannot be read.
    """
    place = Path(path)
    own = {"columns": columns or {}, "units": units or {}, "constants": constants or {}}
    films: dict[int, Any] = {}
    thumbnails: dict[int, str] = {}
    lines: list[dict[str, Any]] = []
    words: list[str] = []
    if (place / RUN).is_file():
        from pinchoff.explorer.films import simulated_film

        frame = _of_run(place)
        films = simulated_film(place)
    elif (place / TABLE).is_file() or (place / LAW).is_file():
        frame, words = _thinned(_of_results(place), [])
        lines = _fitted_line(place)
        if (place / "clips").is_dir():
            from pinchoff.explorer.films import filmed

            films, thumbnails, more = filmed(place, frame)
            words += more
    else:
        frame, words = _thinned(*_of_table(place, own))
    names = [c for c in frame.columns if c not in _HIDDEN and frame[c].notna().any()]
    return {
        "title": place.resolve().name,
        "words": words,
        "columns": [_described(frame, name) for name in names],
        "values": {name: _values(frame[name]) for name in names},
        "films": films,
        "thumbnails": thumbnails,
        "lines": lines,
    }


def _of_results(folder: Path) -> pd.DataFrame:
    from pinchoff.collisions.parquet import read_collisions

    if not (folder / TABLE).is_file():
        got, advice = f"a fit without {TABLE}", "give the table that was fitted"
        raise InputError.of(str(folder), "a folder with collisions", got, advice)
    return read_collisions(folder / TABLE)


def _of_run(folder: Path) -> pd.DataFrame:
    """Return the one row of a run."""
    import pandas as pd

    report = _json(folder / RUN)
    try:
        row = {**report["results"], **report["derived"]}
        parameters = report["parameters"]
        row |= {n: parameters[n] for n in ("size_ratio", "simulation_capillary_number", "offset")}
    except (KeyError, TypeError):
        got, advice = "something else", "run it again"
        raise InputError.of(str(folder / RUN), "what pinchoff run wrote", got, advice) from None
    plain = {name: value for name, value in row.items() if not isinstance(value, (list, dict))}
    return pd.DataFrame([{"source": "simulation", **plain}])


def _of_table(place: Path, own: Mapping[str, Mapping[str, str]]) -> tuple[pd.DataFrame, list[str]]:
    """Read our own tables as they are, and any other table as `pinchoff fit` does."""
    from pinchoff.collisions.importing import import_collisions
    from pinchoff.collisions.parquet import read_collisions
    from pinchoff.collisions.reading import read_table

    foreign = any(own.values())
    if not foreign and (place.is_dir() or place.suffix == ".parquet"):
        try:
            return read_collisions(place), []
        except InputError:
            if place.is_dir():
                raise
    imported = import_collisions(
        place,
        columns=own.get("columns"),
        units=own.get("units"),
        constants=own.get("constants"),
    )
    table = imported.table
    rows = table["collision_id"].to_numpy()
    source = read_table(place).iloc[rows]
    for name in source.columns:
        if name not in table.columns:  # the user's own, to filter by
            table[str(name)] = source[name].to_numpy()
    return table, imported.messages()


def _thinned(frame: pd.DataFrame, words: list[str]) -> tuple[pd.DataFrame, list[str]]:
    """Take evenly spaced rows where there are too many, and say so."""
    if len(frame) > MOST_ROWS:
        kept = np.linspace(0, len(frame) - 1, MOST_ROWS).round().astype(int)
        words = [*words, f"{MOST_ROWS:,} of {len(frame):,} rows, evenly taken, are in this page"]
        units = frame.attrs.get("units", {})
        frame = frame.iloc[kept]
        frame.attrs["units"] = units
    return frame.reset_index(drop=True), words


def _described(frame: pd.DataFrame, name: str) -> dict[str, str]:
    from pandas.api.types import is_bool_dtype, is_numeric_dtype

    from pinchoff.collisions.schema import COLUMNS

    known = {column.name: column for column in COLUMNS}.get(name)
    number = is_numeric_dtype(frame[name]) and not is_bool_dtype(frame[name])
    return {
        "name": name,
        "unit": frame.attrs.get("units", {}).get(name, known.unit if known else ""),
        "meaning": known.meaning if known else "",
        "kind": "number" if number else "word",
    }


def _values(column: pd.Series) -> list[Any]:
    """Return a column as JSON has it; what is not finite or missing is None."""
    from pandas.api.types import is_bool_dtype, is_numeric_dtype

    missing = column.isna().to_numpy()
    if is_bool_dtype(column):
        return [None if m else bool(v) for m, v in zip(missing, column, strict=True)]
    if is_numeric_dtype(column):
        numbers = column.to_numpy(dtype=np.float64, na_value=np.nan)
        return [float(f"{v:.{_DIGITS}g}") if np.isfinite(v) else None for v in numbers.tolist()]
    return [None if m else str(v) for m, v in zip(missing, column, strict=True)]


def _fitted_line(folder: Path) -> list[dict[str, Any]]:
    """Return the line of a fit, where the folder holds one."""
    if not (folder / LAW).is_file():
        return []
    law = _json(folder / LAW)
    try:
        alpha, beta = float(law["alpha"]["value"]), float(law["beta"]["value"])
    except (KeyError, TypeError, ValueError):
        got, advice = "something else", "fit it again"
        raise InputError.of(str(folder / LAW), "what pinchoff fit wrote", got, advice) from None
    return [{"name": "own-line", "label": f"fit of {folder.name}", "alpha": alpha, "beta": beta}]


def _json(path: Path) -> dict[str, Any]:
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError.of(str(path), "readable JSON", str(error), "write it again") from None
    return value if isinstance(value, dict) else {}
