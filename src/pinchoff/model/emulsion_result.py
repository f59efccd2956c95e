"""What comes of a run of many droplets: its events, its sizes, its outlines, and its balance."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.collisions.schema import Column, count_column, measure_column
from pinchoff.model.emulsion_files import EmulsionFolder, joined
from pinchoff.model.gsd import Frame
from pinchoff.model.guards import guard_message
from pinchoff.model.parameters import SPRINGS, Parameters
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.outlines import Outlines

_KINDS = _core.EVENT_KINDS

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

RETIRED_WARNING = 0.01
"""Share of the area from which on a run warns of the droplets that guards took out."""

SIZE_COLUMNS: tuple[Column, ...] = (
    measure_column("time", "t0", "of the frame"),
    count_column("droplet_id", "number of the droplet"),
    count_column("generation", "break-ups in its ancestry since the last merge"),
    measure_column("diameter", "D0", "of the circle of equal area"),
    measure_column("x", "D0", "mean of its vertices"),
    measure_column("y", "D0", "as x"),
)
"""Every droplet of every frame."""

_TABLES = {"events": EVENT_COLUMNS, "sizes": SIZE_COLUMNS}


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
    stopped : bool
        Whether a guard ended it before its time, as ``on_guard="stop"`` asks for.
    """

    parameters: Parameters
    time: float = 0.0
    balance: dict[str, float] = field(default_factory=dict)
    stopped: bool = False
    _folder: EmulsionFolder | None = None
    _recent: dict[str, list[pd.DataFrame]] = field(
        default_factory=lambda: {name: [] for name in _TABLES}
    )  # parts of the tables that are in no folder, or not yet

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
        return self._table("events")

    @property
    def sizes(self) -> pd.DataFrame:
        """One row a droplet and frame, with the columns of `SIZE_COLUMNS`."""
        return self._table("sizes")

    @property
    def outlines(self) -> Outlines | None:
        """The recorded outlines; None if the run had no folder for them."""
        return None if self._folder is None else self._folder.read_outlines()

    @property
    def retired(self) -> pd.DataFrame:
        """The droplets that guards took out, a row each.

        droplet_id, time (t0), x, y and diameter (D0), share (of the area of all droplets that
        there were) and reason.
        """
        events = self.events
        gone = events[events["kind"] == "retired"]
        area = gone["area"].to_numpy(np.float64)
        table: pd.DataFrame = gone[["droplet_id", "time", "x", "y"]].reset_index(drop=True)
        table["diameter"] = np.sqrt(4 / math.pi * area)
        table["share"] = area / self.balance["area_in"]
        table["reason"] = gone["reason"].to_numpy()
        return table

    @property
    def retired_share(self) -> float:
        """The share of the area of all droplets that guards took out."""
        counts = self.balance
        return counts["area_retired"] / counts["area_in"] if counts["area_in"] > 0 else 0.0

    def warn_of_guards(self, stacklevel: int = 2) -> None:
        """Warn where a guard ended the run, or guards took out more than 1 % of all area."""
        if self.stopped or self.retired_share > RETIRED_WARNING:
            warnings.warn(self.guard_report, RuntimeWarning, stacklevel=stacklevel)

    @property
    def guard_report(self) -> str:
        """What guards did to the run and what to do, in words; empty where they did nothing."""
        gone = self.retired
        if not len(gone):
            return ""
        first = gone.iloc[0]
        droplet = (
            f"droplet {first['droplet_id']} ({first['diameter']:.3g} D0, at x = {first['x']:.3g}, "
            f"y = {first['y']:.3g})"
        )
        if self.stopped:
            return (
                f"a guard ended the run at t = {self.time:.4g} t0, with {droplet}: "
                f'{first["reason"]}; with on_guard = "retire" the others go on'
            )
        return (
            f"guards took out {counted(len(gone), 'droplet')} with "
            f"{100 * self.retired_share:.3g} % of all area; the others went on. The first is "
            f"{droplet}: {first['reason']}"
        )

    def outline_pieces(self) -> Iterator[Outlines]:
        """Yield the recorded outlines piece by piece, in order; none without a folder for them."""
        return iter(()) if self._folder is None else self._folder.outline_pieces()

    @property
    def checkpoint(self) -> Path | None:
        """The file from which the run can go on; None without a folder."""
        return None if self._folder is None else self._folder.checkpoint

    def _table(self, name: str) -> pd.DataFrame:
        columns = _TABLES[name]
        if self._folder is not None:
            table = self._folder.read_table(name, columns)
        else:
            table = joined(self._recent[name], columns)
        table.attrs["units"] = {c.name: c.unit for c in columns}
        return table


class Recorder:
    """Takes from a run what it has come to, frame by frame, into its result and its folder."""

    def __init__(
        self,
        run: _core.Emulsion,
        result: Emulsion,
        on_frame: Callable[[float, Frame], object] | None,
    ) -> None:
        self._run = run
        self.result = result
        self._folder = result._folder
        self._on_frame = on_frame

    def begin(self, resume: bool) -> None:
        """Make the folder ready, and go on from its checkpoint; or take the first frame."""
        state = None if self._folder is None else self._folder.begin(resume)
        if state is None:
            self.take_frame()
            return
        try:
            self._run.restore(state)
        except ValueError as error:
            place, advice = str(self.result.checkpoint), "remove the folder and run again"
            raise InputError.of(place, "a checkpoint", str(error), advice) from None
        self._count()

    def take_frame(self) -> None:
        """Take the events up to here, and this frame."""
        run, result = self._run, self.result
        events = self._events()
        result._recent["events"] += [events] if len(events) else []
        result._recent["sizes"].append(_size_table(run))
        self._count()
        if self._folder is not None and self._folder.keeps_outlines:
            self._folder.append_frame(run.time, *flat_frame(run.frame()))
        if self._on_frame is not None:
            self._on_frame(run.time, droplets_of(run.frame()))

    def write_piece(self) -> None:
        """Write what was taken since the last piece, and a checkpoint."""
        recent = self.result._recent
        if self._folder is not None and recent["sizes"]:
            self._folder.write_piece(recent, _TABLES, np.asarray(self._run.state()))
            for parts in recent.values():
                parts.clear()

    def _count(self) -> None:
        self.result.time = self._run.time
        self.result.balance = _balance(self._run)
        self.result.stopped = self._run.stopped

    def _events(self) -> pd.DataFrame:
        import pandas as pd

        events = dict(zip(_core.EVENT_FIELDS, np.asarray(self._run.take_events()).T, strict=True))
        kinds = pd.Categorical([_KINDS[int(code)] for code in events["kind"]], list(_KINDS))
        springs = self.result.parameters.model == SPRINGS
        alarms = zip(events["guard"], events["guard_value"], events["time"], strict=True)
        reasons = [
            "" if math.isnan(g) else guard_message(_core.GUARDS[int(g)], value, at, springs=springs)
            for g, value, at in alarms
        ]
        own = {
            "kind": kinds,
            "droplet_id": events["droplet_id"].astype(np.int64),
            "reason": np.array(reasons, dtype=object),
        }
        return pd.DataFrame({c.name: own.get(c.name, events.get(c.name)) for c in EVENT_COLUMNS})


def _balance(run: _core.Emulsion) -> dict[str, float]:
    values = dict(zip(_core.BALANCE_FIELDS, np.asarray(run.balance()).tolist(), strict=True))
    areas = {name: value for name, value in values.items() if name.startswith("area")}
    counts = {name: int(value) for name, value in values.items() if name not in areas}
    present = sum(counts[name] for name in ("start", "entered", "breakups"))
    present -= sum(counts[name] for name in ("merges", "left", "retired"))
    return counts | areas | {"present": present}


def _size_table(run: _core.Emulsion) -> pd.DataFrame:
    import pandas as pd

    sizes = np.asarray(run.sizes())
    timed = np.column_stack([np.full(len(sizes), run.time), sizes])
    table = pd.DataFrame(timed, columns=[c.name for c in SIZE_COLUMNS])
    return table.astype({c.name: c.dtype for c in SIZE_COLUMNS})


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
