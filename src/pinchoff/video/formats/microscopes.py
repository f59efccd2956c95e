"""Files of Nikon's and Zeiss's microscopes, through their readers, where those are installed."""

from __future__ import annotations

import importlib
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import (
    CHOICE,
    COLOURS,
    About,
    Channels,
    Stack,
    checked_size,
    positive,
    reason_of,
)

_ADVICE = "save one position and one plane of it in Fiji as TIFF"


def _reader(name: str, path: Path) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        rule = f"left out where the module {name} is missing"
        advice = "install it with: pip install 'pinchoff[microscopes]'"
        raise InputError.of(str(path), rule, "it", advice) from None


def _opened(path: Path, reader: Callable[[str | Path], Any], kind: str) -> Any:
    try:
        return reader(path)
    except Exception as error:  # a damaged file makes the modules fail in any way
        got = reason_of(error)
        raise InputError.of(str(path), f"a readable {kind} file", got, CHOICE) from None


def _check_sizes(path: Path, sizes: dict[str, int]) -> None:
    """Refuse what has more than time, channels and a picture, or a picture of an absurd size."""
    more = [axis for axis, size in sizes.items() if size > 1 and axis not in "TCYXS0"]
    if more:
        got = " × ".join(f"{sizes[axis]} along {axis}" for axis in more)
        raise InputError.of(str(path), "frames of one plane in time", got, _ADVICE)
    checked_size(path, sizes["X"], sizes["Y"])


class NikonFile(Stack):
    """A film as NIS-Elements writes it, ``.nd2``.

    Parameters
    ----------
    path : Path
    channel : str, optional
        Name or number of one of its channels.
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        super().__init__()
        self._path, self._nd2 = path, _reader("nd2", path)
        with self._opened() as file:
            sizes = dict(file.sizes)
            _check_sizes(path, sizes)
            count = sizes.get("C", 1)
            names = _nikon_names(file, count) if count > 1 else ()
            self._several = count > 1
            self._channels = Channels(path, channel, names, colour=file.is_rgb)
            self.about = About(
                *(sizes["X"], sizes["Y"], sizes.get("T", 1), _nikon_rate(file)),
                positive(file.voxel_size().x),
                channels=self._channels.names,
                notes=self._channels.notes,
            )

    def _opened(self) -> Any:
        return _opened(self._path, self._nd2.ND2File, "ND2")

    @contextmanager
    def _reading(self) -> Iterator[Callable[[int], NDArray[Any]]]:
        with self._opened() as file:

            def read(number: int) -> NDArray[Any]:
                image = file.read_frame(number)  # (C, Y, X), (Y, X) or (Y, X, 3)
                image = image[self._channels.plane] if self._several else image
                return np.ascontiguousarray(self._channels.of(image))

            yield read


def _nikon_names(file: Any, count: int) -> tuple[str, ...]:
    """Return the names of the channels where each has its own, else their numbers."""
    metadata = getattr(file.metadata, "channels", None) or ()
    names = tuple(each.channel.name for each in metadata)
    return names if len(set(names)) == count else tuple(map(str, range(count)))


def _nikon_rate(file: Any) -> float | None:
    """Return frames a second as they were taken, or else as they were asked for."""
    for loop in file.experiment or ():
        if loop.type == "TimeLoop":
            taken = getattr(loop.parameters.periodDiff, "avg", 0.0) or 0.0
            period = positive(taken or loop.parameters.periodMs)
            return None if period is None else 1e3 / period
    return None


class ZeissFile(Stack):
    """A film as ZEN writes it, ``.czi``.

    Parameters
    ----------
    path : Path
    channel : str, optional
        Number of one of its channels.
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        super().__init__()
        self._path, self._czifile = path, _reader("czifile", path)
        with self._opened() as file:
            sizes = dict(zip(file.axes, file.shape, strict=True))
            _check_sizes(path, sizes)
            self._colour = sizes.get("0", 1) >= len(COLOURS)
            count = sizes.get("C", 1)
            names = tuple(map(str, range(count))) if count > 1 else ()
            self._channels = Channels(path, channel, names, colour=self._colour)
            pixel_um, fps = _zeiss_scale(file.metadata())
            self.about = About(
                *(sizes["X"], sizes["Y"], sizes.get("T", 1), fps, pixel_um),
                channels=self._channels.names,
                notes=self._channels.notes,
            )

    def _opened(self) -> Any:
        return _opened(self._path, lambda path: self._czifile.CziFile(str(path)), "CZI")

    @contextmanager
    def _reading(self) -> Iterator[Callable[[int], NDArray[Any]]]:
        with self._opened() as file:
            first = dict(zip(file.axes, file.start, strict=True))
            tiles: dict[int, list[tuple[int, int, Any]]] = {}
            for entry in file.filtered_subblock_directory:
                start = dict(zip(entry.axes, entry.start, strict=True))
                channel, number, top, left = (start.get(k, 0) - first.get(k, 0) for k in "CTYX")
                if channel == self._channels.plane:
                    tiles.setdefault(number, []).append((top, left, entry))
            yield lambda number: self._joined(file.dtype, tiles[number])

    def _joined(self, kind: Any, tiles: Sequence[tuple[int, int, Any]]) -> NDArray[Any]:
        """Return one frame from the tiles that it is stored in: top, left and entry of each."""
        shape = (self.about.height, self.about.width, len(COLOURS))[: 3 if self._colour else 2]
        image: NDArray[Any] = np.zeros(shape, kind)
        for top, left, entry in tiles:
            keep = tuple(slice(None) if axis in "YX0" else 0 for axis in entry.axes)
            tile = entry.data_segment().data()[keep]
            tile = tile[:, :, : len(COLOURS)] if self._colour else tile[:, :, 0]
            image[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
        return np.ascontiguousarray(self._channels.of(image))


def _zeiss_scale(metadata: str) -> tuple[float | None, float | None]:
    """Return the pixel's size in µm and frames a second, where the file says them."""
    try:
        root = ElementTree.fromstring(metadata)
    except (ElementTree.ParseError, TypeError):
        return None, None
    metres = positive(root.findtext(".//Scaling/Items/Distance[@Id='X']/Value"))
    seconds = positive(root.findtext(".//Dimensions/T/Positions/Interval/Increment"))
    return metres and metres * 1e6, seconds and 1.0 / seconds
