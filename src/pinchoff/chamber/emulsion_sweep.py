"""Several runs of many droplets from one file: every combination of the values that it lists."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.chamber.emulsion_design import EmulsionDesign
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.model.emulsion_result import Emulsion
    from pinchoff.studies.emulsion_sizes import SizeStudy

TABLE = "sweep"
MOST_RUNS = 1000

_MEASURED = ("mean_diameter", "weighted_diameter", "mean_area", "dispersity")
_RATES = ("entered", "breakup", "merge", "left")


@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep.

    Attributes
    ----------
    folder : str
        Its name in the folder of the sweep.
    values : dict
        What is varied, by key: ``array.gap``, ``seed``.
    design : EmulsionDesign
    """

    folder: str
    values: dict[str, Any]
    design: EmulsionDesign


def sweep_runs(config: Mapping[str, Any], beside: Path | None = None) -> list[SweepRun]:
    """Return the runs of a file with a table ``sweep``, all of them checked.

    Parameters
    ----------
    config : mapping
        Of `EmulsionDesign.from_config`, and ``sweep``: for each key of the file that is varied,
        such as ``"array.gap"``, a list of values.
    beside : Path, optional
        The folder of the files that it names.

    Raises
    ------
    InputError
        The table is wrong, or a run is refused; says which.

    Examples
    --------
    >>> runs = sweep_runs({
    ...     "time": 5,
    ...     "array": {"kind": "square", "rows": 2, "columns": 2, "radius": 0.3, "gap": 1.0},
    ...     "flow": {"thickness": 0.5},
    ...     "droplets": {"area_fraction": 0.2},
    ...     "sweep": {"array.gap": [0.9, 1.2], "seed": [1, 2]},
    ... })
    >>> len(runs), runs[2].folder, runs[2].values
    (4, 'run-0002', {'array.gap': 1.2, 'seed': 1})
    """
    given = config.get(TABLE)
    if not isinstance(given, Mapping) or not given:
        advice = 'write "array.gap" = [0.5, 1.0] under [sweep]'
        raise InputError.of(TABLE, "a table of keys and lists of values", given, advice)
    axes = _flat(given)
    for name, values in axes.items():
        if not isinstance(values, list) or not values:
            advice = f"write [{values}]"
            raise InputError.of(f"{TABLE}.{name}", "a list of values", values, advice)
    count = 1
    for values in axes.values():
        count *= len(values)
    if count > MOST_RUNS:
        raise InputError.of(TABLE, f"at most {MOST_RUNS} runs", count, "shorten a list")
    base = {name: value for name, value in config.items() if name != TABLE}
    runs = []
    for number, chosen in enumerate(itertools.product(*axes.values())):
        values = dict(zip(axes, chosen, strict=True))
        one = copy.deepcopy(base)
        for name, value in values.items():
            _put(one, name, value)
        try:
            design = EmulsionDesign.from_config(one, beside)
        except InputError as error:
            said = ", ".join(f"{name} = {value}" for name, value in values.items())
            got = f"{error.got} in run {number} ({said})"
            raise InputError.of(error.argument, error.rule, got, error.advice) from None
        runs.append(SweepRun(f"run-{number:04d}", values, design))
    return runs


def summary_row(one: SweepRun, result: Emulsion, study: SizeStudy) -> dict[str, Any]:
    """Return what came of a run, as a row of the sweep's table."""
    row: dict[str, Any] = {"folder": one.folder, **one.values}
    row |= {"time": result.time, "steady": study.steady}
    for name in _MEASURED:
        row[name], row[f"{name}_error"] = getattr(study, name)
    for name in _RATES:
        row[f"{name}_rate"], row[f"{name}_rate_error"] = study.rates[name]
    return row | {"residence_time": study.residence_time, "retired": result.balance["retired"]}


def _flat(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return keys as ``table.key``: TOML reads ``array.gap`` without quotes as a table."""
    flat: dict[str, Any] = {}
    for name, value in given.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{key}": one for key, one in value.items()}
        else:
            flat[name] = value
    return flat


def _put(config: dict[str, Any], name: str, value: Any) -> None:
    place, dot, key = name.partition(".")
    if not dot:
        config[name] = value
        return
    table = config.setdefault(place, {})
    if not isinstance(table, dict):
        advice = "name a key of a table, such as array.gap"
        raise InputError.of(f"{TABLE}.{name}", "a key of a table", name, advice)
    table[key] = value
