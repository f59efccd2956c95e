"""What was measured, drawn over the frames: a clip to watch, and pictures of every collision."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support import palette
from pinchoff.video.clips import Measured
from pinchoff.video.encounters import Encounter
from pinchoff.video.reading import Frame
from pinchoff.video.writing import ClipWriter

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_FRACTION_BITS = 4  # of OpenCV's coordinates
_SHOWN_WIDTH = 1000  # narrower frames are drawn enlarged, pixels
_FLASH = 12  # frames for which an event stays marked
_AROUND = 7.0  # radii of the obstacle from its centre to the side of such a picture
_THUMBNAIL = 160  # side of a picture of a collision, pixels


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue


OUTLINE, TOUCHING, CUT = _rgb(palette.GREEN), _rgb(palette.ORANGE), _rgb(palette.GREY)
CONTACT, BREAKUP = _rgb(palette.CENTRELINE), _rgb(palette.NECK)
NECK, OBSTACLE, TEXT = _rgb(palette.NECK), _rgb(palette.BLUE), _rgb(palette.BLACK)


def rgb_of(frame: Frame) -> Pixels:
    """Return a frame as (height, width, 3) of red, green and blue, with both sides even."""
    height, width = (side - side % 2 for side in frame.luma.shape)
    luma = np.ascontiguousarray(frame.luma[:height, :width])
    if frame.chroma is None:
        grey: Pixels = cv2.cvtColor(luma, cv2.COLOR_GRAY2RGB)
        return grey
    chroma = frame.chroma[:, : height // 2, : width // 2].reshape(-1)
    planes = np.concatenate([luma.reshape(-1), chroma]).reshape(height * 3 // 2, width)
    colour: Pixels = cv2.cvtColor(planes, cv2.COLOR_YUV2RGB_I420)
    return colour


class _Mark(NamedTuple):
    """An event that stays visible for a while."""

    until: int
    x: float
    y: float
    text: str
    colour: tuple[int, int, int]


class OverlayWriter:
    """Write the frames with outlines, track numbers, contacts, necks and break-ups drawn in.

    Parameters
    ----------
    path : Path
        The clip, ``.mp4``.
    obstacles : ndarray, shape (M, 3)
        Pixels.
    fps : float
    """

    def __init__(self, path: Path, obstacles: Floats, fps: float) -> None:
        self._path, self._obstacles, self._fps = path, obstacles, fps
        self._writer: ClipWriter | None = None
        self._marks: list[_Mark] = []
        self._scale = 1

    def append(self, seen: Measured) -> None:
        """Draw and write one frame."""
        image = rgb_of(seen.frame)
        if self._writer is None:
            self._scale = 2 if image.shape[1] < _SHOWN_WIDTH else 1
            size = (image.shape[1] * self._scale, image.shape[0] * self._scale)
            self._writer = ClipWriter(self._path, size, self._fps)
            self._writer.__enter__()
        if self._scale > 1:
            image = cv2.resize(image, None, fx=self._scale, fy=self._scale)
        for number, (x, y, radius) in enumerate(self._obstacles):
            cv2.circle(image, *self._circle(x, y, radius), OBSTACLE, 1, cv2.LINE_AA, _FRACTION_BITS)
            self._label(image, x, y, f"o{number}", OBSTACLE)
        for droplet, track in zip(seen.droplets, seen.tracks, strict=True):
            colour = CUT if droplet.cut else TOUCHING if droplet.group >= 0 else OUTLINE
            self._line(image, droplet.outline, colour, closed=True)
            self._label(image, droplet.x, droplet.y, str(track), TEXT)
        for neck in seen.necks:
            self._line(image, neck.ends, NECK, closed=False)
        self._mark(image, seen)
        text = f"frame {seen.frame.number}   {seen.frame.time_s:.3f} s"
        cv2.putText(image, text, (8, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, TEXT, 1, cv2.LINE_AA)
        self._writer.append(image)

    def close(self, *, whole: bool) -> None:
        """Finish the clip, or remove it where it is not whole."""
        if self._writer is not None:
            problem = None if whole else InterruptedError
            self._writer.__exit__(problem, None, None)

    def _mark(self, image: Pixels, seen: Measured) -> None:
        number = seen.frame.number
        places = dict(zip(seen.tracks, seen.droplets, strict=True))
        for track, obstacle in seen.met:
            x, y, _ = self._obstacles[obstacle]
            text = f"contact of {track}"
            self._marks.append(_Mark(number + _FLASH, x, y - 30, text, CONTACT))
        for event in seen.events:
            if event.kind in ("break-up", "coalescence"):
                child = places[event.children[0]]
                self._marks.append(
                    _Mark(number + _FLASH, child.x, child.y - 20, event.kind, BREAKUP)
                )
        self._marks = [mark for mark in self._marks if mark.until > number]
        for mark in self._marks:
            self._label(image, mark.x, mark.y, mark.text, mark.colour)

    def _fixed(self, points: Floats) -> NDArray[np.int32]:
        # Enlarged pixels: the centre of pixel k is at s k + (s - 1)/2.
        shifted = points * self._scale + (self._scale - 1) / 2
        return np.rint(shifted * (1 << _FRACTION_BITS)).astype(np.int32)

    def _circle(self, x: float, y: float, radius: float) -> tuple[tuple[int, int], int]:
        centre = self._fixed(np.array([x, y])).tolist()
        return (centre[0], centre[1]), round(radius * self._scale * (1 << _FRACTION_BITS))

    def _line(
        self, image: Pixels, points: Floats, colour: tuple[int, int, int], *, closed: bool
    ) -> None:
        fixed = [self._fixed(points)]
        width = 1 if closed else 2
        cv2.polylines(image, fixed, closed, colour, width, cv2.LINE_AA, _FRACTION_BITS)

    def _label(
        self, image: Pixels, x: float, y: float, text: str, colour: tuple[int, int, int]
    ) -> None:
        (wide, high), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.45, 1)
        place = (round(x * self._scale - wide / 2), round(y * self._scale + high / 2))
        cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)


class Thumbnail(NamedTuple):
    """A collision at its first contact and at its end, side by side.

    Attributes
    ----------
    contact_frame, track_id, obstacle_id : int
        The collision.
    pixels : ndarray of uint8, shape (side, 2 side, 3)
        Red, green and blue.
    """

    contact_frame: int
    track_id: int
    obstacle_id: int
    pixels: Pixels


class ThumbnailTaker:
    """Take two pictures of every collision while its clip is measured.

    Parameters
    ----------
    obstacles : ndarray, shape (M, 3)
        Pixels.
    """

    def __init__(self, obstacles: Floats) -> None:
        self._obstacles = obstacles
        self._before: dict[tuple[int, int], tuple[int, Pixels]] = {}

    def look(self, seen: Measured) -> list[Thumbnail]:
        """Take one frame, and return the pictures of the collisions that are over."""
        if not seen.met and not seen.over:
            return []
        image = rgb_of(seen.frame)
        for droplet in seen.droplets:
            fixed = np.rint(droplet.outline * 16).astype(np.int32)
            cv2.polylines(image, [fixed], True, OUTLINE, 1, cv2.LINE_AA, 4)
        for track, obstacle in seen.met:
            self._before[track, obstacle] = seen.frame.number, self._around(image, obstacle)
        return [self._joined(each, image) for each in seen.over]

    def _joined(self, over: Encounter, image: Pixels) -> Thumbnail:
        track, obstacle = over.track_id, over.obstacle_id
        contact, before = self._before.pop((track, obstacle))
        pixels = np.hstack([before, self._around(image, obstacle)])
        return Thumbnail(contact, track, obstacle, pixels)

    def _around(self, image: Pixels, obstacle: int) -> Pixels:
        x, y, radius = self._obstacles[obstacle]
        half = _AROUND * radius
        scale = _THUMBNAIL / (2.0 * half)
        moved = np.array([[scale, 0.0, scale * (half - x)], [0.0, scale, scale * (half - y)]])
        size = (_THUMBNAIL, _THUMBNAIL)
        cut: Pixels = cv2.warpAffine(image, moved, size, borderMode=cv2.BORDER_REPLICATE)
        return cut
