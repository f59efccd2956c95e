"""Clips as H.264 in an MP4 file, written frame by frame."""

from __future__ import annotations

import os
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from pinchoff.support.errors import InputError
from pinchoff.support.files import HoldsFiles, written_aside

if TYPE_CHECKING:
    from types import ModuleType

Pixels = npt.NDArray[np.uint8]

_CHROMA = np.array([[-37.797, -74.203, 112.0, 32640.0], [112.0, -93.786, -18.214, 32640.0]]) / 255
"""Blue and red difference of red, green, blue and 1, with 16 to 240 for the least and the most
[ITU-R BT.601]."""

# Of x264: five times as fast as its default, files a tenth larger; the search for motion a third
# faster again, nothing to be seen of it.
_USUAL = {"preset": "veryfast", "x264-params": "subme=1:me=dia"}
_QUICK = {"preset": "ultrafast"}  # four times as fast again, files three times as large


def require_video_extra(argument: str) -> ModuleType:
    """Return the module ``av``, once it and the others of the extra are known to be there.

    Raises
    ------
    InputError
        One of them is not installed.
    """
    try:
        import av
        import cv2  # noqa: F401
        import imagecodecs  # noqa: F401
        import tifffile  # noqa: F401
    except ImportError as error:
        raise InputError.of(
            argument,
            "left out where the modules for films are missing",
            f"'{error}'",
            "install them with: pip install 'pinchoff[video]'",
        ) from error
    return av


class ClipWriter(HoldsFiles):
    """Write frames as H.264 (yuv420p); the file appears when it is complete.

    Parameters
    ----------
    path : path
        The file, ``.mp4``.
    size : (int, int)
        Width and height, pixels, both even.
    fps : float
        Frames a second.
    crf : int
        Constant rate factor of x264: 18 shows no loss, 26 is a small file.
    quick : bool, optional
        Whether speed counts more than the size of the file and the sharpness of colours.

    Raises
    ------
    InputError
        The name does not end in ``.mp4``, a side is odd, or PyAV is not installed.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        size: tuple[int, int],
        fps: float,
        crf: int = 20,
        *,
        quick: bool = False,
    ) -> None:
        self._av = require_video_extra("path")
        target = Path(path)
        if target.suffix.lower() != ".mp4":
            raise InputError.of("path", "a name ending in .mp4", target, "rename it")
        if size[0] % 2 or size[1] % 2:
            advice = "H.264 halves the colour's resolution; make both sides even"
            raise InputError.of("size", "even", f"{size[0]} × {size[1]}", advice)
        rate = Fraction(fps).limit_denominator(1001)
        self._quick = quick
        self._planes: Pixels = np.empty((size[1] * 3 // 2, size[0]), dtype=np.uint8)
        with ExitStack() as files:
            unfinished = files.enter_context(written_aside(target))
            self._container: Any = self._av.open(str(unfinished), "w")
            files.callback(self._container.close)
            self._stream: Any = self._container.add_stream(
                "libx264", rate=rate, options={"crf": str(crf), **(_QUICK if quick else _USUAL)}
            )
            self._stream.width, self._stream.height = size
            self._stream.pix_fmt = "yuv420p"
            files.push(self._finish)
            self._files = files.pop_all()

    def _finish(self, kind: type[BaseException] | None, *_: object) -> None:
        """Write what the encoder still holds, where nothing went wrong."""
        if kind is None:
            self._container.mux(self._stream.encode(None))

    def append(self, pixels: Pixels) -> None:
        """Add one frame: (height, width, 3) of red, green and blue."""
        self._fill_planes(np.ascontiguousarray(pixels))
        # x264 copies what it is given, so that the next frame may overwrite the planes.
        frame = self._av.VideoFrame.from_numpy_buffer(self._planes, format="yuv420p")
        self._container.mux(self._stream.encode(frame))

    def _fill_planes(self, image: Pixels) -> None:
        """Write brightness at full and colour at half resolution, in the order of I420."""
        import cv2

        cv2.cvtColor(image, cv2.COLOR_RGB2YUV_I420, dst=self._planes)
        if not self._quick:  # OpenCV takes the colour of one pixel in four
            height, width = image.shape[:2]
            half = cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
            chroma = cv2.transform(half, _CHROMA)
            self._planes.reshape(-1)[height * width :] = np.moveaxis(chroma, 2, 0).reshape(-1)
