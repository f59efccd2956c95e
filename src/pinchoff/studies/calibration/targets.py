"""What a calibration aims at: a separating line, or measured collisions.

Each is given a simulated line at some values of x = Ca Ã z̃, and tells how far it is from it.
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

from pinchoff.collisions.importing import ImportedCollisions, checked_collisions
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, PAPER_SIMULATION_LINE, Line
from pinchoff.fits.form import Form
from pinchoff.fits.intervals import inverse_curvature, normal_quantile
from pinchoff.fits.likelihood import LogisticLikelihood, maximum
from pinchoff.fits.rows import Rows, rows_of
from pinchoff.support.arguments import checked_number, checked_positive, finite_or_nan
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

Floats: TypeAlias = NDArray[np.float64]

PAPER_RANGE = (0.04, 0.2)
"""Ca Ã z̃ over which a line is compared unless said otherwise: where the paper's stars lie."""

_FEWEST_ROWS = 20
_WIDTHS = (0.005, 1.0)  # narrowest and widest transition, in ln S


def checked_ends(argument: str, ends: Any, what: str, advice: str) -> tuple[float, float]:
    """Return the two ends of a range as numbers; `what` they are completes the rule."""
    try:
        low, high = map(finite_or_nan, ends)
    except (TypeError, ValueError):
        low, high = math.nan, math.nan
    if not 0 < low < high:
        rule = f"two positive, finite {what}, the lower one first"
        raise InputError.of(argument, rule, ends, advice)
    return low, high


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

    Examples
    --------
    >>> import pinchoff as po
    >>> target = po.LineTarget(0.089, -0.72)
    >>> round(target.onset()[0], 4)  # Ca Ã z̃ at which head-on droplets begin to break
    0.0347
    """

    alpha: float
    beta: float
    control_range: tuple[float, float] = PAPER_RANGE
    size_ratio: float | None = None
    name: str = "line"

    objective_name = "rms distance in ln S"

    def __post_init__(self) -> None:
        checked_number("alpha", self.alpha, "use 0.089", low=1e-6, high=1e3)
        checked_number("beta", self.beta, "use -0.72", low=-10, high=-1e-3)
        checked_ends("control_range", self.control_range, "numbers", "use (0.04, 0.2)")
        if self.size_ratio is not None:
            checked_positive("size_ratio", self.size_ratio, "give D0/R, or leave it out")

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
    """Measured collisions as a target: how well a simulated line separates those that broke.

    They are read and checked as for `pinchoff.fit_law`, and the same rows are used. Sizes differ
    from row to row; the model takes their median for all.

    Parameters
    ----------
    table : DataFrame, ImportedCollisions or path
        As of `pinchoff.fit_law`.
    name : str, optional
        What to call it in reports; by default the name of the file.

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
        The table is refused, or fewer than 20 rows are left.

    Warns
    -----
    UserWarning
        Rows were set aside.

    Examples
    --------
    >>> import pinchoff as po
    >>> target = po.CollisionsTarget(po.virtual_experiment(seed=1, n=1000))
    >>> target.count
    1000
    """

    objective_name = "mean log loss"

    def __init__(
        self,
        table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str],
        name: str | None = None,
    ) -> None:
        rows, area = _read_rows(table)
        _, self._log_control, self._log_symmetry = rows.features.T
        self._features, self._broke = rows.features, rows.broke
        self.count = len(rows)
        if self.count < _FEWEST_ROWS:
            got, advice = f"{self.count}", "add collisions"
            raise InputError.of("target", f"{_FEWEST_ROWS} or more collisions", got, advice)
        file = isinstance(table, (str, os.PathLike))
        self.name = name or (Path(table).name if file else "collisions")  # type: ignore[arg-type]
        self.size_ratio = float(np.sqrt(4 / math.pi * np.median(area)))
        low, high = np.exp(np.quantile(self._log_control, [0.01, 0.99]))
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

        line = np.interp(self._log_control, np.log(control), np.log(critical))
        above = np.where(self._broke, 1.0, -1.0) * (self._log_symmetry - line)

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
        best = maximum(LogisticLikelihood(self._features, self._broke))
        intercept, slope, _ = best.coefficients.tolist()
        if best.doubtful or slope <= 0:
            return None
        covariance = inverse_curvature(best)
        log_onset = -intercept / slope
        gradient = np.array([-1 / slope, intercept / slope**2, 0.0])
        reach = normal_quantile(0.95) * math.sqrt(gradient @ covariance @ gradient)
        value, low, high = (math.exp(log_onset + k * reach) for k in (0, -1, 1))
        return value, low, high

    def settings(self) -> dict[str, Any]:
        """Return what defines the target, for JSON: rows by their digest."""
        rows = np.column_stack([self._features, self._broke])
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
    """Make a target of a name in `PRESETS`, a line, or collisions as `pinchoff.fit_law` takes them.

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
        return CollisionsTarget(path)
    import pandas as pd

    if isinstance(target, (pd.DataFrame, ImportedCollisions)):
        return CollisionsTarget(target)
    advice = "give 'paper-simulation', a LineTarget or a table of collisions"
    raise InputError.of("target", "a line or a table of collisions", target, advice)


def _read_rows(
    table: pd.DataFrame | ImportedCollisions | str | os.PathLike[str],
) -> tuple[Rows, Floats]:
    """Return the rows that a fit would use, and Ã of each."""
    try:
        collisions = checked_collisions(table, stacklevel=5).table
        rows = rows_of(collisions, Form())
    except InputError as error:
        if error.argument == "table":
            raise error.renamed("target") from None
        file = isinstance(table, (str, os.PathLike)) and error.argument == str(table)
        raise error if file else error.within("target") from None
    return rows, collisions["normalized_area"].to_numpy(dtype=np.float64)[rows.places]
