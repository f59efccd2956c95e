"""Look first: one picture of what each method finds in some frames of a clip."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.files import written_aside
from pinchoff.video.background import sample
from pinchoff.video.choice import Choice, choose
from pinchoff.video.droplets import Droplet
from pinchoff.video.methods.function import SegmentFunction
from pinchoff.video.obstacles import is_obstacle, obstacles_of
from pinchoff.video.overlay import CUT, OBSTACLE, OUTLINE, TOUCHING, rgb_of
from pinchoff.video.reading import Frame
from pinchoff.video.scale import clip_of, scaled
from pinchoff.video.settings import VideoSettings
from pinchoff.video.trials import Trial

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float64]

_MOST_FRAMES = 3
_TILE_WIDTH = 480  # pixels
_CAPTION = 46  # height of a caption, pixels
_FRACTION_BITS = 4  # of OpenCV's coordinates
_CHOSEN = OUTLINE


def write_preview(
    clip: str | os.PathLike[str],
    path: str | os.PathLike[str],
    settings: VideoSettings,
    segment: SegmentFunction | None = None,
) -> Choice:
    """Draw what each method finds in some frames of a clip, side by side; measure nothing.

    Parameters
    ----------
    clip : path
    path : path
        The picture, ``.png``: a column for each method with its score below, the chosen one
        framed; outlines green, orange where droplets touch, grey where they are cut; obstacles
        blue.
    settings : VideoSettings
    segment : callable, optional
        As in `measure_videos`.

    Returns
    -------
    Choice
        With the scores.

    Raises
    ------
    InputError
        The clip cannot be read.
    """
    source = clip_of(Path(clip), settings)
    settings, _ = scaled(source, settings)
    choice = choose(sample(source.frames(sparse=True)), settings, segment)
    obstacles = obstacles_of(choice.background, settings)
    columns = [_column(choice, trial, obstacles) for trial in choice.trials]
    height = max(len(column) for column in columns)
    padded = [
        cv2.copyMakeBorder(
            column, 0, height - len(column), 0, 0, cv2.BORDER_CONSTANT, value=(255, 255, 255)
        )
        for column in columns
    ]
    picture = cv2.cvtColor(np.concatenate(padded, axis=1), cv2.COLOR_RGB2BGR)
    with written_aside(Path(path)) as unfinished:
        unfinished.write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    return choice


def _column(choice: Choice, trial: Trial, obstacles: Floats) -> Pixels:
    """Return the frames of one method below each other, its caption above."""
    chosen = trial is choice.trial
    places = np.linspace(0, len(choice.frames) - 1, min(_MOST_FRAMES, len(choice.frames)))
    frames = [choice.frames[round(k)] for k in places.tolist()]
    tiles = []
    for frame in frames:
        found = trial.segmenter.droplets(frame)
        shown = [droplet for droplet in found if not is_obstacle(droplet, obstacles)]
        tiles.append(_tile(frame, shown, obstacles))
    score = choice.scores()[trial.method]
    head = f"{trial.method}: score {score:.2f}" + (", chosen" if chosen else "")
    count = trial.quality.droplets
    one = len(trial.found) == 1 < len(choice.frames)
    seen = (
        f"{count:.0f} whole droplets in one frame" if one else f"{count:.1f} whole droplets a frame"
    )
    told = f"{seen}; method {trial.method}"
    caption = np.full((_CAPTION, _TILE_WIDTH, 3), 255, dtype=np.uint8)
    _write(caption, head, 18, 0.55)
    _write(caption, told, 38, 0.42)
    column = np.concatenate([caption, *tiles])
    colour = _CHOSEN if chosen else (255, 255, 255)
    framed: Pixels = cv2.copyMakeBorder(column, 4, 4, 4, 4, cv2.BORDER_CONSTANT, value=colour)
    return framed


def _write(image: Pixels, text: str, y: int, size: float) -> None:
    cv2.putText(image, text, (6, y), cv2.FONT_HERSHEY_SIMPLEX, size, (0, 0, 0), 1, cv2.LINE_AA)


def _tile(frame: Frame, droplets: Sequence[Droplet], obstacles: Floats) -> Pixels:
    image = rgb_of(frame)
    scale = _TILE_WIDTH / image.shape[1]
    how = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    image = cv2.resize(image, (_TILE_WIDTH, max(1, round(scale * image.shape[0]))), None, 0, 0, how)
    for droplet in droplets:
        colour = CUT if droplet.cut else OUTLINE if droplet.group < 0 else TOUCHING
        points = _fixed((droplet.outline + 0.5) * scale - 0.5)
        cv2.polylines(image, [points], True, colour, 1, cv2.LINE_AA, _FRACTION_BITS)
    for x, y, radius in obstacles:
        centre = _fixed((np.array([x, y]) + 0.5) * scale - 0.5)
        reach = round(radius * scale * 2**_FRACTION_BITS)
        at = (int(centre[0]), int(centre[1]))
        cv2.circle(image, at, reach, OBSTACLE, 1, cv2.LINE_AA, _FRACTION_BITS)
    tile: Pixels = np.ascontiguousarray(image)
    return tile


def _fixed(points: Floats) -> NDArray[np.int32]:
    fixed: NDArray[np.int32] = np.rint(points * 2**_FRACTION_BITS).astype(np.int32)
    return fixed
