"""What comes out of runs: one `Collision`, or the columns of many."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff import _core
from pinchoff.collisions.law import breakup_number_of
from pinchoff.collisions.reasons import BROKE_BEFORE_CONTACT, NO_CONTACT
from pinchoff.collisions.schema import COLUMNS, OUTCOMES
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import SPRINGS
from pinchoff.support.drawing import Drawable, artist
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.model.outlines import Outlines
    from pinchoff.model.parameters import Parameters

_FAILED = OUTCOMES.index("failed")


def run_columns(
    parameters: Sequence[Parameters],
    results: NDArray[np.float64],
    ids: Sequence[int] = (0,),
    met: Mapping[str, float] | None = None,
) -> dict[str, NDArray[Any]]:
    """Return runs as columns of the collisions table.

    Parameters
    ----------
    parameters : sequence of n Parameters
    results : ndarray, shape (n, len(_core.RESULT_FIELDS))
        What the core returned for them.
    ids : sequence of n int, optional
        The ``collision_id`` of each run.
    met : mapping of str to float, optional
        What `first_meeting` says in place of the parameters.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        Every column of `pinchoff.collisions.schema.COLUMNS`.
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

    Parameters
    ----------
    parameters : Parameters
    contacts : sequence of mapping
        The run's contacts in the order of their times.
    obstacles, droplets : ndarray, shape (M, 3) and (K, 3)
        Centre and radius of each obstacle, start and diameter of each droplet, D0.

    Returns
    -------
    dict of str to float
        NaN where nothing met, or only what a droplet without contact had broken into.
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
    failed, broke = code == _FAILED, result["breakup_count"] > 0
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
    for i in np.flatnonzero(result["outcome"] == _FAILED).tolist():
        guard = _core.GUARDS[int(result["guard"][i])]
        value, time = result["guard_value"][i], result["guard_time"][i]
        reasons[i] = guard_message(guard, value, time, springs=parameters[i].model == SPRINGS)
    return reasons


def _broke_early(result: dict[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    early: NDArray[np.bool_] = result["breakup_time"] < result["contact_time"]
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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Collision(Drawable):
    """What came of one collision. Lengths in D0, speeds in v_f∞, times in t0; NaN: did not happen.

    Attributes
    ----------
    parameters : Parameters
    outcome : str
        "slipped", "broke" or "captured": the time limit came before the droplet had left the
        obstacle behind.
    broke : bool
    symmetry, impact_parameter : float
        S [paper, eq. symdef] and b at first contact.
    contact_time, contact_speed, contact_area, contact_shape_parameter : float
        First contact: when, the centroid's speed, and the outline's area and 𝒜 = P²/(4πA).
    minimum_neck, maximum_shape_parameter : float
        Thinnest neck and largest 𝒜, from first contact on, until the first break-up.
    spring_tension_ratio : float
        Greatest mean tension of the springs over line tension, in the same span; 0 without springs.
    daughter_area_ratio : float
        Smaller over larger daughter of the first break-up.
    daughter_areas : (float, float)
        Smaller and larger daughter of the first break-up, D0².
    breakup_time, breakup_neck : float
        First break-up: when, and the neck that was cut.
    breakup_count, generations, droplet_count : int
        Break-ups in all, break-ups in the ancestry of the youngest droplet, droplets at the end.
    end_time : float
    steps : int
    contacts, breakups : tuple of dict
        Every first contact of a droplet with an obstacle, and every break-up.
    outlines : Outlines or None
        The recorded outlines, if asked for.
    """

    parameters: Parameters
    outcome: str
    broke: bool
    symmetry: float
    impact_parameter: float
    contact_time: float
    contact_speed: float
    contact_area: float
    contact_shape_parameter: float
    minimum_neck: float
    maximum_shape_parameter: float
    spring_tension_ratio: float
    daughter_area_ratio: float
    daughter_areas: tuple[float, float]
    breakup_time: float
    breakup_neck: float
    breakup_count: int
    generations: int
    droplet_count: int
    end_time: float
    steps: int
    contacts: tuple[dict[str, Any], ...]
    breakups: tuple[dict[str, Any], ...]
    outlines: Outlines | None
    _row: dict[str, Any] = field()

    def to_row(self) -> dict[str, Any]:
        """Return the collision as a row of the table that `simulate_many` returns.

        Examples
        --------
        >>> import pinchoff as po
        >>> po.simulate(po.Parameters()).to_row()["outcome"]
        'broke'
        """
        return dict(self._row)

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the outlines, fit for JSON: not measured is None."""
        left_out = ("outlines", "_row", "parameters")
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in left_out}
        return {"parameters": self.parameters.model_dump(mode="json"), **_plain(values)}

    def in_units(self) -> dict[str, float]:
        """Return times, lengths, areas and speeds in the laboratory's units.

        Returns
        -------
        dict of str to float
            By names that carry the unit, such as ``contact_time_s``; NaN: did not happen.

        Raises
        ------
        InputError
            The parameters were not built from physical quantities.

        Examples
        --------
        >>> import pinchoff as po
        >>> p = po.Parameters.from_physical(
        ...     diameter="481 um", obstacle_radius="85 um", speed="1 mm/s", viscosity="48 mPa s",
        ...     surface_tension="20 mN/m", thickness="85 um", offset="20 um")
        >>> round(po.simulate(p).in_units()["contact_time_s"], 2)
        1.07
        """
        scale = self.parameters.scale
        if scale is None:
            rule, advice = "built from physical quantities", "use Parameters.from_physical(...)"
            raise InputError.of("parameters", rule, "dimensionless numbers alone", advice)
        sizes = {"um": scale.diameter_um, "um2": scale.diameter_um**2}
        sizes |= {"s": scale.time_unit_s, "mm_s": scale.speed_mm_s}
        return {
            f"{name}_{unit}": self._row[name] * sizes[unit] for name, unit in _LABORATORY.items()
        }

    @property
    def contact_time_s(self) -> float:
        """Time of the first contact, s; NaN without contact or physical quantities."""
        return float(self._row["contact_time_s"])

    def recorded(self) -> Outlines:
        """Return the outlines.

        Raises
        ------
        InputError
            None were recorded.
        """
        if self.outlines is None:
            advice = "use simulate(parameters, outlines=True)"
            raise InputError.of("outlines", "recorded", None, advice)
        return self.outlines

    def plot(self, axes: Any = None, *, times: Any = None) -> Any:
        """Draw moments of the collision side by side, as `pinchoff.figures.snapshot_strip`.

        Parameters
        ----------
        axes : sequence of n Axes, optional
            Where to draw; by default a new figure, which a notebook shows.
        times : array_like, shape (n,), optional
            In t0; by default six moments from the approach to after the break-up.

        Returns
        -------
        list of Axes

        Raises
        ------
        InputError
            No outlines were recorded.

        Examples
        --------
        >>> import pinchoff as po
        >>> panels = po.simulate(po.Parameters(), outlines=0.1).plot()
        >>> len(panels)
        6
        """
        return self._drawn(axes, times=times)

    def animate(self, path: str | os.PathLike[str] | None = None, *, fps: int = 30) -> Any:
        """Film the collision, as `Outlines.animate`.

        Examples
        --------
        >>> import pinchoff as po
        >>> collision = po.simulate(po.Parameters(), outlines=0.5)
        >>> collision.animate("collision.gif")
        >>> collision.animate()
        <Player of 8 frames: a notebook shows it>
        """
        return artist().animate(self.recorded(), path, fps)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Collision:
        """Read a collision from the ``collision.json`` that ``pinchoff run`` wrote.

        Parameters
        ----------
        path : path
            The file or its folder; outlines that lie beside it are read, too.

        Raises
        ------
        InputError
            There is no such file, or it holds no collision.

        Examples
        --------
        After ``pinchoff run`` has written the folder ``collision``:

        >>> import pinchoff as po
        >>> po.Collision.load("collision")  # doctest: +SKIP
        """
        from pinchoff.model.run_files import read_run

        return _of_row(*read_run(path))

    def __repr__(self) -> str:
        contact = (
            f"S = {self.symmetry:.3f}, contact at t = {self.contact_time:.2f} t0, "
            f"thinnest neck {self.minimum_neck:.3f} D0"
            if math.isfinite(self.contact_time)
            else "no contact"
        )
        breakup = (
            f", broke at t = {self.breakup_time:.2f} t0 into "
            f"1:{1 / self.daughter_area_ratio:.2f}, "
            f"{counted(self.droplet_count, 'droplet')} at the end"
            if self.broke
            else ""
        )
        return f"<Collision {self.outcome}: {contact}{breakup}>"


_LABORATORY = {
    "contact_time": "s",
    "contact_speed": "mm_s",
    "contact_area": "um2",
    "impact_parameter": "um",
    "minimum_neck": "um",
    "breakup_time": "s",
    "breakup_neck": "um",
    "small_daughter_area": "um2",
    "large_daughter_area": "um2",
    "end_time": "s",
}
"""Results with a unit, and the laboratory's unit of each."""


def collision_of(
    parameters: Parameters,
    system: _core.System,
    outlines: Outlines | None,
    met: Mapping[str, float],
) -> Collision:
    """Gather the results of a finished system; `met` as in `run_columns`.

    Raises
    ------
    SimulationError
        A guard stopped the run.
    """
    results = np.asarray(system.result(), dtype=np.float64).reshape(1, -1)
    result = dict(zip(_core.RESULT_FIELDS, results[0].tolist(), strict=True))
    if result["outcome"] == _FAILED:
        guard = _core.GUARDS[int(result["guard"])]
        value, time = result["guard_value"], result["guard_time"]
        raise SimulationError(
            guard_message(guard, value, time, springs=parameters.model == SPRINGS),
            guard=guard,
            value=value,
            time=time,
        )
    columns = run_columns([parameters], results, met=met)
    row = {name: _plain_scalar(values[0]) for name, values in columns.items()}
    row["broke"] = bool(row["broke"])
    return _of_row(parameters, row, system.contacts(), system.breakups(), outlines)


def _of_row(
    parameters: Parameters,
    row: dict[str, Any],
    contacts: Iterable[dict[str, Any]],
    breakups: Iterable[dict[str, Any]],
    outlines: Outlines | None,
) -> Collision:
    return Collision(
        **{f.name: row[f.name] for f in fields(Collision) if f.name in row},
        parameters=parameters,
        daughter_areas=(row["small_daughter_area"], row["large_daughter_area"]),
        contacts=tuple(contacts),
        breakups=tuple(breakups),
        outlines=outlines,
        _row=row,
    )


def _plain_scalar(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: lists, numbers, and None for a number that is not finite."""
    if isinstance(value, dict):
        return {str(key): _plain(content) for key, content in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(content) for content in value]
    value = _plain_scalar(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
