"""The folder of one measured clip: tables, outlines, pictures, and the obstacles as a file."""

from __future__ import annotations

import hashlib
import json
import math
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, NonNegativeInt, PositiveFloat

from pinchoff.collisions.checksums import checksum_of, is_whole
from pinchoff.collisions.parquet import TableWriter
from pinchoff.collisions.schema import Column, count_column, measure_column
from pinchoff.model.gsd import OutlineWriter
from pinchoff.support.errors import InputError
from pinchoff.support.files import HoldsFiles, read_toml, write_text, written_aside
from pinchoff.support.records import Shape, read_record, write_json
from pinchoff.video.clips import Measured
from pinchoff.video.overlay import OverlayWriter, ThumbnailTaker
from pinchoff.video.plugs import PlugFinder, formation_rate
from pinchoff.video.settings import VideoSettings

Floats = NDArray[np.float64]

RESULT = "clip.json"
COLLISIONS = "collisions.parquet"
TRACKS = "tracks.parquet"
EVENTS = "events.parquet"
PLUGS = "plugs.parquet"
OUTLINES = "outlines.gsd"
OVERLAY = "overlay.mp4"
OBSTACLES = "obstacles.toml"
OBSTACLES_AS_FOUND = ".obstacles-as-found.toml"  # tells whether a user has corrected the other
THUMBNAILS = "collisions"

MOST_VERTICES = 96
"""Of an outline in `OUTLINES`; everything is measured on all of its points."""

TRACK_COLUMNS = (
    Column("clip", "", "str", "name of the clip"),
    count_column("frame", "number of the frame, from 0"),
    measure_column("time_s", "s", "when it is shown"),
    count_column("track_id", "the droplet"),
    measure_column("x_um", "µm", "centre of mass; origin top left, x right"),
    measure_column("y_um", "µm", "centre of mass; origin top left, y down"),
    measure_column("area_um2", "µm²", "area"),
    Column("cut", "", "bool", "whether the frame's edge cuts the droplet"),
    Column("touching", "", "bool", "whether it touches another droplet"),
)
EVENT_COLUMNS = (
    Column("clip", "", "str", "name of the clip"),
    count_column("frame", "first frame after the event"),
    Column("kind", "", "str", "entry, exit, break-up, coalescence, found or lost"),
    Column("parents", "1", "int64s", "tracks that end"),
    Column("children", "1", "int64s", "tracks that begin"),
)
PLUG_COLUMNS = (
    Column("clip", "", "str", "name of the clip"),
    count_column("track_id", "the droplet"),
    Column("born", "", "str", "pinch-off in view, entry over the edge, or first frame"),
    count_column("frame", "first frame in which it is seen"),
    measure_column("time_s", "s", "when that is"),
    measure_column("period_s", "s", "since the one before that was born in the same way"),
    count_column("frames", "in which it is whole"),
    measure_column("length_um", "µm", "longer side of the smallest rectangle about it"),
    measure_column("width_um", "µm", "its shorter side"),
    measure_column("area_um2", "µm²", "area"),
    measure_column("speed_mm_s", "mm/s", "of its centre, over the frames in which it is whole"),
)
STREAMED = {TRACKS: TRACK_COLUMNS, EVENTS: EVENT_COLUMNS, PLUGS: PLUG_COLUMNS}
"""Tables that are written row by row."""

TABLES = (COLLISIONS, *STREAMED)


class ClipRecorder(HoldsFiles):
    """Write what is measured in a clip to its folder, frame by frame.

    Obstacles are in pixels, (M, 3); without `overlay_fps` there is no annotated clip.
    """

    def __init__(
        self,
        folder: Path,
        clip: str,
        settings: VideoSettings,
        obstacles: Floats,
        overlay_fps: float | None,
    ) -> None:
        self._folder, self._clip, self._px = folder, clip, settings.pixel_um
        with ExitStack() as files:
            self._tracks = files.enter_context(TableWriter(folder / TRACKS, TRACK_COLUMNS))
            self._events = files.enter_context(TableWriter(folder / EVENTS, EVENT_COLUMNS))
            unfinished = files.enter_context(written_aside(folder / OUTLINES))
            about = {"pixel_size_um": self._px, "y_axis": "down"}
            self._outlines = files.enter_context(
                OutlineWriter(unfinished, obstacles * self._px, about, units="um", flush_every=None)
            )
            self._has_outlines = False
            self._overlay: OverlayWriter | None = None
            if overlay_fps is not None:
                self._overlay = files.enter_context(
                    OverlayWriter(folder / OVERLAY, obstacles, overlay_fps)
                )
            self._files = files.pop_all()
        self._plugs = PlugFinder()
        self._thumbnails = ThumbnailTaker(obstacles)
        self._pictures = folder / THUMBNAILS
        self._pictures.mkdir(exist_ok=True)

    def write_plugs(self) -> float | None:
        """Write the table of plugs; return how many are formed a second, if that is known."""
        px, plugs = self._px, self._plugs.plugs()
        with TableWriter(self._folder / PLUGS, PLUG_COLUMNS) as table:
            for plug in plugs:
                sizes = (plug.length * px, plug.width * px, plug.area * px**2)
                birth = (plug.born, plug.frame, plug.time_s, plug.period_s, plug.frames)
                speed = plug.speed * px * 1e-3
                table.append((self._clip, plug.track, *birth, *sizes, speed))
        return formation_rate(plugs)

    def append(self, seen: Measured) -> None:
        """Write one frame."""
        px, frame = self._px, seen.frame
        for droplet, track in zip(seen.droplets, seen.tracks, strict=True):
            place = (droplet.x * px, droplet.y * px, droplet.area * px**2)
            told = (droplet.cut, droplet.group >= 0)
            self._tracks.append((self._clip, frame.number, frame.time_s, track, *place, *told))
        for event in seen.events:
            ends = (list(event.parents), list(event.children))
            self._events.append((self._clip, event.frame, event.kind, *ends))
        self._append_outlines(seen)
        self._plugs.append(seen)
        for over, pixels in self._thumbnails.look(seen):
            name = thumbnail_name(over.contact_frame, over.track_id, over.obstacle_id)
            bgr = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
            _, data = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 85])
            (self._pictures / name).write_bytes(data.tobytes())
        if self._overlay is not None:
            self._overlay.append(seen)

    def _append_outlines(self, seen: Measured) -> None:
        """Write those of a frame with droplets, and of the first in any case."""
        if not seen.droplets and self._has_outlines:
            return
        self._has_outlines = True
        outlines = []
        for droplet, track in zip(seen.droplets, seen.tracks, strict=True):
            every = -(-len(droplet.outline) // MOST_VERTICES)
            vertices = droplet.outline[::every] * self._px
            outlines.append((track, 0, vertices, np.full_like(vertices, math.nan)))
        self._outlines.append(seen.frame.time_s, outlines)


def thumbnail_name(contact_frame: int, track_id: int, obstacle_id: int) -> str:
    """Return the name of the picture of a collision."""
    return f"frame{contact_frame:06d}-track{track_id}-obstacle{obstacle_id}.jpg"


def write_obstacles(folder: Path, obstacles: Floats) -> None:
    """Write circles as TOML that a user can correct."""
    lines = [
        "# Obstacles of this clip in pixels; the origin is the centre of the top left pixel,",
        "# y points down. Correct, add or remove lines and give the same command again.",
        "obstacles = [",
        *(f"  [{x:.3f}, {y:.3f}, {radius:.3f}]," for x, y, radius in obstacles),
        "]",
        "",
    ]
    # Nobody has corrected the earlier ones; left beside those of now they would seem to be.
    (folder / OBSTACLES).unlink(missing_ok=True)
    for name in (OBSTACLES_AS_FOUND, OBSTACLES):
        write_text(folder / name, "\n".join(lines))


def read_obstacles(path: Path) -> tuple[tuple[float, float, float], ...]:
    """Read circles that `write_obstacles` wrote and a user may have corrected."""
    circles = read_toml(path).get("obstacles")
    advice = "write it as obstacles = [[x, y, radius], …], in pixels"
    try:
        values = np.array(circles, dtype=np.float64).reshape(-1, 3)
    except (TypeError, ValueError):
        values = np.full((1, 3), math.nan)
    if circles is None or not np.all(np.isfinite(values)) or np.any(values[:, 2] <= 0.0):
        rule = "a list of centres and positive radii"
        raise InputError.of(f"{path}: obstacles", rule, circles, advice)
    return tuple((x, y, radius) for x, y, radius in values.tolist())


def fingerprint(source: Path, settings: VideoSettings) -> str:
    """Return what changes when a clip, or how it is measured, changes."""
    from pinchoff import __version__

    stamps = file_stamps(source)
    text = json.dumps([__version__, settings.model_dump(mode="json"), stamps], sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()


def file_stamps(source: Path) -> list[tuple[str, int, int]]:
    """Return name, size in bytes and time of change in ns of each file of a clip."""
    files = sorted(source.iterdir()) if source.is_dir() else [source]
    return [(file.name, file.stat().st_size, file.stat().st_mtime_ns) for file in files]


class _Result(Shape):
    fingerprint: str
    clip: str
    files: list[tuple[str, NonNegativeInt, int]]
    frames: NonNegativeInt
    duration_s: float
    overlay_fps: PositiveFloat | None
    tracks: NonNegativeInt
    plugs_per_s: float | None
    obstacles: list[tuple[float, float, PositiveFloat]]
    method: str
    scores: dict[str, float]
    thresholds: dict[str, Any]
    settings: dict[str, Any]
    warning: str
    checksums: dict[str, str] = Field(default_factory=dict)  # earlier releases wrote none


def finished_result(folder: Path, mark: str) -> dict[str, Any] | None:
    """Return what `RESULT` holds, if the clip was measured whole and just so; else None."""
    try:
        result = read_result(folder)
    except InputError:
        return None
    if result["fingerprint"] != mark:
        return None
    checksums = result.get("checksums", {})
    whole = all(is_whole(folder / name, checksums) for name in TABLES)
    return result if whole else None  # else it is damaged, and measured again


def read_result(folder: Path) -> dict[str, Any]:
    """Return what `RESULT` holds; refuse a folder without it, or with a damaged one."""
    advice = "give DIR/clips/NAME, as pinchoff video wrote it, or measure the clip again"
    if not (folder / RESULT).is_file():
        raise InputError.of(str(folder), "the folder of a measured clip", "none", advice)
    rule = "what pinchoff video wrote of a clip"
    result = read_record(folder / RESULT, _Result, rule, advice)
    try:
        VideoSettings(**result["settings"])
    except InputError as error:
        raise InputError.of(str(folder / RESULT), rule, str(error), advice) from None
    return result


def write_result(folder: Path, result: dict[str, Any]) -> None:
    """Write `RESULT`, the last of a clip's files: it says that the others are whole."""
    checksums = {name: checksum_of(folder / name) for name in TABLES}
    write_json(folder / RESULT, {**result, "checksums": checksums})
