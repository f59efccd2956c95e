"""Rims against their own surroundings: what they enclose, if it is convex, is a droplet.

No empty chamber is needed. What is darker than its local mean is rim or wall; a region that it
encloses is a droplet if its own shape says so: the fluid between two plugs is enclosed too, by
the walls and both caps, but its ends are concave; so are the gaps in a packed layer. Several
levels of darkness are tried at once, because the rims of one picture need not be equally dark.
From the border of the region rays go outwards through the rim; the outline is where the rim has
lost half of its darkness. Where a wall prolongs the rim, it is as wide as it is elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

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

_DENOISING = 0.8  # standard deviation of the filter, pixels
_LEVELS = 7  # of darkness, one twice the other
_EDGE = 0.5  # of the rim's darkness, where the outline lies
_STEP = 0.5  # along rays, pixels
_WITHIN = 2.0  # pixels from the border to where they begin, in the interior
_BEYOND = 3.0  # pixels beyond the rim in which it gets as bright as outside
_TOO_WIDE = 1.4  # usual widths of the rim: there a wall prolongs it
_TOO_NARROW, _PALE_SHARE = 0.6, 0.25  # usual widths; of the border, at most
_SPECK, _OFF = 6, 0.25  # rays on either side of which one may differ, by widths of the rim
_VIEW_QUANTILE = 0.25  # of the rim's widths round a droplet: where no wall prolongs it
_VIEW_SHARE, _VIEW_PX = 0.7, 2.0  # of the rim's width, pixels: no farther from the interior is
# the dark edge of the view if it cuts a droplet
_GAP_SIZE = 0.25  # of the droplets about it: a smaller region that is not round is a gap
_AS_SMALL = 1.5  # times the usual area: no larger is what the frame cuts of a droplet
_GAP_SHARED = 0.4  # least share of a gap's border that droplets are beyond
_GAP_ROUNDNESS = 0.8  # of the area, that of the largest disc within


class _Region(NamedTuple):
    """An enclosed region and what rays found about it.

    Attributes
    ----------
    walk : ndarray
        Round it, on the rim.
    area : float
        Enclosed by the walk, pixels.
    x, y : float
        Its centre.
    border : Border
    width : ndarray, shape (n,)
        Distance to where the rim ends along each ray, pixels; NaN where it does not.
    contrast : ndarray, shape (n,)
        Rim's greatest darkness less the interior's, grey levels.
    level : float
        At which it is enclosed.
    score : float
        How surely it is a droplet, from 0 to 1.
    """

    walk: Walk
    area: float
    x: float
    y: float
    border: Border
    width: Floats
    contrast: Floats
    level: float
    score: float


class EnclosedSegmenter(LevelSegmenter[_Region]):
    """Find the droplets that dark rims enclose; the window is some times the rim's width."""

    REGION_SHARE = 0.2  # the rim takes the rest

    @classmethod
    def learned(
        cls,
        frames: Sequence[Frame],
        signal: Signal,
        window: int,
        minimum_area: float,
        view: Pixels | None = None,
    ) -> EnclosedSegmenter:
        """Return a segmenter for a clip, made from a sample of its frames, and their view."""
        noise = usual_noise(frames, signal)
        levels = tuple(LEAST_CONTRAST * noise * 2.0**k for k in range(_LEVELS))
        first = cls(signal, window, minimum_area, Surroundings(noise, levels, view))
        seen = {frame.number: first._regions(first._darkness(frame)) for frame in frames}
        standing = standing_rows([rows_of(here) for here in seen.values()])
        first.about = about = first.about._replace(standing=standing)
        moving = {
            number: [each for each in here if not about.stands(each)]
            for number, here in seen.items()
        }
        shape = frames[0].luma.shape
        shown = [
            each for here in moving.values() for each in shown_at(one_a_droplet(here, shape), here)
        ]
        about = about._replace(levels=needed_levels(shown))
        learned = cls(signal, window, minimum_area, about)
        learned._shown, learned._seen = shown, moving
        return learned

    def droplets(self, frame: Frame) -> list[Droplet]:
        """Return the droplets of a frame, the touching ones apart."""
        dark = self._darkness(frame)
        return self._outlined(one_a_droplet(self._regions_in(frame, dark), dark.shape), dark)

    def _darkness(self, frame: Frame) -> Image:
        image = self.signal.of(frame)
        size = (self.window, self.window)
        local = cv2.blur(image, size, borderType=cv2.BORDER_REFLECT)
        dark: Image = cv2.subtract(local, cv2.GaussianBlur(image, (0, 0), _DENOISING))
        return dark

    def _regions(self, dark: Image) -> list[_Region]:
        seen = seen_part(self.about.view, (dark.shape[1], dark.shape[0]))
        return [each for level in self.about.levels for each in self._enclosed(dark, level, seen)]

    def _enclosed(self, dark: Image, level: float, seen: Rectangle) -> list[_Region]:
        """Return the convex regions that what is darker than a level encloses."""
        rim = cv2.compare(dark, level, cv2.CMP_GT)
        # The frame's edge closes what it cuts.
        rim = cv2.copyMakeBorder(rim, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=255)
        walks, hierarchy = cv2.findContours(
            rim, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE, offset=(-1, -1)
        )
        if not walks:
            return []
        least = self.REGION_SHARE * self.minimum_area
        holes = []
        for walk, parent in zip(walks, hierarchy[0, :, 3].tolist(), strict=True):
            if parent < 0 or len(walk) ** 2 < 8.0 * least or cv2.contourArea(walk) < least:
                continue
            if is_ground(walk, seen):
                continue
            whole = compact_part(walk)
            if whole is not None:
                holes.append(whole)
        return self._along_rays(holes, dark, level)

    def _along_rays(self, holes: Sequence[Walk], dark: Image, level: float) -> list[_Region]:
        if not holes:
            return []
        height, width = dark.shape
        borders = [border_of(hole[:, 0, :], (width, height)) for hole in holes]
        points = np.concatenate([border.points for border in borders])
        normals = np.concatenate([border.normals for border in borders])
        ends, contrasts = _core.rim_ends(
            dark,
            points,
            normals,
            -_WITHIN,
            _STEP,
            math.ceil((_WITHIN + 0.5 * self.window) / _STEP),
            level,
            _EDGE,
            math.ceil((_WITHIN + _STEP) / _STEP),
            int(_BEYOND / _STEP),
        )
        found, start = [], 0
        for hole, border in zip(holes, borders, strict=True):
            own = slice(start, start + len(border.points))
            start = own.stop
            score = closedness(contrasts[own], border.at_edge, self.about.noise)
            if score > 0.0:
                area = cv2.contourArea(hole)
                x, y = border.points.mean(axis=0).tolist()
                found.append(
                    _Region(hole, area, x, y, border, ends[own], contrasts[own], level, score)
                )
        return found

    def _outlined(self, regions: Sequence[_Region], dark: Image) -> list[Droplet]:
        """Return the droplets, their outlines on the outer edge of their rims."""
        if not regions:
            return []
        height, width = dark.shape
        owner = owners(regions, dark.shape)
        widths = [_rim_widths(region.width, region.border.at_edge) for region in regions]
        like_others = _like_others(regions)
        gaps = [
            _is_gap(region, beyond(away, region.border, owner, number), regions, like_others)
            for number, (region, away) in enumerate(zip(regions, widths, strict=True))
        ]
        if any(gaps):
            regions = [each for each, gap in zip(regions, gaps, strict=True) if not gap]
            widths = [each for each, gap in zip(widths, gaps, strict=True) if not gap]
            owner = owners(regions, dark.shape)
        groups = Groups(len(regions))
        found: list[Droplet | None] = []
        for number, (region, away) in enumerate(zip(regions, widths, strict=True)):
            border = region.border
            others = beyond(away, border, owner, number)
            away = np.where(others >= 0, 0.5 * away, away)  # a wall that two share
            for other in set(others[others >= 0].tolist()):
                if not _is_surroundings(regions[other], region):
                    groups.join(number, other)
            away[border.at_edge] = 0.0
            outline = border.points + smoothed(away)[:, None] * border.normals
            outline = np.clip(outline, 0.0, (width - 1.0, height - 1.0))
            outline = without_dents(outline)
            area = _core.area(outline)
            if area < self.minimum_area:
                found.append(None)
                continue
            # The interior of what is whole ends at its rim, a rim's width before the dark edge.
            rim = part_below(widths[number], _VIEW_QUANTILE)
            reach = max(_VIEW_PX, _VIEW_SHARE * rim)
            cut = bool(border.at_edge.any())
            cut = cut or leaves_view(self.about.view, border.points, border.normals, reach)
            x, y = _core.centroid(outline)
            found.append(Droplet(outline, area, x, y, cut, -1))
        return groups.grouped(found)


def _rim_widths(widths: Floats, at_edge: Bools) -> Floats:
    """Return the rim's width along each ray; where a wall prolongs it, its width elsewhere."""
    free = widths[~at_edge]
    known = free[np.isfinite(free)]
    # A rim that a wall prolongs on more than half of its way is as wide as on the rest.
    typical = part_below(known, 0.4) if len(known) else 1.0
    plain = np.isfinite(widths) & (widths <= _TOO_WIDE * typical)
    filled = np.where(plain, widths, typical)
    # Where it is pale for a short way it seems narrow.
    narrow = filled < _TOO_NARROW * typical
    if np.count_nonzero(narrow) <= _PALE_SHARE * len(widths):
        filled[narrow] = typical
    # A speck on the rim makes a few rays end early or late.
    usual: Floats = _core.running_median(filled, _SPECK)
    return np.where(np.abs(filled - usual) > _OFF * typical, usual, filled)


def _is_surroundings(other: _Region, region: _Region) -> bool:
    """Return whether a neighbour is no droplet but what lies beyond a wall."""
    return bool(other.border.at_edge.any()) and other.area * _GAP_SIZE > region.area


def _like_others(regions: Sequence[_Region]) -> Bools:
    """Return which regions may be droplets: the frame does not cut them, or they are as small.

    What is cut and larger may be all that lies beyond a wall.
    """
    whole = np.array([not region.border.at_edge.any() for region in regions])
    areas = np.array([region.area for region in regions])
    usual = float(np.median(areas[whole])) if whole.any() else 0.0
    alike: Bools = whole | (areas <= _AS_SMALL * usual)
    return alike


def _is_gap(
    region: _Region, neighbours: NDArray[np.int16], regions: Sequence[_Region], like_others: Bools
) -> bool:
    """Return whether a region is what packed droplets leave between them.

    Parameters
    ----------
    region : _Region
    neighbours : ndarray, shape (n,)
        What `beyond` returns.
    regions : sequence of _Region
    like_others : ndarray of bool, shape (len(regions),)
        What `_like_others` returns.
    """
    others = neighbours[(neighbours >= 0) & like_others[neighbours]]
    if len(others) < _GAP_SHARED * len(neighbours):
        return False
    around = [regions[number].area for number in set(others.tolist())]
    if region.area > _GAP_SIZE * part_below(np.array(around), 0.5):
        return False
    left, top, wide, high = cv2.boundingRect(region.walk)
    mask = np.zeros((high + 2, wide + 2), dtype=np.uint8)
    cv2.drawContours(mask, [region.walk], -1, 1, cv2.FILLED, offset=(1 - left, 1 - top))
    inner = float(cv2.distanceTransform(mask, cv2.DIST_L2, 5).max()) - 0.5  # to its edge
    return math.pi * inner**2 < _GAP_ROUNDNESS * cv2.countNonZero(mask)
