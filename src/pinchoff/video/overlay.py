"""What was measured, drawn over the frames: a clip to watch, and pictures of every collision."""

from __future__ import annotations

from collections import defaultdict, deque
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support import palette
from pinchoff.support.files import HoldsFiles
from pinchoff.video.clips import Measured
from pinchoff.video.encounters import Encounter
from pinchoff.video.reading import Frame
from pinchoff.video.writing import ClipWriter

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

_FRACTION_BITS = 4  # of OpenCV's coordinates
_SHOWN_WIDTH = 1000  # narrower frames are drawn enlarged, pixels
_AHEAD = 8  # frames that wait to be drawn
_CRF = 22
_FONT, _FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.45
_LINE_HEIGHT = 24  # of the legend, pixels
_CLOCK_WIDTH = 210  # of frame and time, pixels
_MARK_AWAY = 24.0  # of the name of an event from its place, pixels of the film
_MOST_TAKEN = 64  # pictures of an approach until its contact is known
_BETWEEN = 4  # white pixels between the two pictures of a collision
_WHITE = (255, 255, 255)
_FLASH = 12  # frames for which an event stays marked
_AROUND = 7.0  # radii of the obstacle from its centre to the side of such a picture
_THUMBNAIL = 160  # side of a picture of a collision, pixels


Colour = tuple[int, int, int]


def _rgb(colour: str) -> Colour:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue


OUTLINE, TOUCHING, CUT = _rgb(palette.GREEN), _rgb(palette.ORANGE), _rgb(palette.GREY)
CONTACT, BREAKUP = _rgb(palette.CENTRELINE), _rgb(palette.NECK)
NECK, OBSTACLE, TEXT = _rgb(palette.NECK), _rgb(palette.BLUE), _rgb(palette.BLACK)


_MEANINGS = (
    ("droplet", OUTLINE),
    ("touches another", TOUCHING),
    ("cut by the frame", CUT),
    ("obstacle", OBSTACLE),
    ("neck", NECK),
)
_SIDES = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])  # of a thing, for its label


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
    colour: Colour


class OverlayWriter(HoldsFiles):
    """Write the frames with outlines, track numbers, contacts, necks and break-ups drawn in.

    Below the picture stand the frame's number, its time and what the colours mean. Drawing and
    compressing go on in a thread, while the next frames are measured.

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
        self._legend: Pixels = np.empty((0, 0, 3), dtype=np.uint8)
        self._thread = ThreadPoolExecutor(1)
        self._waiting: deque[Future[None]] = deque()
        self._files = ExitStack()
        self._files.push(self._close)
        self._files.push(self._draw_the_rest)

    def append(self, seen: Measured) -> None:
        """Draw and write one frame."""
        self._waiting.append(self._thread.submit(self._draw, seen))
        while len(self._waiting) > _AHEAD:
            self._waiting.popleft().result()

    def _draw_the_rest(self, kind: type[BaseException] | None, *_: object) -> None:
        while kind is None and self._waiting:
            self._waiting.popleft().result()

    def _close(self, *failure: Any) -> None:
        self._thread.shutdown(cancel_futures=True)
        if self._writer is not None:
            self._writer.__exit__(*failure)

    def _draw(self, seen: Measured) -> None:
        image = rgb_of(seen.frame)
        if self._writer is None:
            self._begin(image)
        assert self._writer is not None
        if self._scale > 1:
            image = cv2.resize(image, None, fx=self._scale, fy=self._scale)
        self._labels = _Labels(image, self._scale, [droplet.outline for droplet in seen.droplets])
        for x, y, radius in self._obstacles:
            cv2.circle(image, *self._circle(x, y, radius), OBSTACLE, 1, cv2.LINE_AA, _FRACTION_BITS)
        for droplet in seen.droplets:
            colour = CUT if droplet.cut else TOUCHING if droplet.group >= 0 else OUTLINE
            self._line(image, droplet.outline, colour, closed=True)
        for neck in seen.necks:
            self._line(image, neck.ends, NECK, closed=False)
        self._mark(seen)
        for number, (x, y, radius) in enumerate(self._obstacles):
            self._labels.write(f"o{number}", (x, y), radius, OBSTACLE)
        for droplet, track in zip(seen.droplets, seen.tracks, strict=True):
            reach = np.ptp(droplet.outline, axis=0) / 2.0
            self._labels.write(str(track), (droplet.x, droplet.y), reach, TEXT)
        self._writer.append(np.vstack([image, self._strip(seen.frame)]))

    def _begin(self, image: Pixels) -> None:
        self._scale = 2 if image.shape[1] < _SHOWN_WIDTH else 1
        width = image.shape[1] * self._scale
        self._legend = _legend(width)
        size = (width, image.shape[0] * self._scale + len(self._legend))
        self._writer = ClipWriter(self._path, size, self._fps, _CRF, quick=True)
        self._writer.__enter__()

    def _strip(self, frame: Frame) -> Pixels:
        strip = self._legend.copy()
        _write(strip, f"frame {frame.number}   {frame.time_s:.4g} s", (6, _LINE_HEIGHT - 7), TEXT)
        return strip

    def _mark(self, seen: Measured) -> None:
        """Mark the events of this frame, and for a while those before."""
        number = seen.frame.number
        places = dict(zip(seen.tracks, seen.droplets, strict=True))
        for track, obstacle in seen.met:
            x, y, _ = self._obstacles[obstacle]
            mark = _Mark(number + _FLASH, x, y, f"contact of {track}", CONTACT)
            self._marks = [earlier for earlier in self._marks if earlier.text != mark.text] + [mark]
        for event in seen.events:
            child = places.get(event.children[0]) if event.children else None
            if event.kind in ("break-up", "coalescence") and child is not None:
                mark = _Mark(number + _FLASH, child.x, child.y, event.kind, BREAKUP)
                self._marks.append(mark)
        self._marks = [mark for mark in self._marks if mark.until > number]
        for mark in self._marks:
            self._labels.write(mark.text, (mark.x, mark.y), _MARK_AWAY, mark.colour)

    def _fixed(self, points: Floats) -> NDArray[np.int32]:
        # Enlarged pixels: the centre of pixel k is at s k + (s - 1)/2.
        shifted = points * self._scale + (self._scale - 1) / 2
        return np.rint(shifted * (1 << _FRACTION_BITS)).astype(np.int32)

    def _circle(self, x: float, y: float, radius: float) -> tuple[tuple[int, int], int]:
        centre = self._fixed(np.array([x, y])).tolist()
        return (centre[0], centre[1]), round(radius * self._scale * (1 << _FRACTION_BITS))

    def _line(self, image: Pixels, points: Floats, colour: Colour, *, closed: bool) -> None:
        fixed = [self._fixed(points)]
        width = 1 if closed else 2
        cv2.polylines(image, fixed, closed, colour, width, cv2.LINE_AA, _FRACTION_BITS)


class _Labels:
    """Write beside things, not on them, and not on what is written already.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3)
        Is written on.
    scale : int
        Its pixels a pixel of the film.
    outlines : list of ndarray, shape (n, 2)
        What is to stay free, pixels of the film.
    """

    def __init__(self, image: Pixels, scale: int, outlines: list[Floats]) -> None:
        self._image, self._scale = image, scale
        boxes = [np.concatenate([outline.min(axis=0), outline.max(axis=0)]) for outline in outlines]
        self._taken = np.array(boxes, dtype=np.float64).reshape(-1, 4) * scale

    def write(
        self, text: str, centre: tuple[float, float], reach: float | Floats, colour: Colour
    ) -> None:
        """Write right of, left of, above or below a thing, where there is most room.

        Parameters
        ----------
        text : str
        centre : (float, float)
        reach : float or ndarray, shape (2,)
            Half of its width and height.
        colour : (int, int, int)
        """
        (wide, high), _ = cv2.getTextSize(text, _FONT, _FONT_SCALE, 1)
        half = np.array([wide, high]) / 2.0
        middle = np.array(centre) * self._scale
        away = np.broadcast_to(np.asarray(reach, dtype=np.float64) * self._scale + 4.0, 2) + half
        boxes = []
        for side in _SIDES:
            place = middle + side * away
            boxes.append(np.concatenate([place - half, place + half]))
        box = min(boxes, key=self._covered)
        self._taken = np.vstack([self._taken, box])
        _write(self._image, text, (round(box[0]), round(box[3])), colour)

    def _covered(self, box: Floats) -> float:
        """Return how much of a box is taken or outside the image, pixels."""
        height, width = self._image.shape[:2]
        area = float(np.prod(box[2:] - box[:2]))
        inside = np.clip(np.minimum(box[2:], (width, height)) - np.maximum(box[:2], 0), 0, None)
        low = np.maximum(box[:2], self._taken[:, :2])
        high = np.minimum(box[2:], self._taken[:, 2:])
        return area - float(inside.prod()) + float(np.clip(high - low, 0, None).prod(axis=1).sum())


def _write(image: Pixels, text: str, place: tuple[int, int], colour: Colour) -> None:
    """Write in a colour with a white edge, so that it can be read on anything."""
    for ink, width in ((_WHITE, 3), (colour, 1)):
        cv2.putText(image, text, place, _FONT, _FONT_SCALE, ink, width, cv2.LINE_AA)


def _legend(width: int) -> Pixels:
    """Return a strip that says what the colours mean, on as many lines as it takes."""
    places, left, line = [], _CLOCK_WIDTH, 0
    for text, colour in _MEANINGS:
        (wide, _), _ = cv2.getTextSize(text, _FONT, _FONT_SCALE, 1)
        if left + wide + 40 > width and left > 6:
            left, line = 6, line + 1
        places.append((left, line, text, colour))
        left += wide + 40
    strip = np.full(((line + 1) * _LINE_HEIGHT, width, 3), 255, dtype=np.uint8)
    for left, line, text, colour in places:
        middle = line * _LINE_HEIGHT + _LINE_HEIGHT // 2
        cv2.line(strip, (left, middle), (left + 16, middle), colour, 2, cv2.LINE_AA)
        _write(strip, text, (left + 21, middle + 5), TEXT)
    return strip


class Thumbnail(NamedTuple):
    """A collision at its first contact and at its end, side by side.

    Attributes
    ----------
    contact_frame, track_id, obstacle_id : int
        The collision.
    pixels : ndarray of uint8, shape (side, width, 3)
        Red, green and blue; white between the two.
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
        self._before: dict[tuple[int, int], dict[int, Pixels]] = defaultdict(dict)

    def look(self, seen: Measured) -> list[Thumbnail]:
        """Take one frame, and return the pictures of the collisions that are over."""
        if not seen.met and not seen.over:
            return []
        image = rgb_of(seen.frame)
        for droplet in seen.droplets:
            fixed = np.rint(droplet.outline * 16).astype(np.int32)
            cv2.polylines(image, [fixed], True, OUTLINE, 1, cv2.LINE_AA, 4)
        for pair in seen.met:
            taken = self._before[pair]
            taken[seen.frame.number] = self._around(image, pair[1])
            if len(taken) > _MOST_TAKEN:
                del taken[min(taken)]
        return [self._joined(encounter, image) for encounter in seen.over]

    def _joined(self, over: Encounter, image: Pixels) -> Thumbnail:
        track, obstacle = over.track_id, over.obstacle_id
        taken = self._before.pop((track, obstacle))
        before = taken[min(taken, key=lambda frame: abs(frame - over.contact_frame))]
        gap = np.full((_THUMBNAIL, _BETWEEN, 3), 255, dtype=np.uint8)
        pixels = np.hstack([before, gap, self._around(image, obstacle)])
        return Thumbnail(over.contact_frame, track, obstacle, pixels)

    def _around(self, image: Pixels, obstacle: int) -> Pixels:
        x, y, radius = self._obstacles[obstacle]
        half = _AROUND * radius
        scale = _THUMBNAIL / (2.0 * half)
        moved = np.array([[scale, 0.0, scale * (half - x)], [0.0, scale, scale * (half - y)]])
        size = (_THUMBNAIL, _THUMBNAIL)
        cut: Pixels = cv2.warpAffine(image, moved, size, borderMode=cv2.BORDER_REPLICATE)
        return cut
