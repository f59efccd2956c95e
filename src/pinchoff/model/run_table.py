"""Many runs, as columns of the collisions table: what was set, what happened, also in µm and s."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff import _core
from pinchoff.collisions.law import breakup_number_of
from pinchoff.collisions.reasons import BROKE_BEFORE_CONTACT, NO_CONTACT
from pinchoff.collisions.schema import COLUMNS, OUTCOMES, Column
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import PARAMETERS, SPRINGS, Parameters
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.model.flow import Flow

FAILED = OUTCOMES.index("failed")

CHUNK_SIZE = 4096
"""Runs that are prepared and held at once, so that a sweep's memory is that of its table."""


def run_batch(
    parameters: Sequence[Parameters],
    ids: Sequence[int],
    *,
    threads: int,
    flow: Flow | None = None,
    varied: Iterable[str] = (),
    show: Callable[[int], object] | None = None,
) -> dict[str, NDArray[Any]]:
    """Run one droplet against one obstacle for each set of parameters.

    Parameters
    ----------
    parameters, ids : sequences of n
        Of each run; its id is the ``collision_id``.
    threads : int
    flow : Flow, optional
        One for all runs; by default the Stokes flow around each run's own obstacle.
    varied : iterable of str, optional
        Names of parameters that differ between the runs of the table, which gets their columns.
    show : callable, optional
        Called with the number of runs that are done.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        Every column of `pinchoff.collisions.schema.COLUMNS` and of `varied_columns`.

    Raises
    ------
    InputError
        A given time step is unstable; the message names the run by its id.
    """
    models = np.array([_model_row(p, number) for p, number in zip(parameters, ids, strict=True)])
    results = _core.run_many(models, flow, threads, show)
    columns = run_columns(parameters, results, ids)
    for name, column in varied_columns(varied).items():
        kind = object if column.dtype == "str" else column.dtype
        if name != "time_step":
            # None, of another model's constants, is NaN
            columns[column.name] = np.array([getattr(p, name) for p in parameters], dtype=kind)
        else:  # "auto" stands for a number
            columns[column.name] = models[:, _core.MODEL_FIELDS.index(name)]
    return columns


def _model_row(parameters: Parameters, number: int) -> NDArray[np.float64]:
    try:
        return parameters.model_row()
    except InputError as error:
        raise error.within(f"parameters[{number}]") from None


def varied_columns(names: Iterable[str]) -> dict[str, Column]:
    """Return columns for the varied parameters that a table would not show otherwise.

    Names of physical quantities are passed over.
    """
    in_every_table = {column.name for column in COLUMNS}
    columns = {name: PARAMETERS[name].as_column() for name in names if name in PARAMETERS}
    return {name: column for name, column in columns.items() if column.name not in in_every_table}


def run_columns(
    parameters: Sequence[Parameters],
    results: NDArray[np.float64],
    ids: Sequence[int] = (0,),
    met: Mapping[str, float] | None = None,
) -> dict[str, NDArray[Any]]:
    """Return runs as every column of `pinchoff.collisions.schema.COLUMNS`, shape (n,) each.

    Parameters
    ----------
    parameters : sequence of n Parameters
    results : ndarray, shape (n, len(_core.RESULT_FIELDS))
        What the core returned for them.
    ids : sequence of n int, optional
        The ``collision_id`` of each run.
    met : mapping of str to float, optional
        What `first_meeting` says in place of the parameters.
    """
    result = dict(zip(_core.RESULT_FIELDS, results.T, strict=True))
    columns: dict[str, NDArray[Any]] = {
        "source": np.full(len(parameters), "simulation", dtype=object),
        "collision_id": np.array(ids, dtype=np.int64),
        **_parameter_columns(parameters),
        **_event_columns(parameters, result),
    }
    columns |= _speed_columns(parameters, columns)
    columns |= _physical_columns(parameters, columns)
    columns |= {name: np.full(len(parameters), value) for name, value in (met or {}).items()}
    columns["breakup_number"] = breakup_number_of(columns)
    return {column.name: columns[column.name] for column in COLUMNS}


def first_meeting(
    parameters: Parameters,
    contacts: Sequence[Mapping[str, Any]],
    obstacles: NDArray[np.float64],
    droplets: NDArray[np.float64],
) -> dict[str, float]:
    """Return the columns that the droplet and the obstacle of the first contact decide.

    They are NaN where nothing met, or only what a droplet without contact had broken into.

    Parameters
    ----------
    parameters : Parameters
    contacts : sequence of mapping
        The run's contacts in the order of their times.
    obstacles, droplets : ndarray, shape (M, 3) and (K, 3)
        Centre and radius of each obstacle, start and diameter of each droplet, D0.
    """
    y = radius = start_y = diameter = math.nan
    if contacts and contacts[0]["droplet_id"] < len(droplets):
        _, y, radius = obstacles[contacts[0]["obstacle"]].tolist()
        _, start_y, diameter = droplets[contacts[0]["droplet_id"]].tolist()
    unit_um = math.nan if parameters.scale is None else parameters.scale.diameter_um
    return {
        "size_ratio": diameter / radius,
        "offset": start_y - y,
        "normalized_area": math.pi / 4.0 * (diameter / radius) ** 2,
        "obstacle_radius_um": radius * unit_um,
    }


def _parameter_columns(parameters: Sequence[Parameters]) -> dict[str, NDArray[np.float64]]:
    names = (
        "size_ratio",
        "simulation_capillary_number",
        "offset",
        "capillary_number",
        "ca_per_ca_sim",
        "normalized_area",
        "normalized_thickness",
    )
    return {name: np.array([getattr(p, name) for p in parameters], float) for name in names}


def _speed_columns(
    parameters: Sequence[Parameters], columns: dict[str, NDArray[Any]]
) -> dict[str, NDArray[Any]]:
    """Return the speed that Ca uses, and Ca; NaN without a contact, if it uses the speed there."""
    own = np.array([p.ca_speed == "contact" for p in parameters], dtype=bool)
    capillary = columns["capillary_number"]
    return {
        "ca_speed": np.array([p.ca_speed for p in parameters], dtype=object),
        "capillary_number": np.where(own, capillary * columns["contact_speed"], capillary),
    }


def spring_tension_ratio(parameters: Parameters, perimeter: float) -> float:
    """Return the mean tension of the springs over line tension, of an outline's perimeter P, D0.

    Each of N edges pulls with k_l N (l - l_eq), so that their mean is k_l (P - P_eq).

    Examples
    --------
    >>> from pinchoff.model.parameters import Parameters
    >>> round(spring_tension_ratio(Parameters(edge_stiffness=3), math.pi + 1), 2)
    3.0
    """
    count = parameters.vertex_count
    resting = math.sqrt(math.pi * count * math.tan(math.pi / count))
    return (parameters.edge_stiffness or 0.0) * (perimeter - resting)


def _event_columns(
    parameters: Sequence[Parameters], result: dict[str, NDArray[np.float64]]
) -> dict[str, NDArray[Any]]:
    code = result["outcome"].astype(np.int64)
    failed, broke = code == FAILED, result["breakup_count"] > 0
    # A neck is infinite while the outline has no two sides far enough apart: nothing measured.
    neck = np.where(np.isfinite(result["minimum_neck"]), result["minimum_neck"], math.nan)
    counts = ("breakup_count", "generations", "droplet_count", "steps", "vertex_updates")
    same = (
        "symmetry",
        "impact_parameter",
        "contact_time",
        "contact_speed",
        "contact_area",
        "contact_shape_parameter",
        "maximum_shape_parameter",
        "small_daughter_area",
        "large_daughter_area",
        "breakup_time",
        "breakup_neck",
        "end_time",
    )
    return {
        "outcome": np.array(OUTCOMES, dtype=object)[code],
        "broke": np.where(failed & ~broke, math.nan, broke),
        "accepted": ~failed & np.isfinite(result["contact_time"]) & ~_broke_early(result),
        "reject_reason": _reject_reasons(parameters, result),
        "speed": result["contact_speed"],
        "neck_thickness": neck,
        "minimum_neck": neck,
        "spring_tension_ratio": np.array(
            [
                spring_tension_ratio(p, perimeter)
                for p, perimeter in zip(
                    parameters, result["maximum_perimeter"].tolist(), strict=True
                )
            ]
        ),
        "daughter_area_ratio": result["small_daughter_area"] / result["large_daughter_area"],
        **{name: result[name] for name in same},
        **{name: result[name].astype(np.int64) for name in counts},
    }


def _reject_reasons(
    parameters: Sequence[Parameters], result: dict[str, NDArray[np.float64]]
) -> NDArray[Any]:
    reasons = np.full(result["guard"].size, "", dtype=object)
    reasons[np.isnan(result["contact_time"])] = NO_CONTACT
    reasons[_broke_early(result)] = BROKE_BEFORE_CONTACT
    for i in np.flatnonzero(result["outcome"] == FAILED).tolist():
        guard = _core.GUARDS[int(result["guard"][i])]
        value, time = result["guard_value"][i], result["guard_time"][i]
        reasons[i] = guard_message(guard, value, time, springs=parameters[i].model == SPRINGS)
    return reasons


def _broke_early(result: dict[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    """Tell where the droplet that met the obstacle was no mother any more.

    Where both times are the same it was a daughter if it was not much larger than the larger one.
    """
    small, large = result["small_daughter_area"], result["large_daughter_area"]
    daughter = result["contact_area"] < large + 0.5 * small
    time, contact_time = result["breakup_time"], result["contact_time"]
    early: NDArray[np.bool_] = (time < contact_time) | ((time == contact_time) & daughter)
    return early


def _physical_columns(
    parameters: Sequence[Parameters], columns: dict[str, NDArray[Any]]
) -> dict[str, NDArray[np.float64]]:
    def of_scale(name: str) -> NDArray[np.float64]:
        return np.array(
            [math.nan if p.scale is None else getattr(p.scale, name) for p in parameters]
        )

    diameter_um = of_scale("diameter_um")
    names = ("obstacle_radius_um", "thickness_um", "viscosity_mPa_s", "surface_tension_mN_m")
    no_image = np.full(len(parameters), math.nan)
    return {
        "contact_time_s": columns["contact_time"] * of_scale("time_unit_s"),
        "obstacle_x_um": no_image,
        "obstacle_y_um": no_image,
        "area_um2": columns["contact_area"] * diameter_um**2,
        "speed_mm_s": columns["contact_speed"] * of_scale("speed_mm_s"),
        "neck_um": columns["minimum_neck"] * diameter_um,
        **{name: of_scale(name) for name in names},
    }
