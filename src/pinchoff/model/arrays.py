"""Arrays of pillars: lattices, disordered arrangements and those of a file.

An array is a rectangular cell with circles in it. Lengths are in D0, as everywhere in the model;
the flow goes along +x. A cell repeats itself in y, and in x too unless `with_margins` has put free
fluid before and behind the pillars.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pinchoff.support.arguments import checked_positive, checked_whole, finite_or_nan
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import os

Floats = NDArray[np.float64]

_MOST_PILLARS = 100_000
_TRIALS_PER_PILLAR = 2000
_RELAXATIONS = 4000  # of a dense disordered array, before it counts as impossible


@dataclass(frozen=True, eq=False)
class PillarArray:
    """Pillars in a rectangular cell whose lower left corner is the origin.

    Attributes
    ----------
    circles : ndarray, shape (M, 3)
        Centre x, y and radius of each pillar, D0; centres in the cell.
    length, width : float
        Extent of the cell along x and y, D0: its periods.

    Raises
    ------
    InputError
        A number is not finite, a centre lies outside the cell, or pillars overlap, also across
        the edges of the cell.

    Examples
    --------
    >>> array = staggered(rows=2, columns=4, radius=0.25, gap=0.5)
    >>> len(array.circles), round(array.porosity, 3), round(array.least_gap, 3)
    (8, 0.804, 0.5)
    """

    circles: Floats
    length: float
    width: float

    def __post_init__(self) -> None:
        advice = "give one row of x, y and radius for each pillar"
        try:
            circles = np.array(self.circles, dtype=np.float64)  # a copy: nobody else may change it
        except (TypeError, ValueError) as error:
            raise InputError.of("circles", "numbers", str(error), advice) from None
        if circles.ndim != 2 or circles.shape[1] != 3 or not len(circles):
            raise InputError.of("circles", "of shape (M, 3)", f"shape {circles.shape}", advice)
        for name in ("length", "width"):
            period = checked_positive(name, getattr(self, name), "give it in D0")
            object.__setattr__(self, name, period)
        wrong = ~np.isfinite(circles).all(axis=1) | ~(circles[:, 2] > 0)
        if wrong.any():
            worst = int(np.argmax(wrong))
            rule = "finite, with positive radii"
            raise InputError.of(f"circles[{worst}]", rule, circles[worst].tolist(), "mend the row")
        size = np.array([self.length, self.width])
        outside = ((circles[:, :2] < 0) | (circles[:, :2] >= size)).any(axis=1)
        if outside.any():
            worst = int(np.argmax(outside))
            rule = f"in the cell from (0, 0) to ({self.length:g}, {self.width:g})"
            got = circles[worst].tolist()
            raise InputError.of(f"circles[{worst}]", rule, got, "move the centre by a period")
        circles.flags.writeable = False
        object.__setattr__(self, "circles", circles)
        gap = self.least_gap
        if not gap > 0:
            got = f"a least gap of {gap:.4g}"
            raise InputError.of("circles", "free of overlap", got, "move them or shrink the radii")

    @property
    def porosity(self) -> float:
        """Share of the cell's area that is fluid."""
        solid = math.pi * float(np.sum(self.circles[:, 2] ** 2))
        return 1.0 - solid / (self.length * self.width)

    @property
    def gaps(self) -> Floats:
        """Gap of each pillar to its nearest neighbour, or an image of one or itself, (M,), D0."""
        largest = float(self.circles[:, 2].max())
        shifts = [(i * self.length, j * self.width, 0.0) for i in (0, -1, 1) for j in (0, -1, 1)]
        images = np.concatenate([self.circles + np.array(shift) for shift in shifts])
        tree = cKDTree(images[:, :2])
        gaps = np.empty(len(self.circles))
        for k, (x, y, radius) in enumerate(self.circles):
            # The nearest centre bounds the gap; only circles within that bound can be nearer.
            distance, _ = tree.query((x, y), k=2)
            near = tree.query_ball_point((x, y), distance[1] + 2.0 * largest)
            others = images[[i for i in near if i != k]]
            away = np.hypot(others[:, 0] - x, others[:, 1] - y)
            gaps[k] = np.min(away - others[:, 2] - radius)
        return gaps

    @property
    def least_gap(self) -> float:
        """Width of the narrowest gap between two pillars, D0."""
        return float(self.gaps.min())

    def with_margins(self, before: float, behind: float) -> PillarArray:
        """Return the array with free fluid before its first and behind its last pillar.

        Parameters
        ----------
        before, behind : float
            Length of free fluid added along x, D0.
        """
        checked_positive("before", before, "give it in D0")
        checked_positive("behind", behind, "give it in D0")
        moved = self.circles + np.array([before, 0.0, 0.0])
        return PillarArray(moved, self.length + before + behind, self.width)

    def scaled(self, factor: float) -> PillarArray:
        """Return the array with every length multiplied, such as 1/D0 for one in µm."""
        checked_positive("factor", factor, "give it in D0")
        return PillarArray(self.circles * factor, self.length * factor, self.width * factor)


def square(*, rows: int, columns: int, radius: float, gap: float) -> PillarArray:
    """Return a square lattice.

    Parameters
    ----------
    rows, columns : int
        How many pillars across the flow (along y) and along it (along x).
    radius : float
        R of every pillar, D0.
    gap : float
        Between neighbours, D0; the pitch is 2 R + gap.

    Raises
    ------
    InputError
        A number is out of its range.

    Examples
    --------
    >>> square(rows=1, columns=1, radius=0.5, gap=1.0).length
    2.0
    """
    return _lattice(rows, columns, radius, gap)


def staggered(*, rows: int, columns: int, radius: float, gap: float) -> PillarArray:
    """Return a square lattice with every other column moved by half a pitch.

    Parameters are those of `square`; the number of columns is even. Neighbours in a column are
    `gap` apart, and so are the columns' edges.

    Examples
    --------
    >>> len(staggered(rows=3, columns=4, radius=0.25, gap=0.5).circles)
    12
    """
    return _lattice(rows, columns, radius, gap, every_other_moved=True)


def hexagonal(*, rows: int, columns: int, radius: float, gap: float) -> PillarArray:
    """Return a hexagonal lattice: every pillar has six neighbours at the same gap.

    Parameters are those of `square`; the number of columns is even.

    Examples
    --------
    >>> array = hexagonal(rows=2, columns=2, radius=0.25, gap=0.5)
    >>> round(array.length / array.width, 4) == round(3**0.5 / 2, 4)
    True
    """
    return _lattice(rows, columns, radius, gap, math.sqrt(0.75), every_other_moved=True)


def disordered(
    *, length: float, width: float, radius: float, porosity: float, least_gap: float, seed: int
) -> PillarArray:
    """Return pillars at random places, none nearer to another than a least gap.

    Pillars are set one after the other where they fit. When the next one does not fit, all of
    them are pushed apart, as hard discs with the gap round them.

    Parameters
    ----------
    length, width : float
        The cell, D0.
    radius : float
        R of every pillar, D0.
    porosity : float
        Share of fluid; the number of pillars is the one that comes nearest to it.
    least_gap : float
        D0.
    seed : int
        Of the places; the same seed gives the same array.

    Raises
    ------
    InputError
        A number is out of its range, or so many pillars do not fit with that gap.

    Examples
    --------
    >>> array = disordered(length=6, width=4, radius=0.25, porosity=0.8, least_gap=0.2, seed=1)
    >>> len(array.circles), array.least_gap > 0.1999
    (24, True)
    """
    lengths = {"length": length, "width": width, "radius": radius, "least_gap": least_gap}
    for name, value in lengths.items():
        checked_positive(name, value, "give it in D0")
    if not 0.0 < finite_or_nan(porosity) < 1.0:
        raise InputError.of("porosity", "between 0 and 1", porosity, "give the share of fluid")
    checked_whole("seed", seed, "use 0", low=0)
    count = round((1.0 - porosity) * length * width / (math.pi * radius**2))
    _require_count("porosity", count)
    generator = np.random.default_rng(seed)
    size = np.array([length, width])
    apart = 2.0 * radius + least_gap
    if min(length, width) < apart:
        got = f"{min(length, width):g}"
        raise InputError.of("length and width", f"at least {apart:g}", got, "enlarge the cell")
    centres = _placed(generator, size, count, apart)
    if centres is None:
        got = f"{count} pillars {apart:.4g} apart"
        rule = "such that the pillars fit with their gap"
        raise InputError.of("porosity", rule, got, "raise porosity, or lower least_gap")
    circles = np.column_stack([centres, np.full(count, radius)])
    return PillarArray(circles[np.lexsort(circles.T[::-1])], length, width)


def read(path: str | os.PathLike[str], *, length: float, width: float) -> PillarArray:
    """Return the array of a table of pillars.

    Parameters
    ----------
    path : path
        CSV, spreadsheet or Parquet with the columns ``x``, ``y`` and ``radius``, in D0.
    length, width : float
        The cell, D0.

    Raises
    ------
    InputError
        The file cannot be read, lacks a column, or the pillars are no array.
    """
    from pinchoff.collisions.reading import read_table

    table = read_table(path)
    names = {str(column).strip().lower(): column for column in table.columns}
    missing = [name for name in ("x", "y", "radius") if name not in names]
    if missing:
        got = ", ".join(map(str, table.columns))
        rule = "a table with the columns x, y and radius"
        raise InputError.of("path", rule, got, "rename its columns; lengths are in D0")
    circles = table[[names[name] for name in ("x", "y", "radius")]].to_numpy()
    return PillarArray(circles, length, width)


def _lattice(
    rows: int,
    columns: int,
    radius: float,
    gap: float,
    narrowing: float = 1.0,
    *,
    every_other_moved: bool = False,
) -> PillarArray:
    """Return columns that are `narrowing` pitches apart; every other one may be half a pitch up."""
    for name, length in (("radius", radius), ("gap", gap)):
        checked_positive(name, length, "give it in D0")
    for name, count in (("rows", rows), ("columns", columns)):
        checked_whole(name, count, "leave out the fraction", low=1)
    if every_other_moved and columns % 2:
        advice = "add one: the last column meets the first across the cell's edge"
        raise InputError.of("columns", "even", columns, advice)
    _require_count("rows times columns", rows * columns)
    pitch = 2.0 * radius + gap
    step = pitch * narrowing
    x = (np.arange(columns) + 0.5) * step
    y = (np.arange(rows) + 0.25) * pitch  # a column moved by half a pitch stays in the cell
    grid_x, grid_y = np.meshgrid(x, y)
    if every_other_moved:
        grid_y[:, 1::2] += 0.5 * pitch
    circles = np.column_stack([grid_x.T.ravel(), grid_y.T.ravel(), np.full(grid_x.size, radius)])
    return PillarArray(circles, columns * step, rows * pitch)


def _placed(
    generator: np.random.Generator, size: Floats, count: int, apart: float
) -> Floats | None:
    """Return centres at least `apart` from each other on the periodic cell, or None."""
    centres = np.empty((0, 2))
    for _ in range(count):
        places = generator.random((_TRIALS_PER_PILLAR, 2)) * size
        if len(centres):
            distance, _ = cKDTree(centres, boxsize=size).query(places)
            free = np.flatnonzero(distance >= apart)
        else:
            free = np.arange(len(places))
        chosen = places[free[0] if free.size else 0]
        centres = np.vstack([centres, chosen])
        if not free.size and not _pushed_apart(centres, size, apart):
            return None
    return centres


def _pushed_apart(centres: Floats, size: Floats, apart: float) -> bool:
    """Move overlapping discs away from each other, in place; tell whether all came free."""
    for _ in range(_RELAXATIONS):
        pairs = cKDTree(centres, boxsize=size).query_pairs(apart, output_type="ndarray")
        if not len(pairs):
            return True
        pairs = pairs[np.lexsort(pairs.T[::-1])]  # the sum below must not depend on the order
        to = centres[pairs[:, 1]] - centres[pairs[:, 0]]
        to -= size * np.round(to / size)
        distance = np.maximum(np.hypot(*to.T), 1e-9 * apart)
        push = (0.5 * (1.02 * apart - distance) / distance)[:, None] * to
        np.add.at(centres, pairs[:, 0], -push)
        np.add.at(centres, pairs[:, 1], push)
        centres %= size
        centres[centres >= size] = 0.0  # round-off at the far edge
    return False


def _require_count(name: str, count: int) -> None:
    if not 1 <= count <= _MOST_PILLARS:
        rule = f"such that there are from 1 to {_MOST_PILLARS} pillars"
        raise InputError.of(name, rule, f"{count} pillars", "change the cell or the radius")
