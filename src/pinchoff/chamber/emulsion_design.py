"""What `pinchoff emulsion` runs: an array, the flow through it, and droplets, read from a table.

Lengths are numbers of D0, or quantities with a unit beside a table of physical quantities; every
refusal names the key.
"""

from __future__ import annotations

import inspect
import math
import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from pinchoff.model import arrays
from pinchoff.model.arrangement import start_clearance
from pinchoff.model.arrays import Floats, PillarArray
from pinchoff.model.emulsion import (
    Coalescence,
    Inlet,
    emulsion_parameters,
    simulate_emulsion,
)
from pinchoff.model.parameters import Parameters
from pinchoff.studies.emulsion_sizes import SizeStudy, study_sizes
from pinchoff.studies.isolated_pillar import isolated_pillar
from pinchoff.support.arguments import checked_number, checked_positive, checked_whole
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml
from pinchoff.support.quantities import positive_magnitude_of

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.periodic_flow import ArrayFlow
    from pinchoff.model.emulsion import Emulsion
    from pinchoff.model.flow import Flow
    from pinchoff.support.progress import Show

_KINDS: dict[str, Callable[..., PillarArray]] = {
    "square": arrays.square,
    "staggered": arrays.staggered,
    "hexagonal": arrays.hexagonal,
    "disordered": arrays.disordered,
    "file": arrays.read,
}
"""Makers of arrays, by kind; ``chamber`` is the device of `pinchoff.chamber`."""
_LENGTHS = ("radius", "gap", "length", "width", "least_gap", "before", "behind")
_RUN = {"interval": 0.5, "smallest_breaking": 0.2, "checkpoint": 10.0, "seed": 0, "outlines": True}
_STOP = "stop_when_steady"
_TABLES = ("parameters", "physical", "array", "flow", "inlet", "droplets", "coalescence")
_PHYSICAL = ("diameter", "speed", "viscosity", "surface_tension")
STRETCHES = 20
"""After each of these parts of a run it is looked whether sizes are steady, if that may end it."""

_SAME_TIME = 0.01  # t0; less than a window
_REFERENCES = 7  # diameters for which the line of a pillar alone is sought
_PAD = 2.0  # of the flow's samples beyond the cell, D0
_PLACES = 20_000  # tried for a droplet before the cell counts as full


@dataclass(frozen=True, eq=False)
class EmulsionDesign:
    """A run of many droplets through an array, ready to begin.

    Build it with `from_toml` or `from_config`.

    Attributes
    ----------
    parameters : Parameters
    array : PillarArray
        With its margins.
    thickness : float
        z of the chamber, D0.
    drive : dict
        ``mean_speed`` or ``pressure_gradient`` of `pinchoff.chamber.array_flow`, or neither.
    time : float
        t0.
    inlet : Inlet or None
    droplets : ndarray, shape (K, 3)
        Those that are there at the start.
    coalescence : Coalescence or None
        None: droplets do not merge.
    settings : dict
        Of `pinchoff.simulate_emulsion`: interval, smallest_breaking, checkpoint, seed, outlines.
    stop_when_steady : bool
        Whether a run may end before its time: at the first of `STRETCHES` equal stretches after
        which its sizes are steady.
    """

    parameters: Parameters
    array: PillarArray
    thickness: float
    drive: dict[str, float]
    time: float
    inlet: Inlet | None
    droplets: Floats
    coalescence: Coalescence | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    stop_when_steady: bool = False

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> EmulsionDesign:
        """Read a design from a TOML file with the keys of `from_config`.

        A table of pillars that it names is looked for beside it.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as `from_config`.
        """
        return cls.from_config(read_toml(Path(path)), beside=Path(path).parent)

    @classmethod
    def from_config(cls, config: Mapping[str, Any], beside: Path | None = None) -> EmulsionDesign:
        """Read a design.

        Parameters
        ----------
        config : mapping
            ``time`` and, if wanted, ``interval``, ``smallest_breaking``, ``checkpoint``, ``seed``
            and ``outlines`` of `pinchoff.simulate_emulsion`, and ``stop_when_steady``; tables
            ``array`` (``kind`` and the arguments of `pinchoff.arrays`, or ``kind = "chamber"`` and,
            if wanted, the ``path`` of a device's file; ``before`` and ``behind``), ``flow``
            (``thickness``,
            ``mean_speed`` or ``pressure_gradient``), ``parameters``, and ``inlet`` or
            ``droplets`` (``places``, or ``diameters`` and ``area_fraction``), and ``coalescence``
            (the arguments of `pinchoff.Coalescence`) where droplets merge. With ``physical``
            (diameter, speed, viscosity, surface_tension) lengths of the other tables may have
            units.
        beside : Path, optional
            The folder of the files that it names.

        Raises
        ------
        InputError
            A key is unknown or missing, or its value wrong; the message names the key.

        Examples
        --------
        >>> design = EmulsionDesign.from_config({
        ...     "time": 10,
        ...     "array": {"kind": "square", "rows": 2, "columns": 2, "radius": 0.3, "gap": 0.9,
        ...               "before": 3, "behind": 2},
        ...     "flow": {"thickness": 0.5},
        ...     "inlet": {"area_fraction": 0.2},
        ... })
        >>> design.periodic, design.inlet.top
        ('y', 3.0)
        """
        _require_known("", config, ("time", _STOP, *_RUN, *_TABLES))
        for name in ("outlines", _STOP):
            if not isinstance(config.get(name, False), bool):
                raise InputError.of(name, "true or false", config[name], "write it without quotes")
        tables = {name: _table(config, name) for name in _TABLES if name in config}
        for name in ("array", "flow"):
            if name not in tables:
                raise InputError.of(name, "a table", "nothing", f"write [{name}]")
        diameter_um = _diameter_um(tables)
        for name in tables.keys() - {"parameters", "physical", "coalescence"}:
            tables[name] = _in_diameters(name, tables[name], diameter_um)
        seed = checked_whole("seed", config.get("seed", 0), "use 0", low=0)
        array = _array(tables["array"], beside or Path(), diameter_um)
        flow = tables["flow"]
        _require_known("flow", flow, ("thickness", "mean_speed", "pressure_gradient"))
        if "thickness" not in flow:
            advice = "give z in D0, or inf for the plane Stokes flow"
            raise InputError.of("flow.thickness", "given", "nothing", advice)
        if len({"mean_speed", "pressure_gradient"} & flow.keys()) == 2:
            got = "both it and pressure_gradient"
            raise InputError.of("flow.mean_speed", "alone", got, "leave one of them out")
        for name, value in flow.items():
            if not (name == "thickness" and value == math.inf):
                checked_positive(f"flow.{name}", value, "see the how-to about arrays")
        parameters = _parameters(tables, array, flow["thickness"], diameter_um)
        if ("inlet" in tables) == ("droplets" in tables):
            got = "both" if "inlet" in tables else "neither"
            advice = "write one of the two: with an inlet, or in a cell that repeats itself"
            raise InputError.of("inlet", "given, or droplets", got, advice)
        return cls(
            parameters,
            array,
            float(flow["thickness"]),
            {name: float(value) for name, value in flow.items() if name != "thickness"},
            checked_positive("time", config.get("time"), "give it in t0"),
            _inlet(tables["inlet"], tables["array"], array) if "inlet" in tables else None,
            _droplets(tables.get("droplets"), array, parameters, seed),
            _coalescence(tables["coalescence"]) if "coalescence" in tables else None,
            {**_RUN, **{name: config[name] for name in _RUN if name in config}},
            bool(config.get(_STOP, False)),
        )

    @property
    def periodic(self) -> str:
        """Along which axes space repeats itself: across always, along without an inlet."""
        return "xy" if self.inlet is None else "y"

    def flow(self, show: Show | None = None) -> ArrayFlow:
        """Return the flow through the array, computed."""
        from pinchoff.chamber import array_flow

        return array_flow(self.array, thickness=self.thickness, show=show, **self.drive)

    def run(self, flow: ArrayFlow, out: Path, **options: Any) -> Emulsion:
        """Run it into a folder, or go on with the run that is there.

        Parameters
        ----------
        flow : ArrayFlow
            What `flow` returned.
        out : Path
        **options
            Of `pinchoff.simulate_emulsion`: threads and progress.
        """
        sampled = flow.sampled(pad=_PAD, periodic=self.periodic)
        if not self.stop_when_steady:
            return self._run_until(self.time, sampled, out, options)
        run = self._run_until(self.time / STRETCHES, sampled, out, options)
        for k in range(1, STRETCHES + 1):
            end = self.time * k / STRETCHES
            # A run that goes on after a stop has passed these ends without being steady.
            if end < run.time - _SAME_TIME:
                continue
            run = self._run_until(end, sampled, out, options)
            if self._is_steady(run, flow):
                break
        return run

    def _is_steady(self, run: Emulsion, flow: ArrayFlow) -> bool:
        try:
            return self.study(run, flow).steady is True
        except InputError:  # too few frames so far
            return False

    def _run_until(
        self, time: float, flow: Flow, out: Path, options: Mapping[str, Any]
    ) -> Emulsion:
        return simulate_emulsion(
            self.parameters,
            time=time,
            droplets=self.droplets if self.inlet is None else None,
            obstacles=self.array,
            flow=flow,
            periodic=self.periodic,
            inlet=self.inlet,
            outlet=None if self.inlet is None else self.array.length,
            coalescence=self.coalescence,
            out=out,
            resume=True,
            **self.settings,
            **options,
        )

    def isolated(
        self, contacts: pd.DataFrame, flow: ArrayFlow, threads: int | None = None
    ) -> pd.DataFrame | None:
        """Return the line of a pillar alone in this flow, for the diameters of contacts.

        None where there is none: in plane Stokes flow, with pillars of several radii, with necks
        that break at a thickness of their own, or without contacts.
        """
        radii = self.array.circles[:, 2]
        fixed = self.parameters.neck_thickness_unit != "diameter"
        if self.thickness == math.inf or np.ptp(radii) > 1e-6 or fixed or not len(contacts):
            return None
        found = contacts["diameter"].to_numpy(np.float64)
        low, high = max(found.min(), radii[0]), found.max()
        diameters = np.geomspace(low, high, _REFERENCES) if high > 1.02 * low else np.array([high])
        speed = flow.mean_velocity[0]
        return isolated_pillar(
            self.parameters, float(radii[0]), self.thickness, diameters, speed, threads
        )

    def study(self, run: Emulsion, flow: ArrayFlow) -> SizeStudy:
        """Return the sizes and rates of a run.

        In a cell that repeats itself a residence time is what the fluid takes through the cell.
        """
        residence = None if self.inlet else self.array.length / flow.mean_velocity[0]
        return study_sizes(run.sizes, run.events, residence_time=residence)


def _table(config: Mapping[str, Any], name: str) -> dict[str, Any]:
    if not isinstance(config[name], Mapping):
        raise InputError.of(name, "a table", config[name], f"write it as [{name}]")
    return dict(config[name])


def _require_known(place: str, table: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for name in table:
        if name not in known:
            argument = f"{place}.{name}" if place else name
            raise unknown_name(argument, "a key of an emulsion's file", name, known)


def _diameter_um(tables: Mapping[str, Mapping[str, Any]]) -> float | None:
    """Return D0 of the physical quantities, µm; None where there are none."""
    if "physical" not in tables:
        return None
    _require_known("physical", tables["physical"], _PHYSICAL)
    try:
        return positive_magnitude_of("diameter", tables["physical"].get("diameter", ""), "um")
    except InputError as error:
        raise error.within("physical") from None


def _in_diameters(
    place: str, table: Mapping[str, Any], diameter_um: float | None
) -> dict[str, Any]:
    """Return a table whose lengths with units are numbers of D0."""
    lengths = {
        "array": _LENGTHS,
        "flow": ("thickness",),
        "inlet": ("x", "bottom", "top", "diameters"),
        "droplets": ("diameters",),
    }[place]

    def read(name: str, value: Any) -> Any:
        if isinstance(value, list):
            return [read(name, one) for one in value]
        if not isinstance(value, str):
            return value
        if diameter_um is None:
            advice = "write it in D0, or add [physical] with the diameter"
            raise InputError.of(f"{place}.{name}", "a number", value, advice)
        return positive_magnitude_of(f"{place}.{name}", value, "um") / diameter_um

    return {name: read(name, v) if name in lengths else v for name, v in table.items()}


def _array(table: Mapping[str, Any], beside: Path, diameter_um: float | None) -> PillarArray:
    kind = table.get("kind")
    kinds = (*_KINDS, "chamber")
    if not isinstance(kind, str) or kind not in kinds:
        raise unknown_name("array.kind", "a kind of array", kind, kinds)
    wanted = ("path",) if kind == "chamber" else tuple(inspect.signature(_KINDS[kind]).parameters)
    _require_known("array", table, ("kind", "before", "behind", *wanted))
    missing = next((name for name in wanted if name not in table), None)
    if missing is not None and kind != "chamber":
        rule = f"given for a {kind} array" if kind != "file" else "given for an array of a file"
        raise InputError.of(f"array.{missing}", rule, "nothing", "write it under [array]")
    values = {name: table[name] for name in wanted if name in table}
    if "path" in values:
        if not isinstance(values["path"], str):
            raise InputError.of("array.path", "the name of a file", values["path"], "quote it")
        values["path"] = beside / values["path"]
    margins = [
        checked_number(f"array.{name}", table.get(name, 0.0), "give it in D0", low=0.0)
        for name in ("before", "behind")
    ]
    if kind == "chamber":
        array = _imaging(values.get("path"), diameter_um)
    else:
        try:
            array = _KINDS[kind](**values)
        except InputError as error:
            raise error.within("array") from None
    if not any(margins):
        return array
    moved = array.circles + np.array([margins[0], 0.0, 0.0])
    return PillarArray(moved, array.length + sum(margins), array.width)


def _imaging(path: Path | None, diameter_um: float | None) -> PillarArray:
    """Return the imaging area of a device, the paper's or that of a file, in D0."""
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.periodic_flow import imaging_array

    chamber = Chamber() if path is None else Chamber.from_toml(path)
    array = imaging_array(chamber)
    if diameter_um is None:
        return array
    return array.scaled(chamber.operation.droplet_diameter_um / diameter_um)


def _parameters(
    tables: Mapping[str, Mapping[str, Any]],
    array: PillarArray,
    thickness: float,
    diameter_um: float | None,
) -> Parameters:
    constants = dict(tables.get("parameters", {}))
    radius = float(np.median(array.circles[:, 2]))
    try:
        if diameter_um is None:
            constants.setdefault("size_ratio", 1.0 / radius)
            return emulsion_parameters(Parameters.from_config(constants))
        physical = dict(tables["physical"])
        physical["obstacle_radius"] = f"{radius * diameter_um!r} um"
        physical["thickness"] = f"{min(thickness, 1e6) * diameter_um!r} um"
        with warnings.catch_warnings():
            # The thickness acts here: through the flow.
            warnings.filterwarnings("ignore", "thickness/obstacle_radius")
            return emulsion_parameters(Parameters.from_config({**constants, "physical": physical}))
    except InputError as error:
        named = error.argument.startswith("physical")
        raise (error if named or diameter_um else error.within("parameters")) from None


def _inlet(table: Mapping[str, Any], margins: Mapping[str, Any], array: PillarArray) -> Inlet:
    _require_known("inlet", table, ("x", "bottom", "top", "area_fraction", "diameters"))
    if "area_fraction" not in table:
        raise InputError.of("inlet.area_fraction", "given", "nothing", "write 0.1")
    for name in ("before", "behind"):
        if not margins.get(name):
            advice = "give the free fluid before and behind the array, such as 3"
            raise InputError.of(f"array.{name}", "positive beside an inlet", 0, advice)
    return Inlet(**{"x": 0.0, "bottom": 0.0, "top": array.width, **table})


def _coalescence(table: Mapping[str, Any]) -> Coalescence:
    _require_known("coalescence", table, tuple(inspect.signature(Coalescence).parameters))
    if "drainage" not in table:
        advice = "write K, or inf where contacts are only recorded"
        raise InputError.of("coalescence.drainage", "given", "nothing", advice)
    return Coalescence(**table)


def _droplets(
    table: Mapping[str, Any] | None, array: PillarArray, parameters: Parameters, seed: int
) -> Floats:
    """Return the droplets of the start: those that are named, or some at random places."""
    if table is None:
        return np.empty((0, 3))
    _require_known("droplets", table, ("places", "diameters", "area_fraction"))
    if "places" in table:
        if len(table) > 1:
            got = ", ".join(table)
            raise InputError.of("droplets.places", "alone", got, "leave the others out")
        return np.array(table["places"], dtype=np.float64).reshape(-1, 3)
    share = checked_number(
        "droplets.area_fraction", table.get("area_fraction"), "use 0.2", low=0, high=0.7, above=True
    )
    given = table.get("diameters", 1.0)
    sizes = [
        checked_positive("droplets.diameters", size, "give it in D0")
        for size in (given if isinstance(given, list) else [given])
    ]
    period = np.array([array.length, array.width])
    pillars = cKDTree(array.circles[:, :2], boxsize=period)
    generator = np.random.default_rng(seed)
    wanted = share * array.porosity * array.length * array.width
    placed: list[list[float]] = []
    while sum(math.pi / 4 * d**2 for *_, d in placed) < wanted:
        size = float(generator.choice(sizes))
        places = generator.random((_PLACES, 2)) * period
        reach = size / 2 + 1.001 * start_clearance(parameters)
        near, which = pillars.query(places, k=min(3, len(array.circles)))
        near, which = near.reshape(_PLACES, -1), which.reshape(_PLACES, -1)
        free = (near - array.circles[which, 2] > reach).all(axis=1)
        for x, y, other in placed:
            away = np.abs(places - [x, y])
            away = np.minimum(away, period - away)
            free &= np.hypot(*away.T) > reach + other / 2
        if not free.any():
            got = f"{share:g}, of which {len(placed)} droplets found room"
            advice = "lower it, widen the gaps, or take smaller droplets"
            raise InputError.of("droplets.area_fraction", "such that they fit", got, advice)
        placed.append([*places[np.flatnonzero(free)[0]].tolist(), size])
    return np.array(placed)
