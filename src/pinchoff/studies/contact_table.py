"""The contacts of a run of many droplets as a table of collisions: to fit a law, or to explore."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pinchoff.collisions.schema import measured_table
from pinchoff.support.paper_constants import CA_PER_CA_SIM

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.parameters import Parameters

SOURCE = "emulsion"
UNSETTLED = "neither broke nor went on for long enough before the run ended"


def contact_table(
    events: pd.DataFrame, contacts: pd.DataFrame, parameters: Parameters
) -> pd.DataFrame:
    """Return the contacts of a run as collisions, a row each.

    Ca is made with the droplet's speed at contact. The model is two-dimensional: z̃ is 1.

    Parameters
    ----------
    events : DataFrame
        Of an `Emulsion`.
    contacts : DataFrame
        What `contact_outcomes` made of them.
    parameters : Parameters
    """
    met = events[events["kind"].astype(str) == "contact"]
    speed = met["speed"].to_numpy(np.float64)
    area = met["area"].to_numpy(np.float64)
    radius = contacts["radius"].to_numpy(np.float64)
    settled = contacts["settled"].to_numpy(bool)
    columns = {
        "source": np.full(len(contacts), SOURCE, dtype=object),
        "capillary_number": CA_PER_CA_SIM * parameters.simulation_capillary_number * speed,
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
    return measured_table(columns)
