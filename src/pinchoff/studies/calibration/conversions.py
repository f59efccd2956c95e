"""The conversion c in Ca = c Ca_sim, from where head-on droplets begin to break."""

from __future__ import annotations

import warnings
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pinchoff.model.parameters import Parameters
from pinchoff.model.simulation import simulate_many
from pinchoff.studies.calibration.targets import Target

_RANGE = (1.0, 1000.0)  # Ca_sim in which the onset is looked for
_PARTS = 8  # intervals into which the range, then every bracket, is cut
_WIDTH = 0.002  # width of the last bracket, in ln Ca_sim
_LATEST = 100.0  # time limit, t0: a head-on droplet may stay on the obstacle for long
_OFFSET = 1e-6  # start y, D0: at 0 round-off would decide when a droplet slides off


@dataclass(frozen=True)
class Conversion:
    """c from matching the onset of break-up, S_c = 1, of simulation and target.

    Attributes
    ----------
    value : float
        c, with the constants as they are.
    low, high : float
        Range of c over the vertex counts, the brackets of the onset and the interval of the
        target's onset. It is a range, not a confidence interval.
    target_onset : (float, float, float)
        x = Ca Ã z̃ at S_c = 1 of the target, and its interval.
    simulated_onset : dict of int to (float, float)
        By vertex count: largest Ca_sim at which a head-on droplet does not break, and smallest
        at which it does.
    """

    value: float
    low: float
    high: float
    target_onset: tuple[float, float, float]
    simulated_onset: dict[int, tuple[float, float]]

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        return asdict(self)


def head_on_onset(
    parameters: Parameters, *, threads: int | None = None
) -> tuple[float, float] | None:
    """Return a bracket of the Ca_sim at which head-on droplets begin to break, or None.

    It is the largest Ca_sim that does not break and the smallest that does, 0.2 % apart, the first
    such pair from below; None where there is none from 1 to 1000. Offset, Ca_sim and time limit of
    the parameters do not matter.
    """
    limit = max(parameters.time_limit, _LATEST)
    model = parameters.replace(offset=_OFFSET, follow_daughters=False, time_limit=limit, scale=None)
    values = np.geomspace(*_RANGE, _PARTS + 1)
    first = _first_that_breaks(model, values, threads)
    if not 0 < first < len(values):
        return None
    low, high = float(values[first - 1]), float(values[first])
    while np.log(high / low) > _WIDTH:
        values = np.geomspace(low, high, _PARTS + 1)
        first = 1 + _first_that_breaks(model, values[1:-1], threads)  # the ends are known
        low, high = float(values[first - 1]), float(values[first])
    return low, high


def _first_that_breaks(model: Parameters, values: NDArray[np.float64], threads: int | None) -> int:
    """Return the place of the first Ca_sim at which the model breaks; past the last for none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a failed run did not break
        runs = simulate_many(
            [model.replace(simulation_capillary_number=float(ca)) for ca in values],
            threads=threads,
            progress=False,
        )
    broke = runs["broke"].fillna(False).to_numpy(dtype=bool)
    return int(np.argmax([*broke, True]))


def match_onset(
    target: Target, parameters: Parameters, *, threads: int | None = None
) -> Conversion | None:
    """Return the c that puts the simulated onset on that of the target; None without either.

    The onset is found with the model's number of vertices and with twice as many, because no other
    constant of the numerics changes it as much as N_v.
    """
    aim = target.onset()
    if aim is None:
        return None
    counts = (parameters.vertex_count, min(2 * parameters.vertex_count, 1024))
    brackets = {}
    for count in counts:
        bracket = head_on_onset(parameters.replace(vertex_count=count), threads=threads)
        if bracket is None:
            return None
        brackets[count] = bracket
    scale = parameters.normalized_area * parameters.normalized_thickness
    onset = float(np.sqrt(np.prod(brackets[counts[0]])))
    ends = [end for bracket in brackets.values() for end in bracket]
    return Conversion(
        value=aim[0] / (scale * onset),
        low=min(aim) / (scale * max(ends)),
        high=max(aim) / (scale * min(ends)),
        target_onset=aim,
        simulated_onset=brackets,
    )
