"""Evaluations of a calibration: the simulated line for given constants, each computed once.

They are kept in a file of one JSON object a line, the settings first, so that a calibration that
was interrupted takes up where it stopped.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import NonNegativeInt

from pinchoff.model.parameters import Parameters
from pinchoff.studies.boundary import boundary
from pinchoff.studies.calibration.targets import Floats, Target
from pinchoff.support.errors import InputError, PinchoffError
from pinchoff.support.files import write_text
from pinchoff.support.paper_constants import CA_PER_CA_SIM
from pinchoff.support.records import Shape, jsonable, parsed_record

if TYPE_CHECKING:
    import pandas as pd

CONVERSION = "conversion"
"""Name of c in Ca = c Ca_sim among the constants."""

LEAST_SYMMETRY = 0.01
"""Least critical symmetry that is told apart: a droplet hardly grazes the obstacle there."""

UNDECIDED = 10.0
"""Objective of constants that are refused together, or with which guards stop what decides."""

_RULE, _ADVICE = "a file of evaluations", "remove it, or choose another folder"

REFUSED = "refused"
"""Status of every place with constants that the model refuses together."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """The simulated line for one set of constants.

    Attributes
    ----------
    changes : mapping of str to float
        Constants in which the model differs from the base, and `CONVERSION`.
    objective : float
        Its distance from the target, as the target defines it.
    critical_symmetry : ndarray, shape (n,)
        S_c at each place, as of `critical_symmetry_of`; above 1: not even a head-on droplet breaks.
    status : tuple of n str
        As in `pinchoff.studies.boundary.bracketing.STATUSES`, or `REFUSED`.
    runs, failed_runs : int
        Collisions, and those without an outcome.
    """

    changes: Mapping[str, float]
    objective: float
    critical_symmetry: Floats
    status: tuple[str, ...]
    runs: int
    failed_runs: int

    def to_dict(self) -> dict[str, Any]:
        """Return it as it is written: NaN as None."""
        content: dict[str, Any] = jsonable(asdict(self))
        return content


def critical_symmetry_of(runs: pd.DataFrame, neck_thickness: float) -> float:
    """Return the critical symmetry of one point, also where its status is not "found".

    It is the middle between the smallest S that broke and the next smaller one that did not (0
    without one), and at least `LEAST_SYMMETRY`. Where nothing broke it is the thinnest neck of
    the head-on droplet over `neck_thickness`: 1 where that begins to break, larger the farther
    it is from it, so that an optimiser sees which way to go. NaN without either.
    """
    touched = runs[runs["symmetry"].notna() & runs["broke"].notna()]
    broke = touched["broke"].astype(bool)
    if not broke.any():
        head_on = touched.loc[touched["offset"] == 0, "minimum_neck"]
        necks = head_on[np.isfinite(head_on)]
        if not len(necks) or neck_thickness == 0:
            return math.nan
        shortfall = float(necks.iloc[0]) / neck_thickness
        return max(1.0, shortfall) if math.isfinite(shortfall) else math.nan
    smallest = float(touched.loc[broke, "symmetry"].min())
    below = touched.loc[~broke & (touched["symmetry"] < smallest), "symmetry"]
    middle = (smallest + (float(below.max()) if len(below) else 0.0)) / 2
    return max(LEAST_SYMMETRY, middle)


class Evaluator:
    """Evaluates constants at places x = Ca Ã z̃, and remembers what it evaluated.

    Its file holds evaluations of one and the same settings; an existing one is read.
    `on_evaluation`, where it is given, is called with the number of evaluations asked for so far.

    Raises
    ------
    InputError
        The file holds evaluations of other settings, or none.
    """

    def __init__(
        self,
        target: Target,
        base: Parameters,
        control: Floats,
        settings: Mapping[str, Any],
        path: Path | None,
        **options: Any,
    ) -> None:
        self._target = target
        self._base = base
        self._control = control
        self._options: dict[str, Any] = options
        self._path = path
        self._lines = [_line(settings)]
        self._known: dict[str, Evaluation] = {}
        self.on_evaluation: Callable[[int], object] | None = None
        self.asked = 0
        if path is not None and path.exists():
            self._take_up(path)

    def __call__(self, changes: Mapping[str, float]) -> Evaluation:
        """Return the line for some constants: from memory, or by simulation."""
        self.asked += 1
        key = _key(changes)
        if key not in self._known:
            self._known[key] = evaluation = self._evaluate(changes)
            self._lines.append(_line(evaluation.to_dict()))
            self._save()
        if self.on_evaluation is not None:
            self.on_evaluation(self.asked)
        return self._known[key]

    def __iter__(self) -> Iterator[Evaluation]:
        """Give every evaluation, in the order in which they were made."""
        return iter(self._known.values())

    def parameters(self, changes: Mapping[str, float]) -> Parameters:
        """Return the model with some constants changed; `CONVERSION` is none of them."""
        constants = {name: value for name, value in changes.items() if name != CONVERSION}
        return self._base.replace(**constants)

    def _evaluate(self, changes: Mapping[str, float]) -> Evaluation:
        try:
            model = self.parameters(changes)
        except InputError:  # values that are allowed one by one, but not together
            count = self._control.size
            nothing = np.full(count, math.nan)
            return Evaluation(dict(changes), UNDECIDED, nothing, (REFUSED,) * count, 0, 0)
        conversion = changes.get(CONVERSION, CA_PER_CA_SIM)
        ca = self._control / (conversion * model.normalized_area * model.normalized_thickness)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # failed runs are counted below
            line = boundary(
                model, {"simulation_capillary_number": ca.tolist()}, progress=False, **self._options
            )
        points = line.runs.groupby("point")
        thinnest = model.neck_thickness
        critical = np.array([critical_symmetry_of(runs, thinnest) for _, runs in points])
        decided = bool(np.isfinite(critical).all())
        return Evaluation(
            dict(changes),
            self._target.loss(self._control, critical) if decided else UNDECIDED,
            critical,
            tuple(line.table["status"]),
            len(line.runs),
            len(line.failures),
        )

    def _take_up(self, path: Path) -> None:
        try:
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        except (OSError, ValueError) as error:
            raise InputError.of(str(path), _RULE, str(error), _ADVICE) from None
        if not lines or lines[0] != self._lines[0]:
            difference = _difference(lines[0] if lines else "{}", self._lines[0])
            rule, advice = "evaluations of the same calibration", "give the earlier settings, or "
            raise InputError.of(str(path), rule, difference, advice + "choose another folder")
        evaluations = [
            _evaluation(line, f"{path}, line {number}", self._control.size)
            for number, line in enumerate(lines[1:], start=2)
        ]
        self._lines = lines
        self._known = {_key(evaluation.changes): evaluation for evaluation in evaluations}

    def _save(self) -> None:
        if self._path is None:
            return
        try:
            write_text(self._path, "".join(self._lines))
        except OSError as error:
            raise PinchoffError(
                f"{self._path.parent} must be a folder that can be written to; got "
                f"'{error.strerror}'; make room and start again: what is there "
                "stays"
            ) from error


def _line(content: Mapping[str, Any]) -> str:
    return json.dumps(content, ensure_ascii=False, allow_nan=False) + "\n"


def _key(changes: Mapping[str, float]) -> str:
    return json.dumps({name: float(f"{changes[name]:.12g}") for name in sorted(changes)})


class _Line(Shape):
    changes: dict[str, float]
    objective: float
    critical_symmetry: list[float | None]
    status: list[str]
    runs: NonNegativeInt
    failed_runs: NonNegativeInt


def _evaluation(line: str, place: str, count: int) -> Evaluation:
    """Read an evaluation of lines with so many places."""
    content = parsed_record(line, place, _Line, _RULE, _ADVICE)
    if not len(content["critical_symmetry"]) == len(content["status"]) == count:
        raise InputError.of(place, f"an evaluation at {count} places", "others", _ADVICE)
    return Evaluation(
        content["changes"],
        content["objective"],
        np.array(content["critical_symmetry"], dtype=np.float64),  # None is NaN
        tuple(content["status"]),
        content["runs"],
        content["failed_runs"],
    )


def _difference(before: str, now: str) -> str:
    try:
        old = json.loads(before)
    except (ValueError, RecursionError):
        return "a file of something else"
    new = json.loads(now)
    names = [name for name in new if not isinstance(old, dict) or old.get(name) != new[name]]
    return f"evaluations with another {', '.join(names)}"
