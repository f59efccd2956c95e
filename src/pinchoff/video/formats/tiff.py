"""TIFF through tifffile: ImageJ hyperstacks, OME, BigTIFF, palettes, and any type of number.

The axes come from the file's own tags; so do the frame interval and the pixel's size.
"""

from __future__ import annotations

import logging
import math
import struct
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import (
    CHOICE,
    COLOURS,
    About,
    Channels,
    Stack,
    checked_size,
    named,
    positive,
    reason_of,
)

_FIJI_ADVICE = "reduce it in Fiji (Image > Hyperstacks > Reduce Dimensionality) to frames"
_PLANE = "YXS"  # axes of one picture; S are its colours
_TIME_AXES = "TIQZ"  # those that may count frames, where there is one alone
_UM = {
    **dict.fromkeys(("um", "µm", "μm", "micron", "microns", "micrometer", "micrometre"), 1.0),
    **dict.fromkeys(("mm", "millimeter", "millimetre"), 1e3),
    **dict.fromkeys(("cm", "centimeter", "centimetre"), 1e4),
    **dict.fromkeys(("nm", "nanometer", "nanometre"), 1e-3),
    **dict.fromkeys(("m", "meter", "metre"), 1e6),
}
_SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", ""), 1.0),
    **dict.fromkeys(("ms", "msec", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("min", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hour", "hours"), 3600.0),
}

# Without a handler the module prints its warnings; what they mean is said here in our words.
logging.getLogger("tifffile").addHandler(logging.NullHandler())


class TiffStack(Stack):
    """A TIFF with one picture or many.

    Parameters
    ----------
    path : Path
    channel : str, optional
        Name or number of one of its channels, or of its colours.
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        super().__init__()
        self._path = path
        with self._opened() as file:
            series = _largest(file)
            sizes = dict(zip(series.axes, series.shape, strict=True))
            checked_size(path, sizes["X"], sizes["Y"])
            self._time_axis = self._frames_along(sizes)
            colour = (
                sizes.get("S", 1) >= len(COLOURS) or series.keyframe.photometric.name == "PALETTE"
            )
            separate = _channel_names(file, sizes.get("C", 1))
            self._channels = Channels(path, channel, separate, colour=colour)
            count = sizes.get(self._time_axis, 1)
            fps, pixel_um, notes = _scale(file)
            notes += self._choices(file, sizes, series)
            self.about = About(
                *(sizes["X"], sizes["Y"], count, fps, pixel_um),
                channels=self._channels.names,
                notes=tuple(notes),
            )

    def _opened(self) -> tifffile.TiffFile:
        try:
            file = tifffile.TiffFile(self._path)
            if file.series and _largest(file).ndim >= 2:
                return file
            got = "none"
        except Exception as error:  # a damaged header makes the module fail in any way
            got = reason_of(error)
        raise InputError.of(str(self._path), "a TIFF with pictures", got, CHOICE) from None

    def _frames_along(self, sizes: dict[str, int]) -> str:
        """Return the axis along which time runs, or nothing for one picture."""
        several = [axis for axis, size in sizes.items() if size > 1 and axis not in "YXSC"]
        if not several:
            return ""
        if len(several) > 1 or several[0] not in _TIME_AXES:
            got = " × ".join(f"{sizes[axis]} along {axis}" for axis in several)
            raise InputError.of(str(self._path), "frames of one plane in time", got, _FIJI_ADVICE)
        return several[0]

    def _choices(self, file: tifffile.TiffFile, sizes: dict[str, int], series: Any) -> list[str]:
        notes = []
        claimed = int((file.imagej_metadata or {}).get("images", 0) if file.is_imagej else 0)
        readable = math.prod(size for axis, size in sizes.items() if axis not in _PLANE)
        if claimed > readable:
            notes.append(f"it says that it holds {claimed} pictures: {readable} can be read")
        elif _breaks_off(file):
            notes.append("it breaks off or is damaged: pictures at its end may be missing")
        if self._time_axis == "Z":
            notes.append(f"its {sizes['Z']} slices (Z) are taken for frames in time")
        notes += self._channels.notes
        others = [" × ".join(map(str, each.shape)) for each in file.series if each is not series]
        if others:
            notes.append(f"pictures of other kinds in it are left out: {named(others)}")
        return notes

    @contextmanager
    def _reading(self) -> Iterator[Callable[[int], NDArray[Any]]]:
        with self._opened() as file:
            series = _largest(file)
            values = _mapped(self._path, series)

            def read(number: int) -> NDArray[Any]:
                chosen = {self._time_axis: number, "C": self._channels.plane}
                place = [chosen.get(axis, 0) for axis in series.axes if axis not in _PLANE]
                if values is None:
                    image = _page(series, place)
                elif place[0] < len(values):
                    image = np.array(values[*place])
                else:
                    raise ValueError("the file ends before it")
                if "".join(axis for axis in series.axes if axis in _PLANE) == "SYX":
                    image = np.ascontiguousarray(np.moveaxis(image, 0, -1))
                return self._channels.of(as_shown(image, series.keyframe))

            yield read


def _page(series: Any, place: Sequence[int]) -> NDArray[Any]:
    """Read the page at a place along the axes of a series that are not within a picture."""
    lead = series.shape[: series.ndim - len(series.keyframe.shape)]
    page = series.pages[int(np.ravel_multi_index(place, lead)) if lead else 0]
    if page is None:
        raise ValueError("it is missing in the file")
    image: NDArray[Any] = page.asarray()
    return image


def _mapped(path: Path, series: Any) -> NDArray[Any] | None:
    """Map the values of several pictures in one piece; of a file that is cut, what is there."""
    order = [k for k, axis in enumerate(series.axes) if axis not in _PLANE]
    if series.dataoffset is None or not series.keyframe.is_memmappable or order[:1] != [0]:
        return None
    kind = np.dtype(series.keyframe.parent.byteorder + series.dtype.char)
    length, *rest = series.shape
    there = (path.stat().st_size - series.dataoffset) // (math.prod(rest) * kind.itemsize)
    if there < 1:
        return None
    shape = (min(length, there), *rest)
    mapped: NDArray[Any] = np.memmap(path, kind, "r", series.dataoffset, shape)
    return np.moveaxis(mapped, order, range(len(order)))  # the axes of one picture come last


def _breaks_off(file: tifffile.TiffFile) -> bool:
    """Return whether a page is said to follow the last one that can be read."""
    layout, handle = file.tiff, file.filehandle
    try:
        handle.seek(file.pages[-1].offset)
        (tags,) = struct.unpack(layout.tagnoformat, handle.read(layout.tagnosize))
    except Exception:  # of the module: the last page is cut
        return True
    handle.seek(tags * layout.tagsize, 1)
    return any(handle.read(layout.offsetsize))


def as_shown(image: NDArray[Any], page: Any) -> NDArray[Any]:
    """Return a page's values as brightness or colour: palettes looked up, white from black told."""
    photometric = page.photometric.name
    if photometric == "PALETTE" and page.colormap is not None:
        colours = np.asarray(page.colormap)[:, image] >> 8
        return np.moveaxis(colours, 0, -1).astype(np.uint8)
    if image.ndim == 3:
        image = image[:, :, : len(COLOURS)] if image.shape[2] >= len(COLOURS) else image[:, :, 0]
    if photometric == "MINISWHITE":
        if image.dtype == np.bool_:
            return ~image
        if image.dtype.kind == "u":
            inverted: NDArray[Any] = (2**page.bitspersample - 1) - image
            return inverted
    return image


def read_picture(path: Path) -> NDArray[Any]:
    """Return the one picture, or the first, of a TIFF, as it is shown."""
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        image = page.asarray()
        if page.axes == "SYX":
            image = np.moveaxis(image, 0, -1)
        return as_shown(image, page)


def page_count(path: Path) -> int:
    """Return how many pictures a TIFF holds; 1 where it cannot be told."""
    try:
        return int(TiffStack(path).about.count or 1)
    except InputError:
        return 1


def _largest(file: tifffile.TiffFile) -> Any:
    return max(file.series, key=lambda series: math.prod(series.shape))


def _channel_names(file: tifffile.TiffFile, count: int) -> tuple[str, ...]:
    """Return the names of the channels where the file has them, else their numbers."""
    if count < 2:
        return ()
    found: list[str] = []
    pixels = _ome_pixels(file)
    if pixels is not None:
        found = [each.get("Name") or "" for each in pixels if each.tag.endswith("Channel")]
    if len(found) != count or not all(found) or len(set(found)) < count:
        return tuple(str(k) for k in range(count))
    return tuple(found)


def _ome_pixels(file: tifffile.TiffFile) -> Any:
    if not file.is_ome or not file.ome_metadata:
        return None
    try:
        root = ElementTree.fromstring(file.ome_metadata)
    except ElementTree.ParseError:
        return None
    return next((each for each in root.iter() if each.tag.endswith("}Pixels")), None)


def _scale(file: tifffile.TiffFile) -> tuple[float | None, float | None, list[str]]:
    """Return frames a second and the pixel's size in µm, where the tags say them, and notes."""
    pixels = _ome_pixels(file)
    if pixels is not None:

        def said_of(name: str, units: dict[str, float], usual: str) -> float | None:
            return _times(pixels.get(name), pixels.get(f"{name}Unit"), units, usual)

        interval = said_of("TimeIncrement", _SECONDS, "s")
        sizes = [said_of(f"PhysicalSize{axis}", _UM, "µm") for axis in "XY"]
    elif file.is_imagej and file.imagej_metadata:
        said = file.imagej_metadata
        interval = _times(said.get("finterval"), said.get("tunit"), _SECONDS, "s")
        unit = str(said.get("unit", "")).replace("\\u00B5", "µ")
        sizes = [_times(_length(file, f"{a}Resolution"), unit, _UM, "") for a in "XY"]
    else:
        said = file.pages.first.tags.valueof(51123) or {}  # Micro-Manager's
        said = said if isinstance(said, dict) else {}
        summary = file.micromanager_metadata if file.is_micromanager else None
        summary = (summary or {}).get("Summary", {})
        sizes = [_times(said.get("PixelSizeUm"), "um", _UM, "")] * 2
        interval = _times(summary.get("Interval_ms"), "ms", _SECONDS, "")
    notes = []
    if all(sizes) and abs(sizes[0] / sizes[1] - 1.0) > 0.01:  # type: ignore[operator]
        notes.append(
            f"its pixels are not square, {sizes[0]:.4g} × {sizes[1]:.4g} µm: the first is used"
        )
    return (1.0 / interval if interval else None), sizes[0], notes


def _times(value: Any, unit: Any, units: dict[str, float], usual: str) -> float | None:
    """Return a positive quantity in our unit; None where it is not said, or in no known unit."""
    factor = units.get(str(unit if unit is not None else usual).strip().lower())
    number = positive(value)
    return None if factor is None or number is None else number * factor


def _length(file: tifffile.TiffFile, tag: str) -> float | None:
    value = file.pages.first.tags.valueof(tag)
    try:
        pixels, units = value
        return float(units) / float(pixels)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
