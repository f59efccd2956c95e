"""The scene of a run of many droplets: what they meet, where they come in, how they merge."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from pinchoff import _core
from pinchoff.model.arrangement import (
    LEAST_DIAMETER,
    MOST_VERTICES,
    Floats,
    droplet_circles,
    obstacle_circles,
)
from pinchoff.model.arrays import PillarArray
from pinchoff.model.flow import Flow, uniform
from pinchoff.model.parameters import SAMPLE_INTERVAL, Parameters
from pinchoff.model.simulation import require_flow
from pinchoff.support.arguments import checked_number
from pinchoff.support.errors import InputError

OnGuard: TypeAlias = Literal["retire", "stop"]

WINDOW = 5 * SAMPLE_INTERVAL
"""Time between two looks at who may meet whom, t0."""

LEAST_PERIOD = 2.0
"""Least period, D0: a droplet shall not meet itself round the cell before it is drawn out."""


@dataclass(frozen=True)
class Inlet:
    """Where droplets come in, as the fluid brings them.

    Attributes
    ----------
    x : float
        Their centres are put on this line, D0; the flow must be known half a droplet before it.
    bottom, top : float
        The ends of the line, D0; centres are drawn evenly between them.
    area_fraction : float
        Of the fluid that flows in across the line; what flows in is summed up, and a droplet
        comes in when its area is there.
    diameters : float or sequence of float
        D0; drawn from with equal chances.
    """

    x: float
    bottom: float
    top: float
    area_fraction: float
    diameters: float | Sequence[float] = 1.0


@dataclass(frozen=True)
class Coalescence:
    """How droplets that touch merge: the film between them drains, and ruptures.

    Two droplets are in contact while their outlines are within one vertex spacing of each other;
    L is the length that they face each other with. With the harmonic mean D_h of their diameters
    the film takes t_d/t0 = K Ca_sim (L/D_h)² D_h/D0 to drain (Reynolds). The clock C = ∫ dt/t_d
    runs while they touch; at C = 1 they merge.

    Attributes
    ----------
    drainage : float
        K. It is fitted, not predicted: see `pinchoff.calibrate_drainage`. 0: droplets merge when
        they touch; infinity: never by draining.
    separation : float, optional
        s, from 0 to 1: droplets that part merge at C >= 1 - s. They do so in experiments, where
        faces that are pulled apart draw out nipples that meet (Bremond, Thiam and Bibette 2008).
    stochastic : bool, optional
        Whether 1/t_d is a rate: the C at which a pair merges is then a random number with an
        exponential distribution and mean 1, drawn from the seed, the pair and the contact.
    """

    drainage: float
    separation: float = 0.0
    stochastic: bool = False


@dataclass(frozen=True)
class Scene:
    """Everything that the core wants to know, checked."""

    parameters: Parameters
    row: Floats
    flow: Flow
    circles: Floats
    starts: Floats
    cell: Floats
    periodic: str
    inlet: Floats
    diameters: Floats
    outlet: float
    coalescence: Floats

    def start(self, settings: dict[str, Any], threads: int, stops_at_guard: bool) -> _core.Emulsion:
        return _core.Emulsion(
            self.row,
            self.flow,
            self.circles,
            self.starts,
            self.cell,
            "x" in self.periodic,
            "y" in self.periodic,
            WINDOW,
            settings["smallest_breaking"],
            self.inlet,
            self.diameters,
            self.outlet,
            self.coalescence,
            settings["seed"],
            threads,
            stops_at_guard=stops_at_guard,
        )

    def record(self) -> dict[str, Any]:
        """Return what decides the run, for the checkpoint; arrays by their numbers' digest."""
        from hashlib import sha256

        def digest(values: Floats) -> str:
            return sha256(np.ascontiguousarray(values, dtype=np.float64).tobytes()).hexdigest()[:16]

        left, right, bottom, top = self._probed()
        probe = np.random.default_rng(0).uniform((left, bottom), (right, top), (256, 2))
        return {
            "parameters": self.parameters.model_dump(mode="json"),
            "cell": self.cell.tolist(),
            "periodic": self.periodic,
            "inlet": self.inlet.tolist(),
            "outlet": self.outlet if math.isfinite(self.outlet) else None,
            "coalescence": [repr(number) for number in self.coalescence.tolist()],
            "obstacles": digest(self.circles),
            "droplets": digest(self.starts),
            "diameters": digest(self.diameters),
            "flow": digest(np.asarray(self.flow.velocity(probe))),
        }

    def _probed(self) -> tuple[float, float, float, float]:
        places = np.concatenate(
            (self.circles[:, :2], self.starts[:, :2], self.cell.reshape(2, 2).T)
        )
        (left, bottom), (right, top) = places.min(axis=0) - 1, places.max(axis=0) + 1
        return float(left), float(right), float(bottom), float(top)


def checked_scene(
    parameters: Parameters,
    droplets: ArrayLike | None,
    obstacles: ArrayLike | PillarArray | None,
    flow: Flow | None,
    cell: Sequence[float] | None,
    periodic: str,
    inlet: Inlet | None,
    outlet: float | None,
    coalescence: Coalescence | None,
) -> Scene:
    if isinstance(obstacles, PillarArray):
        if cell is None:
            cell = (0.0, obstacles.length, 0.0, obstacles.width)
        obstacles = obstacles.circles
    circles = obstacle_circles(parameters, np.empty((0, 3)) if obstacles is None else obstacles)
    if flow is None:
        if len(circles):
            advice = "pass one that knows them all, such as that of an array"
            raise InputError.of("flow", "given where there are obstacles", None, advice)
        flow = uniform()
    require_flow(flow)
    if droplets is None and inlet is None:
        advice = "give [x, y, diameter] for each, or an inlet"
        raise InputError.of("droplets", "given where there is no inlet", None, advice)
    starts = np.empty((0, 3))
    if droplets is not None and len(np.atleast_1d(np.asarray(droplets, dtype=object))):
        starts = droplet_circles(parameters, droplets, circles)
    bounds = _checked_cell(cell, periodic)
    _require_clear_images(starts, circles, bounds, periodic)
    line, diameters = _checked_inlet(parameters, inlet)
    beyond = math.inf if outlet is None else checked_number("outlet", outlet, "give an x in D0")
    row = parameters.replace(follow_daughters=True).model_row()
    merging = _checked_coalescence(parameters, coalescence)
    return Scene(
        parameters, row, flow, circles, starts, bounds, periodic, line, diameters, beyond, merging
    )


def checked_on_guard(value: object) -> OnGuard:
    """Check what follows where a guard refuses a droplet."""
    if value in get_args(OnGuard):
        return value  # type: ignore[return-value]
    advice = 'write "retire" to go on without the droplet, "stop" to end the run there'
    raise InputError.of("on_guard", '"retire" or "stop"', value, advice)


def _checked_coalescence(parameters: Parameters, coalescence: Coalescence | None) -> Floats:
    """Return K Ca_sim, s and whether 1/t_d is a rate; nothing where droplets do not merge."""
    if coalescence is None:
        return np.zeros(0)
    if not isinstance(coalescence, Coalescence):
        advice = "build it with pinchoff.Coalescence(...)"
        raise InputError.of("coalescence", "a Coalescence", coalescence, advice)
    drainage = coalescence.drainage
    if drainage != math.inf:
        drainage = checked_number("coalescence.drainage", drainage, "use 1, or inf", low=0.0)
    separation = checked_number(
        "coalescence.separation", coalescence.separation, "use 0", low=0.0, high=1.0
    )
    if not isinstance(coalescence.stochastic, bool):
        got = coalescence.stochastic
        raise InputError.of("coalescence.stochastic", "True or False", got, "use False")
    film_time = drainage * parameters.simulation_capillary_number
    return np.array([film_time, separation, float(coalescence.stochastic)])


def _checked_cell(cell: Sequence[float] | None, periodic: str) -> Floats:
    if periodic not in ("", "x", "y", "xy"):
        advice = "leave it out where space does not repeat itself"
        raise InputError.of("periodic", "'x', 'y', 'xy' or ''", periodic, advice)
    advice = "give (left, right, bottom, top) in D0"
    if cell is None:
        if periodic:
            raise InputError.of("cell", "given where space is periodic", None, advice)
        return np.zeros(4)
    try:
        bounds = np.array(cell, dtype=np.float64)
    except (TypeError, ValueError):
        bounds = np.empty(0)
    if bounds.shape != (4,) or not np.isfinite(bounds).all():
        raise InputError.of("cell", "four finite numbers", cell, advice)
    for axis, low, high in (("x", bounds[0], bounds[1]), ("y", bounds[2], bounds[3])):
        if axis in periodic and not high - low >= LEAST_PERIOD:
            rule = f"at least {LEAST_PERIOD:g} D0 long along {axis}, its period"
            advice = "take several cells of the array as one"
            raise InputError.of("cell", rule, f"{high - low:g}", advice)
    return bounds


def _require_clear_images(starts: Floats, circles: Floats, cell: Floats, periodic: str) -> None:
    """Refuse droplets that overlap an image of an obstacle or of another droplet."""
    if not periodic or not len(starts):
        return
    discs = np.concatenate((circles, starts * [1.0, 1.0, 0.5]))
    # An axis that is not periodic gets a period longer than any distance.
    far = 4.0 * (np.ptp(discs[:, :2], axis=0).max() + discs[:, 2].max() + 1.0)
    size = np.array([cell[1] - cell[0], cell[3] - cell[2]])
    size = np.where([axis in periodic for axis in "xy"], size, far)
    tree = cKDTree(np.mod(discs[:, :2] - discs[:, :2].min(axis=0), size) % size, boxsize=size)
    for i, disc in enumerate(discs[len(circles) :], start=len(circles)):
        reach = disc[2] + discs[:, 2].max()
        for j in sorted(tree.query_ball_point(tree.data[i], reach)):
            away = np.abs(tree.data[i] - tree.data[j])
            away = np.minimum(away, size - away)
            if j != i and math.hypot(*away) < disc[2] + discs[j, 2]:
                raise InputError.of(
                    f"droplets[{i - len(circles)}]",
                    "clear of the images of all obstacles and droplets",
                    starts[i - len(circles)].tolist(),
                    f"move it away from the image of ({discs[j, 0]:g}, {discs[j, 1]:g})",
                )


def _checked_inlet(parameters: Parameters, inlet: Inlet | None) -> tuple[Floats, Floats]:
    if inlet is None:
        return np.zeros(4), np.zeros(0)
    if not isinstance(inlet, Inlet):
        raise InputError.of("inlet", "an Inlet", inlet, "build it with pinchoff.Inlet(...)")
    x = checked_number("inlet.x", inlet.x, "give it in D0")
    bottom = checked_number("inlet.bottom", inlet.bottom, "give it in D0")
    fraction = checked_number(
        "inlet.area_fraction", inlet.area_fraction, "use 0.1", low=0.0, high=0.9, above=True
    )
    sizes = np.atleast_1d(np.asarray(inlet.diameters, dtype=object))
    if sizes.ndim != 1 or not len(sizes):
        advice = "give one number in D0, or a list to draw from"
        raise InputError.of("inlet.diameters", "numbers", inlet.diameters, advice)
    most = MOST_VERTICES / parameters.vertex_count
    diameters = np.empty(len(sizes))
    for i, size in enumerate(sizes.tolist()):
        name = f"inlet.diameters[{i}]"
        diameters[i] = checked_number(name, size, "give it in D0", low=LEAST_DIAMETER, high=most)
    widest = float(diameters.max())
    top = checked_number(
        "inlet.top", inlet.top, "make room for the largest droplet", low=bottom + 1.2 * widest
    )
    return np.array([x, bottom, top, fraction]), diameters
