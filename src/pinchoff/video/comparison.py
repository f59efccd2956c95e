"""A measured collision beside the simulation of the very same one [paper, appendix B]."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from pinchoff import _core
from pinchoff.collisions.parquet import read_collisions
from pinchoff.model.outlines import Outlines
from pinchoff.model.parameters import SAMPLE_INTERVAL, Parameters
from pinchoff.model.simulation import Collision, simulate
from pinchoff.support.errors import InputError
from pinchoff.support.paper_constants import CA_PER_CA_SIM
from pinchoff.video import clip_folder
from pinchoff.video.contact import FEWEST_FRAMES, Approach, Place
from pinchoff.video.encounters import (
    Encounter,
    along_flow,
    gap_to_circle,
)
from pinchoff.video.microscope.passages import Passage
from pinchoff.video.settings import VideoSettings

Floats = NDArray[np.float64]

_LEAST_OFFSET, _MOST_OFFSET = 1e-3, 2.0  # D0, between which the start is looked for
_TOLERANCE = 1e-4  # of the offset, D0
_GRAZING = 0.01  # S, below which it tells little
_FEWEST_FRAMES = 3  # that are compared
_AFTER_S = 0.3  # seconds of film that are compared after the collision's end


_CIRCLE = ("obstacle_x_um", "obstacle_y_um", "obstacle_radius_um")
_TOLD_THERE = (
    *("capillary_number", "symmetry", "impact_parameter", "speed_mm_s", "size_ratio"),
    *("area_um2", "contact_time_s", "contact_frame", "flow_direction_deg", "side"),
)

ROUNDS = 4
"""Until speed at contact and capillary number agree."""


class _Contact(NamedTuple):
    """A run at its first contact, as near as the film counts as contact; t0, v_f∞, D0."""

    time: float
    symmetry: float
    impact_parameter: float
    velocity: tuple[float, float]

    @property
    def speed(self) -> float:
        return math.hypot(*self.velocity)


@dataclass(frozen=True, eq=False)
class Comparison:
    """A filmed collision and its simulation, in the droplet's own frame.

    The origin is the obstacle's centre, x points along the droplet's velocity at contact.

    Attributes
    ----------
    row : dict
        The collision, as in its table, but speed, S and b where it comes near.
    run : Collision
        Its simulation.
    contact : NamedTuple
        The simulation where it is as near to the obstacle as counts as contact in the film.
    passage : Passage
        The simulation placed in the image and in time.
    source : Path
        The clip.
    settings : VideoSettings
        How it was measured.
    frames : ndarray of int, shape (n,)
        Frames that are compared; of each:
    filmed, simulated : ndarray, shape (n, 2)
        Centre of mass, µm.
    filmed_shape, simulated_shape : ndarray, shape (n,)
        𝒜 = P²/(4πA).
    """

    row: dict[str, Any]
    run: Collision
    contact: _Contact
    passage: Passage
    source: Path
    settings: VideoSettings
    frames: NDArray[np.int64]
    filmed: Floats
    simulated: Floats
    filmed_shape: Floats
    simulated_shape: Floats

    @property
    def position_rms_um(self) -> float:
        """Root mean square distance of the centres of mass at equal times, µm."""
        away = self.filmed - self.simulated
        return float(np.sqrt(np.mean((away**2).sum(axis=1))))

    @property
    def shape_rms(self) -> float:
        """Root mean square difference of 𝒜 at equal times."""
        return float(np.sqrt(np.mean((self.filmed_shape - self.simulated_shape) ** 2)))

    def to_dict(self) -> dict[str, Any]:
        """Return the figures, fit for JSON."""
        return {
            "clip": str(self.source),
            "collision_id": int(self.row["collision_id"]),
            "measured": {
                name: float(self.row[name])
                for name in ("symmetry", "impact_parameter", "speed_mm_s", "size_ratio")
            },
            "measured_outcome": str(self.row["outcome"]),
            "simulated": {
                "symmetry": self.contact.symmetry,
                "impact_parameter": self.contact.impact_parameter,
                "offset": self.run.parameters.offset,
                "simulation_capillary_number": self.run.parameters.simulation_capillary_number,
                "size_ratio": self.run.parameters.size_ratio,
            },
            "simulated_outcome": self.run.outcome,
            "frames": len(self.frames),
            "position_rms_um": self.position_rms_um,
            "shape_rms": self.shape_rms,
        }


def compare_collision(
    folder: str | os.PathLike[str],
    collision_id: int,
    *,
    progress: Callable[[int], object] | None = None,
) -> Comparison:
    """Simulate a measured collision from its own numbers and compare the two.

    D0/R, the droplet's speed and the fluids' properties are those measured. The flow's speed is
    solved for, so that the simulated droplet is as fast, and the start's offset, so that it has
    the measured S; where S is 0, the measured b. All this is where the droplet comes within 16 µm
    of the obstacle, or the contact distance that is set: there film and simulation are told alike.

    Parameters
    ----------
    folder : path
        Folder of a clip that `measure_videos` wrote, ``DIR/clips/NAME``.
    collision_id : int
        As in the clip's own table.
    progress : callable, optional
        Called with how many of `ROUNDS` are done.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        There is no such clip or collision, or too little was measured of it.
    SimulationError
        A guard stopped the simulation.
    """
    place = Path(folder)
    result = clip_folder.read_result(place)
    row = _row(place, collision_id)
    settings = _unchanged_settings(place, result)
    pixel_um = settings.pixel_um
    seen = _filmed(place, row)
    row = _at_distance(row, seen, settings)
    run, contact, flow_mm_s = _simulated(row, settings, progress or (lambda done: None))
    passage = _placed(run, contact, row, flow_mm_s, pixel_um)
    passage = _in_time(passage, seen, pixel_um)
    filmed, simulated = _both(passage, seen, pixel_um)
    if len(filmed) < _FEWEST_FRAMES:
        got, rule = f"{len(filmed)} frames", f"seen whole in {_FEWEST_FRAMES} frames or more"
        raise InputError.of("collision_id", rule, got, "choose another")

    def centres(outlines: list[Floats]) -> Floats:
        return along_flow(np.array([_core.centroid(outline) for outline in outlines]), row)

    return Comparison(
        row=row,
        run=run,
        contact=contact,
        passage=passage,
        source=Path(result["clip"]),
        settings=settings,
        frames=np.array([frame for frame, _, _ in seen[: len(filmed)]]),
        filmed=centres(filmed),
        simulated=centres(simulated),
        filmed_shape=np.array([_core.shape_parameter(outline) for outline in filmed]),
        simulated_shape=np.array([_core.shape_parameter(outline) for outline in simulated]),
    )


def _unchanged_settings(folder: Path, result: dict[str, Any]) -> VideoSettings:
    """Return how a clip was measured, or refuse one that is not there any more or has changed."""
    source, settings = Path(result["clip"]), VideoSettings(**result["settings"])
    advice = "put it back, or measure it again with pinchoff video"
    if not source.exists():
        raise InputError.of(str(source), "the clip that was measured", "nothing there", advice)
    if clip_folder.file_stamps(source) != [tuple(stamp) for stamp in result["files"]]:
        got = "one that has changed since"
        raise InputError.of(str(source), "the clip that was measured", got, advice)
    return settings


_Seen = list[tuple[int, float, Floats]]
"""Frame, time in seconds and outline in µm of a filmed droplet, again and again."""


def _both(passage: Passage, seen: _Seen, pixel_um: float) -> tuple[list[Floats], list[Floats]]:
    """Return the outlines of film and simulation at equal times, µm, until the latter breaks."""
    simulated = []
    for _, time, _ in seen:
        droplets = passage.droplets_at(time)
        if len(droplets) != 1:
            break
        simulated.append(droplets[0][1] * pixel_um)
    return [outline for _, _, outline in seen[: len(simulated)]], simulated


def _in_time(passage: Passage, seen: _Seen, pixel_um: float) -> Passage:
    """Shift the simulation in time by less than a frame: contact falls between two of them."""
    interval = min(np.diff([time for _, time, _ in seen]), default=0.0)

    def shifted(shift: float) -> Passage:
        return passage.moved(passage.start_s + shift, passage.origin, passage.angle)

    def distance(shift: float) -> float:
        filmed, simulated = _both(shifted(shift), seen, pixel_um)
        away = [
            np.subtract(_core.centroid(a), _core.centroid(b))
            for a, b in zip(filmed, simulated, strict=True)
        ]
        return float(np.mean(np.square(away))) if away else math.inf

    if interval == 0.0:
        return passage
    found = minimize_scalar(distance, bounds=(-interval, interval), method="bounded")
    return shifted(float(found.x))


def _row(folder: Path, collision_id: int) -> dict[str, Any]:
    table = read_collisions(folder / clip_folder.COLLISIONS)
    rows: list[Any] = table[table["collision_id"] == collision_id].to_dict("records")
    if not rows:
        rule = f"from 0 to {len(table) - 1}" if len(table) else "left out: there are none"
        raise InputError.of("collision_id", rule, collision_id, "see collisions.parquet")
    row: dict[str, Any] = rows[0]
    for name in ("capillary_number", "symmetry", "speed_mm_s"):
        if not math.isfinite(row[name]):
            advice = "measure with viscosity and surface tension given, or choose another"
            raise InputError.of("collision_id", f"one with a {name}", "NaN", advice)
    return row


def _at_distance(row: dict[str, Any], seen: _Seen, settings: VideoSettings) -> dict[str, Any]:
    """Return a row as it is where the droplet comes near, rather than where it touches.

    Within a frame of the touch it loses much of its speed; so film and simulation are told alike
    at a distance that both cross at a steady pace.
    """
    circle = tuple(float(row[name]) for name in _CIRCLE)
    approach = Approach([], settings.velocity_frames, settings.contact_um, fixed=True)
    for frame, time, outline in seen:
        place = Place(time, *_core.centroid(outline))
        approach.add(frame, place, outline, gap_to_circle(outline, circle))
    if not approach.known:
        return row
    contact = approach.contact()
    if contact.seen < FEWEST_FRAMES:
        return row
    encounter = Encounter(
        obstacle=(circle[0], circle[1], circle[2]),
        outline=contact.outline,
        velocity=(contact.velocity[0] * 1e-3, contact.velocity[1] * 1e-3),
        contact_frame=contact.frame,
        end_frame=int(row["end_frame"]),
        contact_time_s=contact.time_s,
        outcome=str(row["outcome"]),
    )
    measured = encounter.row(settings.laboratory)
    return {**row, **{name: measured[name] for name in _TOLD_THERE}}


def _contact(run: Collision, distance: float) -> _Contact | None:
    """Return the first record in which the droplet is as near; None if it never is."""
    assert run.outlines is not None
    circle = run.outlines.obstacles[0]
    for time, droplets in zip(run.outlines.times.tolist(), run.outlines, strict=True):
        outline = droplets[0].vertices
        # The engine starts a droplet at rest.
        if time > 0.0 and gap_to_circle(outline, circle) <= distance:
            velocity = _core.centroid_velocity(outline, droplets[0].velocities)
            centre = tuple(circle[:2].tolist())
            symmetry = _core.symmetry(outline, centre, velocity)
            impact = _core.impact_parameter(outline, centre, velocity)
            return _Contact(time, symmetry, impact, velocity)
    return None


def _simulated(
    row: dict[str, Any], settings: VideoSettings, progress: Callable[[int], object]
) -> tuple[Collision, _Contact, float]:
    """Return the run, its contact, and the flow's speed in mm/s that gives it the droplet's."""
    speed = 1.0
    for done in range(ROUNDS):
        capillary = float(row["capillary_number"]) / speed / CA_PER_CA_SIM
        run, contact = _matched(row, capillary, settings)
        speed = contact.speed
        progress(done + 1)
    return run, contact, float(row["speed_mm_s"]) / speed


def _matched(
    row: dict[str, Any], capillary: float, settings: VideoSettings
) -> tuple[Collision, _Contact]:
    """Return the run that starts so that it has the measured S, or b where S is 0."""
    base = Parameters(size_ratio=float(row["size_ratio"]), simulation_capillary_number=capillary)
    diameter_um = float(row["size_ratio"] * row["obstacle_radius_um"])
    by_symmetry = float(row["symmetry"]) > _GRAZING

    def tried(offset: float) -> tuple[Collision, _Contact | None]:
        run = simulate(base.replace(offset=offset), outlines=SAMPLE_INTERVAL)
        return run, _contact(run, settings.contact_um / diameter_um)

    def excess(offset: float) -> float:
        contact = tried(offset)[1]
        if contact is None:  # it passes by
            return -1.0
        if by_symmetry:
            return contact.symmetry - float(row["symmetry"])
        return float(row["impact_parameter"]) - contact.impact_parameter

    offset = _LEAST_OFFSET
    if excess(_LEAST_OFFSET) > 0.0:  # else it is more head-on than can be told from exactly so
        offset = float(brentq(excess, _LEAST_OFFSET, _MOST_OFFSET, xtol=_TOLERANCE))
        while excess(offset) == -1.0:
            offset -= _TOLERANCE
    run, contact = tried(math.copysign(offset, row["side"]))
    assert contact is not None
    return run, contact


def _placed(
    run: Collision, contact: _Contact, row: dict[str, Any], flow_mm_s: float, pixel_um: float
) -> Passage:
    assert run.outlines is not None
    diameter_um = float(row["size_ratio"] * row["obstacle_radius_um"])
    unit_s = diameter_um * 1e-3 / flow_mm_s
    vx, vy = contact.velocity
    # The run has y up, the image y down.
    angle = math.radians(float(row["flow_direction_deg"])) + math.atan2(vy, vx)
    origin = (row["obstacle_x_um"] / pixel_um, row["obstacle_y_um"] / pixel_um)
    start = float(row["contact_time_s"]) - contact.time * unit_s
    return Passage(run.outlines, diameter_um / pixel_um, unit_s, origin, start, angle)


def _filmed(folder: Path, row: dict[str, Any]) -> _Seen:
    """Return frame, time and outline, µm, of the droplet before, in and after its collision."""
    tracks = pd.read_parquet(folder / clip_folder.TRACKS)
    own = tracks[(tracks["track_id"] == row["track_id"]) & ~tracks["cut"]]
    frames = dict(zip(own["time_s"].round(9), own["frame"], strict=True))
    outlines = Outlines.load(folder / clip_folder.OUTLINES)
    end_s = float(row["contact_time_s"]) + _AFTER_S
    end_s = max(end_s, float(own.loc[own["frame"] <= row["end_frame"], "time_s"].max()))
    found = []
    for time, droplets in zip(outlines.times.tolist(), outlines, strict=True):
        for droplet in droplets:
            whole = round(time, 9) in frames and time <= end_s
            if droplet.droplet_id == row["track_id"] and whole:
                found.append((int(frames[round(time, 9)]), time, droplet.vertices))
    return found
