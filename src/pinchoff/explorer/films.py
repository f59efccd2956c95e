"""Filmed and simulated outlines for the page: few vertices, few frames, 16-bit integers."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.model.outlines import Outlines
from pinchoff.model.run_files import read_run

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.model.gsd import Floats

MOST_FILMS = 300
MOST_FRAMES = 80
MOST_VERTICES = 48
"""What one page takes, so that it opens fast: about 5 MB of films and as much of pictures."""

_UNIT = 1.0 / 2500.0  # D0; one step of the integers that hold a film, which reach 13 D0
_NEAR = 3.0  # droplets so near to the pillar are shown, D0
_BEFORE, _AFTER = 3.0, 1.5  # how long before the contact and after the end, D0/v


def filmed(folder: Path, frame: pd.DataFrame) -> tuple[dict[int, Any], dict[int, str], list[str]]:
    """Return films and pictures of the collisions of `pinchoff video`.

    Parameters
    ----------
    folder : Path
        What the command wrote.
    frame : DataFrame
        Its collisions.

    Returns
    -------
    films : dict of int to dict
        By row: ``times`` from first contact in D0/v, ``radius`` of the pillar in D0, ``unit``,
        ``counts`` and ``vertices``, about the pillar, x along the flow, the droplet above it.
    thumbnails : dict of int to str
        By row: a picture as a data URL.
    words : list of str
        What was left out.
    """
    from pinchoff.video import clip_folder
    from pinchoff.video.batch import CLIPS
    from pinchoff.video.writing import require_video_extra

    require_video_extra("explore")
    measured = frame[["flow_direction_deg", "area_um2", "speed_mm_s"]].to_numpy(np.float64)
    known = np.isfinite(measured).all(axis=1)
    order = np.argsort(~(frame["accepted"].to_numpy(bool) & known), kind="stable")
    chosen = sorted(int(row) for row in order[:MOST_FILMS])
    films: dict[int, Any] = {}
    thumbnails: dict[int, str] = {}
    clips = frame["clip"].to_numpy(str)
    for clip in dict.fromkeys(clips[chosen].tolist()):
        place = folder / CLIPS / clip
        path = place / clip_folder.OUTLINES
        outlines = Outlines.load(path) if path.is_file() else None
        for number in (row for row in chosen if clips[row] == clip):
            row = {str(name): value for name, value in frame.iloc[number].items()}
            ids = (int(row[n]) for n in ("contact_frame", "track_id", "obstacle_id"))
            picture = place / clip_folder.THUMBNAILS / clip_folder.thumbnail_name(*ids)
            if picture.is_file():
                data = base64.b64encode(picture.read_bytes()).decode()
                thumbnails[number] = f"data:image/jpeg;base64,{data}"
            film = _film_of(outlines, row) if outlines is not None and known[number] else None
            if film is not None:
                films[number] = film
    words = []
    if len(frame) > MOST_FILMS:
        words.append(
            f"outlines and pictures of {MOST_FILMS}, accepted ones first, are in this page"
        )
    return films, thumbnails, words


def _film_of(outlines: Outlines, row: dict[str, Any]) -> dict[str, Any] | None:
    """Return one passage, or None where nothing was recorded of it."""
    from pinchoff.video.encounters import along_flow

    diameter = math.sqrt(4.0 * row["area_um2"] / math.pi)
    unit_s = diameter / (row["speed_mm_s"] * 1e3)
    # Always from above the pillar, as a droplet with a positive offset.
    mirror = np.array([1.0, -1.0 if row["side"] < 0 else 1.0])
    times, frames = [], []
    last = _last_time(outlines, row)
    for k, time in enumerate(outlines.times.tolist()):
        since = (time - row["contact_time_s"]) / unit_s
        if since < -_BEFORE or time > last + _AFTER * unit_s:
            continue
        vertices = [along_flow(o.vertices, row) / diameter * mirror for o in outlines[k]]
        times.append(since)
        frames.append([o for o in vertices if np.hypot(*o.T).min() < _NEAR])
    if not any(frames):
        return None
    return _packed(times, frames, row["obstacle_radius_um"] / diameter)


def _last_time(outlines: Outlines, row: dict[str, Any]) -> float:
    """Return when the collision is over: the break-up, or the droplet's last record."""
    if not math.isnan(row["breakup_time_s"]):
        return float(row["breakup_time_s"])
    own = outlines.frame[outlines.droplet_id == row["track_id"]]
    return float(outlines.times[own].max()) if len(own) else float(row["contact_time_s"])


def simulated_film(folder: Path) -> dict[int, Any]:
    """Return the film of `pinchoff run`, times from first contact in t0."""
    path = folder / "outlines.gsd"
    if not path.is_file():
        return {}
    outlines = Outlines.load(path)
    contact = read_run(folder / "collision.json").row["contact_time"]
    contact = contact if contact == contact else 0.0
    kept = [k for k, t in enumerate(outlines.times.tolist()) if t - contact >= -_BEFORE]
    frames = [[o.vertices for o in outlines[k]] for k in kept]
    times = [float(outlines.times[k]) - contact for k in kept]
    return {0: _packed(times, frames, float(outlines.obstacles[0, 2]))}


def _packed(
    times: Sequence[float], frames: Sequence[Sequence[Floats]], radius: float
) -> dict[str, Any]:
    """Thin frames and outlines, and round vertices to integers."""
    every = -(-len(times) // MOST_FRAMES)
    thin = [[o[:: -(-len(o) // MOST_VERTICES)] for o in frame] for frame in frames[::every]]
    flat = [outline for frame in thin for outline in frame]
    numbers = np.concatenate([np.empty((0, 2)), *flat]) / _UNIT
    limits = np.iinfo(np.int16)
    integers = np.clip(np.round(numbers), limits.min, limits.max).astype("<i2")
    return {
        "times": [round(float(time), 4) for time in times[::every]],
        "radius": radius,
        "unit": _UNIT,
        "counts": [[len(outline) for outline in frame] for frame in thin],
        "vertices": base64.b64encode(integers.tobytes()).decode(),
    }
