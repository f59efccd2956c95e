"""What a reader of one format gives: facts about the clip, and its pictures in sequence."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError

Pixels = NDArray[np.uint8]

IMAGE_SUFFIXES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp")

CHOICE = "give a film, a TIFF stack or a folder of pictures"
COLOURS = ("red", "green", "blue")
MOST_PIXELS = 2**27
"""Of one picture: what claims more is taken for damaged."""
SMALLEST_SIDE = 8
"""Pixels; no droplet fits into less."""
SPARSE = 48
"""Pictures that are enough where some may be left out."""
_MOST_NAMED = 3


@dataclass(frozen=True)
class About:
    """What a clip says of itself."""

    width: int  # pixels, as it is shown
    height: int
    count: int | None = None  # pictures; None where only reading tells
    fps: float | None = None
    pixel_size_um: float | None = None
    timed: bool = False  # whether each picture comes with its time
    channels: tuple[str, ...] = ()  # names of those that can be chosen
    notes: tuple[str, ...] = ()  # what was guessed or left out


class Planes(NamedTuple):
    """One picture as films hold it: brightness, and colour at half the resolution."""

    luma: Pixels  # (height, width)
    chroma: Pixels | None  # (2, ceil(height/2), ceil(width/2))


class Picture(NamedTuple):
    """One picture as it is in the file."""

    number: int  # from 0; what is missing in the file is missing here
    time_s: float | None  # seconds from the first; None where only its number tells
    image: Planes | NDArray[Any]  # or (height, width[, 3]): grey, or red, green and blue


class Source(Protocol):
    """A clip of some format."""

    about: About
    problems: Problems  # of the last reading

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read from the start; where `sparse`, some may be left out."""
        ...


@dataclass
class Problems:
    """What could not be read, told in one line however much it is."""

    _lost: list[str] = field(default_factory=list)
    _other: list[str] = field(default_factory=list)

    def clear(self) -> None:
        """Forget all."""
        self._lost.clear()
        self._other.clear()

    def lost(self, what: str) -> None:
        """Note a picture that is left out."""
        self._lost.append(what)

    def note(self, text: str) -> None:
        """Note something else, once."""
        if text not in self._other:
            self._other.append(text)

    def __str__(self) -> str:
        lost = [f"could not be read and are left out: {named(self._lost)}"] if self._lost else []
        return "; ".join([*lost, *self._other])


class Stack(ABC):
    """A clip whose pictures are read one by one: one that is damaged costs itself only.

    A format sets `about`, and gives in `_reading` what returns the picture at a position.
    """

    about: About

    def __init__(self) -> None:
        self.problems = Problems()

    @abstractmethod
    def _reading(self) -> AbstractContextManager[Callable[[int], NDArray[Any]]]: ...

    def _number_and_name(self, position: int) -> tuple[int, str]:
        return position, f"frame {position}"

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read from the start; where `sparse`, pictures spread over the clip."""
        self.problems.clear()
        count = self.about.count or 1
        with self._reading() as read:
            for position in range(0, count, max(1, count // SPARSE) if sparse else 1):
                number, name = self._number_and_name(position)
                try:
                    image = read(position)
                except Exception as error:  # of a damaged picture, by any of many decoders
                    self.problems.lost(f"{name} ({reason_of(error)})")
                else:
                    yield Picture(number, None, image)


def named(things: Sequence[str]) -> str:
    """Return the first of some names, and how many more there are."""
    more = len(things) - _MOST_NAMED
    return ", ".join(things[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def reason_of(error: BaseException) -> str:
    """Return what a library said, on one line; its kind of error where it said nothing."""
    return " ".join(str(error).split()) or type(error).__name__


def positive(value: Any) -> float | None:
    """Return a number that a file says, or None where it is none, or not positive and finite."""
    try:
        found = float(value)
    except (TypeError, ValueError):
        return None
    return found if math.isfinite(found) and found > 0.0 else None


class Channels:
    """Which of a clip's channels is measured: one that is asked for, by its name or number.

    Channels are pictures of their own, if there are several names of such, or else colours. `plane`
    tells which of the former is measured, `colour` which one of the latter, and `notes` what was
    chosen without being asked for.
    """

    def __init__(
        self, path: Path, asked_for: str | None, separate: Sequence[str] = (), *, colour: bool
    ) -> None:
        self.names = tuple(separate) or (COLOURS if colour else ())
        chosen = None if asked_for is None else self._index(path, asked_for)
        self.plane = (chosen or 0) if separate else 0
        self.colour = None if separate else chosen
        self.notes: tuple[str, ...] = ()
        if separate and chosen is None:
            self.notes = (
                f"it has {len(separate)} channels, {named(separate)}: the first is measured, "
                "the setting channel takes another",
            )

    def _index(self, path: Path, asked_for: str) -> int:
        wanted, known = asked_for.strip().lower(), [name.lower() for name in self.names]
        if wanted in known:
            return known.index(wanted)
        if wanted.isdigit() and int(wanted) < len(known):
            return int(wanted)
        rule, advice = "left out for a clip without channels", f"{path} has one only"
        if known:
            rule = f"one of {', '.join(self.names)}"
            advice = f"those are the channels of {path}"
        raise InputError.of("channel", rule, asked_for, advice)

    def of(self, image: NDArray[Any]) -> NDArray[Any]:
        """Return a picture, or the one colour of it that is measured."""
        return image if self.colour is None or image.ndim < 3 else image[:, :, self.colour]


def checked_size(path: Path, width: int, height: int) -> None:
    """Refuse pictures that are too small, or so large that the file must be damaged."""
    got = f"{width} × {height} pixels"
    if min(width, height) < SMALLEST_SIDE:
        rule = f"a clip of {SMALLEST_SIDE} × {SMALLEST_SIDE} pixels or more"
        raise InputError.of(str(path), rule, got, CHOICE)
    if width * height > MOST_PIXELS:
        rule = f"a clip of {MOST_PIXELS} pixels or fewer a frame"
        raise InputError.of(str(path), rule, got, "check that it is whole, or crop it")
