"""Droplet outlines over time: the form in which every droplet is measured, drawn and stored.

A droplet is a closed polygon, whether it was simulated or filmed. `Outlines` holds all polygons
of a run in flat arrays (ragged: a frame has any number of droplets, a droplet any number of
vertices); `OutlineWriter` appends them to a GSD file while the run goes on.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from pinchoff import _core
from pinchoff.model.gsd import (
    Outline,
    OutlineLike,
    OutlineWriter,
    StoredOutlines,
    flattened,
    offsets_of,
)
from pinchoff.model.outline_files import READERS, TIME_UNITS, write_outlines
from pinchoff.support.drawing import Drawable, artist
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted
from pinchoff.support.paper_constants import NECK_SEPARATION

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["TIME_UNITS", "Outline", "OutlineLike", "OutlineWriter", "Outlines"]


@dataclass(frozen=True, eq=False)
class Outlines(StoredOutlines, Drawable):
    """Closed polygons over time, in flat arrays.

    Outline `k` lies in frame ``frame[k]`` and has the vertices
    ``vertices[offsets[k]:offsets[k + 1]]``.

    Parameters
    ----------
    times : (F,) float array
        Time of each frame, ascending [t0].
    frame, droplet_id, generation : (K,) int arrays
        Frame, droplet and number of break-ups in its ancestry, for each outline; `frame` does
        not descend.
    offsets : (K + 1,) int array
        First vertex of each outline, then the number of vertices.
    vertices, velocities : (V, 2) float arrays
        Positions [D0] and velocities [D0/t0].
    obstacles : (M, 3) float array
        Centre x, y and radius of each circular obstacle [D0].
    parameters : dict
        The parameters of the run as plain numbers and text (it must survive JSON).
    units : str
        Unit of length, "D0".

    Raises
    ------
    InputError
        If the arrays do not fit together.
    """

    def __post_init__(self) -> None:
        outlines, vertices = len(self.frame), len(self.vertices)
        wanted: dict[str, tuple[int, ...]] = {
            "times": (len(self.times),),
            "droplet_id": (outlines,),
            "generation": (outlines,),
            "offsets": (outlines + 1,),
            "vertices": (vertices, 2),
            "velocities": (vertices, 2),
            "obstacles": (len(self.obstacles), 3),
        }
        for name, shape in wanted.items():
            got = getattr(self, name).shape
            if got != shape:
                raise InputError.of(name, f"of shape {shape}", got, "see the docstring of Outlines")
        ends = self.offsets[[0, -1]].tolist()
        if ends != [0, vertices] or np.any(np.diff(self.offsets) < 3):
            raise InputError.of(
                "offsets",
                f"ascending from 0 to the {vertices} vertices, in steps of 3 or more",
                self.offsets,
                "give the first vertex of each outline, then the number of vertices",
            )
        if np.any(np.diff(self.frame) < 0) or np.any((self.frame < 0) | (self.frame >= len(self))):
            raise InputError.of(
                "frame",
                f"ascending and below the {len(self)} times",
                self.frame,
                "sort the outlines by frame",
            )
        if self.units not in TIME_UNITS:
            raise InputError.of(
                "units", f"one of {', '.join(TIME_UNITS)}", self.units, "convert the lengths"
            )

    @classmethod
    def from_frames(
        cls,
        times: npt.ArrayLike,
        frames: Sequence[Iterable[OutlineLike]],
        obstacles: npt.ArrayLike,
        parameters: Mapping[str, Any],
        *,
        units: str = "D0",
    ) -> Outlines:
        """Gather outlines that come frame by frame, as the engine gives them.

        Parameters
        ----------
        times : (F,) array_like
            Time of each frame [t0].
        frames : sequence of F iterables
            For each frame its droplets: (droplet_id, generation, vertices (n, 2) [D0],
            velocities (n, 2) [D0/t0]).
        obstacles : (M, 3) array_like
            Centre x, y and radius of each obstacle [D0].
        parameters : mapping
            The parameters of the run.
        units : str
            Unit of length.
        """
        numbered = [(f, droplet) for f, droplets in enumerate(frames) for droplet in droplets]
        flat = flattened(droplet for _, droplet in numbered)
        return cls(
            times=np.asarray(times, dtype=np.float64).reshape(-1),
            frame=np.array([f for f, _ in numbered], dtype=np.int64),
            droplet_id=flat.droplet_ids,
            generation=flat.generations,
            offsets=offsets_of(flat.sizes),
            vertices=flat.vertices,
            velocities=flat.velocities,
            obstacles=np.array(obstacles, dtype=np.float64).reshape(-1, 3),
            parameters=dict(parameters),
            units=units,
        )

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    @overload
    def __getitem__(self, index: int) -> list[Outline]: ...
    @overload
    def __getitem__(self, index: slice) -> Outlines: ...
    def __getitem__(self, index: int | slice) -> list[Outline] | Outlines:
        """Return the outlines of one frame, negative indices from the end; or some of the frames.

        Examples
        --------
        >>> import pinchoff as po
        >>> outlines = po.simulate(po.Parameters(), outlines=True).outlines
        >>> len(outlines), len(outlines[::10]), len(outlines[0])
        (87, 9, 1)
        """
        chosen = range(len(self))[index]
        if isinstance(chosen, int):
            first, last = np.searchsorted(self.frame, [chosen, chosen + 1])
            return [self.outline(k) for k in range(int(first), int(last))]
        if chosen.step < 0:
            raise InputError.of("step", "positive", chosen.step, "take frames forwards in time")
        return Outlines.from_frames(
            self.times[index],
            [self[frame] for frame in chosen],
            self.obstacles,
            self.parameters,
            units=self.units,
        )

    def plot(self, axes: Any = None, *, times: Any = None) -> Any:
        """Draw moments side by side, as `pinchoff.figures.snapshot_strip`.

        Parameters
        ----------
        axes : sequence of n Axes, optional
            Where to draw; by default a new figure, which a notebook shows.
        times : array_like, shape (n,), optional
            In the unit of `times`; by default six moments from the approach to after the break-up.

        Returns
        -------
        list of Axes
        """
        return self._drawn(axes, times=times)

    def animate(self, path: str | os.PathLike[str] | None = None, *, fps: int = 30) -> Any:
        """Film the run, into a file or as a player for a notebook.

        Parameters
        ----------
        path : path, optional
            ``.gif``, ``.html``, or ``.mp4``, which needs the extra ``video``.
        fps : int, optional
            Frames per second of film, from 1 to 240.

        Returns
        -------
        Player or None
            The player, if there is no path.

        Raises
        ------
        InputError
            An argument is wrong, or no droplet ever comes into view.
        """
        return artist().animate(self, path, fps)

    def __iter__(self) -> Iterator[list[Outline]]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        droplets = len(np.unique(self.droplet_id))
        counts = counted(len(self), "frame"), counted(droplets, "droplet")
        return f"Outlines({', '.join(counts)}, {len(self.vertices)} vertices)"

    def outline(self, k: int) -> Outline:
        """Return outline `k` of all, whatever its frame."""
        span = slice(self.offsets[k], self.offsets[k + 1])
        return Outline(
            int(self.droplet_id[k]),
            int(self.generation[k]),
            self.vertices[span],
            self.velocities[span],
        )

    def neck(self, outline: Outline) -> tuple[float, int, int]:
        """Return the thinnest admissible chord of an outline, as the run's parameters define it.

        Returns
        -------
        thickness : float
            Its length [D0]; infinite where no pair of vertices is admissible.
        i, j : int
            The vertices that it joins.

        Examples
        --------
        >>> import pinchoff as po
        >>> outlines = po.simulate(po.Parameters(), outlines=0.1).outlines
        >>> length, i, j = outlines.neck(outlines[30][0])
        >>> round(length, 2)
        0.18
        """
        in_diameters = self.parameters.get("neck_separation_unit", "perimeter") == "diameter"
        diameter = math.sqrt(4.0 * _core.area(outline.vertices) / math.pi)
        separation = float(self.parameters.get("neck_separation", NECK_SEPARATION))
        return _core.neck(outline.vertices, separation, in_diameters, diameter)

    def measure(self) -> pd.DataFrame:
        """Measure every outline with the geometry that the engine itself uses.

        Returns
        -------
        DataFrame
            One row per outline: frame, time [t0], droplet_id, generation, area [D0²], perimeter
            [D0], x, y (centroid) [D0], shape_parameter, neck_thickness [D0] (NaN where no chord
            is admissible). The units are in ``attrs["units"]``.

        Examples
        --------
        >>> import pinchoff as po
        >>> measured = po.simulate(po.Parameters(), outlines=0.1).outlines.measure()
        >>> "area" in measured and "perimeter" in measured
        True
        """
        import pandas as pd

        outlines = [self.outline(k) for k in range(len(self.frame))]
        rings = [outline.vertices for outline in outlines]
        x, y = np.reshape([_core.centroid(ring) for ring in rings], (-1, 2)).T
        neck = np.array([self.neck(outline)[0] for outline in outlines], dtype=np.float64)
        length = self.units
        columns: dict[str, tuple[str, Any]] = {
            "frame": ("1", self.frame),
            "time": (TIME_UNITS[length], self.times[self.frame]),
            "droplet_id": ("1", self.droplet_id),
            "generation": ("1", self.generation),
            "area": (f"{length}²", [_core.area(ring) for ring in rings]),
            "perimeter": (length, [_core.perimeter(ring) for ring in rings]),
            "x": (length, x),
            "y": (length, y),
            "shape_parameter": ("1", [_core.shape_parameter(ring) for ring in rings]),
            "neck_thickness": (length, np.where(np.isfinite(neck), neck, math.nan)),
        }
        table = pd.DataFrame({name: values for name, (_, values) in columns.items()})
        table.attrs["units"] = {name: unit for name, (unit, _) in columns.items()}
        return table

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the outlines to a file; its suffix chooses the format.

        ``.gsd`` (OVITO and freud open it) and ``.npz`` hold everything and load back equal;
        ``.csv`` is for other programs: one row per vertex, the units in the column names.

        Parameters
        ----------
        path : path
            The file, replaced at once when it is complete.

        Raises
        ------
        InputError
            If the suffix is none of these, or the file cannot be written.

        Examples
        --------
        >>> import pinchoff as po
        >>> outlines = po.simulate(po.Parameters(), outlines=0.5).outlines
        >>> outlines.save("outlines.npz")
        >>> len(po.Outlines.load("outlines.npz")) == len(outlines)
        True
        """
        write_outlines(Path(path), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Outlines:
        """Read outlines from a ``.gsd`` or ``.npz`` file that pinchoff wrote.

        A GSD file is readable while it is being written, and after its writer was killed.

        Raises
        ------
        InputError
            If there is no such file, or it does not hold outlines.
        """
        source = Path(path)
        if source.suffix not in READERS or not source.is_file():
            raise InputError.of(
                "path", "an existing .gsd or .npz file", source, "check the name of the file"
            )
        try:
            return cls(**vars(READERS[source.suffix](source)))
        except Exception as error:  # what damage makes their readers raise is of every kind
            raise InputError.of(
                "path",
                "a file of outlines written by pinchoff",
                f"{source} ({error})",
                "write it again with Outlines.save or `pinchoff run`",
            ) from error
