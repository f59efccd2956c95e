"""Outlines in a GSD file, one frame at a time (OVITO and freud open it)."""

from __future__ import annotations

import json
import math
import os
import struct
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from pinchoff.support.files import HoldsFiles

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_NO_DROPLET = -1  # body and generation of an obstacle


class Outline(NamedTuple):
    """One droplet at one time.

    The last vertex joins the first. Lengths are in the units of the `Outlines` it came from.
    """

    droplet_id: int
    generation: int  # 0 for a droplet that has not broken, 1 for its daughters, ...
    vertices: Floats  # (n, 2)
    velocities: Floats  # (n, 2), length per time


#: What `Outlines.from_frames` and `OutlineWriter.append` accept for one droplet.
OutlineLike = Outline | tuple[int, int, npt.ArrayLike, npt.ArrayLike]

Frame: TypeAlias = list[tuple[int, int, Floats, Floats]]
"""Droplets at one time: (droplet_id, generation, vertices (n, 2), velocities (n, 2))."""


@dataclass(frozen=True, eq=False)
class StoredOutlines:
    """What a file of outlines holds; `pinchoff.Outlines` says what each is, and checks them."""

    times: Floats
    frame: Integers
    droplet_id: Integers
    generation: Integers
    offsets: Integers
    vertices: Floats
    velocities: Floats
    obstacles: Floats
    parameters: dict[str, Any] = field(default_factory=dict)
    units: str = "D0"


class FlatOutlines(NamedTuple):
    """Outlines one after the other: of each its droplet and number of vertices; all vertices."""

    droplet_ids: Integers  # (n,)
    generations: Integers  # (n,)
    sizes: Integers  # (n,)
    vertices: Floats  # (V, 2)
    velocities: Floats  # (V, 2)


def flattened(outlines: Iterable[OutlineLike]) -> FlatOutlines:
    """Put outlines, of which there may be none, one after the other."""
    droplets = [Outline(*outline) for outline in outlines]
    return FlatOutlines(
        np.array([outline.droplet_id for outline in droplets], dtype=np.int64),
        np.array([outline.generation for outline in droplets], dtype=np.int64),
        np.array([len(np.asarray(outline.vertices)) for outline in droplets], dtype=np.int64),
        _stacked([outline.vertices for outline in droplets]),
        _stacked([outline.velocities for outline in droplets]),
    )


def offsets_of(sizes: Integers) -> Integers:
    """Return the first vertex of each outline, then the number of vertices."""
    return np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)


class OutlineWriter(HoldsFiles):
    """Append outlines to a GSD file, frame by frame.

    Every frame reaches the disk at once unless told otherwise: a file whose writer was killed holds
    all frames appended before.
    In OVITO the obstacles (type "obstacle", at their true diameter) come first, then the vertices
    (type "vertex") with bonds along each outline; the particles' body is the droplet's id.

    Parameters
    ----------
    path : path
        The file; an existing one is replaced.
    obstacles : (M, 3) array_like
        Centre x, y and radius of each obstacle [D0].
    parameters : mapping
        The parameters of the run; stored as JSON.
    units : str
        Unit of length, "D0" or "um".
    flush_every : int, optional
        After how many frames they reach the disk, which takes some ms; None: when the file is
        closed. A number and no time, so that equal runs write equal files.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        obstacles: npt.ArrayLike,
        parameters: Mapping[str, Any],
        *,
        units: str = "D0",
        flush_every: int | None = 1,
    ) -> None:
        import gsd.hoomd

        self._flush_every = flush_every
        self._obstacles = np.array(obstacles, dtype=np.float64).reshape(-1, 3)
        # Written with the first frame only; readers take what a frame lacks from the first.
        self._constant = {
            "obstacles": self._obstacles,
            "parameters": _as_bytes(json.dumps(dict(parameters))),
        }
        self._units = units
        self._box_side = 0.0
        self._count = 0  # the library counts what reached the disk
        try:
            Path(path).touch()  # with the permissions of other files; the library gives it fewer
            self._file = gsd.hoomd.open(name=path, mode="w", precision="double")
        except OSError:
            empty = Path(path)
            if empty.is_file() and empty.stat().st_size == 0:
                empty.unlink()  # the library had made it, but could not write to it
            raise
        self._files = ExitStack()
        self._files.callback(self._file.close)

    def close(self) -> None:
        """Close the file."""
        self._files.close()

    def append(self, time: float, outlines: Iterable[OutlineLike]) -> None:
        """Add one frame, at a time [t0].

        Its droplets are (droplet_id, generation, vertices (n, 2) [D0], velocities (n, 2) [D0/t0]).
        """
        self.append_flat(time, *flattened(outlines))

    def append_flat(
        self,
        time: float,
        droplet_ids: Integers,
        generations: Integers,
        sizes: Integers,
        vertices: Floats,
        velocities: Floats,
    ) -> None:
        """Add one frame of `FlatOutlines`."""
        import gsd.hoomd

        frame = gsd.hoomd.Frame()
        frame.configuration.step = self._count
        frame.configuration.box = [*[self._grown_box(vertices)] * 2, 0, 0, 0, 0]
        self._add_particles(frame, vertices, velocities)
        bodies = np.repeat(droplet_ids, sizes)
        frame.particles.body = self._with_obstacles(bodies).astype(np.int32)
        frame.particles.diameter = np.concatenate(
            (2.0 * self._obstacles[:, 2], _edge_lengths(vertices, sizes))
        )
        frame.bonds.types = ["edge"]
        frame.bonds.N = len(vertices)
        frame.bonds.group = len(self._obstacles) + _ring_bonds(sizes)
        frame.log = {
            "time": np.array([time], dtype=np.float64),
            "units": self._units,  # in every frame: the library takes no text from the first
            "particles/generation": self._with_obstacles(np.repeat(generations, sizes)).astype(
                np.int32
            ),
            **(self._constant if self._count == 0 else {}),
        }
        self._file.append(frame)
        self._count += 1
        if self._flush_every and self._count % self._flush_every == 0:
            self._file.flush()

    def _add_particles(self, frame: Any, vertices: Floats, velocities: Floats) -> None:
        fixed = len(self._obstacles)
        frame.particles.N = fixed + len(vertices)
        frame.particles.types = ["vertex", "obstacle"]
        frame.particles.typeid = np.repeat([1, 0], [fixed, len(vertices)])
        frame.particles.position = np.zeros((frame.particles.N, 3))
        frame.particles.position[:fixed, :2] = self._obstacles[:, :2]
        frame.particles.position[fixed:, :2] = vertices
        frame.particles.velocity = np.zeros((frame.particles.N, 3))
        frame.particles.velocity[fixed:, :2] = velocities

    def _with_obstacles(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.concatenate((np.full(len(self._obstacles), _NO_DROPLET), values))

    def _grown_box(self, vertices: Floats) -> float:
        # GSD wants a box round the origin that holds all particles. It has no meaning here, so it
        # changes as seldom as can be.
        everything = np.concatenate((vertices, self._obstacles[:, :2]))
        reach = float(np.max(np.abs(everything), initial=1.0))
        self._box_side = max(self._box_side, 2.0 * math.ceil(reach + 1.0))
        return self._box_side


def _stacked(parts: Sequence[npt.ArrayLike]) -> Floats:
    """Join (n, 2) arrays, of which there may be none, to one (V, 2) array."""
    arrays = [np.asarray(part, dtype=np.float64) for part in parts]
    return np.concatenate([np.empty((0, 2)), *arrays])


def _ring_bonds(sizes: Integers) -> Integers:
    """Return the vertex pairs that bound each outline in turn: (V, 2)."""
    pairs: Integers = np.arange(sizes.sum())[:, None] + np.array([0, 1])
    ends = np.cumsum(sizes)
    pairs[ends - 1, 1] = ends - sizes  # the last vertex joins the first
    return pairs


def _edge_lengths(vertices: Floats, sizes: Integers) -> Floats:
    """Return for each vertex its outline's mean edge length, the vertex's diameter [paper, 3.1]."""
    if not len(vertices):
        return np.empty(0)
    starts = np.cumsum(sizes) - sizes
    last = starts + sizes - 1  # it joins the first
    edges = np.diff(vertices, axis=0, append=vertices[:1])
    edges[last] = vertices[starts] - vertices[last]
    means = np.add.reduceat(np.sqrt(edges[:, 0] ** 2 + edges[:, 1] ** 2), starts) / sizes
    lengths: Floats = np.repeat(means, sizes)
    return lengths


def _as_bytes(text: str) -> npt.NDArray[np.uint8]:
    return np.frombuffer(text.encode(), dtype=np.uint8)


def _as_text(data: str | npt.NDArray[np.uint8]) -> str:
    """Return a text, which may stand in the file as its bytes."""
    return data if isinstance(data, str) else data.tobytes().decode()


def read_gsd(path: Path) -> StoredOutlines:
    """Read all frames of a file that `OutlineWriter` wrote, or still writes.

    Raises
    ------
    OSError, RuntimeError, ValueError, KeyError
        If the file is no GSD file, or does not hold outlines.
    """
    import gsd.hoomd

    _require_whole(path)
    with gsd.hoomd.open(name=path, mode="r") as file:
        if len(file) == 0:
            raise ValueError("it has no frames")
        log = file[0].log
        read = [(float(frame.log["time"][0]), _flat_frame(frame)) for frame in file]
    frames = [frame for _, frame in read]
    ids, generations, sizes, vertices, velocities = map(np.concatenate, zip(*frames, strict=True))
    return StoredOutlines(
        times=np.array([time for time, _ in read]),
        frame=np.repeat(np.arange(len(frames)), [len(frame.sizes) for frame in frames]),
        droplet_id=ids.astype(np.int64),
        generation=generations.astype(np.int64),
        offsets=offsets_of(sizes),
        vertices=vertices.astype(np.float64),
        velocities=velocities.astype(np.float64),
        obstacles=np.array(log["obstacles"], dtype=np.float64).reshape(-1, 3),
        parameters=json.loads(_as_text(log["parameters"])),
        units=_as_text(log["units"]),
    )


# The file's header and an entry of its index, as GSD 1 and 2 have them.
_MAGIC = 0x65DF65DF65DF65DF
_HEADER = struct.Struct("<QQQQQII64s64s80x")  # magic, index, entries, names, names, ...
_ENTRY = np.dtype(
    [
        *(("frame", "<u8"), ("rows", "<u8"), ("location", "<i8"), ("columns", "<u4")),
        *(("name", "<u2"), ("kind", "u1"), ("flags", "u1")),
    ]
)
_NAME_SIZE = 64  # bytes in which the list of names is counted; the names stand close in it
_KIND_SIZES = np.array([0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8, 1])  # bytes of a number, by its kind


def _require_whole(path: Path) -> None:
    """Refuse a file whose index points outside of it (ValueError); the library would crash."""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_HEADER.size)
        if len(head) < _HEADER.size:
            raise ValueError("it is cut short")
        magic, index_at, count, names_at, names, *_ = _HEADER.unpack(head)
        if magic != _MAGIC:
            raise ValueError("it is no GSD file")
        lists = ((index_at, count * _ENTRY.itemsize), (names_at, names * _NAME_SIZE))
        if any(start < _HEADER.size or start + length > size for start, length in lists):
            raise ValueError("its index is damaged")
        file.seek(index_at)
        table = np.frombuffer(file.read(count * _ENTRY.itemsize), dtype=_ENTRY)
        file.seek(names_at)
        known = len([name for name in file.read(names * _NAME_SIZE).split(b"\0") if name])
    _require_entries(table[: _used(table)], size, known)


def _used(table: npt.NDArray[Any]) -> int:
    """Return how many entries of an index are in use, up to the first empty one."""
    free = np.flatnonzero(table["location"] == 0)
    return int(free[0]) if len(free) else len(table)


def _require_entries(table: npt.NDArray[Any], size: int, names: int) -> None:
    kinds = table["kind"].astype(np.intp)
    known = (kinds > 0) & (kinds < len(_KIND_SIZES)) & (table["name"] < names)
    # In floating point, because a damaged count may overflow a product of integers.
    numbers = table["rows"].astype(float) * table["columns"]
    ends = table["location"] + numbers * _KIND_SIZES[np.where(known, kinds, 0)]
    inside = (table["location"] >= _HEADER.size) & (ends <= size)
    frames = table["frame"].astype(float)
    if not (known & inside).all() or np.any(np.diff(frames) < 0) or np.any(frames > len(table)):
        raise ValueError("its index is damaged")


def _flat_frame(frame: Any) -> FlatOutlines:
    particles = frame.particles
    is_vertex = particles.typeid == particles.types.index("vertex")
    bodies = particles.body[is_vertex]
    # Each droplet's vertices stand together, so a new outline begins where the body changes.
    starts = np.flatnonzero(np.diff(bodies, prepend=_NO_DROPLET))
    return FlatOutlines(
        bodies[starts],
        frame.log["particles/generation"][is_vertex][starts],
        np.diff(starts, append=len(bodies)),
        particles.position[is_vertex, :2],
        particles.velocity[is_vertex, :2],
    )
