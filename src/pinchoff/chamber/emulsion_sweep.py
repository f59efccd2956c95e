"""Several runs of many droplets from one file: every combination of the values that it lists."""

from __future__ import annotations

import copy
import itertools
import math
import tempfile
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.chamber.emulsion_design import EmulsionDesign
from pinchoff.model.emulsion_files import CHECKPOINT_NAME
from pinchoff.studies.sweep.cluster import computed_on
from pinchoff.support.errors import InputError
from pinchoff.support.files import put_in_table, written_aside

if TYPE_CHECKING:
    from distributed import Client

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

    The file is as of `EmulsionDesign.from_config`; ``sweep`` holds for each key of it that is
    varied, such as ``"array.gap"``, a list of values.

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
    count = math.prod(map(len, axes.values()))
    if count > MOST_RUNS:
        raise InputError.of(TABLE, f"at most {MOST_RUNS} runs", count, "shorten a list")
    base = {name: value for name, value in config.items() if name != TABLE}
    runs = []
    for number, chosen in enumerate(itertools.product(*axes.values())):
        values = dict(zip(axes, chosen, strict=True))
        one = copy.deepcopy(base)
        try:
            for name, value in values.items():
                put_in_table(one, name, value)
            design = EmulsionDesign.from_config(one, beside)
        except InputError as error:
            said = ", ".join(f"{name} = {value}" for name, value in values.items())
            got = f"{error.got} in run {number} ({said})"
            raise InputError.of(error.argument, error.rule, got, error.advice) from None
        runs.append(SweepRun(f"run-{number:04d}", values, design))
    return runs


def run_on_cluster(
    runs: Sequence[SweepRun], folder: Path, client: Client
) -> Generator[SweepRun, None, None]:
    """Run designs on a Dask cluster, one a task, and yield each when its files are here.

    The files are those that the run gives on threads. A run that was begun in its folder is left
    to be gone on with there. Workers need no common disk.

    Raises
    ------
    InputError
        The cluster has no workers, or they have another version of the package.
    PinchoffError
        The scheduler was lost, or a run took one worker after the other with it.
    """
    missing = []
    for number, one in enumerate(runs):
        if (folder / one.folder / CHECKPOINT_NAME).exists():
            yield one
        else:
            missing.append(number)
    given = ((number, runs[number].design) for number in missing)
    with closing(computed_on(client, _run_files, given)) as results:
        for number, files in results:
            place = folder / runs[number].folder
            place.mkdir(parents=True, exist_ok=True)
            # The checkpoint last: it counts on the others.
            for name in sorted(files, key=lambda name: (name == CHECKPOINT_NAME, name)):
                with written_aside(place / name) as unfinished:
                    unfinished.write_bytes(files[name])
            yield runs[number]


def _run_files(number: int, design: EmulsionDesign) -> tuple[int, dict[str, bytes]]:
    """Run a design on a worker; return its number and the files of its folder."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "run"
        design.run(design.flow(), folder, threads=1)
        return number, {path.name: path.read_bytes() for path in folder.iterdir()}


def summary_row(one: SweepRun, result: Emulsion, study: SizeStudy) -> dict[str, Any]:
    """Return what came of a run, as a row of the sweep's table."""
    row: dict[str, Any] = {"folder": one.folder, **one.values}
    row |= {"time": result.time, "steady": study.steady}
    for name in _MEASURED:
        row[name], row[f"{name}_error"] = getattr(study, name)
    for name in _RATES:
        row[f"{name}_rate"], row[f"{name}_rate_error"] = study.rates[name]
    return row | {
        "residence_time": study.residence_time,
        "stopped": result.stopped,
        "retired": result.balance["retired"],
        "retired_share": result.retired_share,
    }


def _flat(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return keys as ``table.key``: TOML reads ``array.gap`` without quotes as a table."""
    flat: dict[str, Any] = {}
    for name, value in given.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{key}": one for key, one in value.items()}
        else:
            flat[name] = value
    return flat
