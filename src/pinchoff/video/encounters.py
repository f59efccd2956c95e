"""A filmed droplet's meeting with an obstacle, as a row of the collisions table.

What is measured at first contact is measured here, on an outline, by the geometry of the compiled
core: for droplets that a camera saw and for the truth behind a drawn clip alike.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.collisions.law import breakup_number_of
from pinchoff.collisions.parquet import write_collisions
from pinchoff.collisions.schema import (
    COLUMNS,
    SHARED_COLUMNS,
    Column,
    count_column,
    measure_column,
    measured_table,
)
from pinchoff.support import paper_constants as paper
from pinchoff.support.checked import Checked, Number, explained

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]

CONTACT_DISTANCE_UM = 16.0
"""A droplet whose outline stops closing the gap this near to an obstacle has met it, µm: 3 pixels
of the paper's camera. A film of oil keeps them apart; in the simulation it is the wall."""

RELEASE = 1.0
"""A collision is over when the droplet is this many obstacle radii away."""

CUT_BY_FRAME = "cut by the frame"
CLIP_ENDED = "the clip ends during the collision"
"""Why a filmed collision is not used, whether it is measured or drawn."""

FILM_COLUMNS: tuple[Column, ...] = (
    Column("clip", "", "str", "name of the clip"),
    count_column("track_id", "the droplet's track in the clip"),
    count_column("obstacle_id", "number of the obstacle in the clip"),
    count_column("contact_frame", "first frame in contact, from 0"),
    count_column("end_frame", "last frame of the collision that was followed"),
    measure_column(
        "flow_direction_deg", "°", "the droplet's direction at contact, from x towards y"
    ),
    measure_column(
        "side", "1", "1 where its centre of mass is left of the obstacle, -1 where right"
    ),
    measure_column("breakup_frame", "1", "first frame with two droplets"),
    measure_column("breakup_time_s", "s", "time of that frame"),
    measure_column("breakup_neck_um", "µm", "neck in the last frame before the break-up"),
    measure_column(
        "small_daughter_area_um2", "µm²", "smaller daughter in the frame of the break-up"
    ),
    measure_column(
        "large_daughter_area_um2", "µm²", "larger daughter in the frame of the break-up"
    ),
)
"""What only a filmed collision has."""

_ALSO_SIMULATED = (
    "size_ratio",
    "outcome",
    "contact_shape_parameter",
    "maximum_shape_parameter",
)


def _unless_unknown(meaning: str) -> Any:
    advice = f"{meaning}, or leave it out where it is unknown"
    return explained("a positive, finite number", advice, gt=0.0, default=None)


class Laboratory(Checked):
    """What a camera does not see. Unknown is None; what follows from it is then NaN.

    Parameters
    ----------
    obstacle_radius_um : float, optional
        R, µm.
    thickness_um : float, optional
        z, the chamber's thickness, µm.
    viscosity_mPa_s : float, optional
        μ, the fluid's dynamic viscosity, mPa s.
    surface_tension_mN_m : float, optional
        γ, mN/m.

    Raises
    ------
    InputError
        A value is not finite or not positive.
    """

    obstacle_radius_um: Number | None = _unless_unknown("R in µm")
    thickness_um: Number | None = _unless_unknown("z in µm")
    viscosity_mPa_s: Number | None = _unless_unknown("μ in mPa s")  # noqa: N815
    surface_tension_mN_m: Number | None = _unless_unknown("γ in mN/m")  # noqa: N815

    def known(self, name: str) -> float:
        """Return a value by its name, NaN where it is unknown."""
        value = getattr(self, name)
        return math.nan if value is None else float(value)


PAPER_LABORATORY = Laboratory(
    obstacle_radius_um=paper.OBSTACLE_RADIUS_UM,
    thickness_um=paper.THICKNESS_UM,
    viscosity_mPa_s=paper.VISCOSITY_MPA_S,
    surface_tension_mN_m=paper.SURFACE_TENSION_MN_M,
)
"""That of the paper's experiment."""


@dataclass(frozen=True, kw_only=True)
class Encounter:
    """One droplet that met one obstacle.

    Lengths in µm, with the origin at the centre of the image's top left pixel and y down; NaN and
    None: did not happen, or was not measured.

    Attributes
    ----------
    obstacle : (float, float, float)
        Centre and radius in the image.
    outline : ndarray, shape (n, 2)
        The droplet in the frame of first contact.
    velocity : (float, float)
        Of its centre of mass then, mm/s.
    contact_frame, end_frame : int
        First frame in contact, and the last one that was followed.
    contact_time_s : float
    outcome : str
        "slipped", "broke" or "captured".
    breakup_frame : float
        First frame with two droplets.
    breakup_time_s : float
    daughter_areas : (float, float)
        In that frame, µm²; in any order.
    neck : float
        Thinnest from first contact on, before any break-up.
    breakup_neck : float
        In the last frame before the break-up.
    maximum_shape_parameter : float
    reject_reason : str
        Empty for a collision that is fit for use.
    track_id, obstacle_id : int
    """

    obstacle: tuple[float, float, float]
    outline: Floats
    velocity: tuple[float, float]
    contact_frame: int
    end_frame: int
    contact_time_s: float
    outcome: str
    breakup_frame: float = math.nan
    breakup_time_s: float = math.nan
    daughter_areas: tuple[float, float] = (math.nan, math.nan)
    neck: float = math.nan
    breakup_neck: float = math.nan
    maximum_shape_parameter: float = math.nan
    reject_reason: str = ""
    track_id: int = 0
    obstacle_id: int = 0

    def row(self, laboratory: Laboratory) -> dict[str, Any]:
        """Return the columns of the table, but for those that number the row."""
        area = _core.area(self.outline)
        diameter = math.sqrt(4.0 * area / math.pi)
        centre = self.obstacle[:2]
        speed = math.hypot(*self.velocity)
        radius = laboratory.obstacle_radius_um or self.obstacle[2]
        thickness = laboratory.known("thickness_um")
        viscosity = laboratory.known("viscosity_mPa_s")
        tension = laboratory.known("surface_tension_mN_m")
        symmetry = impact = side = math.nan
        if speed > 0.0:
            symmetry = _core.symmetry(self.outline, centre, self.velocity)
            impact = _core.impact_parameter(self.outline, centre, self.velocity)
            side = self._side()
        small, large = sorted(self.daughter_areas)
        row: dict[str, Any] = {
            "size_ratio": diameter / radius,
            "capillary_number": viscosity * speed / tension * 1e-3,
            "normalized_area": area / radius**2,
            "normalized_thickness": thickness / radius,
            "symmetry": symmetry,
            "impact_parameter": impact / diameter,
            "outcome": self.outcome,
            "broke": self.outcome == "broke",
            "accepted": not self.reject_reason,
            "reject_reason": self.reject_reason,
            "contact_shape_parameter": _core.shape_parameter(self.outline),
            "maximum_shape_parameter": self.maximum_shape_parameter,
            "neck_thickness": self.neck / diameter,
            "daughter_area_ratio": small / large,
            "contact_time_s": self.contact_time_s,
            "obstacle_x_um": centre[0],
            "obstacle_y_um": centre[1],
            "area_um2": area,
            "speed_mm_s": speed,
            "neck_um": self.neck,
            "obstacle_radius_um": radius,
            "thickness_um": thickness,
            "viscosity_mPa_s": viscosity,
            "surface_tension_mN_m": tension,
            "track_id": self.track_id,
            "obstacle_id": self.obstacle_id,
            "contact_frame": self.contact_frame,
            "end_frame": self.end_frame,
            "flow_direction_deg": math.degrees(math.atan2(self.velocity[1], self.velocity[0])),
            "side": side,
            "breakup_frame": self.breakup_frame,
            "breakup_time_s": self.breakup_time_s,
            "breakup_neck_um": self.breakup_neck,
            "small_daughter_area_um2": small,
            "large_daughter_area_um2": large,
        }
        row["breakup_number"] = breakup_number_of(row)
        return row

    def _side(self) -> float:
        """Return on which side of the obstacle the droplet's centre of mass passes it."""
        x, y = _core.centroid(self.outline)
        vx, vy = self.velocity
        # Left as one looks along the flow; y points down.
        left = vy * (x - self.obstacle[0]) - vx * (y - self.obstacle[1])
        return math.copysign(1.0, left)


def encounter_table(
    encounters: Sequence[Encounter], laboratory: Laboratory, source: str, clip: str
) -> pd.DataFrame:
    """Return a clip's encounters as a collisions table, numbered in their order.

    Its columns are `SHARED_COLUMNS`, four more of a simulation's, and `FILM_COLUMNS`; its source is
    "video", or "film" for the truth behind a drawn clip.
    """
    more = (*(c for c in COLUMNS if c.name in _ALSO_SIMULATED), *FILM_COLUMNS)
    rows = [encounter.row(laboratory) for encounter in encounters]
    not_measured = ("source", "clip", "collision_id", "speed")
    columns: dict[str, NDArray[Any]] = {
        column.name: np.array([row[column.name] for row in rows])
        for column in (*SHARED_COLUMNS, *more)
        if column.name not in not_measured
    }
    columns["source"] = np.full(len(rows), source, dtype=object)
    columns["clip"] = np.full(len(rows), clip, dtype=object)
    return measured_table(columns, more)


def write_encounters(table: pd.DataFrame, path: str | os.PathLike[str]) -> None:
    """Write what `encounter_table` returned, as ``.parquet`` or ``.csv``."""
    write_collisions(table, path, FILM_COLUMNS)


def thinnest_neck(outline: Floats) -> tuple[float, int, int]:
    """Return the neck's thickness and the vertices it joins; NaN where there is none."""
    thickness, i, j = _core.neck(outline, paper.NECK_SEPARATION, False, 1.0)
    return (thickness if math.isfinite(thickness) else math.nan), i, j


def gap_to_circle(outline: Floats, circle: Sequence[float] | Floats) -> float:
    """Return the distance between an outline's edges and a circle; negative where they overlap."""
    x, y, radius = (float(value) for value in circle)
    return float(_core.distance(outline, (x, y))) - radius


def along_flow(points: Floats, row: Mapping[str, Any]) -> Floats:
    """Return image points in µm relative to a row's obstacle, x along the flow, y to its left."""
    angle = math.radians(float(row["flow_direction_deg"]))
    x, y = (points - (row["obstacle_x_um"], row["obstacle_y_um"])).T
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.column_stack([cosine * x + sine * y, sine * x - cosine * y])
