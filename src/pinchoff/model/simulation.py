"""Run collisions: one in detail, or very many into a table."""

from __future__ import annotations

import itertools
import math
import os
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff import _core
from pinchoff.collisions.schema import COLUMNS, Column
from pinchoff.model.arrangement import Floats, droplet_circles, obstacle_circles
from pinchoff.model.flow import Flow
from pinchoff.model.given import as_parameters, each_given
from pinchoff.model.gsd import Frame
from pinchoff.model.guards import warn_of_failures
from pinchoff.model.parameters import (
    PARAMETERS,
    SAMPLE_INTERVAL,
    Parameters,
    require_parameters,
)
from pinchoff.model.results import Collision, collision_of
from pinchoff.model.run_table import CHUNK_SIZE, first_meeting, run_batch, varied_columns
from pinchoff.support.arguments import checked_whole, finite_or_nan
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.progress import Show, progress_bar, shifted, wanted_progress

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.outlines import Outlines

__all__ = ["Collision", "Flow", "simulate", "simulate_many"]

RECORDING_INTERVAL = 0.05
"""Time between two recorded outlines unless said otherwise, t0."""

LONGEST_INTERVAL = 1e6
"""Longer than any run, t0: an interval as long or longer records its start and its end."""

MOST_THREADS = 1024


def simulate(
    parameters: Parameters,
    *,
    flow: Flow | None = None,
    obstacles: ArrayLike | None = None,
    droplets: ArrayLike | None = None,
    outlines: bool | float | None = False,
    on_frame: Callable[[float, Frame], object] | None = None,
    progress: bool = False,
) -> Collision:
    """Run one collision from its start to its outcome.

    Parameters
    ----------
    parameters : Parameters
        The model.
    flow : Flow, optional
        What `pinchoff.flow` builds; by default the Stokes flow around the first obstacle.
    obstacles : array_like, shape (M, 3), optional
        Centre x, y and radius (at least 1e-3) of each obstacle, D0. By default one of radius
        1/size_ratio at the origin. M may be zero if a flow is given; the run then lasts until
        the time limit.
    droplets : array_like, shape (K, 3), optional
        Start x, y and diameter of each droplet, D0, clear of obstacles and each other by 0.05 D0
        (a coarse outline: by a vertex spacing). By default one of diameter 1 at
        (-start_distance, offset). A diameter is at least 0.02, and at most 4096/vertex_count.
    outlines : bool or float, optional
        Whether to record the outlines, or the time between two records in t0, rounded up to a
        multiple of the sampling interval: recording never changes the results.
    on_frame : callable, optional
        Called as ``on_frame(time, droplets)`` for every record at once, for instance
        `OutlineWriter.append`; records also when `outlines` is False.
    progress : bool, optional
        Whether to show a bar on stderr.

    Returns
    -------
    Collision
        For several droplets: the first contact and the first break-up of any of them. With
        obstacles or droplets of one's own, the groups of the break-up law are those of the
        droplet and the obstacle of the first contact; without contact they are NaN.

    Raises
    ------
    InputError
        An argument is wrong.
    SimulationError
        A guard stopped the run, because its result could not be trusted.
    KeyboardInterrupt
        Ctrl-C, at once.

    Warns
    -----
    UserWarning
        There are several obstacles and no flow: the Stokes flow knows the first only.

    Examples
    --------
    >>> import pinchoff as po
    >>> collision = po.simulate(po.Parameters(offset=0.02), outlines=True)
    >>> collision.outcome, round(collision.symmetry, 3), collision.droplet_count
    ('broke', 0.911, 2)
    >>> len(collision.outlines.times)
    85
    """
    require_parameters("parameters", parameters)
    circles = obstacle_circles(parameters, obstacles)
    starts = droplet_circles(parameters, droplets, circles)
    if flow is None:
        flow = _flow_around(circles)
    require_flow(flow)
    require_on_frame(on_frame)
    keep = outlines is not None and outlines is not False
    every = _samples_between_records(outlines)
    system = _core.System(parameters.model_row(), flow, circles, starts)
    times: list[float] = []
    frames: list[Frame] = []

    def record() -> None:
        frame = system.outlines()
        if keep:
            times.append(system.time)
            frames.append(frame)
        if on_frame is not None:
            on_frame(system.time, frame)

    recording = keep or on_frame is not None
    with progress_bar(progress, "collision", parameters.time_limit) as show:
        _run(system, every, record if recording else None, show)
    kept = None
    if keep:
        from pinchoff.model.outlines import Outlines  # only when asked for

        values = parameters.model_dump(mode="json")
        kept = Outlines.from_frames(times, frames, circles, values)
    own = obstacles is not None or droplets is not None
    met = first_meeting(parameters, system.contacts(), circles, starts) if own else {}
    return collision_of(parameters, system, kept, met)


def _run(
    system: _core.System,
    every: int,
    record: Callable[[], None] | None,
    show: Show | None,
) -> None:
    """Advance sample by sample, so that Ctrl-C acts at once, and record every so many samples."""
    recorded = -1.0
    for sample in itertools.count():
        due = sample % every == 0 or system.finished
        if record is not None and due and system.time > recorded:
            recorded = system.time
            record()
        if show is not None:
            show(system.time)
        if system.finished:
            return
        # A sample is a whole number of steps, close to its nominal length: half way is the next.
        system.advance(system.time + 0.5 * SAMPLE_INTERVAL)


def simulate_many(
    parameters: Iterable[Parameters | Mapping[str, Any]] | Mapping[str, Any] | pd.DataFrame,
    *,
    outlines: bool | Iterable[int] = False,
    all_columns: bool = False,
    threads: int | None = None,
    progress: bool | None = None,
    flow: Flow | None = None,
) -> pd.DataFrame:
    """Run many collisions, on all cores, into one table.

    The rows are the same, in the order of the parameters, whatever the number of threads. Runs
    are prepared a few thousand at a time: a generator of a million costs the memory of the table.

    Parameters
    ----------
    parameters : iterable of Parameters or dict, DataFrame, or dict of lists
        One per collision: `Parameters`, or dicts of their values, or a table with a column for
        each value that is given (NaN: not given). A dict of lists is a grid: every combination,
        the last name fastest.
    outlines : bool or iterable of int, optional
        Rows whose outlines are recorded too, or True for all: they are `Outlines` in the column
        ``outlines``, and None elsewhere and where a guard stopped the run.
    all_columns : bool, optional
        Whether to keep columns for which nothing is known: those of the laboratory where no run
        was built from physical quantities, and those of an image.
    threads : int, optional
        How many threads; by default as many as there are cores for this process.
    progress : bool, optional
        Whether to show a bar; by default in terminals and notebooks.
    flow : Flow, optional
        One flow for all; by default the Stokes flow around each run's own obstacle.

    Returns
    -------
    DataFrame
        The columns of `pinchoff.collisions.schema.COLUMNS`, then those of parameters that were
        given and differ between the runs, with their units in ``attrs["units"]``. A run that a
        guard stopped is a row with ``accepted`` False and a ``reject_reason``; so is one whose
        droplet never touched the obstacle.

    Raises
    ------
    InputError
        An argument is wrong; the message names its position.
    KeyboardInterrupt
        Ctrl-C, once the runs in progress have ended; no further one starts.

    Warns
    -----
    RuntimeWarning
        Guards stopped some of the runs; says how many.

    Examples
    --------
    >>> import pinchoff as po
    >>> runs = po.simulate_many({"offset": [0, 0.2], "line_tension": [40, 80]})
    >>> runs["broke"].tolist(), runs["line_tension"].tolist()
    ([True, True, False, False], [40.0, 80.0, 40.0, 80.0])
    >>> runs.attrs["units"]["contact_time"]
    't0'
    """
    from pinchoff.collisions import schema

    given = each_given(parameters)
    workers = thread_count(threads)
    if flow is not None:
        require_flow(flow)
    recorded = _Recorder(outlines, flow)
    total = len(given) if isinstance(given, Sized) else None
    parts: list[dict[str, NDArray[Any]]] = []
    given_names: set[str] = set()
    done = 0
    with progress_bar(wanted_progress(progress), "collisions", total, unit="runs") as show:
        for raw in _chunks(given):
            ids = range(done, done + len(raw))
            chunk = [as_parameters(one, number) for number, one in zip(ids, raw, strict=True)]
            given_names = given_names.union(*(p.model_fields_set for p in chunk))
            parts.append(
                run_batch(
                    chunk,
                    ids,
                    threads=workers,
                    flow=flow,
                    varied=PARAMETERS,
                    show=shifted(show, done),
                )
            )
            recorded.record(ids, chunk)
            done += len(chunk)
    table = schema.table(parts, _varied(parts, given_names))
    warn_of_failures(int((table["outcome"] == "failed").sum()), done)
    if not all_columns:
        unknown = [name for name in _LABORATORY_COLUMNS if table[name].isna().all()]
        known_units = {n: u for n, u in table.attrs["units"].items() if n not in unknown}
        table = table.drop(columns=unknown)
        table.attrs["units"] = known_units
    return recorded.added_to(table)


_LABORATORY_COLUMNS = tuple(
    column.name
    for column in COLUMNS
    if any(unit in column.unit for unit in ("µm", "mm", "mPa", "mN")) or column.unit == "s"
)


def _varied(parts: Sequence[Mapping[str, NDArray[Any]]], said: set[str]) -> list[Column]:
    """Return the columns of parameters that were given and differ between the runs."""

    def differs(name: str) -> bool:
        values = np.concatenate([part[name] for part in parts])
        first = values[:1]
        same = values == first
        if values.dtype.kind == "f":
            same |= np.isnan(values) & np.isnan(first)
        return not same.all()

    columns = varied_columns(name for name in PARAMETERS if name in said).values()
    return [column for column in columns if differs(column.name)] if parts else []


class _Recorder:
    """The outlines of chosen runs, each of which is simulated a second time to record them."""

    def __init__(self, wanted: bool | Iterable[int], flow: Flow | None) -> None:
        self._all = wanted is True
        self._rows = set() if isinstance(wanted, bool) else _row_numbers(wanted)
        self._flow = flow
        self._found: dict[int, Outlines | None] = {}

    def record(self, ids: range, chunk: Sequence[Parameters]) -> None:
        """Record those of a chunk that are wanted."""
        for number, parameters in zip(ids, chunk, strict=True):
            if self._all or number in self._rows:
                try:
                    run = simulate(parameters, flow=self._flow, outlines=True)
                except SimulationError:  # the row has the reason
                    self._found[number] = None
                else:
                    self._found[number] = run.outlines

    def added_to(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the table with the outlines as a column, if any were wanted."""
        if missing := sorted(self._rows - self._found.keys()):
            rule = f"numbers of rows, from 0 to {len(table) - 1}"
            raise InputError.of("outlines", rule, missing[0], "count the runs from 0")
        if not (self._all or self._rows):
            return table
        column = np.full(len(table), None, dtype=object)
        for number, outlines in self._found.items():
            column[number] = outlines
        table["outlines"] = column
        return table


def _row_numbers(wanted: object) -> set[int]:
    advice = "use True for all, or give rows as [0, 5]"
    rule = "True, False or numbers of rows"
    if not isinstance(wanted, Iterable) or isinstance(wanted, str):
        raise InputError.of("outlines", rule, wanted, advice)
    numbers = list(wanted)
    if not all(isinstance(n, int | np.integer) and not isinstance(n, bool) for n in numbers):
        raise InputError.of("outlines", rule, numbers, advice)
    return {int(number) for number in numbers}


def _chunks(parameters: Iterable[Any]) -> Iterator[list[Any]]:
    rest = iter(parameters)
    while chunk := list(itertools.islice(rest, CHUNK_SIZE)):
        yield chunk


def thread_count(threads: int | None) -> int:
    """Check a number of threads; None stands for as many as there are cores for this process."""
    if threads is None:
        if hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1
    advice = "leave it out for all cores"
    return checked_whole("threads", threads, advice, low=1, high=MOST_THREADS)


def _samples_between_records(outlines: object) -> int:
    unsaid = outlines is None or isinstance(outlines, bool)
    interval = RECORDING_INTERVAL if unsaid else finite_or_nan(outlines)
    if not interval > 0:
        raise InputError.of(
            "outlines",
            "True, False or a positive, finite interval in t0",
            outlines,
            f"use True to record every {RECORDING_INTERVAL} t0",
        )
    return max(1, math.ceil(min(interval, LONGEST_INTERVAL) / SAMPLE_INTERVAL - 1e-9))


def require_flow(flow: object) -> None:
    """Refuse anything that is not a flow."""
    if not isinstance(flow, Flow):
        advice = "build it with pinchoff.flow.stokes, uniform or sampled"
        raise InputError.of("flow", "a flow", flow, advice)


def require_on_frame(on_frame: object) -> None:
    """Refuse what cannot be called for every frame."""
    if on_frame is not None and not callable(on_frame):
        advice = "give a function of (time, droplets)"
        raise InputError.of("on_frame", "callable", on_frame, advice)


def _flow_around(circles: Floats) -> Flow:
    if not len(circles):
        advice = "pass one, such as pinchoff.flow.uniform()"
        raise InputError.of("flow", "given when there is no obstacle", None, advice)
    if len(circles) > 1:
        warnings.warn(
            f"the default flow is that around the first of the {len(circles)} obstacles alone: "
            "pass one that knows them all as flow=, such as pinchoff.flow.sampled(...)",
            UserWarning,
            stacklevel=3,
        )
    x, y, radius = circles[0].tolist()
    return _core.StokesFlow(radius, x, y)
