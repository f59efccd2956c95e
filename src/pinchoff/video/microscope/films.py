"""Films: a scene through the microscope, frame by frame, and the clip with its truth."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.model.parameters import SAMPLE_INTERVAL, Parameters
from pinchoff.model.simulation import simulate
from pinchoff.support.errors import InputError
from pinchoff.video.encounters import Laboratory, encounter_table, write_encounters
from pinchoff.video.microscope.appearance import Microscope
from pinchoff.video.microscope.passages import Passage
from pinchoff.video.microscope.scenes import Scene
from pinchoff.video.microscope.truth import scene_encounters
from pinchoff.video.writing import ClipWriter, require_video_extra

if TYPE_CHECKING:
    import pandas as pd

Pixels = NDArray[np.uint8]

_SHUTTER_INSTANTS = 5  # scenes that are averaged while the shutter is open


class Film(NamedTuple):
    """What `film` wrote.

    Attributes
    ----------
    clip, truth : Path
        The video, and the table of its collisions.
    frame_count : int
    collisions : DataFrame
        The table.
    """

    clip: Path
    truth: Path
    frame_count: int
    collisions: pd.DataFrame


def passage_of(parameters: Parameters, microscope: Microscope, laboratory: Laboratory) -> Passage:
    """Simulate a collision and give it the size and speed that it has under the microscope.

    Daughters are followed in any case: otherwise they would stop to be droplets in view.

    Parameters
    ----------
    parameters : Parameters
    microscope : Microscope
    laboratory : Laboratory
        Its obstacle radius, viscosity and surface tension are all known.

    Raises
    ------
    SimulationError
        A guard stopped the run.
    InputError
        The run ends so early that a droplet has its obstacle still before it.

    Examples
    --------
    >>> from pinchoff import Parameters
    >>> from pinchoff.video.encounters import Laboratory
    >>> from pinchoff.video.microscope import Microscope
    >>> camera = Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = passage_of(Parameters(simulation_capillary_number=25), camera, laboratory)
    >>> round(run.unit_px, 1), round(run.unit_s, 2)  # D0 in pixels and t0 in seconds
    (91.1, 0.47)
    """
    run = simulate(parameters.replace(follow_daughters=True), outlines=SAMPLE_INTERVAL)
    assert run.outlines is not None
    diameter_um = parameters.size_ratio * laboratory.known("obstacle_radius_um")
    tension, viscosity = (
        laboratory.known(name) for name in ("surface_tension_mN_m", "viscosity_mPa_s")
    )
    speed_mm_s = parameters.capillary_number * tension / viscosity * 1e3
    unit_s = diameter_um * 1e-3 / speed_mm_s
    passage = Passage(run.outlines, diameter_um / microscope.pixel_size_um, unit_s)
    if passage.ends_before_obstacle:
        rule, advice = "long enough for droplets to pass the obstacle", "raise it"
        raise InputError.of("time_limit", rule, parameters.time_limit, advice)
    return passage


def truth_of(clip: Path) -> Path:
    """Return the name of the table with the truth about a drawn clip.

    Examples
    --------
    >>> truth_of(Path("film.mp4")).name
    'film.truth.parquet'
    """
    return clip.with_suffix(".truth.parquet")


def frames(scene: Scene, microscope: Microscope, frame_count: int) -> Iterator[Pixels]:
    """Draw a scene, frame by frame.

    Yields
    ------
    ndarray of uint8, shape (height, width, 3)
        Red, green and blue.

    Examples
    --------
    >>> from pinchoff import Parameters
    >>> from pinchoff.video.encounters import Laboratory
    >>> from pinchoff.video.microscope import Microscope, lane_scene
    >>> camera = Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = passage_of(Parameters(simulation_capillary_number=25), camera, laboratory)
    >>> scene, frame_count = lane_scene([run], camera)
    >>> next(frames(scene, camera, frame_count)).shape
    (300, 480, 3)
    """
    require_video_extra("microscope")
    from pinchoff.video.microscope.drawing import Canvas

    canvas = Canvas(microscope, scene.obstacles, frame_count)
    for index in range(frame_count):
        yield canvas.draw(index, _instants(scene, microscope, index))


def _instants(scene: Scene, microscope: Microscope, index: int) -> list[list[NDArray[np.float64]]]:
    open_for = microscope.exposure
    shifts: Sequence[float] = [0.0]
    if open_for > 0.0:
        shifts = (np.linspace(-0.5, 0.5, _SHUTTER_INSTANTS) * open_for).tolist()
    return [
        [d.vertices for d in scene.droplets_at((index + s) / microscope.fps, microscope.size)]
        for s in shifts
    ]


def film(
    scene: Scene,
    path: str | os.PathLike[str],
    frame_count: int,
    *,
    microscope: Microscope | None = None,
    laboratory: Laboratory | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Film:
    """Write a scene as an H.264 clip, and the truth about its collisions beside it.

    Parameters
    ----------
    scene : Scene
        What `lane_scene` arranged, or one of your own.
    path : path
        The clip, ``.mp4``; the truth is ``NAME.truth.parquet`` in the same folder, a collisions
        table with source "film". Both appear when they are complete, the truth first.
    frame_count : int
    microscope : Microscope, optional
    laboratory : Laboratory, optional
        For the capillary number and the normalized numbers of the truth.
    progress : callable, optional
        Called after every frame with the frames done and the frames in all.

    Returns
    -------
    Film

    Raises
    ------
    InputError
        The name does not end in ``.mp4``, or PyAV or OpenCV is not installed.

    Examples
    --------
    >>> from pinchoff import Parameters
    >>> from pinchoff.video.encounters import Laboratory
    >>> from pinchoff.video.microscope import Microscope, lane_scene
    >>> camera = Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = passage_of(Parameters(simulation_capillary_number=25), camera, laboratory)
    >>> scene, frame_count = lane_scene([run], camera)
    >>> clip, truth, *_ = film(scene, "film.mp4", frame_count, microscope=camera)
    >>> clip.name, truth.name
    ('film.mp4', 'film.truth.parquet')
    """
    look = microscope or Microscope()
    clip = Path(path)
    truth = truth_of(clip)
    encounters = scene_encounters(scene, look, frame_count)
    table = encounter_table(encounters, laboratory or Laboratory(), "film", clip.stem)
    with ClipWriter(clip, look.size, look.fps, look.crf) as writer:
        for done, pixels in enumerate(frames(scene, look, frame_count), start=1):
            writer.append(pixels)
            if progress is not None:
                progress(done, frame_count)
        write_encounters(table, truth)
    return Film(clip, truth, frame_count, table)
