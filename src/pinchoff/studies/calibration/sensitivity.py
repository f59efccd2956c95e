"""How much the simulated line changes with single constants, and with pairs of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pinchoff.model.parameters import Parameters
from pinchoff.studies.calibration.evaluation import Evaluation, Evaluator
from pinchoff.studies.calibration.targets import Floats
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

CONSTANTS = (
    "edge_stiffness",
    "neck_thickness",
    "neck_separation",
    "line_tension",
    "area_stiffness",
    "wall_stiffness",
    "vertex_count",
    "start_distance",
)
"""Constants whose sensitivity is looked at."""

_STEP = 1.2  # factor by which each constant is raised and lowered
_VERTEX_STEP = 1.25
_VERTEX_MULTIPLE = 4  # N_v is kept to multiples of it


@dataclass(frozen=True, eq=False)
class Landscape:
    """The objective over two constants, the others as in the best set.

    Attributes
    ----------
    names : (str, str)
        The constants along x and along y.
    x, y : ndarray, shape (nx,) and (ny,)
        Their values.
    objective : ndarray, shape (ny, nx)
    best : (float, float)
        Their values in the best set.
    """

    names: tuple[str, str]
    x: Floats
    y: Floats
    objective: Floats
    best: tuple[float, float]


def has_meaning(names: Iterable[str], model: Parameters) -> bool:
    """Tell whether all of some constants have a meaning in a model; ``conversion`` always has."""
    return all(getattr(model, name, 0.0) is not None for name in names)


def landscape(
    evaluator: Evaluator, best: Evaluation, names: tuple[str, str], grid: tuple[Floats, Floats]
) -> Landscape:
    """Evaluate the objective over a grid of two constants, the others as in the best set.

    The grid is their values, shapes (nx,) and (ny,).
    """
    x, y = grid

    def objective(*values: float) -> float:
        return evaluator({**best.changes, **dict(zip(names, values, strict=True))}).objective

    surface = np.array([[objective(a, b) for a in x.tolist()] for b in y.tolist()])
    model = evaluator.parameters(best.changes)
    place = (float(getattr(model, names[0])), float(getattr(model, names[1])))
    return Landscape(names, x, y, surface, place)


def sensitivity_table(evaluator: Evaluator, best: Evaluation) -> pd.DataFrame:
    """Return how much S_c changes with each of the model's `CONSTANTS`, near the best set.

    Each constant is made a fifth larger and a fifth smaller (N_v: a quarter, to a multiple of 4),
    the others kept; what follows from one by default, as k̃_a and ε̃_w do from γ̃, follows it.

    Returns
    -------
    DataFrame
        ``constant``, ``value``, ``low`` and ``high`` (values that were tried), ``mean`` and
        ``largest``: d ln S_c/d ln constant over the places, on average and of largest size;
        ``objective_low`` and ``objective_high``. NaN where the runs do not decide.
    """
    import pandas as pd

    model = evaluator.parameters(best.changes)
    rows = []
    for name in CONSTANTS:
        if not has_meaning((name,), model):
            continue
        ends = _ends(name, model)
        low, high = (evaluator({**best.changes, name: end}) for end in ends)
        change = np.log(high.critical_symmetry / low.critical_symmetry)
        response = change / math.log(ends[1] / ends[0])
        rows.append(
            {
                "constant": name,
                "value": float(getattr(model, name)),
                "low": ends[0],
                "high": ends[1],
                "mean": float(response.mean()),
                "largest": float(response[np.argmax(np.abs(response))]),
                "objective_low": low.objective,
                "objective_high": high.objective,
            }
        )
    return pd.DataFrame(rows)


def _ends(name: str, model: Parameters) -> tuple[float, float]:
    """Return a value below and one above the model's; the model's own where one is not allowed."""
    value = getattr(model, name)
    if name == "vertex_count":
        steps = (value / _VERTEX_STEP, value * _VERTEX_STEP)
        ends = [_VERTEX_MULTIPLE * round(value / _VERTEX_MULTIPLE) for value in steps]
    else:
        ends = [value / _STEP, value * _STEP]
    return _allowed(name, ends[0], model), _allowed(name, ends[1], model)


def _allowed(name: str, value: float, model: Parameters) -> float:
    try:
        model.replace(**{name: value})
    except InputError:
        return getattr(model, name)  # type: ignore[no-any-return]
    return value
