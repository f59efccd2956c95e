"""Films in any container that FFmpeg opens, through PyAV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pinchoff.support.errors import InputError
from pinchoff.video.formats.source import (
    CHOICE,
    About,
    Channels,
    Picture,
    Pixels,
    Planes,
    Problems,
    checked_size,
)
from pinchoff.video.writing import require_video_extra

_PLANAR = ("yuv420p", "yuvj420p")
_DEEP_COLOUR = ("rgb48", "bgr48", "rgba64", "bgra64", "gbrp", "gbrap", "bayer_")
_SLANT = 0.1  # sine of an angle that is not to be seen
_MOST_DAMAGED = 200  # packets in a row, after which the rest is given up


class Film:
    """A film.

    Parameters
    ----------
    path : Path
    channel : str, optional
        "red", "green" or "blue".
    """

    def __init__(self, path: Path, channel: str | None = None) -> None:
        self._path, self._av = path, require_video_extra("video")
        self.problems = Problems()
        with self._opened() as container:
            stream = container.streams.video[0]
            width, height = stream.codec_context.width, stream.codec_context.height
            checked_size(path, width, height)
            flags = self._av.format.Flags
            timed = flags.no_timestamps not in flags(container.format.flags)
            rate = float(stream.average_rate or 0.0) or None
            grey = str(stream.codec_context.pix_fmt or "").startswith(("gray", "mono"))
            count = stream.frames or None
            turn, notes = self._turn(container)
        if not turn[0, 0]:
            width, height = height, width
        self._turned = turn
        self._channels = Channels(path, channel, colour=not grey)
        rate, names = rate if timed else None, self._channels.names
        self.about = About(width, height, count, rate, None, timed, names, notes)

    def _opened(self) -> Any:
        try:
            container = self._av.open(str(self._path))
        except (self._av.FFmpegError, OSError, ValueError) as error:
            got = str(getattr(error, "strerror", None) or error)
            raise InputError.of(str(self._path), "a readable film", got, CHOICE) from None
        pictures = container.streams.video
        if not pictures or pictures[0].codec_context is None:
            container.close()
            got = "pictures of an unknown kind" if pictures else "no pictures in it"
            raise InputError.of(str(self._path), "a film", got, CHOICE)
        return container

    def _turn(self, container: Any) -> tuple[NDArray[np.float64], tuple[str, ...]]:
        """Return how the film is turned and mirrored to be shown, as its first frame says."""
        upright = np.eye(2)
        try:
            first = next(container.decode(video=0), None)
        except (self._av.FFmpegError, ValueError):
            return upright, ()
        matrix = None if first is None else _display_matrix(first)
        if matrix is None:
            return upright, ()
        turn = np.rint(matrix / max(float(np.abs(matrix).max()), 1e-9))
        square = np.array_equal(turn @ turn.T, upright)
        if not square or np.abs(turn - matrix).max() > _SLANT:
            return upright, ("the film is to be shown at a slant, which is left out",)
        return turn, ()

    def pictures(self, *, sparse: bool = False) -> Iterator[Picture]:
        """Read from the start; where `sparse`, only frames on which no others depend."""
        self.problems.clear()
        with self._opened() as container:
            stream = container.streams.video[0]
            stream.codec_context.thread_type = "SLICE"
            stream.codec_context.thread_count = 1  # clips run side by side, one a core
            if sparse:
                stream.codec_context.skip_frame = "NONREF"
            rate = self.about.fps
            start, last = None, -1
            for picture, after_damage in self._decoded(container, stream):
                time = picture.time if self.about.timed else None
                number = last + 1
                if time is not None:
                    start = time if start is None else start
                    time = float(time - start)
                    if rate and (sparse or after_damage):
                        number = max(number, round(time * rate))
                last = number
                yield Picture(number, time, self._image(picture))

    def _decoded(self, container: Any, stream: Any) -> Iterator[tuple[Any, bool]]:
        """Decode packet by packet: what is damaged costs its own frames only."""
        damaged = in_a_row = 0
        packets = container.demux(stream)
        last = -1
        while in_a_row < _MOST_DAMAGED:
            try:
                packet = next(packets, None)
                if packet is None:
                    return
                for picture in packet.decode():
                    in_a_row, last = 0, last + 1
                    yield picture, damaged > 0
            except (self._av.FFmpegError, ValueError) as error:
                damaged, in_a_row = damaged + 1, in_a_row + 1
                self.problems.note(f"damaged after frame {last}: {error}")
        self.problems.note(f"nothing was read beyond frame {last}")

    def _image(self, picture: Any) -> Planes | NDArray[Any]:
        name = picture.format.name
        if name.startswith("gray"):
            return self._upright(picture.to_ndarray())
        if name.startswith(("mono", "ya")):
            return self._upright(picture.to_ndarray(format="gray"))
        deep = "16" in name or picture.format.components[0].bits > 8
        if deep and name.startswith(_DEEP_COLOUR):
            return self._channels.of(self._upright(picture.to_ndarray(format="rgb48le")))
        if self._channels.colour is not None:
            return self._channels.of(self._upright(picture.to_ndarray(format="rgb24")))
        if name not in _PLANAR:
            picture = picture.reformat(format="yuv420p")
        luma, *chroma = (self._upright(_plane(plane)) for plane in picture.planes)
        return Planes(luma, np.stack(chroma))

    def _upright(self, image: NDArray[Any]) -> NDArray[Any]:
        (across, b), (c, down) = self._turned
        if not across:  # the stored x is shown along y
            image, across, down = np.swapaxes(image, 0, 1), c, b
        return np.ascontiguousarray(image[:: int(down), :: int(across)])


def _display_matrix(picture: Any) -> NDArray[np.float64] | None:
    """Return where the stored x and y axes point when shown, (2, 2); None where it is not said."""
    for data in picture.side_data:
        if data.type.name == "DISPLAYMATRIX":
            nine = np.frombuffer(bytes(data), dtype=np.int32).reshape(3, 3)
            return nine[:2, :2] / 65536.0
    return None


def _plane(plane: Any) -> Pixels:
    # Rows are padded; the copy outlives the decoder's buffer.
    rows = np.frombuffer(plane, dtype=np.uint8).reshape(plane.height, plane.line_size)
    return np.ascontiguousarray(rows[:, : plane.width])
