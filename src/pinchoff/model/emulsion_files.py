"""The folder of a run of many droplets: pieces of its tables and outlines, and its checkpoint.

A piece is what happened between two checkpoints. Its files are written aside and renamed, then
the checkpoint is; so a run that was killed goes on from whole pieces, and what it had begun after
the last checkpoint is written again.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import NonNegativeInt

from pinchoff.collisions.parquet import write_table
from pinchoff.collisions.schema import Column
from pinchoff.model.gsd import Floats, OutlineWriter
from pinchoff.support.errors import InputError
from pinchoff.support.files import HoldsFiles, written_aside
from pinchoff.support.records import Shape, parsed_record

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.outlines import Outlines

CHECKPOINT_NAME = "checkpoint.npz"
FORMAT = 2
"""Of the state in a checkpoint; it changes when the state does."""


class _Header(Shape):
    format: int
    piece: NonNegativeInt
    record: dict[str, Any]


class EmulsionFolder(HoldsFiles):
    """The files of one run; a run that is stopped loses the outlines since its last checkpoint.

    Parameters
    ----------
    path : Path
    record : mapping
        What decides the run, as JSON has it; a checkpoint of another run is refused.
    circles : ndarray, shape (M, 3)
        The obstacles, for the outlines' files.
    keeps_outlines : bool
    """

    def __init__(
        self, path: Path, record: Mapping[str, Any], circles: Floats, keeps_outlines: bool
    ) -> None:
        self.path = path
        self.checkpoint = path / CHECKPOINT_NAME
        self.keeps_outlines = keeps_outlines
        self._record = {**json.loads(json.dumps(record)), "outlines": keeps_outlines}
        self._circles = circles
        self._piece = 0
        self._writer: OutlineWriter | None = None
        self._files = ExitStack()  # what is being written

    def begin(self, resume: bool) -> Floats | None:
        """Make the folder ready; return the state to go on from, or None; refuse another run's."""
        state = None
        if self.checkpoint.exists():
            if not resume:
                advice = "choose another folder, or resume the run that is there"
                raise InputError.of("out", "a folder without a run", self.path, advice)
            state = self._read_checkpoint()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            rule, reason = "a folder that can be made", error.strerror or str(error)
            raise InputError.of("out", rule, f"{self.path} ({reason})", "choose another") from None
        for name in ("events", "sizes", "outlines"):
            for path in self._pieces(name):
                # left by a run that was killed after its last checkpoint
                if int(path.stem.rsplit("-", 1)[1]) >= self._piece:
                    path.unlink()
        return state

    def _read_checkpoint(self) -> Floats:
        place, rule = str(self.checkpoint), "a checkpoint"
        advice = "remove the folder and run again"
        try:
            # By a file of ours: NumPy leaves its own open where the archive is damaged.
            with self.checkpoint.open("rb") as file, np.load(file, allow_pickle=False) as data:
                text = str(data["header"])
                state = np.array(data["state"], dtype=np.float64).reshape(-1)
        except Exception as error:  # what damage makes the library raise is of every kind
            raise InputError.of(place, rule, str(error), advice) from None
        header = parsed_record(text, place, _Header, rule, advice)
        format_found, record = header["format"], header["record"]
        self._piece = header["piece"]
        if format_found != FORMAT:
            advice = "go on with the version of pinchoff that wrote it, or run again"
            raise InputError.of(place, f"of format {FORMAT}", format_found, advice)
        names = {**self._record, **record}
        other = [name for name in names if record.get(name) != self._record.get(name)]
        if other:
            got = f"one with other {', '.join(other)}"
            advice = "give the same arguments as then, or choose another folder"
            raise InputError.of("resume", "of a run with the same settings", got, advice)
        return state

    def append_frame(self, time: float, *flat: NDArray[Any]) -> None:
        """Add one frame to the outlines of this piece; see `OutlineWriter.append_flat`."""
        if self._writer is None:
            unfinished = self._files.enter_context(written_aside(self._named("outlines")))
            self._writer = OutlineWriter(
                unfinished, self._circles, self._record["parameters"], flush_every=None
            )
            self._files.callback(self._writer.close)
        self._writer.append_flat(time, *flat)

    def write_piece(
        self,
        tables: Mapping[str, Sequence[pd.DataFrame]],
        columns: Mapping[str, Sequence[Column]],
        state: Floats,
    ) -> None:
        """Write the tables of a piece, each in parts, and the checkpoint behind it."""
        for name, parts in tables.items():
            table = joined(parts, columns[name])
            if len(table):
                write_table(table, self._named(name), columns[name])
        self._files.close()
        self._writer = None
        self._piece += 1
        header = {"format": FORMAT, "piece": self._piece, "record": self._record}
        with written_aside(self.checkpoint) as unfinished, unfinished.open("wb") as file:
            np.savez(file, header=np.array(json.dumps(header)), state=state)

    def read_table(self, name: str, columns: Sequence[Column]) -> pd.DataFrame:
        """Return a table of all pieces."""
        import pandas as pd

        return joined([pd.read_parquet(path) for path in self._pieces(name)], columns)

    def outline_pieces(self) -> Iterator[Outlines]:
        """Yield the outlines of each piece, so that not all have to be in memory."""
        from pinchoff.model.outlines import Outlines

        return (Outlines.load(path) for path in self._pieces("outlines"))

    def read_outlines(self) -> Outlines | None:
        """Return the outlines of all pieces; None where none were kept."""
        from pinchoff.model.outlines import Outlines

        parts = list(self.outline_pieces())
        if not parts:
            return None
        times = [time for part in parts for time in part.times.tolist()]
        frames = [list(part[k]) for part in parts for k in range(len(part.times))]
        return Outlines.from_frames(times, frames, self._circles, self._record["parameters"])

    def _named(self, name: str) -> Path:
        suffix = ".gsd" if name == "outlines" else ".parquet"
        return self.path / f"{name}-{self._piece:06d}{suffix}"

    def _pieces(self, name: str) -> list[Path]:
        return sorted(self.path.glob(f"{name}-??????.*"))


def joined(parts: Sequence[pd.DataFrame], columns: Sequence[Column]) -> pd.DataFrame:
    """Return tables as one; where none has rows one without rows, with columns of their types."""
    import pandas as pd

    if filled := [part for part in parts if len(part)]:
        return pd.concat(filled, ignore_index=True)
    typed = {c.name: pd.Series(dtype="object" if c.dtype == "str" else c.dtype) for c in columns}
    return pd.DataFrame(typed)
