"""Scenes that tests draw: discs on straight lines, whose every measure is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core
from pinchoff.model.outlines import Outlines
from pinchoff.video.microscope import Microscope, Passage, Scene, frames
from pinchoff.video.reading import Frame


def _disc(radius: float, count: int = 128) -> np.ndarray:
    angles = 2 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _moving(shape, start, velocity, obstacle=None, fps=60.0):
    """Let an outline glide: `start` in pixels at frame 0, `velocity` in pixels a frame."""
    end = np.asarray(start) + 600.0 * np.asarray(velocity)
    return _along(shape, [start, end], [0.0, 600.0], obstacle, fps)


def _along(shape, places, frame_numbers, obstacle=None, fps=60.0):
    """Let an outline pass through places, (n, 2) in pixels, at times given in frames."""
    circles = [(1e6, 1e6, 1.0)] if obstacle is None else [obstacle]
    # Passages have y up; images have it down.
    flip = np.array([1.0, -1.0])
    times = np.array(frame_numbers) / fps
    steps = np.diff(places, axis=0) / np.diff(times)[:, None] * flip
    records = []
    for place, step in zip(places, [*steps, steps[-1]], strict=True):
        vertices = (np.asarray(shape) + place) * flip
        records.append([(0, 0, vertices, np.tile(step, (len(vertices), 1)))])
    mirrored = [[x, -y, r] for x, y, r in circles]
    return Passage(Outlines.from_frames(times, records, mirrored, {}), 1.0, 1.0)


def _sliding(shape, radius, below, obstacle, angle=0.0, speed=3.0, fps=60.0):
    """Let a disc run against an obstacle, off its centre, then slide aside and past it."""
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    nearest = radius + obstacle[2] + 0.5
    ahead = math.sqrt(nearest**2 - below**2)
    # The first stretch only tells the speed, as in a run of the engine, which starts at rest.
    turns = np.array(
        [(-93.0, below), (-90.0, below), (-ahead, below), (-ahead, nearest), (120.0, nearest)]
    )
    lengths = np.hypot(*np.diff(turns, axis=0).T)
    places = np.array(obstacle[:2]) + turns[:, :1] * along + turns[:, 1:] * across
    return _along(shape, places, np.concatenate([[0.0], np.cumsum(lengths / speed)]), obstacle, fps)


def _merging(one, other, merged, starts, velocity, frame, obstacle, fps=60.0):
    """Let two outlines glide until a frame from which on they are one."""
    flip = np.array([1.0, -1.0])
    step = np.asarray(velocity) * flip * fps
    middle = np.average(starts, axis=0, weights=[_core.area(one), _core.area(other)])

    def record(number, shape, start, time):
        vertices = (np.asarray(shape) + start) * flip + step * time
        return (number, 0, vertices, np.tile(step, (len(vertices), 1)))

    times = np.array([0.0, 1.0, frame - 1.0, frame, frame + 60.0]) / fps
    parts = [(0, one, starts[0]), (1, other, starts[1])]
    frames = [[record(*part, t) for part in parts] for t in times[:3]]
    frames += [[record(2, merged, middle, t)] for t in times[3:]]
    mirrored = [[obstacle[0], -obstacle[1], obstacle[2]]]
    return Passage(Outlines.from_frames(times, frames, mirrored, {}), 1.0, 1.0)


def _drawn(scene: Scene, microscope: Microscope, count: int) -> list[Frame]:
    """Return frames as a reader would give them, without a file between."""
    import cv2

    found = []
    for number, pixels in enumerate(frames(scene, microscope, count)):
        yuv = cv2.cvtColor(pixels, cv2.COLOR_RGB2YUV)
        half = (microscope.width // 2, microscope.height // 2)
        chroma = cv2.resize(yuv[:, :, 1:], half, interpolation=cv2.INTER_AREA)
        luma = np.ascontiguousarray(yuv[:, :, 0])
        time = number / microscope.fps
        found.append(Frame(number, time, luma, np.ascontiguousarray(np.moveaxis(chroma, 2, 0))))
    return found


def _symmetry_of_disc(radius: float, offset: float) -> float:
    """Return S of a disc whose centre is `offset` from the line, from the circular segment."""
    if abs(offset) >= radius:
        return 0.0
    h = abs(offset)
    segment = radius**2 * math.acos(h / radius) - h * math.sqrt(radius**2 - h**2)
    return 2.0 * segment / (math.pi * radius**2)


@pytest.fixture
def microscope() -> Microscope:
    """A microscope that is quick to draw with."""
    return Microscope(width=240, height=180, pixel_size_um=5.0, noise=2.0, unevenness=0.1)


@pytest.fixture
def disc():
    """Function (radius, count) -> (count, 2) vertices round the origin."""
    return _disc


@pytest.fixture
def moving():
    """Function (shape, start, velocity, obstacle) -> Passage, in pixels and frames."""
    return _moving


@pytest.fixture
def sliding():
    """Function (shape, radius, below, obstacle, angle, speed, fps) -> Passage."""
    return _sliding


@pytest.fixture
def merging():
    """Function (one, other, merged, starts, velocity, frame, obstacle) -> Passage."""
    return _merging


@pytest.fixture
def drawn():
    """Function (scene, microscope, count) -> list of Frame."""
    return _drawn


@pytest.fixture
def symmetry_of_disc():
    """Function (radius, offset) -> S."""
    return _symmetry_of_disc
