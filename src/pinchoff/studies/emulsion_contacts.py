"""What came of each contact of an emulsion's droplets with a pillar: rows for the break-up law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pinchoff.collisions.law import breakup_number
from pinchoff.collisions.schema import COLUMNS, measured_table

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.parameters import Parameters

SETTLED = 3.0
"""A contact counts as one without a break-up once the droplet went on for so long, t0, unmerged."""

SOURCE = "emulsion"
_CA_STANDS_FOR = tuple(c for c in COLUMNS if c.name in ("ca_per_ca_sim", "ca_speed"))
UNSETTLED = "neither broke nor went on for long enough before the run ended"


def contact_outcomes(
    events: pd.DataFrame,
    circles: NDArray[np.float64],
    parameters: Parameters,
    end: float,
    width: float = math.inf,
) -> pd.DataFrame:
    """Return a row for each first contact of a droplet with a pillar, with what came of it.

    A break-up is put down to the pillar nearest to its neck among those that the droplet touched.

    Parameters
    ----------
    events : DataFrame
        Of an `Emulsion`.
    circles : ndarray, shape (M, 3)
        The pillars.
    parameters : Parameters
    end : float
        Of the run, t0.
    width : float, optional
        Period of the cell across the flow, D0.

    Returns
    -------
    DataFrame
        droplet_id, obstacle, time, radius of the obstacle and diameter of the droplet, D0,
        symmetry, breakup_number (with the droplet's area and speed at contact, and the line of
        the paper's simulations), broke, and settled: whether its outcome was seen before the
        droplet merged or the run ended.
    """
    import pandas as pd

    kinds = events["kind"].astype(str)
    met = events[kinds == "contact"]
    broken = events[kinds == "breakup"].set_index("droplet_id")
    gone = events[kinds.isin(("breakup", "left", "retired"))].set_index("droplet_id")["time"]
    pillar = met["obstacle"].to_numpy(np.int64)
    droplet = met["droplet_id"].to_numpy(np.int64)
    neck = broken[["x", "y"]].reindex(droplet).to_numpy(np.float64)
    away = neck - circles[pillar, :2]
    if math.isfinite(width):
        away[:, 1] -= width * np.round(away[:, 1] / width)
    gap = np.hypot(*away.T) - circles[pillar, 2]
    nearest = pd.Series(gap).groupby(droplet).transform("min").to_numpy(np.float64)
    time = met["time"].to_numpy(np.float64)
    ended = gone.reindex(droplet).fillna(math.inf).to_numpy(np.float64)
    merged = events[kinds == "merge"]
    seen = np.full(len(met), end)
    for name in ("droplet_id", "partner") if len(merged) else ():
        times = merged.set_index(name)["time"].reindex(droplet).to_numpy(np.float64)
        seen = np.fmin(seen, times)
    number = breakup_number(
        parameters.capillary_number * met["speed"],
        normalized_area=met["area"] / circles[pillar, 2] ** 2,
        symmetry=met["symmetry"],
    )
    return pd.DataFrame(
        {
            "droplet_id": droplet,
            "obstacle": pillar,
            "time": time,
            "radius": circles[pillar, 2],
            "diameter": np.sqrt(4 / math.pi * met["area"].to_numpy(np.float64)),
            "symmetry": met["symmetry"].to_numpy(np.float64),
            "breakup_number": number,
            "broke": np.isfinite(gap) & (gap == nearest),
            "settled": (ended < math.inf) | (time + SETTLED <= seen),
        }
    )


def contact_table(
    events: pd.DataFrame, contacts: pd.DataFrame, parameters: Parameters
) -> pd.DataFrame:
    """Return the contacts of a run as collisions, a row each, as `contact_outcomes` found them.

    Ca is made with the droplet's speed at contact, and is that of the parameters for any size of a
    droplet: the fluids are the same. The model is two-dimensional: z̃ is 1.
    """
    met = events[events["kind"].astype(str) == "contact"]
    speed = met["speed"].to_numpy(np.float64)
    area = met["area"].to_numpy(np.float64)
    radius = contacts["radius"].to_numpy(np.float64)
    settled = contacts["settled"].to_numpy(bool)
    columns = {
        "source": np.full(len(contacts), SOURCE, dtype=object),
        "capillary_number": parameters.capillary_number * speed,
        "ca_per_ca_sim": np.full(len(contacts), parameters.ca_per_ca_sim),
        "ca_speed": np.full(len(contacts), "contact", dtype=object),
        "normalized_area": area / radius**2,
        "normalized_thickness": np.ones(len(contacts)),
        "symmetry": contacts["symmetry"].to_numpy(np.float64),
        "breakup_number": contacts["breakup_number"].to_numpy(np.float64),
        "broke": contacts["broke"].to_numpy(bool),
        "accepted": settled,
        "reject_reason": np.where(settled, "", UNSETTLED).astype(object),
        "speed": speed,
        "impact_parameter": met["impact_parameter"].to_numpy(np.float64),
    }
    if parameters.scale is not None:
        columns["speed_mm_s"] = speed * parameters.scale.speed_mm_s
        columns["area_um2"] = area * parameters.scale.diameter_um**2
        columns["obstacle_radius_um"] = radius * parameters.scale.diameter_um
    return measured_table(columns, more=_CA_STANDS_FOR)
