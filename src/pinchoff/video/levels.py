"""Thresholds that follow from the image.

The ring is the darkest part of the droplets. The outline lies at the darkness that a blurred ring,
fitted to the mean profile across the outlines of the sample, has at its outer edge. The interior's
colour is that of the regions that dark rings enclose.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.background import Background, masked_background, median_background
from pinchoff.video.droplets import Droplet
from pinchoff.video.methods.rings import Levels, RingSegmenter
from pinchoff.video.profiles import REACHES, across, apparent_width, fit_ring, mean_profile
from pinchoff.video.reading import Frame
from pinchoff.video.settings import VideoSettings

T = TypeVar("T")
Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_FIRST_EDGE = 0.5  # of the ring's darkness, before the profile is known
_RING_QUANTILE = 0.98  # of what is clearly darker than the fluid
_CLEARLY = 6.0  # standard deviations of the noise
_FEW = 8  # frames, about, from which the colour is taken
_MARGIN_PX = 4  # round droplets, where the background is not learned
_HIGHER_HOLES = (0.7, 0.85, 0.92)  # of the ring's darkness, for droplets that are dark inside
_DARK = 0.8  # of the edge's level: where the noise of the interior may reach it
_EDGE_LIMITS = (0.05, 0.95)  # of the ring's darkness
_LEAST_COLOUR = 0.04  # of the ring's darkness: a paler interior is told by its ring alone


class Calibrated(NamedTuple):
    """What a clip is measured with.

    Attributes
    ----------
    background : Background
    levels : Levels
    """

    background: Background
    levels: Levels

    def thresholds(self) -> dict[str, Any]:
        """Return what followed from the image, by name and unit."""
        return {
            "ring_grey_levels": self.levels.ring,
            "edge_level": self.levels.edge,
            "pale_edge_level": self.levels.pale_edge,
            "inner_edge_level": self.levels.hole,
            "ring_width_px": self.levels.ring_width,
            "interior_colour_yuv": self.levels.colour.tolist(),
            "noise_grey_levels": self.background.noise,
        }


def calibrate(
    frames: Sequence[Frame], settings: VideoSettings, background: Background | None = None
) -> Calibrated:
    """Learn the background and the thresholds of a clip from a sample of its frames.

    Parameters
    ----------
    frames : sequence of Frame
    settings : VideoSettings
        What they say is taken as it is.
    background : Background, optional
        Median of the frames, where it is known.
    """
    background = background or median_background(frames)
    levels = Levels(
        ring=settings.ring_darkness or _ring(frames, background),
        edge=settings.edge_level or _FIRST_EDGE,
        colour=np.zeros(3),
        interior=settings.interior_level,
        minimum_area=settings.minimum_area_px,
    )
    first_hole = _first_hole(frames, background, levels)
    levels = replace(levels, hole=first_hole)
    # The first time roughly, on half of the frames.
    for some in (frames[::2], frames):
        levels = replace(levels, colour=_colour(some, background, levels, settings))
        levels = replace(levels, hole=settings.inner_edge_level or _hole(levels, first_hole))
        segmenter = RingSegmenter(background, levels)
        found = [segmenter.droplets(frame) for frame in some]
        if len(some) > 2:
            masks = [
                _near([droplet.outline for droplet in droplets], background.luma.shape)
                for droplets in found
            ]
            background = masked_background(some, masks, background)
        levels = _at_ring(levels, some, found, background, settings)
        levels = replace(levels, pale_edge=settings.pale_edge_level or _pale_edge(levels))
        levels = replace(levels, hole=settings.inner_edge_level or _hole(levels, first_hole))
    return Calibrated(background, levels)


def _at_ring(
    levels: Levels,
    frames: Sequence[Frame],
    found: Sequence[Sequence[Droplet]],
    background: Background,
    settings: VideoSettings,
) -> Levels:
    """Return the levels with the edge and the width that the rings of a sample have."""
    segmenter = RingSegmenter(background, levels)
    for reach in REACHES:
        places, examples = across(reach), _examples(found, reach)
        profiles = _profiles(frames, examples, segmenter, background, places)
        if not profiles:
            return levels
        if settings.edge_level is None:
            curvature = _curvature(list(itertools.chain(*examples)))
            level = fit_ring(profiles, places).edge(curvature) / levels.ring
            levels = replace(levels, edge=float(np.clip(level, *_EDGE_LIMITS)))
        edge = max(levels.edge, levels.hole) * levels.ring
        width = apparent_width(np.mean(profiles, axis=0), places, edge)
        if width > 0.0:
            break  # else the ring is wider than the profiles reach
    if settings.ring_width_um is not None:
        width = settings.ring_width_um / settings.pixel_um
    return replace(levels, ring_width=width)


def _ring(frames: Sequence[Frame], background: Background) -> float:
    """Return how much darker than the fluid the droplets' rings are, at average light."""
    values = []
    for frame in frames:
        dark = background.luma * background.lamp(frame.luma) - frame.luma
        dark = cv2.GaussianBlur(dark, (3, 3), 0.7) / background.light
        values.append(dark[dark > _CLEARLY * background.noise])
    everything = np.concatenate(values)
    if everything.size < 20:
        return 255.0  # nothing is darker than the fluid: there are no droplets
    return float(np.quantile(everything, _RING_QUANTILE))


def _colour(
    frames: Sequence[Frame], background: Background, levels: Levels, settings: VideoSettings
) -> Floats:
    """Return how the interior differs from the fluid: brightness, blue and red difference."""
    if settings.interior is not None:
        pixel = np.array([[settings.interior]], dtype=np.float32) / 255.0
        yuv = cv2.cvtColor(pixel, cv2.COLOR_RGB2YUV)[0, 0] * 255.0
        fluid = float(np.median(background.luma))
        return np.array(
            [
                yuv[0] - fluid,
                yuv[1] - 128.0 - _tint(background, 0),
                yuv[2] - 128.0 - _tint(background, 1),
            ]
        )
    if settings.clicks:
        return _clicked(frames, background, settings)
    # Spots that are all ring have no interior.
    segmenter = RingSegmenter(background, replace(levels, colour=np.zeros(3), ring_width=0.0))
    seen = []
    for frame in _few(frames):
        found = segmenter.droplets(frame)
        if found:
            inner = _cores([droplet.outline for droplet in found], frame.luma.shape)
            if inner.any():
                seen.append(_contrast(frame, background, inner))
    if not seen:
        return np.zeros(3)
    colour: Floats = np.median(np.array(seen), axis=0)
    return colour if np.linalg.norm(colour) > _LEAST_COLOUR * levels.ring else np.zeros(3)


def _first_hole(frames: Sequence[Frame], background: Background, levels: Levels) -> float:
    """Return the lowest level above `edge` at which rings enclose anything; 0 if `edge` does."""
    for hole in (0.0, *_HIGHER_HOLES):
        segmenter = RingSegmenter(background, replace(levels, hole=hole))
        if any(segmenter.droplets(frame) for frame in _few(frames)):
            return hole
    return 0.0


def _hole(levels: Levels, first: float) -> float:
    """Return `edge`, or a level halfway from the interior to the ring if `edge` is too low."""
    if not levels.colour.any():
        return max(levels.edge, first)
    interior = -float(levels.colour[0]) / levels.ring
    return levels.edge if interior < _DARK * levels.edge else 0.5 * (interior + 1.0)


def _pale_edge(levels: Levels) -> float:
    """Return a level halfway from the edge's to the interior's, which may itself be dark."""
    return 0.5 * (levels.edge + max(0.0, -float(levels.colour[0])) / levels.ring)


def _tint(background: Background, plane: int) -> float:
    return 0.0 if background.chroma is None else float(np.median(background.chroma[plane])) - 128.0


def _clicked(frames: Sequence[Frame], background: Background, settings: VideoSettings) -> Floats:
    seen = []
    for number, x, y in settings.clicks:
        frame = min(frames, key=lambda frame: abs(frame.number - number))
        mask = np.zeros(frame.luma.shape, dtype=np.uint8)
        cv2.circle(mask, (round(x), round(y)), 2, 255, cv2.FILLED)
        if not mask.any():
            got, advice = f"({x:g}, {y:g})", "give pixels within droplets"
            raise InputError.of("clicks", "inside the frame", got, advice)
        seen.append(_contrast(frame, background, mask))
    clicked: Floats = np.median(np.array(seen), axis=0)
    return clicked


def _few(frames: Sequence[T]) -> Sequence[T]:
    """Return some of the frames, spread evenly: enough for what droplets have in common."""
    return frames[:: max(1, len(frames) // _FEW)]


def _cores(outlines: Sequence[Floats], shape: tuple[int, ...]) -> Pixels:
    """Return a mask of the middles of droplets, away from their rings."""
    mask = np.zeros(shape[:2], dtype=np.uint8)
    for outline in outlines:
        # Towards the centre by half: within the droplet, whatever its size, if it is not bent.
        middle = outline.mean(axis=0)
        cv2.fillPoly(mask, [np.rint(middle + 0.5 * (outline - middle)).astype(np.int32)], 255)
    return mask


def _contrast(frame: Frame, background: Background, mask: Pixels) -> Floats:
    light = cv2.mean(background.light, mask)[0]
    lamp = background.lamp(frame.luma)
    seen = np.zeros(3)
    seen[0] = (cv2.mean(frame.luma, mask)[0] / lamp - cv2.mean(background.luma, mask)[0]) / light
    if frame.chroma is not None and background.chroma is not None:
        half = mask[::2, ::2].copy()
        for k in (0, 1):
            ours, theirs = frame.chroma[k], background.chroma[k]
            seen[k + 1] = cv2.mean(ours, half)[0] - cv2.mean(theirs, half)[0]
    return seen


def _near(outlines: Sequence[Floats], shape: tuple[int, ...]) -> Pixels:
    """Return a mask of droplets and what is near to them."""
    mask = np.zeros(shape[:2], dtype=np.uint8)
    points = [np.rint(outline).astype(np.int32) for outline in outlines]
    if points:
        cv2.fillPoly(mask, points, 255)
        cv2.polylines(mask, points, True, 255, 2 * _MARGIN_PX)
    return mask


def _examples(found: Sequence[Sequence[Droplet]], reach: float) -> list[list[Floats]]:
    """Return the outlines in each frame on which to look at the ring.

    They are whole, touch no other and, if there are such, are large enough that a profile does not
    reach their other side.
    """
    whole = [
        [droplet for droplet in droplets if not droplet.cut and droplet.group < 0]
        for droplets in found
    ]
    least = np.pi * reach**2
    large = [[droplet for droplet in droplets if droplet.area >= least] for droplets in whole]
    return [
        [droplet.outline for droplet in droplets] for droplets in (large if any(large) else whole)
    ]


def _curvature(outlines: Sequence[Floats]) -> float:
    """Return the mean curvature of outlines, each of which turns once, 1/pixel."""
    perimeter = sum(float(np.hypot(*(np.roll(o, -1, axis=0) - o).T).sum()) for o in outlines)
    return 2.0 * np.pi * len(outlines) / perimeter


def _profiles(
    frames: Sequence[Frame],
    outlines: Sequence[Sequence[Floats]],
    segmenter: RingSegmenter,
    background: Background,
    places: Floats,
) -> list[Floats]:
    """Return the mean darkness across the outlines in each frame that has some."""
    profiles = []
    for frame, here in zip(frames, outlines, strict=True):
        if here:
            dark = segmenter.darkness(frame, background.lamp(frame.luma)) / background.light
            profiles.append(mean_profile(dark, here, places))
    return profiles
