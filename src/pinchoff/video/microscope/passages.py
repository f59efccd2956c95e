"""A droplet that passes an obstacle, at any time: a run of the engine, placed in the image."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pinchoff import _core
from pinchoff.model.outlines import Outline, Outlines

Floats = NDArray[np.float64]


_AT_REST = 0.02  # v_f∞: slower ones stay where they are


class PlacedDroplet(NamedTuple):
    """One droplet at one time, in the image.

    Attributes
    ----------
    passage : int
        Number of the passage in its scene.
    droplet_id : int
        As in the run.
    vertices : ndarray, shape (n, 2)
        x and y, pixels; the origin is the centre of the top left pixel, y points down.
    """

    passage: int
    droplet_id: int
    vertices: Floats


@dataclass(frozen=True, eq=False)
class Passage:
    """A run of the engine with one obstacle, placed in the image and in time.

    Before the run begins and after it ends its droplets glide on at the velocity that they have
    there, so that they come into view and leave it.

    Parameters
    ----------
    outlines : Outlines
        The run, D0 and t0.
    unit_px : float
        D0 in pixels.
    unit_s : float
        t0 in seconds.
    origin : (float, float)
        Where the run's origin lies, pixels.
    start_s : float
        When the run begins in the clip, seconds.
    angle : float
        Direction of the flow in the image, radians from x towards y, that is clockwise as seen.
    """

    outlines: Outlines
    unit_px: float
    unit_s: float
    origin: tuple[float, float] = (0.0, 0.0)
    start_s: float = 0.0
    angle: float = 0.0

    @cached_property
    def _by_frame(self) -> list[dict[int, Outline]]:
        return [{droplet.droplet_id: droplet for droplet in frame} for frame in self.outlines]

    @cached_property
    def _at_first(self) -> list[Outline]:
        # The engine starts a droplet at rest; one record later the flow carries it.
        return _gliding(self._by_frame[min(1, len(self._by_frame) - 1)])

    @cached_property
    def _at_last(self) -> list[Outline]:
        return _gliding(self._by_frame[-1])

    @cached_property
    def obstacles(self) -> Floats:
        """Centre x, y and radius of the run's obstacles, pixels: (M, 3)."""
        circles = self.outlines.obstacles
        return np.column_stack([self.to_image(circles[:, :2]), circles[:, 2] * self.unit_px])

    def to_image(self, points: Floats) -> Floats:
        """Return points of the run, (n, 2) in D0 with y up, in pixels with y down."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        along, up = points[:, 0] * self.unit_px, points[:, 1] * self.unit_px
        placed = np.empty_like(points)
        placed[:, 0] = self.origin[0] + cosine * along + sine * up
        placed[:, 1] = self.origin[1] + sine * along - cosine * up
        return placed

    def droplets_at(self, time_s: float) -> list[tuple[int, Floats]]:
        """Return (droplet_id, vertices (n, 2) in pixels) of every droplet at a time of the clip."""
        return [(number, self.to_image(r)) for number, r in self.in_run(time_s)]

    def in_run(self, time_s: float) -> list[tuple[int, Floats]]:
        """Return the same in D0, as the run has it."""
        times = self.outlines.times
        time = (time_s - self.start_s) / self.unit_s
        first = min(1, len(times) - 1)
        if time <= times[first]:
            return [(d.droplet_id, _glided(d, time - times[first])) for d in self._at_first]
        if time >= times[-1]:
            return [(d.droplet_id, _glided(d, time - times[-1])) for d in self._at_last]
        k = int(np.searchsorted(times, time, side="right")) - 1
        share = (time - times[k]) / (times[k + 1] - times[k])
        after = self._by_frame[k + 1]
        return [
            (number, _between(droplet, after.get(number), share, time - times[k]))
            for number, droplet in self._by_frame[k].items()
        ]

    @property
    def ends_before_obstacle(self) -> bool:
        """Whether droplets that glide on from the end of the run would go through an obstacle."""
        for droplet in self._at_last:
            speed = float(np.hypot(*droplet.velocities))
            if speed < _AT_REST:
                continue
            along = droplet.velocities / speed
            for x, y, radius in self.outlines.obstacles:
                before = np.array([x, y]) - droplet.vertices
                ahead = before @ along > 0.0
                beside = np.abs(before @ np.array([-along[1], along[0]]))
                if np.any(ahead & (beside < radius)):
                    return True
        return False

    def moved(self, start_s: float, origin: tuple[float, float], angle: float) -> Passage:
        """Return the same run at another time and place."""
        return replace(self, start_s=start_s, origin=origin, angle=angle)


def _gliding(droplets: dict[int, Outline]) -> list[Outline]:
    """Return droplets as a whole at the velocity of their centres of mass, (2,)."""
    return [
        d._replace(velocities=np.array(_core.centroid_velocity(d.vertices, d.velocities)))
        for d in droplets.values()
    ]


def _glided(droplet: Outline, time: float) -> Floats:
    return droplet.vertices + droplet.velocities * time


def _between(droplet: Outline, after: Outline | None, share: float, time: float) -> Floats:
    # A droplet that the next record lacks has broken in between: until then it goes on.
    if after is None or len(after.vertices) != len(droplet.vertices):
        return _glided(droplet, time)
    return (1.0 - share) * droplet.vertices + share * after.vertices
