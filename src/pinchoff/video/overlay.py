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
    """

    def __init__(self, path: Path, obstacles: Floats, fps: float) -> None:
        self._path, self._obstacles, self._fps = path, obstacles, fps
        self._writer: ClipWriter | None = None
        self._marks: list[_Mark] = []
        self._scale = 1
        self._canvas: Pixels = np.empty((0, 0, 3), dtype=np.uint8)  # the picture above the legend
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
        pixels = rgb_of(seen.frame)
        if self._writer is None:
            self._begin(pixels)
        assert self._writer is not None
        height, width = pixels.shape[0] * self._scale, pixels.shape[1] * self._scale
        image, strip = self._canvas[:height], self._canvas[height:]
        cv2.resize(pixels, (width, height), dst=image)
        strip[:] = self._legend
        clock = f"frame {seen.frame.number}   {seen.frame.time_s:.4g} s"
        _write(strip, clock, (6, _LINE_HEIGHT - 7), TEXT)
        outlines = [droplet.outline for droplet in seen.droplets]
        boxes = np.array([[outline.min(axis=0), outline.max(axis=0)] for outline in outlines])
        labels = _Labels(image, self._scale, boxes)
        for x, y, radius in self._obstacles:
            cv2.circle(image, *self._circle(x, y, radius), OBSTACLE, 1, cv2.LINE_AA, _FRACTION_BITS)
        for droplet in seen.droplets:
            colour = CUT if droplet.cut else TOUCHING if droplet.group >= 0 else OUTLINE
            self._line(image, droplet.outline, colour, closed=True)
        for neck in seen.necks:
            self._line(image, neck, NECK, closed=False)
        for mark in self._marks_after(seen):
            labels.write(mark.text, (mark.x, mark.y), _MARK_AWAY, mark.colour)
        for number, (x, y, radius) in enumerate(self._obstacles):
            labels.write(f"o{number}", (x, y), radius, OBSTACLE)
        for droplet, track, (low, high) in zip(seen.droplets, seen.tracks, boxes, strict=True):
            labels.write(str(track), (droplet.x, droplet.y), (high - low) / 2.0, TEXT)
        self._writer.append(self._canvas)

    def _begin(self, pixels: Pixels) -> None:
        self._scale = 2 if pixels.shape[1] < _SHOWN_WIDTH else 1
        width = pixels.shape[1] * self._scale
        self._legend = _legend(width)
        height = pixels.shape[0] * self._scale + len(self._legend)
        self._canvas = np.empty((height, width, 3), dtype=np.uint8)
        self._writer = ClipWriter(self._path, (width, height), self._fps, _CRF, quick=True)
        self._writer.__enter__()

    def _marks_after(self, seen: Measured) -> list[_Mark]:
        """Return the marks of the events of this frame, and of those shortly before."""
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
        return self._marks

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

    Boxes are to stay free, (n, 2, 2), the least and largest x and y of each in pixels of the film;
    the image has `scale` pixels for each of these.
    """

    def __init__(self, image: Pixels, scale: int, boxes: Floats) -> None:
        self._image, self._scale = image, scale
        self._taken = boxes.reshape(-1, 4) * scale

    def write(
        self, text: str, centre: tuple[float, float], reach: float | Floats, colour: Colour
    ) -> None:
        """Write right of, left of, above or below a thing, where there is most room.

        Its reach is half of its width and height.
        """
        (wide, high), _ = cv2.getTextSize(text, _FONT, _FONT_SCALE, 1)
        half = np.array([wide, high]) / 2.0
        middles = np.array(centre) * self._scale + _SIDES * (reach * self._scale + 4.0 + half)
        boxes = np.hstack([middles - half, middles + half])
        box = boxes[np.argmin(self._covered(boxes))]
        self._taken = np.concatenate([self._taken, box[None]])
        _write(self._image, text, (round(box[0]), round(box[3])), colour)

    def _covered(self, boxes: Floats) -> Floats:
        """Return how much of each of several boxes is taken or outside the image, pixels."""
        height, width = self._image.shape[:2]
        sides = boxes[:, 2:] - boxes[:, :2]
        inside = np.minimum(boxes[:, 2:], (width, height)) - np.maximum(boxes[:, :2], 0)
        low = np.maximum(boxes[:, None, :2], self._taken[:, :2])
        shared = np.maximum(np.minimum(boxes[:, None, 2:], self._taken[:, 2:]) - low, 0)
        taken = (shared[:, :, 0] * shared[:, :, 1]).sum(axis=1)
        covered: Floats = sides.prod(axis=1) - np.maximum(inside, 0).prod(axis=1) + taken
        return covered


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


class ThumbnailTaker:
    """Take two pictures of every collision while its clip is measured."""

    def __init__(self, obstacles: Floats) -> None:
        self._obstacles = obstacles
        self._before: dict[tuple[int, int], dict[int, Pixels]] = defaultdict(dict)

    def look(self, seen: Measured) -> list[tuple[Encounter, Pixels]]:
        """Take one frame, and return the collisions that are over, each with its two pictures."""
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
        return [(encounter, self._joined(encounter, image)) for encounter in seen.over]

    def _joined(self, over: Encounter, image: Pixels) -> Pixels:
        """Return contact and end side by side, (side, width, 3), with white between."""
        taken = self._before.pop((over.track_id, over.obstacle_id))
        before = taken[min(taken, key=lambda frame: abs(frame - over.contact_frame))]
        gap = np.full((_THUMBNAIL, _BETWEEN, 3), 255, dtype=np.uint8)
        return np.hstack([before, gap, self._around(image, over.obstacle_id)])

    def _around(self, image: Pixels, obstacle: int) -> Pixels:
        x, y, radius = self._obstacles[obstacle]
        half = _AROUND * radius
        scale = _THUMBNAIL / (2.0 * half)
        moved = np.array([[scale, 0.0, scale * (half - x)], [0.0, scale, scale * (half - y)]])
        size = (_THUMBNAIL, _THUMBNAIL)
        cut: Pixels = cv2.warpAffine(image, moved, size, borderMode=cv2.BORDER_REPLICATE)
        return cut
