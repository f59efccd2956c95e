"""Choose constants of the model so that its separating line meets a target."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.model.parameters import Parameters, require_parameters
from pinchoff.model.simulation import thread_count
from pinchoff.studies.calibration.conversions import Conversion, match_onset
from pinchoff.studies.calibration.evaluation import Evaluation, Evaluator
from pinchoff.studies.calibration.free_constants import (
    DEFAULT_FREE,
    Bounds,
    bounds_of,
    grid_of,
    values_of,
)
from pinchoff.studies.calibration.sensitivity import (
    Landscape,
    has_meaning,
    landscape,
    sensitivity_table,
)
from pinchoff.studies.calibration.targets import Floats, Target, as_target
from pinchoff.support.arguments import checked_whole
from pinchoff.support.drawing import Drawable
from pinchoff.support.locks import held_folder
from pinchoff.support.progress import progress_bar, wanted_progress

if TYPE_CHECKING:
    import os

    import pandas as pd

    from pinchoff.collisions.law import Line

LANDSCAPES = (("edge_stiffness", "neck_separation"), ("neck_separation", "neck_thickness"))
"""Pairs of constants whose landscape is drawn."""

LOG = "evaluations.jsonl"

_FORMAT = 1
_TOLERANCE = 0.01  # the search ends where its trials are nearer, relative to the bounds,
_FLATNESS = 1e-3  # and their objectives too: brackets of finite width make them as rough
_FIRST_STEP = 0.15  # of the search, relative to the bounds


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Drawable):
    """The constants that bring the simulated line nearest to a target, and their sensitivities.

    Attributes
    ----------
    target : LineTarget or CollisionsTarget
    parameters : Parameters
        The base with the best constants; its offset and Ca_sim have no meaning here.
    best, start : Evaluation
        The line with the best constants and that of the base.
    bounds : dict of str to (float, float)
        Of the free constants.
    control : ndarray, shape (n,)
        x = Ca Ã z̃ where the lines are compared.
    converged : bool
        Whether the search ended by itself, and not because its evaluations were used up.
    evaluations : DataFrame
        Every evaluation there is: constants, ``objective`` and ``runs``.
    sensitivity : DataFrame
        By constant: relative change of S_c per relative change of the constant.
    landscapes : list of Landscape
    conversion : Conversion or None
        c from matching the onset, with its range.
    """

    target: Target
    parameters: Parameters
    best: Evaluation
    start: Evaluation
    bounds: Bounds
    control: Floats
    converged: bool
    evaluations: pd.DataFrame
    sensitivity: pd.DataFrame
    landscapes: list[Landscape]
    conversion: Conversion | None

    @property
    def at_bound(self) -> list[str]:
        """Free constants that the search drove to within 1 % of one of their bounds."""
        value = self.best.changes
        return [
            name
            for name, ends in self.bounds.items()
            if any(abs(math.log(value[name] / end)) < 0.01 for end in ends)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        return {
            "target": self.target.settings(),
            "objective_name": self.target.objective_name,
            "objective": self.best.objective,
            "objective_of_base": self.start.objective,
            "best": dict(self.best.changes),
            "bounds": {name: list(ends) for name, ends in self.bounds.items()},
            "at_bound": self.at_bound,
            "converged": self.converged,
            "control_parameter": self.control.tolist(),
            "best_line": self.best.to_dict(),
            "base_line": self.start.to_dict(),
            "sensitivity": self.sensitivity.to_dict("records"),
            "conversion": None if self.conversion is None else self.conversion.to_dict(),
            "evaluations": len(self.evaluations),
            "parameters": self.parameters.model_dump(mode="json"),
        }

    def __repr__(self) -> str:
        constants = ", ".join(f"{name} = {value:.4g}" for name, value in self.best.changes.items())
        return (
            f"<Calibration to {self.target.name}: {constants}; {self.target.objective_name} "
            f"{self.best.objective:.4g}>"
        )


def calibrate(
    target: str | os.PathLike[str] | pd.DataFrame | Line | Target,
    free: Iterable[str] | Mapping[str, tuple[float, float]] | None = None,
    base: Parameters | None = None,
    *,
    points: int = 6,
    width: float = 0.005,
    scan: int = 16,
    evaluations: int = 80,
    grid: int = 0,
    out: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Calibration:
    """Fit constants of the model to a separating line or to measured collisions.

    For each trial set of constants the separating line is simulated at a few places in
    x = Ca Ã z̃ and compared with the target. The search is that of Nelder and Mead, in logarithms
    and within bounds, from the base on; it finds the valley that the base lies in.

    Parameters
    ----------
    target : str, path-like, DataFrame, Line, LineTarget or CollisionsTarget
        ``"paper-simulation"``, ``"paper-experiment"``, a line, or collisions with the columns
        ``symmetry``, ``capillary_number``, ``normalized_area``, ``normalized_thickness`` and
        ``broke`` as a table, Parquet or CSV file. Collisions are compared by the log loss of
        `CollisionsTarget.loss`, lines by their rms distance in ln S.
    free : iterable of str, or mapping of str to (float, float), optional
        Names of the constants to fit, or names and bounds, among ``edge_stiffness``,
        ``neck_separation``, ``neck_thickness``, ``line_tension`` and ``conversion``, which is c in
        Ca = c Ca_sim. Whole numbers such as ``vertex_count`` stay as they are. By default
        ``edge_stiffness`` and ``neck_thickness``; with front tracking, which has no springs,
        ``neck_separation`` and ``neck_thickness``.
    base : Parameters, optional
        The other constants, and where to start; the default preset unless given.
    points : int, optional
        Places in x, evenly spaced in ln x over the target's range.
    width, scan : float and int, optional
        As of `pinchoff.boundary`.
    evaluations : int, optional
        The most evaluations of the search.
    grid : int, optional
        Values of each constant for the landscapes in `LANDSCAPES`; 0: none are made.
    out : path-like, optional
        Folder for the evaluations, which a second call with the same settings takes up.
    threads : int, optional
        How many threads; by default as many as there are cores for this process.
    progress : bool, optional
        Whether to show a bar on stderr; by default in terminals and notebooks.

    Returns
    -------
    Calibration

    Raises
    ------
    InputError
        An argument is wrong, or `out` holds evaluations of other settings.
    PinchoffError
        An evaluation cannot be written; what is there stays.

    Examples
    --------
    >>> import pinchoff as po
    >>> coarse = po.Parameters(vertex_count=48)
    >>> found = po.calibrate("paper-simulation", {"edge_stiffness": (2, 4)}, coarse, points=3,
    ...                      width=0.1, scan=6, evaluations=4)
    >>> found.best.objective <= found.start.objective
    True
    """
    aim = as_target(target)
    model = _base(aim, base)
    bounds = bounds_of(DEFAULT_FREE[model.model] if free is None else free, model)
    checked_whole("points", points, "use 6", low=3, high=50)
    checked_whole("evaluations", evaluations, "use 80", low=1, high=100_000)
    if grid:
        checked_whole("grid", grid, "use 7, or 0 for no landscapes", low=3, high=50)
    control = np.geomspace(*aim.control_range, points)
    with nullcontext() if out is None else held_folder(Path(out)):
        evaluator = Evaluator(
            aim,
            model,
            control,
            _settings(aim, model, bounds, points, width, scan),
            None if out is None else Path(out) / LOG,
            width=width,
            scan=scan,
            threads=thread_count(threads),
        )
        found = _explored(evaluator, bounds, model, evaluations, grid, wanted_progress(progress))
    parameters = evaluator.parameters(found["best"].changes)
    return Calibration(
        target=aim,
        parameters=parameters,
        bounds=bounds,
        control=control,
        evaluations=_evaluations_table(evaluator),
        conversion=match_onset(aim, parameters, threads=threads),
        **found,
    )


def _explored(
    evaluator: Evaluator, bounds: Bounds, model: Parameters, most: int, grid: int, with_bar: bool
) -> dict[str, Any]:
    """Return what the search finds, the landscapes and the sensitivities, as of `Calibration`."""
    pairs = [pair for pair in LANDSCAPES if has_meaning(pair, model)] if grid else []
    with progress_bar(with_bar, "evaluations", 1 + most + len(pairs) * grid**2) as show:
        evaluator.on_evaluation = show
        start = evaluator(values_of(bounds, model))
        best, converged = _search(evaluator, bounds, start, most)
        landscapes = [
            landscape(evaluator, best, names, grid_of(names, bounds, model, grid))
            for names in pairs
        ]
        evaluator.on_evaluation = None
        sensitivity = sensitivity_table(evaluator, best)
    return {
        "start": start,
        "best": best,
        "converged": converged,
        "landscapes": landscapes,
        "sensitivity": sensitivity,
    }


def _search(
    evaluator: Evaluator, bounds: Bounds, start: Evaluation, most: int
) -> tuple[Evaluation, bool]:
    """Return the best evaluation of a search from the start, and whether it came to an end."""
    from scipy.optimize import minimize

    names = list(bounds)
    ends = np.array([bounds[name] for name in names]).T
    low, span = np.log(ends[0]), np.log(ends[1] / ends[0])
    found = [start]

    def objective(place: Floats) -> float:
        values = np.clip(np.exp(low + span * place), *ends)  # rounding must not leave the bounds
        changes = dict(zip(names, values.tolist(), strict=True))
        found.append(evaluator(changes))
        return found[-1].objective

    origin = (np.log([start.changes[name] for name in names]) - low) / span
    steps = np.where(origin > 0.5, -_FIRST_STEP, _FIRST_STEP)
    simplex = np.vstack([origin, origin + np.diag(steps)])
    options = {"initial_simplex": simplex, "maxfev": most, "xatol": _TOLERANCE, "fatol": _FLATNESS}
    result = minimize(
        objective, origin, method="Nelder-Mead", bounds=[(0, 1)] * len(names), options=options
    )
    return min(found, key=lambda evaluation: evaluation.objective), bool(result.success)


def _base(target: Target, base: Parameters | None) -> Parameters:
    model = Parameters() if base is None else base
    require_parameters("base", model)
    changes = {} if target.size_ratio is None else {"size_ratio": target.size_ratio}
    return model.replace(offset=0.0, follow_daughters=False, scale=None, **changes)


def _settings(
    target: Target, model: Parameters, bounds: Bounds, points: int, width: float, scan: int
) -> dict[str, Any]:
    from pinchoff import __version__

    return {
        "format": _FORMAT,
        "pinchoff_version": __version__,
        "target": target.settings(),
        "base": model.model_dump(mode="json"),
        "free": {name: list(ends) for name, ends in bounds.items()},
        "points": points,
        "width": width,
        "scan": scan,
    }


def _evaluations_table(evaluator: Evaluator) -> pd.DataFrame:
    import pandas as pd

    rows = [
        {
            **evaluation.changes,
            "objective": evaluation.objective,
            "runs": evaluation.runs,
            "failed": evaluation.failed_runs,
        }
        for evaluation in evaluator
    ]
    return pd.DataFrame(rows)
