"""Folders of pictures: the numbers in their names are the numbers of the frames."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import (
    CHOICE,
    COLOURS,
    SPARSE,
    About,
    Picture,
    Problems,
    channel_index,
    checked_size,
    named,
    reason_of,
)
from pinchoff.video.formats.tiff import read_picture

SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp")

_SIZED = 15  # pictures, spread over the folder, that tell which size is the sequence's
_MOST_SPREAD = 1000  # frames a picture, beyond which numbers are dates rather than counts
_JPEG_END = b"\xff\xd9"
_JPEG_TAIL = 4096  # bytes in which it stands; cameras pad


class PictureFolder:
    """A folder of pictures.

    Files belong to the sequence if their names differ in one number only and they have the size
    of most. Of several sequences the longest is taken; the other pictures are named in the notes.

    Parameters
    ----------
    path : Path
    channel : str, optional
        "red", "green" or "blue".

    Attributes
    ----------
    about : About
    problems : Problems
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        self._path = path
        self.problems = Problems()
        files = [each for each in path.iterdir() if _is_picture(each)]
        if not files:
            raise InputError.of(str(path), "a folder with pictures", "none", CHOICE)
        self._sequence, left_out = _sequence(path, files)
        self._shape, colour = self._common_shape()
        checked_size(path, self._shape[1], self._shape[0])
        names = COLOURS if colour else ()
        self._colour = colour
        self._channel = channel_index(channel, names, path)
        notes = [f"not of the sequence and left out: {named(left_out)}"] if left_out else []
        numbers = [each.number for each in self._sequence]
        if numbers[-1] - numbers[0] > _MOST_SPREAD * len(numbers):
            notes.append("the numbers in the names count no frames: one picture follows the other")
            numbers = list(range(len(numbers)))
            files = [each.path for each in self._sequence]
            self._sequence = [_Numbered(*each) for each in zip(files, numbers, strict=True)]
        missing = numbers[-1] - numbers[0] + 1 - len(numbers)
        if missing:
            notes.append(
                f"by their names {missing} of {missing + len(numbers)} pictures are missing: "
                "time runs on where they are"
            )
        height, width = self._shape
        self.about = About(width, height, len(numbers), channels=names, notes=tuple(notes))

    def _common_shape(self) -> tuple[tuple[int, int], bool]:
        """Return the size of most pictures, and whether these have colour."""
        every = max(1, len(self._sequence) // _SIZED)
        shapes: Counter[tuple[int, ...]] = Counter()
        problem = ""
        for each in self._sequence[::every] + self._sequence[: every if every > 1 else 0]:
            try:
                shapes[decoded(each.path).shape] += 1
            except Exception as error:  # any decoder, of a damaged file
                problem = problem or f"{each.path.name}: {reason_of(error)}"
        if not shapes:
            raise InputError.of(str(self._path), "a folder with readable pictures", problem, CHOICE)
        shape = shapes.most_common(1)[0][0]
        return (shape[0], shape[1]), len(shape) == 3

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read in the order of the numbers; where `sparse`, pictures spread over the folder."""
        self.problems.clear()
        first = self._sequence[0].number
        every = max(1, len(self._sequence) // SPARSE) if sparse else 1
        for path, number in self._sequence[::every]:
            try:
                image = decoded(path)
            except Exception as error:  # any decoder, of a damaged file
                self.problems.lost(f"{path.name} ({reason_of(error)})")
                continue
            if image.shape[:2] != self._shape:
                self.problems.lost(f"{path.name} ({image.shape[1]} × {image.shape[0]} pixels)")
                continue
            yield Picture(number - first, None, self._alike(image))

    def _alike(self, image: NDArray[Any]) -> NDArray[Any]:
        """Return a picture with colour if most have it, and without if not."""
        if self._colour and image.ndim == 2:
            image = np.repeat(image[:, :, None], len(COLOURS), axis=2)
        elif not self._colour and image.ndim == 3:
            self.problems.note("some pictures have colour, which is left out")
            image = image.mean(axis=2).astype(image.dtype)
        return image if self._channel is None else image[:, :, self._channel]


class PictureFile(PictureFolder):
    """One picture alone."""

    def __init__(self, path: Path, channel: str | None = None) -> None:
        self._path = path
        self.problems = Problems()
        self._sequence = [_Numbered(path, 0)]
        self._shape, self._colour = self._common_shape()
        checked_size(path, self._shape[1], self._shape[0])
        names = COLOURS if self._colour else ()
        self._channel = channel_index(channel, names, path)
        self.about = About(self._shape[1], self._shape[0], 1, channels=names)


class _Numbered(NamedTuple):
    path: Path
    number: int


def _is_picture(path: Path) -> bool:
    return path.suffix.lower() in SUFFIXES and path.is_file() and not path.name.startswith(".")


def _sequence(folder: Path, files: Sequence[Path]) -> tuple[list[_Numbered], list[str]]:
    """Return the pictures of a folder with their numbers in order, and the names of the others."""
    by_pattern: dict[str, list[Path]] = defaultdict(list)
    for path in files:
        by_pattern[re.sub(r"\d+", "#", path.name.lower())].append(path)
    longest = max(by_pattern, key=lambda pattern: (len(by_pattern[pattern]), pattern))
    if "#" not in longest:  # without numbers, the names give the order
        numbered = [_Numbered(path, k) for k, path in enumerate(sorted(files))]
        return numbered, []
    own = by_pattern[longest]
    numbers = _frame_numbers(folder, own)
    left_out = sorted(path.name for path in files if path not in own)
    return sorted(map(_Numbered, own, numbers), key=lambda each: each.number), left_out


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
