"""What was measured, for ImageJ, TrackMate and trackpy.

ImageJ counts from the corner of the top left pixel, everything here from its centre; ImageJ counts
slices from 1, everything here frames from 0.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pinchoff.model.outlines import Outlines
from pinchoff.support.errors import InputError
from pinchoff.support.files import write_csv, written_aside
from pinchoff.support.locks import held_folder
from pinchoff.video import clip_folder
from pinchoff.video.batch import CLIPS
from pinchoff.video.settings import VideoSettings

ROIS = "rois.zip"
TRACKPY = "tracks.csv"
TRACKMATE = "trackmate.csv"
"""Ends of the names of what is written for a clip."""

_CORNER = 0.5  # pixels from a pixel's corner to its centre
_DIGITS = "%.9g"


def measured_clips(folder: str | os.PathLike[str]) -> list[Path]:
    """Return the folders of measured clips: the one that is given, or all of a batch."""
    given = Path(folder)
    inside = given / CLIPS
    several = sorted(inside.iterdir()) if inside.is_dir() else []
    found = [place for place in [given, *several] if (place / clip_folder.RESULT).is_file()]
    if not found:
        advice = "give DIR, or DIR/clips/NAME, as pinchoff video wrote it"
        raise InputError.of(str(given), "the folder of a measured clip", "none", advice)
    return found


def exported_names(clips: list[Path]) -> list[str]:
    """Return the names of the files that `export_clip` writes for clips."""
    return [f"{clip.name}.{end}" for clip in clips for end in (ROIS, TRACKPY, TRACKMATE)]


def export_clip(clip: str | os.PathLike[str], out: str | os.PathLike[str]) -> list[Path]:
    """Write outlines and tracks of a measured clip for other tools.

    Parameters
    ----------
    clip : path
        Folder of a clip that `measure_videos` wrote, ``DIR/clips/NAME``.
    out : path
        Folder for three files, whose names begin with that of the clip: ``rois.zip``, outlines for
        ImageJ's ROI manager, named by track; ``tracks.csv``, as trackpy has them, with ``frame``,
        ``particle`` and ``x``, ``y``, ``area`` in pixels; ``trackmate.csv``, as TrackMate has its
        spots, in µm and s.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    InputError
        It is not the folder of a measured clip, or its files do not belong together.

    Examples
    --------
    >>> from pinchoff import Parameters, VideoSettings, measure_videos, microscope
    >>> from pinchoff.video.encounters import Laboratory
    >>> camera = microscope.Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = microscope.passage_of(
    ...     Parameters(simulation_capillary_number=25, offset=0.02), camera, laboratory
    ... )
    >>> scene, frame_count = microscope.lane_scene([run], camera)
    >>> film = microscope.film(scene, "film.mp4", frame_count, microscope=camera)
    >>> settings = VideoSettings(
    ...     pixel_size_um=camera.pixel_size_um, laboratory=laboratory, method="rings"
    ... )
    >>> measured = measure_videos([film.clip], "measured", settings, overlay=False, processes=1)
    >>> len(export_clip("measured/clips/film", "exported"))
    3
    """
    folder, target = Path(clip), Path(out)
    result = clip_folder.read_result(folder)
    settings = VideoSettings(**result["settings"])
    tracks = pd.read_parquet(folder / clip_folder.TRACKS)
    rois, trackpy, trackmate = (target / name for name in exported_names([folder]))
    with held_folder(target):
        _write_rois(rois, folder, tracks, settings)
        write_csv(trackpy, trackpy_table(tracks, settings.pixel_um), float_format=_DIGITS)
        write_csv(trackmate, trackmate_table(tracks), float_format=_DIGITS)
    return [rois, trackpy, trackmate]


def trackpy_table(tracks: pd.DataFrame, pixel_um: float) -> pd.DataFrame:
    """Return tracks, as in ``tracks.parquet``, with trackpy's names, in pixels and frames."""
    return pd.DataFrame(
        {
            "frame": tracks["frame"],
            "particle": tracks["track_id"],
            "x": tracks["x_um"] / pixel_um,
            "y": tracks["y_um"] / pixel_um,
            "area": tracks["area_um2"] / pixel_um**2,
            "time_s": tracks["time_s"],
            "x_um": tracks["x_um"],
            "y_um": tracks["y_um"],
            "area_um2": tracks["area_um2"],
            "cut": tracks["cut"].astype(int),
            "touching": tracks["touching"].astype(int),
        }
    )


def trackmate_table(tracks: pd.DataFrame) -> pd.DataFrame:
    """Return tracks, as in ``tracks.parquet``, with the names of TrackMate's spots, in µm and s."""
    return pd.DataFrame(
        {
            "LABEL": "ID" + tracks.index.astype(str),
            "ID": tracks.index,
            "TRACK_ID": tracks["track_id"],
            "QUALITY": 1.0,
            "POSITION_X": tracks["x_um"],
            "POSITION_Y": tracks["y_um"],
            "POSITION_Z": 0.0,
            "POSITION_T": tracks["time_s"],
            "FRAME": tracks["frame"],
            "RADIUS": np.sqrt(tracks["area_um2"] / math.pi),
            "AREA": tracks["area_um2"],
        }
    )


def _write_rois(path: Path, folder: Path, tracks: pd.DataFrame, settings: VideoSettings) -> None:
    import roifile

    outlines = Outlines.load(folder / clip_folder.OUTLINES)
    if not np.array_equal(outlines.droplet_id, tracks["track_id"]):
        got = f"{len(outlines.droplet_id)} outlines and {len(tracks)} places in tracks"
        advice = "measure the clip again"
        raise InputError.of(str(folder), "one measurement", got, advice)
    with written_aside(path) as unfinished:
        roifile.roiwrite(unfinished, _rois(outlines, tracks, settings), mode="w")


def _rois(outlines: Outlines, tracks: pd.DataFrame, settings: VideoSettings) -> Iterator[Any]:
    import roifile

    corner = np.array((settings.crop or (0, 0))[:2]) + _CORNER
    frames = tracks["frame"].to_numpy()
    for k, (frame, track) in enumerate(zip(frames, outlines.droplet_id, strict=True)):
        points = outlines.outline(k).vertices / settings.pixel_um + corner
        roi = roifile.ImagejRoi.frompoints(
            points.astype(np.float32), name=f"{frame:05d}-{track:04d}", position=int(frame)
        )
        roi.roitype = roifile.ROI_TYPE.POLYGON
        yield roi
