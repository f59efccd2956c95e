"""Films of Phantom cameras, ``.cine``: the rate is that of recording, as the header says it.

Grey pictures of 8 to 16 bits are read here, packed or not; coloured ones through FFmpeg. The fields
and packings are those that Vision Research publishes in "Cine file format".
"""

from __future__ import annotations

import dataclasses
import os
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.films import Film
from pinchoff.video.formats.source import (
    About,
    Channels,
    Source,
    Stack,
    checked_size,
    reason_of,
)

_ADVICE = "save it anew from the maker's PCC as an uncompressed cine, TIFF or AVI"

_FILE_HEADER = struct.Struct("<2sHHHiIiIIIIQ")
_PICTURE_HEADER = struct.Struct("<IiiHHIIiiII")
_MARK, _RATE, _COLOURS_IN = 140, 768, 808  # bytes into the setup block
_JPEG = 1  # compression of the whole film
_PACKED = {0x100: 10, 0x400: 12}  # bits of a pixel, by the compression of a picture
_ANNOTATION = 8  # least bytes before a picture: their own count and the picture's


class _Header(NamedTuple):
    """What the headers say; offsets in bytes from the start of the file."""

    width: int
    height: int
    bits: int  # of a pixel in the file
    packed: bool
    size: int  # of one picture, bytes
    rate: float | None
    grey: bool
    offsets: tuple[int, ...]


def opened_phantom(path: Path, channel: str | None = None) -> Source:
    """Return what reads a film of a Phantom camera.

    Raises
    ------
    InputError
        It is damaged, or compressed in a way that is not read here.
    """
    header = _read_header(path)
    if header.grey:
        return PhantomFile(path, header, channel)
    film = Film(path, channel)
    film.about = dataclasses.replace(
        film.about, count=len(header.offsets), fps=header.rate, timed=False
    )
    return film


class PhantomFile(Stack):
    """A grey film of a Phantom camera.

    Parameters
    ----------
    path : Path
    header : _Header
    channel : str, optional
        Refused: it has one only.
    """

    def __init__(self, path: Path, header: _Header, channel: str | None = None) -> None:
        super().__init__()
        Channels(path, channel, colour=False)
        self._path, self._header = path, header
        self.about = About(header.width, header.height, len(header.offsets), header.rate)

    @contextmanager
    def _reading(self) -> Iterator[Callable[[int], NDArray[Any]]]:
        with self._path.open("rb") as file:
            yield lambda number: self._picture(file, self._header.offsets[number])

    def _picture(self, file: BinaryIO, offset: int) -> NDArray[Any]:
        header = self._header
        file.seek(offset)
        before = int.from_bytes(file.read(4), "little")
        if before < _ANNOTATION:
            raise ValueError("no picture at its place")
        file.seek(offset + before)
        data = file.read(header.size)
        if len(data) < header.size:
            raise ValueError("the file ends within it")
        shape = (header.height, header.width)
        if header.packed:
            packed = imagecodecs.packints_decode(
                data, np.uint16, header.bits, runlen=header.width * header.height
            )
            return packed.reshape(shape)
        kind = np.uint8 if header.bits == 8 else np.dtype("<u2")
        rows = np.frombuffer(data, kind).reshape(shape)
        return np.ascontiguousarray(rows[::-1])  # the lowest row comes first


def _read_header(path: Path) -> _Header:
    try:
        with path.open("rb") as file:
            return _header(file, path)
    except InputError:
        raise
    except (struct.error, ValueError) as error:
        raise _refused(path, "a readable cine", reason_of(error)) from None


def _header(file: BinaryIO, path: Path) -> _Header:
    mark, _, compression, version, _, _, _, count, at_picture, at_setup, at_offsets, _ = (
        _FILE_HEADER.unpack(file.read(_FILE_HEADER.size))
    )
    if mark != b"CI":
        raise ValueError("no cine header")
    if version != 1:
        raise _refused(path, "a cine of version 1", f"version {version}")
    if compression == _JPEG:
        raise _refused(path, "an uncompressed cine", "one of JPEG pictures")
    file.seek(at_picture)
    _, width, height, _, bits, packing, size, *_ = _PICTURE_HEADER.unpack(
        file.read(_PICTURE_HEADER.size)
    )
    file.seek(at_setup)
    setup = file.read(_COLOURS_IN + 4)
    if setup[_MARK : _MARK + 2] != b"ST":
        raise ValueError("no setup block")
    (rate,) = struct.unpack_from("<I", setup, _RATE)
    (colours,) = struct.unpack_from("<I", setup, _COLOURS_IN)
    if packing not in (0, *_PACKED):
        raise _refused(path, "packed to 10 or 12 bits or not at all", f"packing {packing:#x}")
    width, height = abs(width), abs(height)
    checked_size(path, width, height)
    if at_offsets + 8 * count > file.seek(0, os.SEEK_END):  # before so much memory is asked for
        raise ValueError(f"a list of {count} pictures, for which it is too short")
    file.seek(at_offsets)
    offsets = struct.unpack(f"<{count}Q", file.read(8 * count))
    grey = not colours & 0xFFFF and (packing != 0 or bits in (8, 16))
    bits = _PACKED.get(packing, bits)
    needed = -(-width * height * bits // 8)
    if grey and 0 < size < needed:
        raise ValueError(f"pictures of {size} bytes where {bits} bits a pixel need {needed}")
    return _Header(width, height, bits, packing != 0, needed, rate or None, grey, offsets)


def _refused(path: Path, rule: str, got: str) -> InputError:
    return InputError.of(str(path), rule, got, _ADVICE)
