"""Spots: droplets that are darker all over than the fluid about them.

Dyed, fluorescent (in the negative) or small droplets show no rim. What is darker than the light
about it is a spot at each of several levels; a spot that is not convex is parted where it is
narrow. Of the spots that one droplet makes at several levels the one with the sharpest border
stays. Rays across the border find where brightness is halfway between both sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

from pinchoff import _core
from pinchoff.video.droplets import Droplet
from pinchoff.video.methods.surroundings import (
    LevelSegmenter,
    Surroundings,
    beyond,
    needed_levels,
    owners,
    shown_at,
    usual_noise,
)
from pinchoff.video.reading import Frame
from pinchoff.video.regions import (
    LEAST_CONTRAST,
    SAME,
    Border,
    Groups,
    Rectangle,
    Walk,
    border_of,
    closedness,
    compact_part,
    is_ground,
    leaves_view,
    one_a_droplet,
    part_below,
    seen_part,
    smoothed,
    without_dents,
)
from pinchoff.video.signal import Image, Signal
from pinchoff.video.standing import rows_of, standing_rows

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Pixels = NDArray[np.uint8]

_DENOISING = 1.0  # standard deviation of the filter, pixels
_LEVELS = 7  # of darkness, from the noise to nearly the darkest
_FAINTEST, _NEARLY = 2.0, 0.8  # times the least contrast, and of the darkest
_REACH = 0.25  # of the radius: how far rays go to both sides
_LEAST_REACH = 3.0  # pixels
_VIEW_PX = 4.0  # from a spot to the edge of the view that cuts it
_STEP = 0.5  # along rays, pixels
_ON = 2.0  # pixels beyond the border, where another part of the spot may go on
_ASTRAY = 3  # rays on either side of one that may go astray
_SPARSE = 0.3  # least share of its convex hull that a cluster of droplets fills
_FAINT, _FAINT_CUT = 0.1, 0.3  # of the usual contrast, that of a spot, and of one that is cut
_SPECK = 0.5  # of the smallest droplet: a smaller hole is a speck in one
_STUBS = 0.6  # radii of a part: what is thinner is not of it
_NECK = 0.8  # of the narrower part's width: what is thinner parts two droplets


class _Spot(NamedTuple):
    """One spot at one level; lengths in pixels."""

    walk: Walk
    area: float
    x: float
    y: float
    border: Border
    move: Floats  # outwards to the edge, along each ray
    level: float
    score: float
    contrast: float  # median, grey levels


class SpotSegmenter(LevelSegmenter[_Spot]):
    """Find the droplets that are dark all over; the window is larger than a droplet."""

    _faintest = 0.0  # grey levels: fainter are shades of the light and of a codec's blocks

    @classmethod
    def learned(
        cls,
        frames: Sequence[Frame],
        signal: Signal,
        window: int,
        minimum_area: float,
        view: Pixels | None = None,
    ) -> SpotSegmenter:
        """Return a segmenter for a clip, made from a sample of its frames, and their view."""
        noise = usual_noise(frames, signal)
        first = cls(signal, window, minimum_area, Surroundings(noise, view=view))
        darkest = max(float(first._darkness(frame).max()) for frame in frames[:3])
        faintest = _FAINTEST * LEAST_CONTRAST * noise
        levels = np.geomspace(faintest, max(_NEARLY * darkest, 2.0 * faintest), _LEVELS)
        first.about = about = first.about._replace(levels=tuple(levels.tolist()))
        seen = {frame.number: first._regions(first._darkness(frame)) for frame in frames}
        best = [one_a_droplet(here, frames[0].luma.shape) for here in seen.values()]
        faintest = _FAINT * _usual_contrast([spot for here in best for spot in here])
        shown = [
            each
            for here, spots in zip(best, seen.values(), strict=True)
            for each in shown_at([spot for spot in here if spot.contrast >= faintest], spots)
        ]
        standing = standing_rows([rows_of(here) for here in seen.values()])
        about = about._replace(levels=needed_levels(shown), standing=standing)
        learned = cls(signal, window, minimum_area, about)
        learned._shown, learned._seen, learned._faintest = shown, seen, faintest
        return learned

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame, the touching ones apart."""
        dark = self._darkness(frame)
        height, width = dark.shape
        kept = _without_faint_cut(one_a_droplet(self._regions_in(frame, dark), dark.shape))
        owner = owners(kept, dark.shape)
        groups = Groups(len(kept))
        found: list[Droplet | None] = []
        for number, spot in enumerate(kept):
            border = spot.border
            others = beyond(spot.move, border, owner, number)
            for neighbour in set(others[others >= 0].tolist()):
                groups.join(number, neighbour)
            # Single rays go astray where droplets meet.
            usual = _core.running_median(spot.move, _ASTRAY)
            away = np.where((others >= 0) | border.at_edge, 0.0, usual)
            outline = border.points + smoothed(away)[:, None] * border.normals
            outline = np.clip(outline, 0.0, (width - 1.0, height - 1.0))
            cut = bool(border.at_edge.any())
            cut = cut or leaves_view(self.about.view, outline, border.normals, _VIEW_PX)
            outline = without_dents(outline)
            area = _core.area(outline)
            middle_x, middle_y = _core.centroid(outline)
            droplet = Droplet(outline, area, middle_x, middle_y, cut, -1)
            found.append(droplet if area >= self.minimum_area else None)
        return groups.grouped(found)

    def _may_be_droplet(self, region: _Spot) -> bool:
        return region.contrast >= self._faintest and super()._may_be_droplet(region)

    def _darkness(self, frame: Frame) -> Image:
        image = self.signal.of(frame)
        size = (self.window, self.window)
        # The light: what is brighter than the local mean, averaged again, knows little of spots.
        local = cv2.blur(image, size, borderType=cv2.BORDER_REFLECT)
        light = cv2.blur(cv2.max(image, local), size, borderType=cv2.BORDER_REFLECT)
        dark: Image = cv2.subtract(light, cv2.GaussianBlur(image, (0, 0), _DENOISING))
        return dark

    def _regions(self, dark: Image) -> list[_Spot]:
        seen = seen_part(self.about.view, (dark.shape[1], dark.shape[0]))
        spots = [spot for level in self.about.levels for spot in self._at_level(dark, level, seen)]
        return _nested(spots, dark.shape)

    def _at_level(self, dark: Image, level: float, seen: Rectangle) -> list[_Spot]:
        mask = cv2.compare(dark, level, cv2.CMP_GT)
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        walks, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        spots: list[_Spot] = []
        for place, walk in enumerate(walks):
            if hierarchy[0, place, 3] >= 0 or cv2.contourArea(walk) < 0.5 * self.minimum_area:
                continue
            if is_ground(walk, seen):
                continue
            whole = compact_part(walk)
            if whole is not None:
                parts = [whole]
            elif cv2.contourArea(walk) >= max(
                2.0 * self.minimum_area, _SPARSE * cv2.contourArea(cv2.convexHull(walk))
            ):
                parts = self._parted(walk, _gaps(walks, hierarchy[0], place))
            else:
                continue  # a net of noise, or of walls
            for part in parts:
                spot = self._measured(part, dark, level)
                if spot is not None:
                    spots.append(spot)
        return spots

    def _parted(self, walk: Walk, gaps: Sequence[Walk]) -> list[Walk]:
        """Return the compact parts of a spot that necks divide; gaps among them are no part."""
        left, top, wide, high = cv2.boundingRect(walk)
        inside = np.zeros((high + 2, wide + 2), dtype=np.uint8)
        cv2.drawContours(inside, [walk], -1, 255, cv2.FILLED, offset=(1 - left, 1 - top))
        large = [gap for gap in gaps if cv2.contourArea(gap) >= _SPECK * self.minimum_area]
        cv2.drawContours(inside, large, -1, 0, cv2.FILLED, offset=(1 - left, 1 - top))
        depth = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
        smallest = 0.5 * math.sqrt(self.minimum_area / math.pi)
        cores = _cores(depth, smallest)
        count, _ = cv2.connectedComponents(cores)
        if count < 3:
            return []
        # Every pixel belongs to the core that is nearest.
        _, nearest = cv2.distanceTransformWithLabels(
            255 - cores, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_CCOMP
        )
        nearest[inside == 0] = 0
        parts = []
        for number, window in enumerate(find_objects(nearest), start=1):
            own = np.where(nearest[window] == number, 255, 0).astype(np.uint8)
            own = cv2.copyMakeBorder(own, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
            # Without what is left of walls and necks.
            size = int(_STUBS * math.sqrt(cv2.countNonZero(own) / math.pi)) | 1
            disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
            own = cv2.morphologyEx(own, cv2.MORPH_OPEN, disc)
            corner = (left + window[1].start - 2, top + window[0].start - 2)
            walks, _ = cv2.findContours(
                own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE, offset=corner
            )
            if not walks:
                continue
            part = compact_part(max(walks, key=cv2.contourArea))
            if part is not None and cv2.contourArea(part) >= 0.5 * self.minimum_area:
                parts.append(part)
        return parts

    def _measured(self, walk: Walk, dark: Image, level: float) -> _Spot | None:
        height, width = dark.shape
        border = border_of(walk[:, 0, :], (width, height))
        area = cv2.contourArea(walk)
        reach = max(_LEAST_REACH, _REACH * math.sqrt(area / math.pi))
        contrast, beyond, steep, place = _core.spot_edges(
            dark, border.points, border.normals, reach, _STEP, _ON
        ).T
        # Where it is as dark beyond, another part of the spot goes on.
        open_ends = border.at_edge | (beyond > level)
        score = closedness(contrast, open_ends, self.about.noise)
        if score <= 0.0:
            return None
        usual = max(part_below(contrast, 0.5), 1e-6)
        sharp = part_below(steep[~open_ends], 0.5) / usual
        x, y = border.points.mean(axis=0).tolist()
        move = np.where(np.isnan(place), 0.0, place)
        return _Spot(walk, area, x, y, border, move, level, score * min(1.0, 4.0 * sharp), usual)


def _nested(spots: Sequence[_Spot], shape: tuple[int, ...]) -> list[_Spot]:
    """Return the spots without those that a larger one is about which is darker all over.

    What is darker than a level is darker than every lower one: it has no parts there.
    """
    darker = np.zeros(shape, dtype=np.float32)  # area of the largest spot at higher levels
    kept: list[_Spot] = []
    for spot in sorted(spots, key=lambda each: (-each.level, each.area)):
        if spot.area < SAME * darker[round(spot.y), round(spot.x)]:
            continue
        kept.append(spot)
        cv2.drawContours(darker, [spot.walk], -1, spot.area, cv2.FILLED)
    return kept


def _without_faint_cut(spots: Sequence[_Spot]) -> list[_Spot]:
    """Return the spots without those that the frame cuts and that are pale beside whole ones.

    At the frame's edge less of a border has to show, so that shades of the light pass for spots.
    """
    whole = [spot.contrast for spot in spots if not spot.border.at_edge.any()]
    least = _FAINT_CUT * float(np.median(whole)) if whole else 0.0
    return [spot for spot in spots if spot.contrast >= least or not spot.border.at_edge.any()]


def _usual_contrast(spots: Sequence[_Spot]) -> float:
    """Return the median contrast, weighted by area: there are many faint specks, but small ones."""
    if not spots:
        return 0.0
    spots = sorted(spots, key=lambda spot: spot.contrast)
    covered = np.cumsum([spot.area for spot in spots])
    return spots[int(np.searchsorted(covered, 0.5 * covered[-1]))].contrast


def _gaps(walks: Sequence[Walk], hierarchy: NDArray[np.int32], place: int) -> list[Walk]:
    """Return the walks round the holes in a spot."""
    gaps, hole = [], int(hierarchy[place, 2])
    while hole >= 0:
        gaps.append(walks[hole])
        hole = int(hierarchy[hole, 0])
    return gaps


def _touches(cores: Pixels, row: int, column: int, radius: int, apart: int) -> bool:
    """Return whether a disc is not farther than some pixels from what is in a mask."""
    reach = radius + apart + 1
    top, left = max(0, row - reach), max(0, column - reach)
    around = cores[top : row + reach + 1, left : column + reach + 1]
    disc = np.zeros_like(around)
    cv2.circle(disc, (column - left, row - top), radius, 255, cv2.FILLED)
    if apart:
        disc = cv2.dilate(disc, np.ones((2 * apart + 1, 2 * apart + 1), np.uint8))
    return bool(cv2.countNonZero(cv2.min(disc, np.ascontiguousarray(around))))


def _cores(depth: Image, smallest: float) -> Pixels:
    """Return where the middles of the parts of a spot are, from the depth below its border."""
    size = max(3, int(2.0 * smallest)) | 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    smooth = cv2.GaussianBlur(depth, (0, 0), 1.0)
    peaks = (smooth >= cv2.dilate(smooth, disc)) & (smooth > smallest)
    cores = np.zeros(depth.shape, dtype=np.uint8)
    # The deepest first: a peak within another's core is a ripple of it, not a droplet.
    rows, columns = np.nonzero(peaks)
    for k in np.argsort(-smooth[rows, columns]):
        row, column = int(rows[k]), int(columns[k])
        if cores[row, column]:
            continue
        radius = max(1, int(_NECK * smooth[row, column]))
        if _touches(cores, row, column, radius, 0):
            # They meet: the neck between is not narrow, unless this one is well apart.
            radius = max(1, radius // 2)
            if _touches(cores, row, column, radius, 1):
                continue
        cv2.circle(cores, (column, row), radius, 255, cv2.FILLED)
    return cores
