"""The collisions table: one row per collision, simulated, filmed or imported.

The schema is written here once: the name, unit, type and meaning of every column. Not measured
is NaN, never zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray


class Column(NamedTuple):
    """One column of the table.

    Attributes
    ----------
    name : str
    unit : str
        "1" for a pure number, "" for what is not a number.
    dtype : str
        Its pandas type.
    meaning : str
    categories : tuple of str
        Every value that a column of type "category" can have.
    shared : bool
        Whether every table has it, wherever its collisions come from; the others only a simulation.
    """

    name: str
    unit: str
    dtype: str
    meaning: str
    categories: tuple[str, ...] = ()
    shared: bool = False


def measure_column(name: str, unit: str, meaning: str) -> Column:
    """Return a column of numbers, NaN where not measured."""
    return Column(name, unit, "float64", meaning)


def count_column(name: str, meaning: str) -> Column:
    """Return a column of whole numbers."""
    return Column(name, "1", "int64", meaning)


def _shared(name: str, unit: str, meaning: str, dtype: str = "float64") -> Column:
    return Column(name, unit, dtype, meaning, shared=True)


CA_SPEEDS = ("far", "contact")
"""Speeds that Ca is made with."""

OUTCOMES = ("slipped", "broke", "captured", "failed")
"""What can come of a run, in the order of the core's codes."""

COLUMNS: tuple[Column, ...] = (
    _shared("source", "", "where the collision comes from, such as 'simulation'", "str"),
    _shared("collision_id", "1", "number of the collision within its source, from 0", "int64"),
    # What was set
    measure_column("size_ratio", "1", "D0/R"),
    measure_column("simulation_capillary_number", "1", "Ca_sim, line tension against drag"),
    measure_column("offset", "D0", "start y of the droplet relative to the obstacle's centre"),
    # The groups of the break-up law
    _shared("capillary_number", "1", "Ca = μv/γ; of simulations as ca_per_ca_sim and ca_speed say"),
    measure_column("ca_per_ca_sim", "1", "Ca/Ca_sim that was assumed"),
    Column("ca_speed", "", "category", "speed in Ca: v_f∞, or at first contact", CA_SPEEDS),
    _shared("normalized_area", "1", "Ã = A/R²"),
    _shared("normalized_thickness", "1", "z̃ = z/R"),
    _shared("symmetry", "1", "S at first contact"),
    _shared("breakup_number", "1", "Bk, from the separating line of the paper's simulations"),
    # What happened
    Column("outcome", "", "category", "what came of it", OUTCOMES),
    _shared("broke", "", "whether the droplet broke; missing where a run failed before", "boolean"),
    _shared("accepted", "", "whether the row is fit for use", "bool"),
    _shared("reject_reason", "", "why it is not; empty when accepted", "str"),
    # First contact
    _shared("impact_parameter", "D0", "b at first contact"),
    _shared("speed", "v_f∞", "speed of the droplet's centre of mass at first contact"),
    measure_column("contact_time", "t0", "time of the first contact"),
    measure_column("contact_speed", "v_f∞", "the same as speed"),
    measure_column("contact_area", "D0²", "area at first contact"),
    measure_column("contact_shape_parameter", "1", "𝒜 = P²/(4πA) at first contact"),
    # Deformation and break-up
    _shared("neck_thickness", "D0", "thinnest neck from first contact on"),
    measure_column("minimum_neck", "D0", "the same as neck_thickness"),
    measure_column("maximum_shape_parameter", "1", "largest 𝒜 after contact, before any break-up"),
    measure_column(
        "spring_tension_ratio",
        "1",
        "greatest mean tension of the springs over line tension, as maximum_shape_parameter",
    ),
    _shared("daughter_area_ratio", "1", "smaller over larger daughter of the first break-up"),
    measure_column("small_daughter_area", "D0²", "smaller daughter of the first break-up"),
    measure_column("large_daughter_area", "D0²", "larger daughter of the first break-up"),
    measure_column("breakup_time", "t0", "time of the first break-up"),
    measure_column("breakup_neck", "D0", "neck that was cut in the first break-up"),
    count_column("breakup_count", "break-ups, of daughters too"),
    count_column("generations", "break-ups in the ancestry of the youngest droplet"),
    count_column("droplet_count", "droplets at the end"),
    measure_column("end_time", "t0", "when the run ended"),
    count_column("steps", "time steps taken"),
    count_column("vertex_updates", "vertices times steps"),
    # Physical units, where the scale is known
    _shared("contact_time_s", "s", "time of the first contact"),
    _shared("obstacle_x_um", "µm", "obstacle's centre in the image; origin top left, x right"),
    _shared("obstacle_y_um", "µm", "obstacle's centre in the image; origin top left, y down"),
    _shared("area_um2", "µm²", "area at first contact"),
    _shared("speed_mm_s", "mm/s", "speed of the droplet's centre of mass at first contact"),
    _shared("neck_um", "µm", "thinnest neck from first contact on"),
    _shared("obstacle_radius_um", "µm", "R"),
    _shared("thickness_um", "µm", "z of the chamber"),
    _shared("viscosity_mPa_s", "mPa s", "dynamic viscosity of the continuous phase"),
    _shared("surface_tension_mN_m", "mN/m", "surface tension"),
)
"""The columns in their order."""

SHARED_COLUMNS: tuple[Column, ...] = tuple(c for c in COLUMNS if c.shared)
"""What every table has."""

SYNTHETIC = "synthetic"
"""How the source of a row begins that was neither simulated nor measured, but drawn."""


def units() -> dict[str, str]:
    """Return the unit of every column, by name.

    Examples
    --------
    >>> units()["contact_time"], units()["area_um2"]
    ('t0', 'µm²')
    """
    return {column.name: column.unit for column in COLUMNS}


def table(parts: Sequence[Mapping[str, NDArray[Any]]], more: Sequence[Column] = ()) -> pd.DataFrame:
    """Join columns, given in parts, to a table with the units in ``attrs["units"]``.

    Every part holds arrays, shape (rows of the part,), of all `COLUMNS` and of `more`, which stand
    behind these. No rows without parts.
    """
    joined = {
        column.name: np.concatenate([part[column.name] for part in parts]) if parts else np.empty(0)
        for column in (*COLUMNS, *more)
    }
    return _frame(joined, (*COLUMNS, *more))


def measured_table(
    columns: Mapping[str, NDArray[Any]], more: Sequence[Column] = ()
) -> pd.DataFrame:
    """Make a table of collisions that were not simulated; what is not given was not measured.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (rows,)
        Any of `SHARED_COLUMNS`, ``source`` among them, and all of `more`. Rows are accepted
        unless ``accepted`` says otherwise, and numbered unless ``collision_id`` does.
    more : sequence of Column, optional
        Further columns, which stand behind the shared ones.

    Returns
    -------
    DataFrame
        With the units in ``attrs["units"]``.

    Examples
    --------
    >>> table = measured_table({"source": np.array(["notebook"]), "symmetry": np.array([0.8])})
    >>> table["symmetry"].tolist(), table["capillary_number"].isna().tolist()
    ([0.8], [True])
    """
    count = len(columns["source"])
    unsaid = {"bool": True, "str": "", "boolean": None, "float64": math.nan}
    filled = {"collision_id": np.arange(count), **columns}
    for column in SHARED_COLUMNS:
        if column.name not in filled:
            filled[column.name] = np.full(count, unsaid[column.dtype])
    return _frame(filled, (*SHARED_COLUMNS, *more))


def _frame(columns: Mapping[str, NDArray[Any]], schema: Sequence[Column]) -> pd.DataFrame:
    import pandas as pd  # slow to import, and a single collision does without

    frame = pd.DataFrame(
        {c.name: pd.Series(columns[c.name], dtype=pandas_type(c), copy=False) for c in schema},
        copy=False,
    )
    frame.attrs["units"] = {column.name: column.unit for column in schema}
    return frame


def pandas_type(column: Column) -> Any:
    """Return the type of a column in a DataFrame."""
    import pandas as pd

    return pd.CategoricalDtype(list(column.categories)) if column.categories else column.dtype


def synthetic(frame: pd.DataFrame) -> bool:
    """Return whether rows of a table were drawn rather than simulated or measured."""
    return bool(frame["source"].str.startswith(SYNTHETIC).any())
