"""What comes out of one run: a `Collision`."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff import _core
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import SPRINGS
from pinchoff.model.run_table import FAILED, run_columns
from pinchoff.support.drawing import Drawable, artist
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.numerals import counted
from pinchoff.support.records import jsonable

if TYPE_CHECKING:
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.parameters import Parameters


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
        return {"parameters": self.parameters.model_dump(mode="json"), **jsonable(values)}

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
    """Gather the results of a finished system; `SimulationError` where a guard stopped it."""
    results = np.asarray(system.result(), dtype=np.float64).reshape(1, -1)
    result = dict(zip(_core.RESULT_FIELDS, results[0].tolist(), strict=True))
    if result["outcome"] == FAILED:
        guard = _core.GUARDS[int(result["guard"])]
        value, time = result["guard_value"], result["guard_time"]
        raise SimulationError(
            guard_message(guard, value, time, springs=parameters.model == SPRINGS),
            guard=guard,
            value=value,
            time=time,
        )
    columns = run_columns([parameters], results, met=met)
    row = {name: values[:1].tolist()[0] for name, values in columns.items()}
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
