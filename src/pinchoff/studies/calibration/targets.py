"""What a calibration aims at: a separating line, or measured collisions.

Both are asked at the same places, values of x = Ca Ã z̃, how far a simulated line is from them.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, PAPER_SIMULATION_LINE, Line
from pinchoff.collisions.reading import read_table
from pinchoff.fits.intervals import inverse_curvature
from pinchoff.fits.likelihood import LogisticLikelihood, maximum
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

Floats: TypeAlias = NDArray[np.float64]

PAPER_RANGE = (0.04, 0.2)
"""Ca Ã z̃ over which a line is compared unless said otherwise: where the paper's stars lie."""

TABLE_COLUMNS = (
    "symmetry",
    "capillary_number",
    "normalized_area",
    "normalized_thickness",
    "broke",
)
"""Columns that measured collisions must have."""

_FEWEST_ROWS = 20
_WIDTHS = (0.005, 1.0)  # of the transition, in ln S


def _require_number(name: str, value: object, low: float, high: float, advice: str) -> None:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (number and low <= float(value) <= high):  # type: ignore[arg-type]
        raise InputError.of(name, f"a finite number from {low:g} to {high:g}", value, advice)


@dataclass(frozen=True)
class LineTarget:
    """A separating line S_c = α x^β with x = Ca Ã z̃, over a range of x.

    Attributes
    ----------
    alpha, beta : float
        Prefactor, positive, and exponent, negative.
    control_range : (float, float)
        Least and greatest x that count.
    size_ratio : float, optional
        D0/R of the droplets behind the line; by default that of the calibration's base.
    name : str
        What to call it in reports.
    """

    alpha: float
    beta: float
    control_range: tuple[float, float] = PAPER_RANGE
    size_ratio: float | None = None
    name: str = "line"

    objective_name = "rms distance in ln S"

    def __post_init__(self) -> None:
        _require_number("alpha", self.alpha, 1e-6, 1e3, "use 0.089")
        _require_number("beta", self.beta, -10, -1e-3, "use -0.72")
        try:
            low, high = self.control_range
        except (TypeError, ValueError):
            low, high = math.nan, math.nan
        if not (0 < low < high < math.inf):
            rule = "two positive, finite numbers, the lower one first"
            advice = "use (0.04, 0.2)"
            raise InputError.of("control_range", rule, self.control_range, advice)

    def symmetry(self, control: Floats) -> Floats:
        """Return S_c on the line at x, shape (n,)."""
        return np.asarray(self.alpha * control**self.beta, dtype=np.float64)

    def loss(self, control: Floats, critical: Floats) -> float:
        """Return the root mean square of ln of simulated over given S_c.

        Parameters
        ----------
        control, critical : ndarray, shape (n,)
            x, and the simulated S_c there.
        """
        distance = np.log(critical / self.symmetry(control))
        return float(np.sqrt(np.mean(distance**2)))

    def onset(self) -> tuple[float, float, float]:
        """Return x at S_c = 1, and a range that is empty: a line comes without uncertainty."""
        value = self.alpha ** (-1 / self.beta)
        return value, value, value

    def settings(self) -> dict[str, Any]:
        """Return what defines the target, for JSON."""
        return {
            "kind": "line",
            "name": self.name,
            "alpha": self.alpha,
            "beta": self.beta,
            "control_range": list(self.control_range),
            "size_ratio": self.size_ratio,
        }


class CollisionsTarget:
    """Measured collisions, and how well a simulated line tells those that broke from the rest.

    Rows that miss one of the numbers, have S = 0 or are not accepted are left out. Sizes differ
    from row to row; the model has one, their median.

    Parameters
    ----------
    table : DataFrame
        With `TABLE_COLUMNS`.
    name : str, optional
        What to call it in reports.

    Attributes
    ----------
    size_ratio : float
        Median D0/R of the rows.
    control_range : (float, float)
        From the 1 % to the 99 % quantile of x = Ca Ã z̃.
    count : int
        Rows that are used.

    Raises
    ------
    InputError
        Columns are missing, are not numbers, or fewer than 20 rows or one outcome is left.
    """

    objective_name = "mean log loss"

    def __init__(self, table: pd.DataFrame, name: str = "collisions") -> None:
        missing = [column for column in TABLE_COLUMNS if column not in table.columns]
        if missing:
            got = f"a table without {', '.join(missing)}"
            rule = f"collisions with the columns {', '.join(TABLE_COLUMNS)}"
            raise InputError.of("target", rule, got, "add them")
        if "accepted" in table.columns:
            table = table[table["accepted"].astype(bool)]
        numbers = {column: _numbers(table, column) for column in TABLE_COLUMNS}
        sound = np.all([np.isfinite(each) & (each >= 0) for each in numbers.values()], axis=0)
        sound &= np.all([numbers[column] > 0 for column in TABLE_COLUMNS[:4]], axis=0)
        area = numbers["normalized_area"][sound]
        control = numbers["capillary_number"] * numbers["normalized_area"]
        self._control: Floats = (control * numbers["normalized_thickness"])[sound]
        self._symmetry: Floats = numbers["symmetry"][sound]
        self._broke: NDArray[np.bool_] = numbers["broke"][sound] > 0
        self.count = int(sound.sum())
        _require_rows(self.count, self._broke)
        self.name = name
        self.size_ratio = float(np.sqrt(4 / math.pi * np.median(area)))
        low, high = np.quantile(self._control, [0.01, 0.99])
        self.control_range = (float(low), float(high))
        if not low < high:
            got = f"Ca Ã z̃ = {low:.4g} in nearly all rows"
            raise InputError.of("target", "collisions that differ in Ca Ã z̃", got, "add others")

    def loss(self, control: Floats, critical: Floats) -> float:
        r"""Return the mean log loss of a logistic transition across the simulated line.

        .. math:: p = 1/(1 + (S_c(x)/S)^{1/w})

        is the probability of break-up of a row; S_c between the places is interpolated in
        logarithms. The width w, in ln S, is the one that makes the loss least.

        Parameters
        ----------
        control, critical : ndarray, shape (n,)
            x, ascending, and the simulated S_c there.
        """
        from scipy.optimize import minimize_scalar

        line = np.interp(np.log(self._control), np.log(control), np.log(critical))
        above = np.where(self._broke, 1.0, -1.0) * (np.log(self._symmetry) - line)

        def mean_loss(log_width: float) -> float:
            return float(np.mean(np.logaddexp(0.0, -above / math.exp(log_width))))

        bounds = tuple(map(math.log, _WIDTHS))
        return float(minimize_scalar(mean_loss, bounds=bounds, method="bounded").fun)

    def onset(self) -> tuple[float, float, float] | None:
        """Return x at S_c = 1 of the rows' own power law, and the ends of its 95 % interval.

        The law is a logistic regression of the outcome on ln S and ln x; the interval follows
        from its covariance to first order. None where the rows do not decide it, as when a line
        separates them without a single exception.
        """
        design = np.stack(
            [np.ones(self.count), np.log(self._symmetry), np.log(self._control)], axis=1
        )
        best = maximum(LogisticLikelihood(design, self._broke))
        intercept, _, slope = best.coefficients.tolist()
        if best.doubtful or slope <= 0:
            return None
        covariance = inverse_curvature(best)
        log_onset = -intercept / slope
        gradient = np.array([-1 / slope, 0.0, intercept / slope**2])
        reach = 1.96 * math.sqrt(gradient @ covariance @ gradient)
        value, low, high = (math.exp(log_onset + k * reach) for k in (0, -1, 1))
        return value, low, high

    def settings(self) -> dict[str, Any]:
        """Return what defines the target, for JSON: rows by their digest."""
        rows = np.stack([self._control, self._symmetry, self._broke.astype(np.float64)])
        return {
            "kind": "collisions",
            "name": self.name,
            "rows": self.count,
            "digest": hashlib.sha256(rows.tobytes()).hexdigest(),
            "control_range": list(self.control_range),
            "size_ratio": self.size_ratio,
        }


Target: TypeAlias = LineTarget | CollisionsTarget

PRESETS: Mapping[str, LineTarget] = {
    "paper-simulation": LineTarget(*PAPER_SIMULATION_LINE, name="paper-simulation"),
    "paper-experiment": LineTarget(*PAPER_EXPERIMENT_LINE, name="paper-experiment"),
}
"""Targets by name: the lines that the paper fits to its simulations and to its experiments."""


def as_target(target: object) -> Target:
    """Make a target of what stands for one.

    Parameters
    ----------
    target : str, path-like, DataFrame, Line, LineTarget or CollisionsTarget
        A name in `PRESETS`; a Parquet or CSV file of collisions; the table itself; a line.

    Raises
    ------
    InputError
        It is none of these, or the file cannot be read.
    """
    if isinstance(target, (LineTarget, CollisionsTarget)):
        return target
    if isinstance(target, Line):
        return LineTarget(*target)
    if isinstance(target, str) and target in PRESETS:
        return PRESETS[target]
    if isinstance(target, (str, os.PathLike)):
        path = Path(target)
        if isinstance(target, str) and not path.suffix and not path.exists():
            rule = "paper-simulation, paper-experiment or a file of collisions"
            raise unknown_name("target", rule, target, PRESETS)
        return CollisionsTarget(read_table(path), name=path.name)
    import pandas as pd

    if isinstance(target, pd.DataFrame):
        return CollisionsTarget(target)
    advice = "give 'paper-simulation', a LineTarget or a table of collisions"
    raise InputError.of("target", "a line or a table of collisions", target, advice)


def _numbers(table: pd.DataFrame, column: str) -> Floats:
    import pandas as pd

    try:
        values = pd.to_numeric(table[column]).to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError):
        rule = "numbers" if column != "broke" else "true or false, or 1 or 0"
        got = str(table[column].dtype)
        raise InputError.of(f"target[{column!r}]", rule, got, "correct the column") from None
    return np.asarray(values)


def _require_rows(count: int, broke: NDArray[np.bool_]) -> None:
    if count < _FEWEST_ROWS:
        rule = f"{_FEWEST_ROWS} or more collisions with all of {', '.join(TABLE_COLUMNS)}"
        raise InputError.of("target", rule, f"{count}", "add collisions")
    if broke.all() or not broke.any():
        got = f"{count} of one outcome"
        raise InputError.of(
            "target", "collisions of which some broke and some did not", got, "add others"
        )
