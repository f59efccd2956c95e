"""The tables of a file about many droplets: the array, the droplets, the model, each checked."""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from pinchoff.model import arrays
from pinchoff.model.arrangement import start_clearance
from pinchoff.model.arrays import Floats, PillarArray
from pinchoff.model.emulsion import emulsion_parameters
from pinchoff.model.emulsion_scene import Coalescence, Inlet
from pinchoff.model.parameters import Parameters
from pinchoff.support.arguments import checked_number, checked_positive
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.units import magnitude_of

_KINDS: dict[str, Callable[..., PillarArray]] = {
    "square": arrays.square,
    "staggered": arrays.staggered,
    "hexagonal": arrays.hexagonal,
    "disordered": arrays.disordered,
    "file": arrays.read,
}
"""Makers of arrays, by kind; ``chamber`` is the device of `pinchoff.chamber`."""
_LENGTHS = ("radius", "gap", "length", "width", "least_gap", "before", "behind")
_PHYSICAL = ("diameter", "speed", "viscosity", "surface_tension")
_LONGEST_MARGIN = 1000.0  # D0; the mesh of the flow goes on through it
_PLACES = 20_000  # tried for a droplet before the cell counts as full
_AT_ONCE = 64  # of these are compared with the droplets that are there already


def table_of(config: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return a table of a file, which must be one."""
    if not isinstance(config[name], Mapping):
        raise InputError.of(name, "a table", config[name], f"write it as [{name}]")
    return dict(config[name])


def require_known(
    place: str, table: Mapping[str, Any], known: tuple[str, ...], **needed: str
) -> None:
    """Refuse keys that a table does not have, and one that lacks a needed key, with its advice."""
    for name in table:
        if name not in known:
            argument = f"{place}.{name}" if place else name
            raise unknown_name(argument, "a key of an emulsion's file", name, known)
    for name, advice in needed.items():
        if name not in table:
            raise InputError.of(f"{place}.{name}", "given", "nothing", advice)


def diameter_of_physical(tables: Mapping[str, Mapping[str, Any]]) -> float | None:
    """Return D0 of the physical quantities, µm; None where there are none."""
    if "physical" not in tables:
        return None
    require_known("physical", tables["physical"], _PHYSICAL)
    try:
        return magnitude_of("diameter", tables["physical"].get("diameter", ""), "um", positive=True)
    except InputError as error:
        raise error.within("physical") from None


def in_diameters(place: str, table: Mapping[str, Any], diameter_um: float | None) -> dict[str, Any]:
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
        return magnitude_of(f"{place}.{name}", value, "um", positive=True) / diameter_um

    return {name: read(name, v) if name in lengths else v for name, v in table.items()}


def read_array(table: Mapping[str, Any], beside: Path, diameter_um: float | None) -> PillarArray:
    """Return the array of [array], with its margins."""
    kind = table.get("kind")
    kinds = (*_KINDS, "chamber")
    if not isinstance(kind, str) or kind not in kinds:
        raise unknown_name("array.kind", "a kind of array", kind, kinds)
    wanted = ("path",) if kind == "chamber" else tuple(inspect.signature(_KINDS[kind]).parameters)
    require_known("array", table, ("kind", "before", "behind", *wanted))
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
        checked_number(
            f"array.{name}", table.get(name, 0.0), "give it in D0", low=0.0, high=_LONGEST_MARGIN
        )
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


def read_flow(table: Mapping[str, Any]) -> tuple[float, dict[str, float]]:
    """Return z of [flow], D0, and what drives the flow, an argument of `array_flow`."""
    known = ("thickness", "mean_speed", "pressure_gradient")
    advice = "give z in D0, or inf for the plane Stokes flow"
    require_known("flow", table, known, thickness=advice)
    if {"mean_speed", "pressure_gradient"} <= table.keys():
        got = "both it and pressure_gradient"
        raise InputError.of("flow.mean_speed", "alone", got, "leave one of them out")
    for name, value in table.items():
        if not (name == "thickness" and value == math.inf):
            checked_positive(f"flow.{name}", value, "see the how-to about arrays")
    drive = {name: float(value) for name, value in table.items() if name != "thickness"}
    return float(table["thickness"]), drive


def _imaging(path: Path | None, diameter_um: float | None) -> PillarArray:
    """Return the imaging area of a device, the paper's or that of a file, in D0."""
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.periodic_flow import imaging_array

    chamber = Chamber() if path is None else Chamber.from_toml(path)
    array = imaging_array(chamber)
    if diameter_um is None:
        return array
    return array.scaled(chamber.operation.droplet_diameter_um / diameter_um)


def read_parameters(
    tables: Mapping[str, Mapping[str, Any]],
    array: PillarArray,
    thickness: float,
    diameter_um: float | None,
) -> Parameters:
    """Return the model of [parameters], and of [physical] where there is one."""
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


def read_inlet(table: Mapping[str, Any], margins: Mapping[str, Any], array: PillarArray) -> Inlet:
    """Return the inlet of [inlet]; `margins` is [array]."""
    known = ("x", "bottom", "top", "area_fraction", "diameters")
    require_known("inlet", table, known, area_fraction="write 0.1")
    for name in ("before", "behind"):
        if not margins.get(name):
            advice = "give the free fluid before and behind the array, such as 3"
            raise InputError.of(f"array.{name}", "positive beside an inlet", 0, advice)
    return Inlet(**{"x": 0.0, "bottom": 0.0, "top": array.width, **table})


def read_coalescence(table: Mapping[str, Any]) -> Coalescence:
    """Return how droplets merge, of [coalescence]."""
    known = tuple(inspect.signature(Coalescence).parameters)
    advice = "write K, or inf where contacts are only recorded"
    require_known("coalescence", table, known, drainage=advice)
    return Coalescence(**table)


def read_droplets(
    table: Mapping[str, Any] | None, array: PillarArray, parameters: Parameters, seed: int
) -> Floats:
    """Return the droplets of the start: those that are named, or some at random places."""
    if table is None:
        return np.empty((0, 3))
    require_known("droplets", table, ("places", "diameters", "area_fraction"))
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
        place = _first_clear(places[free], np.array(placed).reshape(-1, 3), reach, period)
        if place is None:
            got = f"{share:g}, of which {len(placed)} droplets found room"
            advice = "lower it, widen the gaps, or take smaller droplets"
            raise InputError.of("droplets.area_fraction", "such that they fit", got, advice)
        placed.append([*place.tolist(), size])
    return np.array(placed)


def _first_clear(places: Floats, placed: Floats, reach: float, period: Floats) -> Floats | None:
    """Return the first place with no droplet nearer than a distance; None if there is none."""
    for first in range(0, len(places), _AT_ONCE):
        some = places[first : first + _AT_ONCE]
        away = np.abs(some[:, None] - placed[:, :2])
        away = np.minimum(away, period - away)
        clear = (np.hypot(away[..., 0], away[..., 1]) > reach + placed[:, 2] / 2).all(axis=1)
        if clear.any():
            found: Floats = some[int(np.argmax(clear))]
            return found
    return None
