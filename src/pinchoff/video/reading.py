"""Reading clips: frames in sequence, each with the time at which it is shown.

A clip is a video file that PyAV opens, a multi-page TIFF or a folder of images. Every frame comes
as brightness at full resolution and colour at half of it, whatever the file holds.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.writing import require_video_extra

Pixels = NDArray[np.uint8]

IMAGE_SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp")
VIDEO_SUFFIXES = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".wmv")

DEFAULT_FPS = 60.0
"""Frames a second of images without times, unless said otherwise [paper, sec. 2]."""

_PLANAR = ("yuv420p", "yuvj420p")
_CHOICE = "give a video, a multi-page TIFF or a folder of images"


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
    warning: str = field(default="", init=False)

    def __post_init__(self) -> None:
        if not self.path.exists():
            raise InputError.of(str(self.path), "an existing clip", "nothing there", _CHOICE)

    @property
    def name(self) -> str:
        """The clip's name in tables and files."""
        return self.path.name if self.path.is_dir() else self.path.stem

    def frames(self, *, sparse: bool = False) -> Iterator[Frame]:
        """Read all frames in sequence; one is held at a time.

        Parameters
        ----------
        sparse : bool, optional
            Whether frames on which no others depend may be left out, which is faster; the others
            are numbered by their times, at the file's mean rate.

        Yields
        ------
        Frame

        Raises
        ------
        InputError
            Not even the first frame can be read. What can be read of a damaged file is read, and
            `warning` says where it ended.
        """
        self.warning = ""
        if self.path.is_dir():
            reader = self._images(_image_files(self.path))
        elif self.path.suffix.lower() in IMAGE_SUFFIXES:
            reader = self._pages()
        else:
            reader = self._video(sparse)
        size = None
        for frame in reader:
            size = size or frame.luma.shape
            if frame.luma.shape != size:
                self.warning = f"frame {frame.number} has another size; what follows was left out"
                return
            yield frame
        if size is None:
            raise InputError.of(
                str(self.path), "a clip with frames", self.warning or "none", _CHOICE
            )

    def _video(self, sparse: bool) -> Iterator[Frame]:
        av = require_video_extra("video")
        try:
            container = av.open(str(self.path))
        except (av.FFmpegError, OSError, ValueError) as error:
            got = str(getattr(error, "strerror", None) or error)
            raise InputError.of(str(self.path), "a readable video", got, _CHOICE) from None
        with container:
            if not container.streams.video:
                raise InputError.of(str(self.path), "a video", "no pictures in it", _CHOICE)
            stream = container.streams.video[0]
            stream.codec_context.thread_type = "SLICE"
            stream.codec_context.thread_count = 1  # clips run side by side, one a core
            if sparse:
                stream.codec_context.skip_frame = "NONREF"
            rate = float(stream.average_rate or DEFAULT_FPS)
            start = None
            index = 0
            try:
                for picture in container.decode(stream):
                    time = index / rate if picture.time is None else picture.time
                    start = time if start is None else start
                    number = round((time - start) * rate) if sparse else index
                    shown = number / self.fps if self.fps else time - start
                    yield Frame(number, float(shown), *_planes(picture))
                    index += 1
            except (av.FFmpegError, ValueError) as error:
                self.warning = f"damaged after frame {index - 1}: {error}"

    def _images(self, files: list[Path]) -> Iterator[Frame]:
        depth = None
        for index, path in enumerate(files):
            image = cv2.imdecode(np.fromfile(path, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
            if image is None:
                self.warning = f"{path.name} is no image; what follows was left out"
                return
            depth = depth or _bit_depth(image)
            yield Frame(index, index / (self.fps or DEFAULT_FPS), *_split(image, depth))

    def _pages(self) -> Iterator[Frame]:
        count = cv2.imcount(str(self.path))
        depth = None
        for index in range(count):
            found, pages = cv2.imreadmulti(str(self.path), index, 1, flags=cv2.IMREAD_UNCHANGED)
            if not found:
                self.warning = f"page {index} cannot be read; what follows was left out"
                return
            depth = depth or _bit_depth(pages[0])
            yield Frame(index, index / (self.fps or DEFAULT_FPS), *_split(pages[0], depth))


def _image_files(folder: Path) -> list[Path]:
    files = [path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES]

    def natural(path: Path) -> list[Any]:
        return [int(s) if s.isdigit() else s for s in re.split(r"(\d+)", path.name)]

    return sorted(files, key=natural)


def _planes(picture: Any) -> tuple[Pixels, Pixels | None]:
    grey = picture.format.name.startswith(("gray", "mono"))
    if grey:
        return np.ascontiguousarray(picture.to_ndarray(format="gray")), None
    if picture.format.name not in _PLANAR:
        picture = picture.reformat(format="yuv420p")
    luma, *chroma = (_plane(plane) for plane in picture.planes)
    return luma, np.stack(chroma)


def _plane(plane: Any) -> Pixels:
    # Rows are padded; the copy outlives the decoder's buffer.
    rows = np.frombuffer(plane, dtype=np.uint8).reshape(plane.height, plane.line_size)
    return np.ascontiguousarray(rows[:, : plane.width])


def _bit_depth(image: NDArray[Any]) -> int:
    """Return the number of bits that a camera filled: 12 bits are often stored in 16."""
    if image.dtype == np.uint8:
        return 8
    return min(16, max(8, 2 * -(-int(image.max()).bit_length() // 2)))


def _split(image: NDArray[Any], depth: int) -> tuple[Pixels, Pixels | None]:
    if image.dtype != np.uint8:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            image = np.clip(image * 2.0 ** (8 - depth), 0, 255)
        image = np.nan_to_num(image).astype(np.uint8)
    if image.ndim == 2:
        return np.ascontiguousarray(image), None
    yuv = cv2.cvtColor(np.ascontiguousarray(image[:, :, :3]), cv2.COLOR_BGR2YUV)
    height, width = yuv.shape[:2]
    half = (-(-width // 2), -(-height // 2))
    chroma = cv2.resize(yuv[:, :, 1:], half, interpolation=cv2.INTER_AREA)
    luma = np.ascontiguousarray(yuv[:, :, 0])
    return luma, np.ascontiguousarray(np.moveaxis(chroma, 2, 0))
