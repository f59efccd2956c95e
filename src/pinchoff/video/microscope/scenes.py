"""Scenes: which droplets pass which obstacles in a clip, and when, clear of one another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.microscope.appearance import Microscope
from pinchoff.video.microscope.passages import Passage, PlacedDroplet

Floats = NDArray[np.float64]

GAP_PX = 14.0
"""Least distance between the boxes round two droplets, pixels."""

_STAGGER = 0.08  # of the length in view: neighbouring obstacles stand this far apart along the flow
_MOST_FRAMES = 2_000  # a droplet that takes longer to pass stays at its obstacle
_STAY_SHOWN = 300  # frames for which such a droplet is shown


@dataclass(frozen=True, eq=False)
class Scene:
    """Obstacles and the droplets that pass them.

    Parameters
    ----------
    passages : tuple of Passage
    """

    passages: tuple[Passage, ...]

    @property
    def obstacles(self) -> Floats:
        """Centre x, y and radius of each obstacle, pixels: (M, 3)."""
        circles = [passage.obstacles for passage in self.passages]
        if not circles:
            return np.empty((0, 3))
        return np.unique(np.round(np.concatenate(circles), 6), axis=0)

    def droplets_at(self, time_s: float, size: tuple[int, int]) -> list[PlacedDroplet]:
        """Return the droplets that are wholly or partly in view of an image, (width, height)."""
        placed, corner = [], np.array(size) - 0.5
        for number, passage in enumerate(self.passages):
            for droplet_id, vertices in passage.droplets_at(time_s):
                low, high = vertices.min(axis=0), vertices.max(axis=0)
                if (high > -0.5).all() and (low < corner).all():
                    placed.append(PlacedDroplet(number, droplet_id, vertices))
        return placed


class _Slot(NamedTuple):
    """A passage that has got its place: the frames it is in view, and its boxes then."""

    first_frame: int
    boxes: Floats  # (frames, 4): left, top, right, bottom along and across the flow, pixels
    stays: bool


def lane_scene(
    passages: Sequence[Passage],
    microscope: Microscope,
    *,
    lanes: int | None = None,
    angle: float = 0.0,
    gap_px: float = GAP_PX,
    seed: int = 0,
) -> tuple[Scene, int]:
    """Let runs pass one obstacle in each of several lanes, as many as fit, one after the other.

    Parameters
    ----------
    passages : sequence of Passage
        Runs round the origin with one obstacle each; where and when they are is chosen here. A
        droplet that stays at its obstacle closes its lane; when all are closed, what is left of
        such runs is left out.
    microscope : Microscope
    lanes : int, optional
        How many obstacles stand across the flow; by default as many as there is room for.
    angle : float, optional
        Direction of the flow, radians from x towards y.
    gap_px : float, optional
        Least distance between the boxes round two droplets, pixels.
    seed : int, optional
        Of the pauses between droplets.

    Returns
    -------
    scene : Scene
    frame_count : int
        Frames until the last droplet has left.

    Raises
    ------
    InputError
        There are no passages.

    Examples
    --------
    >>> from pinchoff import Parameters
    >>> from pinchoff.video.encounters import Laboratory
    >>> from pinchoff.video.microscope import Microscope, passage_of
    >>> camera = Microscope(width=480, height=300)
    >>> laboratory = Laboratory(
    ...     obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    ... )
    >>> run = passage_of(Parameters(simulation_capillary_number=25), camera, laboratory)
    >>> scene, frame_count = lane_scene([run, run], camera)
    >>> len(scene.passages), len(scene.obstacles)
    (2, 1)
    """
    if not passages:
        raise InputError.of("passages", "one or more", "none", "give runs of the engine")
    random = np.random.default_rng(seed)
    along, across = _extent(microscope, angle)
    tracks = [_track(passage, microscope.fps, along) for passage in passages]
    count = lanes or _lane_count(tracks, across, gap_px)
    centres = ((np.arange(count) + 0.5) / count * across - across / 2).tolist()
    shifts = (along * _STAGGER * np.where(np.arange(count) % 2, 1.0, -1.0) * (count > 1)).tolist()
    slots: list[list[_Slot]] = [[] for _ in range(count)]
    placed, end = [], 0
    # What stays at its obstacle closes a lane: so it comes last.
    for k in sorted(range(len(passages)), key=lambda k: tracks[k].stays):
        track = tracks[k]
        open_lanes = [lane for lane in range(count) if not (slots[lane] and slots[lane][-1].stays)]
        if not open_lanes:
            break
        lane = min(open_lanes, key=lambda k: slots[k][-1].first_frame if slots[k] else -1)
        here = track.boxes + np.array([shifts[lane], centres[lane]] * 2)
        earliest = slots[lane][-1].first_frame if slots[lane] else 0
        earliest += int(random.integers(1, 12))
        near = [slot for j in (lane - 1, lane, lane + 1) if 0 <= j < count for slot in slots[j]]
        first = _first_free(here, near, earliest, gap_px)
        slots[lane].append(_Slot(first, here, track.stays))
        end = max(end, first + min(len(here), _STAY_SHOWN if track.stays else len(here)))
        cosine, sine = math.cos(angle), math.sin(angle)
        origin = (
            (microscope.width - 1) / 2 + cosine * shifts[lane] - sine * centres[lane],
            (microscope.height - 1) / 2 + sine * shifts[lane] + cosine * centres[lane],
        )
        start_s = (first - track.first_frame) / microscope.fps
        placed.append(passages[k].moved(start_s, origin, angle))
    return Scene(tuple(placed)), end


def _extent(microscope: Microscope, angle: float) -> tuple[float, float]:
    """Return how far the image reaches along the flow, and across it through its middle."""
    cosine, sine = max(abs(math.cos(angle)), 1e-9), max(abs(math.sin(angle)), 1e-9)
    width, height = microscope.size
    return width * cosine + height * sine, min(width / sine, height / cosine)


def _track(passage: Passage, fps: float, along: float) -> _Slot:
    """Return where a passage is while in view; frames are counted from the run's start."""
    reach = (0.5 + 2 * _STAGGER) * along

    at_origin = passage.moved(0.0, (0.0, 0.0), 0.0)

    def box(frame: int) -> tuple[float, float, float, float]:
        points = np.concatenate([r for _, r in at_origin.droplets_at(frame / fps)])
        return (*points.min(axis=0).tolist(), *points.max(axis=0).tolist())

    first = 0
    while box(first)[2] > -reach and first > -_MOST_FRAMES:
        first -= 1
    found = [box(first)]
    while found[-1][0] < reach and len(found) < _MOST_FRAMES:
        found.append(box(first + len(found)))
    return _Slot(first, np.array(found), len(found) == _MOST_FRAMES)


def _lane_count(tracks: Sequence[_Slot], across: float, gap: float) -> int:
    widest = max(float((track.boxes[:, 3] - track.boxes[:, 1]).max()) for track in tracks)
    return max(1, int(across / (widest + 2 * gap)))


def _first_free(boxes: Floats, others: Sequence[_Slot], earliest: int, gap: float) -> int:
    """Return the first frame from `earliest` on at which nothing comes near to anything."""
    frame = earliest
    while any(_meet(boxes, frame, other, gap) for other in others):
        frame += 1
    return frame


def _meet(boxes: Floats, first_frame: int, other: _Slot, gap: float) -> bool:
    first = max(first_frame, other.first_frame)
    last = min(first_frame + len(boxes), other.first_frame + len(other.boxes))
    if first >= last:
        return False
    a = boxes[first - first_frame : last - first_frame]
    b = other.boxes[first - other.first_frame : last - other.first_frame]
    apart = (a[:, :2] > b[:, 2:] + gap) | (b[:, :2] > a[:, 2:] + gap)
    return bool(np.any(~apart.any(axis=1)))
