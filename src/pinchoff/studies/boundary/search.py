"""The line between droplets that break and droplets that do not, found by simulation.

At each point of parameter space runs differ in the droplet's offset alone, and so in the symmetry
S of its collision; the line is where they begin to break [paper, sec. 4.1].
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pinchoff.model.flow import Flow
from pinchoff.model.parameters import Parameters, require_parameters
from pinchoff.model.run_table import CHUNK_SIZE, run_batch
from pinchoff.model.simulation import require_flow, thread_count
from pinchoff.studies.boundary.bracketing import Search, Trial, run_searches
from pinchoff.studies.boundary.line_fit import LineFit, fit_line
from pinchoff.studies.boundary.table import COLUMNS, boundary_table, write_table
from pinchoff.support.arguments import checked_number, checked_whole
from pinchoff.support.checked import unknown_name
from pinchoff.support.drawing import Drawable
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted
from pinchoff.support.progress import Show, progress_bar, shifted, wanted_progress

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["COLUMNS", "Boundary", "boundary", "write_table"]

_LARGEST_OFFSET = 5.0
_WIDENING = 1.35
_NOT_VARIED = {
    "offset": "leave it out: it is what the search varies",
    "follow_daughters": "leave it out: runs end at the first break-up",
    "scale": "leave it out",
}


@dataclass(frozen=True, eq=False, repr=False)
class Boundary(Drawable):
    """Brackets round the separating line.

    Attributes
    ----------
    table : DataFrame
        One row per point, with `COLUMNS` and the units in ``attrs["units"]``.
    runs : DataFrame
        Every collision that was run, as `pinchoff.simulate_many` returns them, with the column
        ``point``; by point and offset.
    base : Parameters
        What all points have in common.
    varied : tuple of str
        Names of the parameters that were varied.
    """

    table: pd.DataFrame
    runs: pd.DataFrame
    base: Parameters
    varied: tuple[str, ...]

    @property
    def found(self) -> pd.DataFrame:
        """Rows of `table` that have a critical symmetry."""
        return self.table[self.table["status"] == "found"]

    @property
    def failures(self) -> pd.DataFrame:
        """Runs without an outcome: their point, offset and reason.

        Guards stopped them; or they broke, or reached the time limit, before any contact.
        """
        columns = ["point", "size_ratio", "simulation_capillary_number", "offset", "reject_reason"]
        without = _without_outcome(self.runs["outcome"], self.runs["symmetry"])
        failures: pd.DataFrame = self.runs.loc[without, columns]
        return failures

    def fit(
        self,
        *,
        free_area: bool = False,
        speed: Literal["flow", "contact"] = "flow",
        confidence: float = 0.95,
    ) -> LineFit:
        """Fit S_c = α (Ca Ã^p z̃)^β to the middles of the brackets that were found.

        Parameters
        ----------
        free_area : bool, optional
            Whether p is fitted too, instead of the paper's 1.
        speed : "flow" or "contact", optional
            Speed in Ca: v_f∞, or the droplet's at first contact.
        confidence : float, optional
            Of the intervals.

        Returns
        -------
        LineFit
            See `pinchoff.studies.boundary.line_fit.fit_line` for what the intervals mean.

        Raises
        ------
        InputError
            Too few points were found, or an argument is wrong.

        Examples
        --------
        >>> import pinchoff as po
        >>> capillary = {"simulation_capillary_number": [20, 40, 80]}
        >>> line = po.boundary(po.Parameters(), capillary, width=0.02, scan=12)
        >>> round(line.fit().beta.value, 1)
        -0.7
        """
        if speed not in ("flow", "contact"):
            raise InputError.of("speed", "'flow' or 'contact'", speed, "choose one of them")
        rows = self.found
        # whether Ca is made with that speed already
        own = rows.get("ca_speed", rows["contact_speed"]).eq("contact")
        contact_speed = rows["contact_speed"]
        to_contact, to_flow = contact_speed.where(~own, 1.0), (1.0 / contact_speed).where(own, 1.0)
        factor = to_contact if speed == "contact" else to_flow
        return fit_line(
            rows["capillary_number"] * rows["normalized_thickness"] * factor,
            rows["normalized_area"],
            rows["critical_symmetry"],
            rows["width"],
            free_area=free_area,
            speed=speed,
            confidence=confidence,
        )

    def __repr__(self) -> str:
        counts = self.table["status"].value_counts()
        statuses = ", ".join(f"{count} {status}" for status, count in counts.items())
        points, runs = counted(len(self.table), "point"), counted(len(self.runs), "run")
        return f"<Boundary of {points}: {statuses}; {runs}>"


def boundary(
    base: Parameters,
    vary: Mapping[str, Iterable[Any]] | None = None,
    *,
    width: float = 0.005,
    scan: int = 24,
    threads: int | None = None,
    progress: bool | None = None,
    flow: Flow | None = None,
) -> Boundary:
    """Find the symmetry at which droplets begin to break, at each point of a grid.

    At each point a scan over the offset comes first, from head-on to where droplets hardly touch
    the obstacle any more. Where its outcome changes once, a bracket closes on that place; where it
    changes more often, the intervals are reported and there is no bracket. An island narrower
    than the scan's spacing is missed: raise `scan` to see smaller ones. All points advance
    together, so that every core has work; the rows depend neither on the number of threads nor on
    the other points. A captured droplet counts as not broken; a run that a guard stopped counts
    as nothing, and is reported.

    Parameters
    ----------
    base : Parameters
        What all points have in common. Its offset does not matter, and runs end at the first
        break-up, whatever it says.
    vary : mapping of str to sequence, optional
        Values of any parameter but the offset, by name; the points are their grid, the last name
        varying fastest. By default the one point `base`.
    width : float, optional
        Largest width of a bracket, in S.
    scan : int, optional
        Intervals of the scan over the offset.
    threads : int, optional
        How many threads; by default as many as there are cores for this process.
    progress : bool, optional
        Whether to show a bar on stderr; by default in terminals and notebooks.
    flow : Flow, optional
        One flow for all points, about an obstacle at the origin; by default the Stokes flow around
        each point's own.

    Returns
    -------
    Boundary

    Raises
    ------
    InputError
        An argument is wrong.
    KeyboardInterrupt
        Ctrl-C, once the runs in progress have ended.

    Warns
    -----
    RuntimeWarning
        Guards stopped some of the runs; says how many.

    Examples
    --------
    >>> import pinchoff as po
    >>> line = po.boundary(po.Parameters(), {"simulation_capillary_number": [20, 40, 80]})
    >>> line.found["critical_symmetry"].round(2).tolist()
    [0.84, 0.47, 0.31]
    """
    width = checked_number("width", width, "use 0.005", low=1e-6, high=0.5)
    scan = checked_whole("scan", scan, "use 24", low=4, high=10_000)
    if flow is not None:
        require_flow(flow)
    workers = thread_count(threads)
    points, varied = _points(base, vary or {})
    searches = [Search(_reach(point), width, scan, _LARGEST_OFFSET) for point in points]
    with_bar = wanted_progress(progress)
    with progress_bar(with_bar, "separating line", len(points) * (scan + 7)) as show:
        runner = _Runner(points, workers, show, flow)
        brackets = run_searches(searches, runner)
    runs = runner.table()
    found = Boundary(boundary_table(points, varied, brackets, runs), runs, base, varied)
    _warn_of_failures(found)
    return found


class _Runner:
    """Runs the collisions that the searches ask for, and keeps them."""

    def __init__(
        self, points: Sequence[Parameters], threads: int, show: Show | None, flow: Flow | None
    ) -> None:
        self._points = points
        self._threads = threads
        self._show = show
        self._flow = flow
        self._parts: list[dict[str, Any]] = []
        self._point: list[int] = []

    def __call__(self, batch: list[tuple[int, float]]) -> list[Trial]:
        trials: list[Trial] = []
        for start in range(0, len(batch), CHUNK_SIZE):
            trials += self._chunk(batch[start : start + CHUNK_SIZE])
        return trials

    def _chunk(self, batch: list[tuple[int, float]]) -> list[Trial]:
        done = len(self._point)
        parameters = [self._points[k].replace(offset=offset) for k, offset in batch]
        ids = range(done, done + len(batch))
        columns = run_batch(
            parameters, ids, threads=self._threads, flow=self._flow, show=shifted(self._show, done)
        )
        self._parts.append(columns)
        self._point += [k for k, _ in batch]
        return [
            Trial(offset, float(symmetry), None if without else bool(broke))
            for (_, offset), symmetry, broke, without in zip(
                batch,
                columns["symmetry"],
                columns["broke"],
                _without_outcome(columns["outcome"], columns["symmetry"]),
                strict=True,
            )
        ]

    def table(self) -> pd.DataFrame:
        from pinchoff.collisions import schema

        runs = schema.table(self._parts)
        runs.insert(0, "point", self._point)
        runs.attrs["units"]["point"] = "1"
        return runs.sort_values(["point", "offset"], kind="stable", ignore_index=True)


def _without_outcome(outcome: Any, symmetry: Any) -> Any:
    """Tell the runs that say nothing about the line: stopped by a guard, or without a contact.

    One that misses the obstacle does say something: it slips. One that broke without touching is
    no collision, and one that had not arrived at the time limit is none yet.
    """
    return (outcome == "failed") | ((outcome != "slipped") & np.isnan(symmetry))


def _points(
    base: Parameters, vary: Mapping[str, Iterable[Any]]
) -> tuple[list[Parameters], tuple[str, ...]]:
    """Return the grid of points, and the names that vary."""
    require_parameters("base", base)
    if not isinstance(vary, Mapping):
        raise InputError.of("vary", "a mapping of names to values", vary, 'as {"size_ratio": [4]}')
    values = {name: _values(name, given) for name, given in vary.items()}
    common = base.replace(offset=0.0, follow_daughters=False)
    if common.scale is not None and {"size_ratio", "simulation_capillary_number"} & values.keys():
        common = common.replace(scale=None)  # other numbers would not be those of the experiment
    grid = itertools.product(*values.values())
    points = [common.replace(**dict(zip(values, chosen, strict=True))) for chosen in grid]
    for point in points:
        point.model_row()  # refuses an unstable time step before anything runs
    return points, tuple(values)


def _values(name: str, given: object) -> list[Any]:
    place = f"vary[{name!r}]"
    if name not in Parameters.model_fields:
        raise unknown_name("vary", "the name of a parameter", name, Parameters.model_fields)
    if name in _NOT_VARIED:
        raise InputError.of("vary", "a parameter that may be varied", repr(name), _NOT_VARIED[name])
    if isinstance(given, (str, bytes, Mapping)) or not isinstance(given, Iterable):
        raise InputError.of(place, "a list of values", given, f"write [{given!r}]")
    values = np.asarray(given).tolist() if isinstance(given, np.ndarray) else list(given)
    if not values:
        raise InputError.of(place, "one value or more", values, "give values, or leave it out")
    return values


def _reach(point: Parameters) -> float:
    r"""Return an offset near a grazing contact, where the scan starts.

    It is the streamline of [paper, eq. v_r fluid], of stream function
    :math:`\psi = y\,(\ln(r/R) - 1/2 + R^2/2r^2)`, which passes the obstacle at D0/2; a droplet that
    the flow widens touches from somewhat farther out.
    """

    def forward(distance: float) -> float:
        ratio = distance / point.obstacle_radius
        return math.log(ratio) - 0.5 + 0.5 / ratio**2

    touching = point.obstacle_radius + 0.5
    return _WIDENING * touching * forward(touching) / forward(point.start_distance)


def _warn_of_failures(found: Boundary) -> None:
    """Warn of runs that count as neither broken nor not, point by point."""
    for point, failures in found.failures.groupby("point"):
        low, high = failures["offset"].min(), failures["offset"].max()
        runs = (found.runs["point"] == point).sum()
        warnings.warn(
            f"{len(failures)} of {runs} runs of point {point} have no outcome, at offsets "
            f"from {low:.5f} to {high:.5f} D0; the first: {failures['reject_reason'].iloc[0]}",
            RuntimeWarning,
            stacklevel=3,
        )
