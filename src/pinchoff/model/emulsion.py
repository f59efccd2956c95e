"""Many droplets among many obstacles: from the arrangement to events, sizes and outlines.

Droplets interact through contact alone. The engine groups those that can meet and advances each
group with a time step of its own, on all threads, so that the cost grows like the number of
droplets; results do not depend on the number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from pinchoff import _core
from pinchoff.collisions.schema import Column, count_column, measure_column
from pinchoff.model.arrangement import droplet_circles, obstacle_circles
from pinchoff.model.arrays import PillarArray
from pinchoff.model.emulsion_files import EmulsionFolder, Piece
from pinchoff.model.flow import Flow, uniform
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import FRONT, PARAMETERS, SAMPLE_INTERVAL, SPRINGS, Parameters
from pinchoff.model.simulation import require_flow, thread_count
from pinchoff.support.arguments import checked_number, checked_positive, checked_whole
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.locks import held_folder
from pinchoff.support.progress import progress_bar

if TYPE_CHECKING:
    import os

    import pandas as pd

    from pinchoff.model.outlines import Outlines

Floats: TypeAlias = NDArray[np.float64]
Frame: TypeAlias = list[tuple[int, int, Floats, Floats]]
"""Droplets at one time: (droplet_id, generation, vertices (n, 2), velocities (n, 2))."""

WINDOW = 5 * SAMPLE_INTERVAL
"""Time between two looks at who may meet whom, t0."""

LEAST_PERIOD = 2.0
"""Least period, D0: a droplet shall not meet itself round the cell before it is drawn out."""

_KINDS = _core.EVENT_KINDS
_BALANCE = _core.BALANCE_FIELDS

EVENT_COLUMNS: tuple[Column, ...] = (
    Column("kind", "", "category", "what happened", _KINDS),
    measure_column("time", "t0", "when"),
    count_column("droplet_id", "the droplet that it happened to"),
    measure_column("x", "D0", "where: the droplet's centre, or the middle of its neck"),
    measure_column("y", "D0", "as x"),
    measure_column("area", "D0^2", "of the droplet"),
    measure_column("obstacle", "1", "contact: number of the obstacle, from 0"),
    measure_column("symmetry", "1", "contact: S"),
    measure_column("impact_parameter", "D0", "contact: b"),
    measure_column("speed", "v_f", "contact: of the droplet's centre"),
    measure_column("shape_parameter", "1", "contact: P^2/(4 pi A)"),
    measure_column("daughter_1", "1", "breakup: droplet_id of one daughter"),
    measure_column("daughter_2", "1", "breakup: droplet_id of the other"),
    measure_column("area_1", "D0^2", "breakup: of daughter_1; of two that touch: of droplet_id"),
    measure_column("area_2", "D0^2", "breakup: of daughter_2; of two that touch: of partner"),
    measure_column("neck_thickness", "D0", "breakup: of the neck that was cut"),
    measure_column("partner", "1", "touched, parted, merge, unmerged: droplet_id of the other one"),
    measure_column("into", "1", "merge: droplet_id of what came of the two"),
    measure_column("facing_length", "D0", "parted, merge: L, the most of this contact"),
    measure_column("clock", "1", "parted, merge: C at the end, where 1 is a drained film"),
    measure_column("since", "t0", "parted, merge: when the contact began"),
    measure_column("waited", "t0", "entered: how long there was no room for it"),
    Column("reason", "", "str", "respaced, retired, unmerged: what a guard found wrong with it"),
)
"""The events of an emulsion; what has no meaning for a kind is NaN."""

SIZE_COLUMNS: tuple[Column, ...] = (
    measure_column("time", "t0", "of the frame"),
    count_column("droplet_id", "number of the droplet"),
    count_column("generation", "break-ups in its ancestry since the last merge"),
    measure_column("diameter", "D0", "of the circle of equal area"),
    measure_column("x", "D0", "mean of its vertices"),
    measure_column("y", "D0", "as x"),
)
"""Every droplet of every frame."""


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


def simulate_emulsion(
    parameters: Parameters,
    *,
    time: float,
    droplets: ArrayLike | None = None,
    obstacles: ArrayLike | PillarArray | None = None,
    flow: Flow | None = None,
    cell: Sequence[float] | None = None,
    periodic: str = "",
    inlet: Inlet | None = None,
    outlet: float | None = None,
    coalescence: Coalescence | None = None,
    smallest_breaking: float = 0.0,
    interval: float = 0.5,
    on_frame: Callable[[float, Frame], object] | None = None,
    out: str | os.PathLike[str] | None = None,
    outlines: bool = True,
    checkpoint: float = 10.0,
    resume: bool = False,
    seed: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> Emulsion:
    """Run many droplets among many obstacles.

    Parameters
    ----------
    parameters : Parameters
        The model. Where neither ``model`` nor a constant of the springs is given it is front
        tracking, in which a small droplet shortens no other's step; `Emulsion.parameters` tells.
        Offset, start distance and time limit are those of a single collision and play no part;
        daughters are always followed.
    time : float
        How long, t0; rounded up to windows of 0.05 t0.
    droplets : array_like, shape (K, 3), optional
        Start x, y and diameter of each, D0, clear of each other and of the obstacles; by default
        none, if there is an inlet.
    obstacles : array_like, shape (M, 3), or PillarArray, optional
        Centre x, y and radius of each, D0; by default none.
    flow : Flow, optional
        What `pinchoff.flow` builds, or an array's; by default uniform, if there is no obstacle.
    cell : (left, right, bottom, top), optional
        D0; needed where space is periodic. By default that of the PillarArray.
    periodic : {"", "x", "y", "xy"}, optional
        Along which axes the cell repeats itself. Outlines are stored whole.
    inlet : Inlet, optional
        Where droplets come in. One that finds no room waits.
    outlet : float, optional
        Droplets wholly beyond this x leave the run, D0.
    coalescence : Coalescence, optional
        How droplets merge; by default they do not, and their contacts are not recorded.
    smallest_breaking : float, optional
        Droplets of a smaller diameter do not break, D0.
    interval : float, optional
        Time between two frames, t0; rounded up to windows.
    on_frame : callable, optional
        Called as ``on_frame(time, droplets)`` for every frame. Velocities are half a time step
        behind the positions.
    out : path, optional
        A folder for events, sizes, outlines and checkpoints, written piece by piece. Without it
        events and sizes are kept in memory, and no outlines.
    outlines : bool, optional
        Whether the folder gets the outlines of every frame.
    checkpoint : float, optional
        Time between two checkpoints, t0; rounded up to frames.
    resume : bool, optional
        Whether to go on from the folder's checkpoint, if it has one. The result is the same to
        the last bit as that of a run that was not interrupted.
    seed : int, optional
        Of the places and diameters at the inlet, and of stochastic merging.
    threads : int, optional
        By default as many as there are cores for this process.
    progress : bool, optional
        Whether to show a bar on stderr.

    Returns
    -------
    Emulsion

    Raises
    ------
    InputError
        An argument is wrong.
    SimulationError
        Droplets with more than 0.1 % of the area had to be taken out, because their shapes could
        not be trusted. The folder holds the run up to there.
    KeyboardInterrupt
        Ctrl-C; the folder holds the run up to its last checkpoint.

    Examples
    --------
    >>> import pinchoff as po
    >>> run = po.simulate_emulsion(
    ...     po.Parameters(simulation_capillary_number=20),
    ...     time=1, droplets=[[0, 0, 1], [0, 1.5, 0.8]],
    ... )
    >>> run.balance["present"], len(run.sizes)
    (2, 6)
    """
    parameters = emulsion_parameters(parameters)
    scene = _scene(
        parameters, droplets, obstacles, flow, cell, periodic, inlet, outlet, coalescence
    )
    settings = {
        "smallest_breaking": checked_number(
            "smallest_breaking", smallest_breaking, "give a diameter in D0", low=0.0
        ),
        "seed": checked_whole("seed", seed, "use 0", low=0, high=2**63 - 1),
    }
    windows = _windows("time", time)
    per_frame = _windows("interval", interval)
    frames_per_piece = max(1, math.ceil(_windows("checkpoint", checkpoint) / per_frame))
    if on_frame is not None and not callable(on_frame):
        raise InputError.of("on_frame", "callable", on_frame, "give a function of (time, droplets)")
    if resume and out is None:
        raise InputError.of("out", "given to resume", None, "name the folder of the earlier run")
    run = scene.start(settings, thread_count(threads))
    record = scene.record() | settings | {"interval": per_frame * WINDOW}
    folder = None if out is None else EmulsionFolder(Path(out), record, scene.circles, outlines)
    result = Emulsion(parameters=parameters, _folder=folder)
    with (
        ExitStack() as held,
        progress_bar(progress, "emulsion", windows * WINDOW, unit="t0") as show,
    ):
        if folder is not None:
            held.enter_context(held_folder(folder.path))
            held.enter_context(folder)
        _run(run, windows, per_frame, frames_per_piece, result, on_frame, resume, show)
    return result


def emulsion_parameters(parameters: Parameters) -> Parameters:
    """Return the parameters with the model that a run of many droplets takes by default.

    Raises
    ------
    InputError
        They are none.

    Examples
    --------
    >>> emulsion_parameters(Parameters(simulation_capillary_number=20)).model
    'front-tracking'
    >>> emulsion_parameters(Parameters(edge_stiffness=0.1)).model
    'deformable-particle'
    """
    if not isinstance(parameters, Parameters):
        advice = "build it with pinchoff.Parameters(...)"
        raise InputError.of("parameters", "a Parameters", parameters, advice)
    springs = {name for name, entry in PARAMETERS.items() if entry.model == SPRINGS}
    if ({"model"} | springs) & parameters.model_fields_set:
        return parameters
    return parameters.replace(model=FRONT)


def _windows(name: str, value: object) -> int:
    length = checked_positive(name, value, "give it in t0")
    if length > 1e7:
        raise InputError.of(name, "at most 1e7 t0", value, "run in pieces, with resume")
    return max(1, math.ceil(length / WINDOW - 1e-9))


def _run(
    run: _core.Emulsion,
    windows: int,
    per_frame: int,
    frames_per_piece: int,
    result: Emulsion,
    on_frame: Callable[[float, Frame], object] | None,
    resume: bool,
    show: Any,
) -> None:
    """Advance from frame to frame; write a piece whenever one is full, and at the end."""
    folder = result._folder
    state = None
    if folder is not None:
        state = folder.begin(resume)
    done = 0
    if state is not None:
        try:
            run.restore(state)
        except ValueError as error:
            advice = "remove the folder and run again"
            got = str(error)
            raise InputError.of(str(result.checkpoint), "a checkpoint", got, advice) from None
        done = round(run.time / WINDOW)
        result._take_count(run)
    else:
        result._note(run, on_frame)
    frames = 0
    while done < windows and not run.failed:
        step = min(per_frame - done % per_frame, windows - done)
        run.advance(step)
        done += step
        result._note(run, on_frame)
        frames += 1
        if frames % frames_per_piece == 0:
            result._write_piece(run)
        if show is not None:
            show(run.time, label=f"{result.balance['present']} droplets, t0")
    result._write_piece(run)
    if run.failed:
        area = 100 * result.balance["area_retired"] / result.balance["area_in"]
        worst = result._reasons[-1] if result._reasons else "unknown"
        raise SimulationError(
            "the area of retired droplets must be at most 0.1 % of all; "
            f"got {area:.2g} % at t = {run.time:.4g} t0; the last one: {worst}",
            guard="retired",
            value=area / 100,
            time=run.time,
        )


@dataclass(eq=False, repr=False)
class Emulsion:
    """What came of a run of many droplets.

    Attributes
    ----------
    parameters : Parameters
    time : float
        Where it ended, t0.
    balance : dict
        What happened, in numbers. ``start`` + ``entered`` + ``breakups`` - ``merges`` - ``left`` -
        ``retired`` droplets are ``present``; ``touches`` contacts of two droplets began, and
        ``unmerged`` merges were refused; ``waits`` is how many had to wait at the inlet; areas in
        D0^2.
    """

    parameters: Parameters
    time: float = 0.0
    balance: dict[str, float] = field(default_factory=dict)
    _folder: EmulsionFolder | None = field(default=None, repr=False)
    _events: list[pd.DataFrame] = field(default_factory=list, repr=False)
    _sizes: list[pd.DataFrame] = field(default_factory=list, repr=False)
    _piece: Piece = field(default_factory=Piece, repr=False)
    _reasons: list[str] = field(default_factory=list, repr=False)

    def __repr__(self) -> str:
        counts = self.balance
        gone = f", {counts['retired']} retired" if counts.get("retired") else ""
        return (
            f"<Emulsion at t = {self.time:.4g} t0: {counts.get('present', 0)} droplets, "
            f"{counts.get('breakups', 0)} break-ups, {counts.get('merges', 0)} merges, "
            f"{counts.get('entered', 0)} entered, "
            f"{counts.get('left', 0)} left{gone}>"
        )

    @property
    def events(self) -> pd.DataFrame:
        """One row an event, with the columns of `EVENT_COLUMNS`."""
        return self._table("events", self._events, EVENT_COLUMNS)

    @property
    def sizes(self) -> pd.DataFrame:
        """One row a droplet and frame, with the columns of `SIZE_COLUMNS`."""
        return self._table("sizes", self._sizes, SIZE_COLUMNS)

    @property
    def outlines(self) -> Outlines | None:
        """The recorded outlines; None if the run had no folder for them."""
        return None if self._folder is None else self._folder.read_outlines()

    def outline_pieces(self) -> Iterator[Outlines]:
        """Yield the recorded outlines piece by piece, in order; none without a folder for them."""
        return iter(()) if self._folder is None else self._folder.outline_pieces()

    @property
    def checkpoint(self) -> Path | None:
        """The file from which the run can go on; None without a folder."""
        return None if self._folder is None else self._folder.checkpoint

    def _table(
        self, name: str, kept: list[pd.DataFrame], columns: Sequence[Column]
    ) -> pd.DataFrame:
        import pandas as pd

        if self._folder is not None:
            table = self._folder.read_table(name, columns)
        else:
            empty = pd.DataFrame({c.name: [] for c in columns})
            table = pd.concat(kept, ignore_index=True) if kept else empty
        table.attrs["units"] = {c.name: c.unit for c in columns}
        return table

    def _note(self, run: _core.Emulsion, on_frame: Callable[[float, Frame], object] | None) -> None:
        """Take the events up to here, and this frame."""
        events = self._take_events(run)
        sizes = _size_table(run)
        self._take_count(run)
        if self._folder is None:
            self._events += [events] if len(events) else []
            self._sizes.append(sizes)
        else:
            self._piece.events.append(events)
            self._piece.sizes.append(sizes)
            if self._folder.keeps_outlines:
                self._folder.append_frame(run.time, *flat_frame(run.frame()))
        if on_frame is not None:
            on_frame(run.time, droplets_of(run.frame()))

    def _take_count(self, run: _core.Emulsion) -> None:
        self.time = run.time
        self.balance = _balance(run)

    def _take_events(self, run: _core.Emulsion) -> pd.DataFrame:
        import pandas as pd

        events = dict(zip(_core.EVENT_FIELDS, np.asarray(run.take_events()).T, strict=True))
        names = [_KINDS[int(code)] for code in events["kind"]]
        kinds = pd.Categorical(names, categories=list(_KINDS))
        guards, values, times = events["guard"], events["guard_value"], events["time"]
        springs = self.parameters.model == SPRINGS
        reasons = [
            "" if math.isnan(g) else guard_message(_core.GUARDS[int(g)], value, at, springs=springs)
            for g, value, at in zip(guards, values, times, strict=True)
        ]
        self._reasons += [r for r, k in zip(reasons, kinds, strict=True) if k == "retired"]
        own = {
            "kind": kinds,
            "droplet_id": events["droplet_id"].astype(np.int64),
            "reason": np.array(reasons, dtype=object),
        }
        return pd.DataFrame({c.name: own.get(c.name, events.get(c.name)) for c in EVENT_COLUMNS})

    def _write_piece(self, run: _core.Emulsion) -> None:
        if self._folder is not None and self._piece.sizes:
            tables = {"events": EVENT_COLUMNS, "sizes": SIZE_COLUMNS}
            self._folder.write_piece(self._piece, tables, np.asarray(run.state()))
            self._piece = Piece()


def _balance(run: _core.Emulsion) -> dict[str, float]:
    values = dict(zip(_BALANCE, np.asarray(run.balance()).tolist(), strict=True))
    areas = {name: value for name, value in values.items() if name.startswith("area")}
    counts = {name: int(value) for name, value in values.items() if name not in areas}
    present = sum(counts[name] for name in ("start", "entered", "breakups"))
    present -= sum(counts[name] for name in ("merges", "left", "retired"))
    return counts | areas | {"present": present}


def _size_table(run: _core.Emulsion) -> pd.DataFrame:
    import pandas as pd

    sizes = np.asarray(run.sizes())
    names = [c.name for c in SIZE_COLUMNS[1:]]
    table = pd.DataFrame(sizes, columns=names)
    table = table.astype({c.name: c.dtype for c in SIZE_COLUMNS[1:]})
    table.insert(0, "time", np.full(len(sizes), run.time))
    return table


def flat_frame(frame: tuple[Any, Any, Any, Any]) -> tuple[NDArray[Any], ...]:
    """Return ids, generations, numbers of vertices (n,), vertices and velocities (V, 2)."""
    numbers, offsets, vertices, velocities = (np.asarray(part) for part in frame)
    whole = numbers.astype(np.int64)
    sizes = np.diff(offsets.astype(np.int64))
    return whole[:, 0], whole[:, 1], sizes, vertices, velocities


def droplets_of(frame: tuple[Any, Any, Any, Any]) -> Frame:
    """Return the droplets of a frame of flat arrays."""
    ids, generations, sizes, vertices, velocities = flat_frame(frame)
    ends = np.cumsum(sizes)
    starts = (ends - sizes).tolist()
    spans = zip(ids.tolist(), generations.tolist(), starts, ends.tolist(), strict=True)
    return [(droplet, born, vertices[a:b], velocities[a:b]) for droplet, born, a, b in spans]


# ---------------------------------------------------------------- the scene, checked


@dataclass(frozen=True)
class _Scene:
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

    def start(self, settings: dict[str, Any], threads: int) -> _core.Emulsion:
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


def _scene(
    parameters: Parameters,
    droplets: ArrayLike | None,
    obstacles: ArrayLike | PillarArray | None,
    flow: Flow | None,
    cell: Sequence[float] | None,
    periodic: str,
    inlet: Inlet | None,
    outlet: float | None,
    coalescence: Coalescence | None,
) -> _Scene:
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
    return _Scene(
        parameters, row, flow, circles, starts, bounds, periodic, line, diameters, beyond, merging
    )


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
    if cell is None:
        if periodic:
            advice = "give (left, right, bottom, top) in D0"
            raise InputError.of("cell", "given where space is periodic", None, advice)
        return np.zeros(4)
    try:
        bounds = np.array(cell, dtype=np.float64)
    except (TypeError, ValueError):
        bounds = np.empty(0)
    if bounds.shape != (4,) or not np.isfinite(bounds).all():
        advice = "give (left, right, bottom, top) in D0"
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
    most = 4096 / parameters.vertex_count
    diameters = np.array(
        [
            checked_number(f"inlet.diameters[{i}]", d, "give it in D0", low=0.02, high=most)
            for i, d in enumerate(sizes.tolist())
        ]
    )
    widest = float(diameters.max())
    top = checked_number(
        "inlet.top", inlet.top, "make room for the largest droplet", low=bottom + 1.2 * widest
    )
    return np.array([x, bottom, top, fraction]), diameters
