"""Collisions as a short script finds them: one threshold, filled regions, links by overlap.

What `pinchoff video` is compared with in docs/video.md. It is told where the obstacles are, reads a
clip into memory and takes Otsu's threshold of the difference from the median frame; regions that
overlap from frame to frame are one droplet, one that overlaps two has broken. `examples/
video_accuracy.py --plain` measures its errors.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes
from skimage.color import rgb2gray
from skimage.filters import threshold_otsu
from skimage.measure import find_contours, label, regionprops

from pinchoff.video.encounters import (
    CONTACT_DISTANCE_UM,
    RELEASE,
    Encounter,
    gap_to_circle,
    thinnest_neck,
)

Floats = NDArray[np.float64]

SMALLEST_PX = 100  # pixels: smaller regions are left out
VELOCITY_FRAMES = 3  # between the two centres that give the velocity


class _Droplet:
    """One region, followed by overlap."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.centres: list[Floats] = []
        self.passed: set[int] = set()
        self.meeting: dict[str, Any] | None = None


def measure_plainly(clip: Path, obstacles: Floats, pixel_um: float) -> list[Encounter]:
    """Return the collisions of a clip.

    Parameters
    ----------
    clip : Path
    obstacles : ndarray, shape (M, 3)
        Centre x, y and radius, pixels.
    pixel_um : float
        Side of a pixel, µm.
    """
    with av.open(str(clip)) as container:
        rate = float(container.streams.video[0].average_rate)
        frames = [
            (255 * rgb2gray(frame.to_ndarray(format="rgb24"))).astype(np.uint8)
            for frame in container.decode(video=0)
        ]
    background = np.median(frames[:: max(1, len(frames) // 40)], axis=0)
    level = threshold_otsu(np.stack([background - frame for frame in frames[::40]]))
    finder = _Finder(obstacles, pixel_um, rate)
    for number, frame in enumerate(frames):
        finder.step(number, background - frame, level)
    return finder.over


class _Finder:
    def __init__(self, obstacles: Floats, pixel_um: float, rate: float) -> None:
        self._obstacles, self._px, self._rate = obstacles, pixel_um, rate
        self._before: NDArray[np.int32] | None = None
        self._droplets: dict[int, _Droplet] = {}  # by the label of the frame before
        self._count = 0
        self.over: list[Encounter] = []

    def step(self, frame: int, dark: Floats, level: float) -> None:
        mask = binary_fill_holes(dark > level)
        labels = label(mask)
        regions = [each for each in regionprops(labels) if each.area >= SMALLEST_PX]
        parents = {each.label: self._overlapping(labels, each) for each in regions}
        droplets: dict[int, _Droplet] = {}
        for region in regions:
            mothers = parents[region.label]
            sisters = [k for k, m in parents.items() if mothers and m == mothers]
            if len(mothers) == 1 and len(sisters) == 1:
                droplets[region.label] = self._droplets[mothers[0]]
                continue
            droplets[region.label] = _Droplet(self._count)
            self._count += 1
            if len(mothers) == 1:
                mother = self._droplets[mothers[0]]
                droplets[region.label].passed = set(mother.passed)
                if region.label == sisters[0] and mother.meeting is not None:
                    areas = sorted(r.area for r in regions if r.label in sisters)[-2:]
                    self._close(mother, "broke", frame, areas)
        for region in regions:
            droplet = droplets[region.label]
            droplet.centres.append(np.array(region.centroid[::-1]))
            self._look(droplet, frame, region, dark, level)
        self._before, self._droplets = labels, droplets

    def _overlapping(self, labels: NDArray[np.int32], region: Any) -> list[int]:
        if self._before is None:
            return []
        under = self._before[region.slice][region.image]
        return [k for k in np.unique(under).tolist() if k in self._droplets]

    def _look(self, droplet: _Droplet, frame: int, region: Any, dark: Floats, level: float) -> None:
        away = np.hypot(*(self._obstacles[:, :2] - droplet.centres[-1]).T) - self._obstacles[:, 2]
        obstacle = int(np.argmin(away))
        if away[obstacle] > 2.0 * region.axis_major_length and droplet.meeting is None:
            return
        outline = self._outline(region, dark, level)
        if droplet.meeting is None:
            gap = gap_to_circle(outline, self._obstacles[obstacle]) * self._px
            enough = len(droplet.centres) > VELOCITY_FRAMES
            if gap <= CONTACT_DISTANCE_UM and obstacle not in droplet.passed and enough:
                droplet.passed.add(obstacle)
                moved = droplet.centres[-1] - droplet.centres[-1 - VELOCITY_FRAMES]
                speed = self._px * 1e-3 * self._rate / VELOCITY_FRAMES
                droplet.meeting = {
                    "obstacle": obstacle,
                    "frame": frame,
                    "outline": outline,
                    "velocity": moved * speed,
                    "necks": [],
                }
        if droplet.meeting is not None:
            droplet.meeting["necks"].append(thinnest_neck(outline)[0])
            circle = self._obstacles[droplet.meeting["obstacle"]]
            if gap_to_circle(outline, circle) > RELEASE * circle[2]:
                self._close(droplet, "slipped", frame, [])

    @staticmethod
    def _outline(region: Any, dark: Floats, level: float) -> Floats:
        top, left, bottom, right = region.bbox
        edge = dark[top:bottom, left:right]
        alone = np.where(region.image, np.maximum(edge, level + 1.0), np.minimum(edge, level))
        contour = max(find_contours(np.pad(alone, 1), level), key=len)
        return np.ascontiguousarray(contour[:-1, ::-1] + (left - 1, top - 1))

    def _close(self, droplet: _Droplet, outcome: str, frame: int, areas: list[float]) -> None:
        meeting, px = droplet.meeting, self._px
        assert meeting is not None
        droplet.meeting = None
        necks = np.array(meeting["necks"])
        finite = necks[np.isfinite(necks)]
        x, y, radius = (self._obstacles[meeting["obstacle"]] * px).tolist()
        broke = outcome == "broke"
        self.over.append(
            Encounter(
                obstacle=(x, y, radius),
                outline=meeting["outline"] * px,
                velocity=tuple(meeting["velocity"].tolist()),
                contact_frame=meeting["frame"],
                end_frame=frame,
                contact_time_s=meeting["frame"] / self._rate,
                outcome=outcome,
                breakup_frame=frame if broke else math.nan,
                breakup_time_s=frame / self._rate if broke else math.nan,
                daughter_areas=tuple(a * px**2 for a in areas) if broke else (math.nan, math.nan),
                neck=float(finite.min()) * px if finite.size else math.nan,
                breakup_neck=float(necks[-1]) * px if broke else math.nan,
                maximum_shape_parameter=math.nan,
                reject_reason="",
                track_id=droplet.number,
                obstacle_id=meeting["obstacle"],
            )
        )
