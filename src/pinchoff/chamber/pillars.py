"""Pillars, and the table of where they stand.

Design, synthetic film and analysis take the positions from here, so that they agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import pandas as pd


class Pillar(NamedTuple):
    """A round pillar, µm, and the region that it stands in."""

    x_um: float
    y_um: float
    radius_um: float
    region: str


def pillar_table(pillars: Sequence[Pillar]) -> pd.DataFrame:
    """Return pillars as a table, in the design's coordinates.

    Returns
    -------
    DataFrame
        ``obstacle_x_um``, ``obstacle_y_um``, ``obstacle_radius_um`` and ``region``.

    Examples
    --------
    >>> pillar_table([Pillar(0.0, 450.0, 85.0, "imaging")])["region"].tolist()
    ['imaging']
    """
    import pandas as pd

    columns = ["obstacle_x_um", "obstacle_y_um", "obstacle_radius_um", "region"]
    table = pd.DataFrame(pillars, columns=columns)
    table.attrs["units"] = dict.fromkeys(columns[:3], "µm")
    return table
