"""What can stand in a table of collisions, and where: quantities, their columns and units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.units import is_unit, unit_factor

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


LARGEST = 1e60
"""Numbers beyond it, or below its inverse, leave the range of a double in the law's powers."""


class Quantity(NamedTuple):
    """A number that can be imported.

    Attributes
    ----------
    column : str
        Its column in our table, or the name under which it is used up.
    unit : str
        Of that column; empty: a pure number.
    low, high : float
        What is possible.
    positive : bool
        Whether `low` itself is impossible.
    """

    column: str
    unit: str = ""
    low: float = 0.0
    high: float = math.inf
    positive: bool = True

    def possible(self, values: Floats) -> NDArray[np.bool_]:
        """Return which values are, shape (n,)."""
        above = values > self.low if self.positive else values >= self.low
        return np.asarray(above & (values <= self.high) & np.isfinite(values))

    def rule(self) -> str:
        """Say what a value must be; completes "must be"."""
        if math.isinf(self.low):
            return "a finite number"
        if math.isfinite(self.high):
            least = f"above {self.low:g} and at most" if self.positive else f"from {self.low:g} to"
            return f"{least} {self.high:g}"
        return "positive and finite" if self.positive else f"finite and {self.low:g} or more"


QUANTITIES = {
    "symmetry": Quantity("symmetry", high=2.0, positive=False),
    "capillary_number": Quantity("capillary_number"),
    "normalized_area": Quantity("normalized_area"),
    "normalized_thickness": Quantity("normalized_thickness"),
    "area": Quantity("area_um2", "um^2"),
    "diameter": Quantity("diameter_um", "um"),
    "speed": Quantity("speed_mm_s", "mm/s"),
    "obstacle_radius": Quantity("obstacle_radius_um", "um"),
    "thickness": Quantity("thickness_um", "um"),
    "viscosity": Quantity("viscosity_mPa_s", "mPa*s"),
    "surface_tension": Quantity("surface_tension_mN_m", "mN/m"),
    "daughter_area_ratio": Quantity("daughter_area_ratio", high=1.0),
    "first_daughter_area": Quantity("first_daughter_area_um2", "um^2"),
    "second_daughter_area": Quantity("second_daughter_area_um2", "um^2"),
    "neck": Quantity("neck_um", "um", positive=False),
    "neck_thickness": Quantity("neck_thickness", positive=False),
    "impact_parameter": Quantity("impact_parameter", positive=False),
    "contact_time": Quantity("contact_time_s", "s", low=-math.inf),
    "obstacle_x": Quantity("obstacle_x_um", "um", low=-math.inf),
    "obstacle_y": Quantity("obstacle_y_um", "um", low=-math.inf),
}
"""Numbers by the names under which they can be imported."""

WORDS = ("broke", "accepted", "reject_reason", "source", "collision_id")
"""What can be imported beside numbers."""


# How a column's name may end to tell its unit: as ``_mN_m`` for mN/m.
_SUFFIXES = {
    re.sub("[/*]", "_", unit.replace("^", "")): unit
    for unit in (
        *("um", "mm", "m", "um^2", "mm^2", "um/s", "mm/s", "m/s"),
        *("mPa*s", "Pa*s", "mN/m", "N/m", "ms", "s"),
    )
}


_IN_BRACKETS = re.compile(r"(.+?)\s*[\[(]([^\[\]()]+)[\])]")


class Place(NamedTuple):
    """Where a quantity stands in the source, and what its numbers are multiplied by."""

    column: str
    factor: float = 1.0


def find_columns(
    frame: pd.DataFrame, columns: Mapping[str, str], units: Mapping[str, str]
) -> dict[str, Place]:
    """Find the column of every quantity and word that a table has.

    `columns` and `units` are as of `pinchoff.import_collisions`.

    Raises
    ------
    InputError
        A name, column or unit is wrong or missing, or there is no outcome or no symmetry.
    """
    known = (*QUANTITIES, *WORDS)
    for given in (*columns, *units):
        if given not in known:
            raise unknown_name(given, "a quantity that can be imported", given, known)
    places = {}
    for name in known:
        column = columns.get(name)
        if column is not None:
            column = _named(frame, column)
            if column is None:
                names = map(str, frame.columns)
                raise unknown_name(name, "a column of the table", columns[name], names)
        place = _place(frame, name, column, units.get(name))
        if place is not None:
            places[name] = place
        elif name in units:
            advice = "say which column it is, or drop the unit"
            raise InputError.of(name, "a column of the table", "none of that name", advice)
    for name, rule in (
        ("broke", "a column that says whether the droplet broke"),
        ("symmetry", "a column with the symmetry at first contact"),
    ):
        if name not in places:
            got = f"the columns {', '.join(map(str, frame.columns))}"
            raise InputError.of(name, rule, got, f"say which one: {name}=COLUMN")
    return places


def _named(frame: pd.DataFrame, name: str) -> str | None:
    """Return the column of a name, whose case, spaces and hyphens do not matter.

    Raises
    ------
    InputError
        There are several.
    """
    if name in frame.columns:
        return name
    same = [str(column) for column in frame.columns if _key(column) == _key(name)]
    if len(same) > 1:
        got = " and ".join(map(repr, same))
        raise InputError.of(f"the column {name}", "one column", got, "rename or drop the others")
    return same[0] if same else None


def _key(name: object) -> str:
    return re.sub(r"[\s_-]+", "_", str(name).strip()).lower()


def _place(frame: pd.DataFrame, name: str, column: str | None, unit: str | None) -> Place | None:
    """Find the column of a quantity and what brings its numbers to our unit."""
    ours = QUANTITIES[name] if name in QUANTITIES else Quantity(name)
    own = _named(frame, ours.column) if column is None else None
    below = frame.attrs.get("unit_row", {})
    if own is not None:  # as in our own tables
        told = unit or below.get(own)
        if unit or (ours.unit and told and unit_factor(f"unit of {name}", told, ours.unit) != 1.0):
            got, advice = f"{told} for the column {own!r}", "the column's name tells it"
            raise InputError.of(f"unit of {name}", "left out", got, advice)
        return Place(own)
    if not ours.unit:
        return None if column is None else Place(column)
    if column is None:
        column = _with_unit(frame, name)
    if column is None:
        return None
    told = unit or _told_unit(column) or below.get(column)
    if told is None:
        advice = f"say {name}={ours.unit.replace('*', ' ')}, or whatever it is"
        raise InputError.of(f"unit of {name}", "given", f"a column {column!r}", advice)
    return Place(column, unit_factor(f"unit of {name}", told, ours.unit))


def _with_unit(frame: pd.DataFrame, name: str) -> str | None:
    """Return the column of a quantity whose name ends in a unit, or is the quantity's alone."""
    for ending in _SUFFIXES:
        column = _named(frame, f"{name}_{ending}")
        if column is not None:
            return column
    in_brackets = [str(column) for column in frame.columns if _bare(column) == _key(name)]
    if in_brackets:
        return in_brackets[0]
    # In a table of simulations a bare name, such as speed, is a number without a unit.
    return None if "simulation_capillary_number" in frame else _named(frame, name)


def _bare(column: object) -> str | None:
    """Return a name without its unit in brackets, as in ``area (µm²)``."""
    found = _IN_BRACKETS.fullmatch(str(column).strip())
    return _key(found[1]) if found else None


def _told_unit(column: str) -> str | None:
    """Return the unit at the end of a column's name; the longest that fits."""
    found = _IN_BRACKETS.fullmatch(column.strip())
    if found and is_unit(found[2]):
        return found[2]
    endings = [suffix for suffix in _SUFFIXES if _key(column).endswith(f"_{suffix}".lower())]
    return _SUFFIXES[max(endings, key=len)] if endings else None
