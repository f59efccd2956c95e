"""The separating line of one pillar alone, in the flow of the chamber that an array stands in.

What droplets do in an array is compared with it. The paper's line is that of a plane Stokes flow
and of D0/R = 5.66; in a thin chamber, and for other droplets, the line lies elsewhere.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pinchoff.collisions.law import breakup_number
from pinchoff.model.flow import brinkman
from pinchoff.model.parameters import Parameters
from pinchoff.studies.boundary import boundary
from pinchoff.support.arguments import checked_positive
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]

_LEAST_VERTICES = 16
_WIDTH = 0.01  # of a bracket, in S


def isolated_pillar(
    parameters: Parameters,
    radius: float,
    thickness: float,
    diameters: Floats,
    speed: float = 1.0,
    threads: int | None = None,
) -> pd.DataFrame:
    """Find where droplets of some diameters begin to break on a pillar that stands alone.

    Parameters
    ----------
    parameters : Parameters
        Of a run of many droplets; ``vertex_count`` is that of a droplet of 1 D0.
    radius : float
        Of the pillar, D0.
    thickness : float
        z of the chamber, D0.
    diameters : ndarray, shape (n,)
        Of the droplets, D0.
    speed : float, optional
        Of the fluid far from the pillar, v_f∞.
    threads : int, optional
        By default as many as there are cores for this process.

    Returns
    -------
    DataFrame
        A row a diameter: diameter (D0), symmetry (S_c), speed (of the droplet at contact, v_f∞)
        and breakup_number: Bk on the line, with that speed. NaN where no line was found.

    Raises
    ------
    InputError
        A number is not positive, or the thickness is infinite: in plane Stokes flow a pillar alone
        has no speed far away.

    Examples
    --------
    >>> p = Parameters(model="front-tracking", simulation_capillary_number=60, vertex_count=48)
    >>> isolated_pillar(p, 0.3, 0.5, np.array([1.0]))["symmetry"].round(1).tolist()
    [0.3]
    """
    import pandas as pd

    radius = checked_positive("radius", radius, "give it in D0")
    speed = checked_positive("speed", speed, "give it in v_f∞")
    if thickness == math.inf:
        advice = "compare with an array whose pillars stand far apart"
        raise InputError.of("thickness", "finite for a pillar alone", thickness, advice)
    rows = []
    for diameter in np.asarray(diameters, dtype=np.float64).tolist():
        # The same collision in units of the droplet's own diameter. A vertex has the drag μD/N and
        # the line tension is one force for all: Ca_sim, made with D0, grows like D.
        count = 2 * round(parameters.vertex_count * diameter / 2)
        alone = parameters.replace(
            size_ratio=diameter / radius,
            vertex_count=max(_LEAST_VERTICES, count),
            simulation_capillary_number=parameters.simulation_capillary_number * diameter * speed,
            scale=None,
        )
        flow = brinkman(radius / diameter, thickness / diameter)
        with warnings.catch_warnings():  # runs without an outcome: a wider bracket, or no line
            warnings.simplefilter("ignore", RuntimeWarning)
            found = boundary(alone, width=_WIDTH, flow=flow, threads=threads, progress=False).table
        symmetry = float(found["critical_symmetry"].iloc[0])
        contact = float(found["contact_speed"].iloc[0]) * speed
        number = breakup_number(
            parameters.capillary_number * contact,
            normalized_area=math.pi / 4 * (diameter / radius) ** 2,
            symmetry=symmetry,
        )
        rows.append((diameter, symmetry, contact, number))
    return pd.DataFrame(rows, columns=["diameter", "symmetry", "speed", "breakup_number"])


def relative_breakup_number(contacts: pd.DataFrame, isolated: pd.DataFrame) -> Floats:
    """Return Bk of contacts over that at which a droplet of their diameter breaks alone.

    Parameters
    ----------
    contacts : DataFrame
        Of `contact_outcomes`.
    isolated : DataFrame
        Of `isolated_pillar`; between its diameters ln Bk is interpolated.

    Returns
    -------
    ndarray, shape (n,)
        NaN outside its diameters.
    """
    known = isolated[np.isfinite(isolated["breakup_number"])].sort_values("diameter")
    if not len(known):
        return np.full(len(contacts), math.nan)
    line = np.interp(
        np.log(contacts["diameter"].to_numpy(np.float64)),
        np.log(known["diameter"].to_numpy(np.float64)),
        np.log(known["breakup_number"].to_numpy(np.float64)),
        left=math.nan,
        right=math.nan,
    )
    relative: Floats = contacts["breakup_number"].to_numpy(np.float64) / np.exp(line)
    return relative
