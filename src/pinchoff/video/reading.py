"""Reading clips: frames in sequence, each with the time at which it is shown.

A clip is a film, a TIFF stack, a file of a microscope or a folder of pictures
(`pinchoff.video.formats`). Every frame comes as brightness at full resolution and colour at half
of it, whatever the file holds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats import STACK_SUFFIXES, opened
from pinchoff.video.formats.selection import ALL_FRAMES
from pinchoff.video.formats.source import (
    CHOICE,
    IMAGE_SUFFIXES,
    About,
    Pixels,
    Planes,
    Source,
)
from pinchoff.video.formats.whitepoint import BYTES, Range, range_of, to_bytes, without_gaps

DEFAULT_FPS = 60.0
"""Frames a second of pictures without times, unless said otherwise [paper, sec. 2]."""

Crop = tuple[int, int, int, int]
"""Left, top, width and height of a part of the picture, pixels; left and top even."""


class Frame(NamedTuple):
    """One frame of a clip.

    Attributes
    ----------
    number : int
        From 0.
    time_s : float
        When it is shown, seconds from the first frame.
    luma : ndarray of uint8, shape (height, width)
        Brightness.
    chroma : ndarray of uint8, shape (2, ceil(height/2), ceil(width/2)), or None
        Blue and red difference, 128 without colour; None for a clip of grey frames.
    """

    number: int
    time_s: float
    luma: Pixels
    chroma: Pixels | None


@dataclass
class Clip:
    """A clip that can be read from its start, any number of times.

    Parameters
    ----------
    path : Path
        The file or folder.
    fps : float, optional
        Frames a second; by default the times are those that the file gives.
    frames_wanted : range, optional
        Which frames are read; they keep their numbers and times.
    crop : (int, int, int, int), optional
        Left, top, width and height of the part that is read, pixels.
    channel : str, optional
        Name or number of a channel, or red, green or blue.

    Attributes
    ----------
    warning : str
        What went wrong while it was last read; empty when nothing did.

    Raises
    ------
    InputError
        There is nothing to read.
    """

    path: Path
    fps: float | None = None
    frames_wanted: range = ALL_FRAMES
    crop: Crop | None = None
    channel: str | None = None
    warning: str = field(default="", init=False)
    _source: Source = field(init=False, repr=False)
    _range: Range | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        self._source = opened(self.path, self.channel)
        about = self._source.about
        if self.crop is not None:
            left, top, width, height = self.crop
            if left + width > about.width or top + height > about.height:
                rule = f"within {about.width} × {about.height} pixels"
                raise InputError.of("crop", rule, str(self.crop), "make it smaller")
        if not (self.fps or about.fps or about.timed or not _is_film(self.path)):
            rule, got = "given for a film without times", "nothing"
            raise InputError.of(
                "fps", rule, got, f"say at how many frames a second {self.path} was taken"
            )

    @property
    def name(self) -> str:
        """The clip's name in tables and files."""
        return self.path.name if self.path.is_dir() else self.path.stem

    @property
    def about(self) -> About:
        """What the file says of itself."""
        return self._source.about

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of what is read, pixels."""
        if self.crop is not None:
            return self.crop[2], self.crop[3]
        return self.about.width, self.about.height

    @property
    def frame_count(self) -> int | None:
        """How many frames are read, where the file says it."""
        count = self.about.count
        wanted = self.frames_wanted
        return (
            None if count is None else len(range(count)[wanted.start : wanted.stop : wanted.step])
        )

    def frames(self, *, sparse: bool = False) -> Iterator[Frame]:
        """Read all frames in sequence; one is held at a time.

        Where `sparse`, frames may be left out if that is faster; the others keep their numbers.
        What can be read of a damaged file is read, and `warning` says what was left out.

        Raises
        ------
        InputError
            Not even one frame can be read.
        """
        self.warning = ""
        shape, gaps = None, 0
        try:
            for number, time, image in self._source.pictures(sparse=sparse):
                if number >= self.frames_wanted.stop:
                    break
                if number not in self.frames_wanted:
                    continue
                planes, lost = self._planes(image)
                gaps += lost
                if shape is not None and planes.luma.shape != shape:
                    self._source.problems.note(
                        f"from frame {number} on it has another size: left out"
                    )
                    break
                shape = planes.luma.shape
                yield Frame(number, self._time(number, time), *planes)
            if gaps:
                self._source.problems.note(
                    f"{gaps} values are no numbers: the median of their frame stands for them"
                )
        finally:
            self.warning = str(self._source.problems)
        if shape is None:
            got = self.warning or "none"
            if self.frames_wanted != ALL_FRAMES:
                got = f"none of {self.about.count or 'its'} frames"
            raise InputError.of(str(self.path), "a clip with frames", got, CHOICE)

    def _time(self, number: int, time: float | None) -> float:
        if self.fps or time is None:
            return number / (self.fps or self.about.fps or DEFAULT_FPS)
        return time

    def _planes(self, image: Planes | NDArray[Any]) -> tuple[Planes, int]:
        gaps = 0
        if not isinstance(image, Planes):
            image, gaps = without_gaps(image)
            values = BYTES if image.dtype == np.uint8 else self._values()
            image = _split(to_bytes(image, values))
        if self.crop is None:
            return image, gaps
        left, top, width, height = self.crop
        luma = np.ascontiguousarray(image.luma[top : top + height, left : left + width])
        chroma = image.chroma
        if chroma is not None:
            rows = slice(top // 2, top // 2 + -(-height // 2))
            columns = slice(left // 2, left // 2 + -(-width // 2))
            chroma = np.ascontiguousarray(chroma[:, rows, columns])
        return Planes(luma, chroma), gaps

    def _values(self) -> Range:
        """Return what is black and white in this clip; that takes one reading, once."""
        if self._range is None:
            source = opened(self.path, self.channel)
            images = (picture.image for picture in source.pictures())
            self._range = range_of(image for image in images if not isinstance(image, Planes))
        return self._range


def _is_film(path: Path) -> bool:
    still = (*IMAGE_SUFFIXES, *STACK_SUFFIXES, ".nd2", ".czi")
    return not path.is_dir() and path.suffix.lower() not in still


def _split(image: Pixels) -> Planes:
    """Return brightness and colour of a picture, (height, width) or (height, width, 3)."""
    if image.ndim == 2:
        return Planes(np.ascontiguousarray(image), None)
    yuv = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2YUV)
    height, width = yuv.shape[:2]
    half = (-(-width // 2), -(-height // 2))
    luma, *colour = cv2.split(yuv)
    chroma = [cv2.resize(plane, half, interpolation=cv2.INTER_AREA) for plane in colour]
    return Planes(luma, np.stack(chroma))
