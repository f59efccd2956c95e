"""Appendix C in numbers: how well critical symmetries collapse with the ratio μ̃/γ̃."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


class Spread(NamedTuple):
    """How well the critical symmetries of several line tensions agree at equal μ̃/γ̃."""

    typical: float  # root mean square of the relative distances from the mean over line tensions
    largest: float  # of them
    bracket: float  # half the widest, relative to its S_c: no agreement can be seen beyond that


def collapse_spread(rows: pd.DataFrame) -> Spread:
    """Measure how well S_c(μ̃/γ̃) is one curve, in rows of `Boundary.found`.

    Raises
    ------
    InputError
        No simulation capillary number has a critical symmetry at two line tensions.
    """
    groups = rows.groupby("simulation_capillary_number")
    shared = rows[groups["line_tension"].transform("nunique") > 1]
    if shared.empty:
        raise InputError.of(
            "boundary",
            "one with several line tensions at one simulation capillary number",
            "none",
            'vary both "line_tension" and "simulation_capillary_number"',
        )
    symmetry = shared["critical_symmetry"]
    mean = symmetry.groupby(shared["simulation_capillary_number"]).transform("mean")
    distance = (symmetry / mean - 1).abs()
    half = shared["width"] / (2 * symmetry)
    return Spread(float(np.sqrt((distance**2).mean())), float(distance.max()), float(half.max()))


def slopes(rows: pd.DataFrame) -> dict[float, float]:
    """Return the least-squares slope of ln S_c against ln μ̃, by line tension.

    Line tensions with fewer than two critical symmetries are left out.
    """
    return {
        float(str(tension)): float(
            np.polyfit(np.log(group["drag"]), np.log(group["critical_symmetry"]), 1)[0]
        )
        for tension, group in rows.groupby("line_tension")
        if len(group) > 1
    }
