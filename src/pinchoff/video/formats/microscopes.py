"""Files of Nikon's and Zeiss's microscopes, through their readers, where those are installed."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

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

_ADVICE = "save one position and one plane of it in Fiji as TIFF"


def _reader(name: str, path: Path) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        rule = f"left out where the module {name} is missing"
        advice = "install it with: pip install 'pinchoff[microscopes]'"
        raise InputError.of(str(path), rule, "it", advice) from None


def _only_time(path: Path, sizes: dict[str, int]) -> None:
    """Refuse what has more than time, channels and a picture."""
    more = [axis for axis, size in sizes.items() if size > 1 and axis not in "TCYXS0"]
    if more:
        got = " × ".join(f"{sizes[axis]} along {axis}" for axis in more)
        raise InputError.of(str(path), "frames of one plane in time", got, _ADVICE)


def _channel_notes(names: Sequence[str], channel: int | None) -> tuple[str, ...]:
    if len(names) < 2 or channel is not None:
        return ()
    return (
        f"it has {len(names)} channels, {named(names)}: the first is measured, "
        "the setting channel takes another",
    )


class NikonFile:
    """A film as NIS-Elements writes it, ``.nd2``.

    Parameters
    ----------
    path : Path
    channel : str, optional
        Name or number of one of its channels.

    Attributes
    ----------
    about : About
    problems : Problems
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        self._path, self._nd2 = path, _reader("nd2", path)
        self.problems = Problems()
        with self._opened() as file:
            sizes = dict(file.sizes)
            _only_time(path, sizes)
            checked_size(path, sizes["X"], sizes["Y"])
            several = sizes.get("C", 1) > 1
            names: tuple[str, ...] = COLOURS if file.is_rgb else ()
            if several:
                metadata = getattr(file.metadata, "channels", None) or ()
                names = tuple(each.channel.name for each in metadata)
                if len(set(names)) != sizes["C"]:
                    names = tuple(map(str, range(sizes["C"])))
            self._several = several
            self._channel = channel_index(channel, names, path)
            pixel = float(file.voxel_size().x)
            notes = _channel_notes(names, self._channel) if several else ()
            self.about = About(
                sizes["X"],
                sizes["Y"],
                sizes.get("T", 1),
                _nikon_rate(file),
                pixel if pixel > 0.0 else None,
                False,
                names,
                notes,
            )

    def _opened(self) -> Any:
        try:
            return self._nd2.ND2File(self._path)
        except Exception as error:  # a damaged file makes the module fail in any way
            got = reason_of(error)
            raise InputError.of(str(self._path), "a readable ND2 file", got, CHOICE) from None

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read from the start; where `sparse`, pictures spread over the clip."""
        self.problems.clear()
        count = self.about.count or 1
        with self._opened() as file:
            for number in range(0, count, max(1, count // SPARSE) if sparse else 1):
                try:
                    image = file.read_frame(number)  # (C, Y, X), (Y, X) or (Y, X, 3)
                except Exception as error:  # of a damaged frame
                    self.problems.lost(f"frame {number} ({reason_of(error)})")
                    continue
                if self._several:
                    image = image[self._channel or 0]
                elif self._channel is not None:
                    image = image[:, :, self._channel]
                yield Picture(number, None, np.ascontiguousarray(image))


def _nikon_rate(file: Any) -> float | None:
    """Return frames a second as they were taken, or else as they were asked for."""
    for loop in file.experiment or ():
        if loop.type == "TimeLoop":
            taken = getattr(loop.parameters.periodDiff, "avg", 0.0) or 0.0
            period = taken or loop.parameters.periodMs
            return 1e3 / period if period > 0.0 else None
    return None


class ZeissFile:
    """A film as ZEN writes it, ``.czi``.

    Parameters
    ----------
    path : Path
    channel : str, optional
        Number of one of its channels.

    Attributes
    ----------
    about : About
    problems : Problems
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        self._path, self._czifile = path, _reader("czifile", path)
        self.problems = Problems()
        with self._opened() as file:
            sizes = dict(zip(file.axes, file.shape, strict=True))
            _only_time(path, sizes)
            checked_size(path, sizes["X"], sizes["Y"])
            self._colour = sizes.get("0", 1) >= len(COLOURS)
            names = tuple(map(str, range(sizes.get("C", 1)))) if sizes.get("C", 1) > 1 else ()
            names = names or (COLOURS if self._colour else ())
            self._several = sizes.get("C", 1) > 1
            self._channel = channel_index(channel, names, path)
            pixel_um, fps = _zeiss_scale(file.metadata())
            notes = _channel_notes(names, self._channel) if self._several else ()
            self.about = About(
                sizes["X"], sizes["Y"], sizes.get("T", 1), fps, pixel_um, False, names, notes
            )

    def _opened(self) -> Any:
        try:
            return self._czifile.CziFile(str(self._path))
        except Exception as error:  # a damaged file makes the module fail in any way
            got = reason_of(error)
            raise InputError.of(str(self._path), "a readable CZI file", got, CHOICE) from None

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read from the start; where `sparse`, pictures spread over the clip."""
        self.problems.clear()
        wanted = (self._channel or 0) if self._several else 0
        count = self.about.count or 1
        with self._opened() as file:
            parts: dict[int, list[Any]] = {}
            for entry in file.filtered_subblock_directory:
                place = dict(zip(entry.axes, entry.start, strict=True))
                start = dict(zip(file.axes, file.start, strict=True))
                if place.get("C", 0) - start.get("C", 0) == wanted:
                    parts.setdefault(place.get("T", 0) - start.get("T", 0), []).append(entry)
            for number in range(0, count, max(1, count // SPARSE) if sparse else 1):
                try:
                    image = self._joined(file, parts[number])
                except Exception as error:  # of a damaged block
                    self.problems.lost(f"frame {number} ({reason_of(error)})")
                    continue
                yield Picture(number, None, image)

    def _joined(self, file: Any, entries: Sequence[Any]) -> NDArray[Any]:
        """Return one frame from the tiles that it is stored in."""
        first = dict(zip(file.axes, file.start, strict=True))
        shape = (self.about.height, self.about.width, len(COLOURS))[: 3 if self._colour else 2]
        image: NDArray[Any] = np.zeros(shape, file.dtype)
        for entry in entries:
            place = dict(zip(entry.axes, entry.start, strict=True))
            tile = entry.data_segment().data()
            axes = entry.axes
            keep = tuple(slice(None) if axis in "YX0" else 0 for axis in axes)
            tile = tile[keep]
            tile = tile[:, :, : len(COLOURS)] if self._colour else tile[:, :, 0]
            top, left = place["Y"] - first["Y"], place["X"] - first["X"]
            image[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
        if self._colour and self._channel is not None and not self._several:
            image = image[:, :, self._channel]
        return np.ascontiguousarray(image)


def _zeiss_scale(metadata: str) -> tuple[float | None, float | None]:
    """Return the pixel's size in µm and frames a second, where the file says them."""
    try:
        root = ElementTree.fromstring(metadata)
    except (ElementTree.ParseError, TypeError):
        return None, None
    size = root.findtext(".//Scaling/Items/Distance[@Id='X']/Value")
    interval = root.findtext(".//Dimensions/T/Positions/Interval/Increment")
    values = []
    for text in (size, interval):
        try:
            value = float(text or "")
        except ValueError:
            value = 0.0
        values.append(value if value > 0.0 else None)
    metres, seconds = values
    return (None if metres is None else metres * 1e6), (None if seconds is None else 1.0 / seconds)
