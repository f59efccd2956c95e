"""Which frames of a clip are measured."""

from __future__ import annotations

import re
import sys

from pinchoff.support.errors import InputError

ALL_FRAMES = range(sys.maxsize)

_FRAMES = re.compile(r"(\d*):(\d*)(?::(\d*))?")
_ADVICE = "write it as 0:200 or 0:200:2, as Python does"


def frame_range(text: str) -> range:
    """Read ``START:STOP`` or ``START:STOP:STEP``, any of them left out.

    Raises
    ------
    InputError
        It is not written so, or holds no frame.
    """
    found = _FRAMES.fullmatch(text.strip())
    if found is None:
        raise InputError.of("frames", "START:STOP or START:STOP:STEP", repr(text), _ADVICE)
    start, stop, step = (
        int(part) if part else default
        for part, default in zip(found.groups(), (0, sys.maxsize, 1), strict=True)
    )
    if step < 1 or stop <= start:
        raise InputError.of("frames", "a range with frames in it", text, _ADVICE)
    return range(start, stop, step)
