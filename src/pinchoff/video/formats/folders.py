"""Folders of pictures: the numbers in their names are the numbers of the frames."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import (
    CHOICE,
    COLOURS,
    IMAGE_SUFFIXES,
    About,
    Channels,
    Stack,
    checked_size,
    named,
    reason_of,
)
from pinchoff.video.formats.tiff import read_picture

_SIZED = 15  # pictures, spread over the folder, that tell which size is the sequence's
_MOST_SPREAD = 1000  # frames a picture, beyond which numbers are dates rather than counts
_JPEG_END = b"\xff\xd9"
_JPEG_TAIL = 4096  # bytes in which it stands; cameras pad


class PictureFolder(Stack):
    """A folder of pictures, or one picture alone.

    Files belong to the sequence if their names differ in one number only and they have the size
    of most. Of several sequences the longest is taken; the other pictures are named in the notes.

    Parameters
    ----------
    path : Path
    channel : str, optional
        "red", "green" or "blue".
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        super().__init__()
        self._path = path
        self._numbers, self._files, notes = _sequence(path) if path.is_dir() else ([0], [path], [])
        (height, width), self._in_colour = self._common_shape()
        checked_size(path, width, height)
        self._channels = Channels(path, channel, colour=self._in_colour)
        self.about = About(
            width, height, len(self._files), channels=self._channels.names, notes=tuple(notes)
        )

    def _common_shape(self) -> tuple[tuple[int, int], bool]:
        """Return the size of most pictures, and whether these have colour."""
        every = max(1, len(self._files) // _SIZED)
        shapes: Counter[tuple[int, ...]] = Counter()
        problem = ""
        for path in self._files[::every] + self._files[: every if every > 1 else 0]:
            try:
                shapes[decoded(path).shape] += 1
            except Exception as error:  # any decoder, of a damaged file
                problem = problem or f"{path.name}: {reason_of(error)}"
        if not shapes:
            folder = self._path.is_dir()
            rule = "a folder with readable pictures" if folder else "a readable picture"
            raise InputError.of(str(self._path), rule, problem, CHOICE)
        shape = shapes.most_common(1)[0][0]
        return (shape[0], shape[1]), len(shape) == 3

    def _number_and_name(self, position: int) -> tuple[int, str]:
        return self._numbers[position] - self._numbers[0], self._files[position].name

    @contextmanager
    def _reading(self) -> Iterator[Callable[[int], NDArray[Any]]]:
        yield lambda position: self._alike(decoded(self._files[position]))

    def _alike(self, image: NDArray[Any]) -> NDArray[Any]:
        """Return a picture with colour if most have it, and without if not."""
        height, width = image.shape[:2]
        if (width, height) != (self.about.width, self.about.height):
            raise ValueError(f"{width} × {height} pixels")
        if self._in_colour and image.ndim == 2:
            image = np.repeat(image[:, :, None], len(COLOURS), axis=2)
        elif not self._in_colour and image.ndim == 3:
            self.problems.note("some pictures have colour, which is left out")
            image = image.mean(axis=2).astype(image.dtype)
        return self._channels.of(image)


def _sequence(folder: Path) -> tuple[list[int], list[Path], list[str]]:
    """Return the numbers and files of a folder's pictures in order, and notes on what is odd."""
    files = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix.lower() in IMAGE_SUFFIXES
        and path.is_file()
        and not path.name.startswith(".")
    ]
    if not files:
        raise InputError.of(str(folder), "a folder with pictures", "none", CHOICE)
    by_pattern: dict[str, list[Path]] = defaultdict(list)
    for path in files:
        by_pattern[re.sub(r"\d+", "#", path.name.lower())].append(path)
    longest = max(by_pattern, key=lambda pattern: (len(by_pattern[pattern]), pattern))
    if "#" not in longest:  # without numbers, the names give the order
        return list(range(len(files))), files, []
    own, notes = by_pattern.pop(longest), []
    left_out = sorted(path.name for others in by_pattern.values() for path in others)
    if left_out:
        notes.append(f"not of the sequence and left out: {named(left_out)}")
    by_number = dict(sorted(zip(_frame_numbers(folder, own), own, strict=True)))
    numbers, own = list(by_number), list(by_number.values())
    missing = numbers[-1] - numbers[0] + 1 - len(numbers)
    if numbers[-1] - numbers[0] > _MOST_SPREAD * len(numbers):
        notes.append("the numbers in the names count no frames: one picture follows the other")
        numbers = list(range(len(numbers)))
    elif missing:
        notes.append(
            f"by their names {missing} of {missing + len(numbers)} pictures are missing: "
            "time runs on where they are"
        )
    return numbers, own, notes


def _frame_numbers(folder: Path, files: Sequence[Path]) -> list[int]:
    """Return the number in each name that counts the frames: no two share it, and it spans least.

    Raises
    ------
    InputError
        There is none, as where names number channels or positions too.
    """
    table = [[int(text) for text in re.findall(r"\d+", path.name)] for path in files]
    columns = [list(column) for column in zip(*table, strict=True)]
    counting = [column for column in columns if len(set(column)) == len(files)]
    if not counting:
        two = [path.name for path in sorted(files)[:2]]
        rule = "a folder whose pictures have a number each"
        advice = "put each channel and each position into a folder of its own"
        raise InputError.of(str(folder), rule, named(two), advice)
    return min(counting, key=lambda column: max(column) - min(column))


def decoded(path: Path) -> NDArray[Any]:
    """Return a picture: (height, width) or (height, width, 3) of red, green and blue.

    Whatever a decoder raises is raised; a file that breaks off is not taken for whole.
    """
    head = path.read_bytes() if path.suffix.lower() not in (".tif", ".tiff") else b""
    if head.startswith(b"\x89PNG"):
        image = imagecodecs.png_decode(head)
    elif head.startswith(b"\xff\xd8"):
        if _JPEG_END not in head[-_JPEG_TAIL:]:
            raise ValueError("the file breaks off")
        image = imagecodecs.jpeg_decode(head)
    elif head.startswith(b"BM"):
        image = imagecodecs.bmp_decode(head)
    elif head and not head.startswith((b"II", b"MM")):
        raise ValueError("it is no picture")
    else:
        image = read_picture(path)
    if image.ndim == 3:
        image = image[:, :, : len(COLOURS)] if image.shape[2] >= len(COLOURS) else image[:, :, 0]
    return np.asarray(image)
