"""Which part of a clip is measured: some of its frames, some of its picture."""

from __future__ import annotations

import re
from typing import NamedTuple

from pinchoff.support.errors import InputError

_FRAMES = re.compile(r"(\d*):(\d*)(?::(\d*))?")
_ADVICE = "write it as 0:200 or 0:200:2, as Python does"


class FrameRange(NamedTuple):
    """Frames from one on, up to another, every so many.

    Attributes
    ----------
    start : int
    stop : int or None
        The first that is left out; None for the end of the clip.
    step : int
    """

    start: int = 0
    stop: int | None = None
    step: int = 1

    @classmethod
    def read(cls, text: str) -> FrameRange:
        """Read ``START:STOP`` or ``START:STOP:STEP``, any of them left out.

        Raises
        ------
        InputError
            It is not written so, or holds no frame.
        """
        found = _FRAMES.fullmatch(text.strip())
        if found is None:
            raise InputError.of("frames", "START:STOP or START:STOP:STEP", repr(text), _ADVICE)
        start, stop, step = (int(part) if part else None for part in found.groups())
        wanted = cls(start or 0, stop, 1 if step is None else step)
        if wanted.step < 1 or (stop is not None and stop <= wanted.start):
            raise InputError.of("frames", "a range with frames in it", text, _ADVICE)
        return wanted

    def holds(self, number: int) -> bool:
        """Return whether a frame is among them."""
        after = number - self.start
        return after >= 0 and after % self.step == 0 and not self.ends_before(number)

    def ends_before(self, number: int) -> bool:
        """Return whether neither a frame nor any later one is among them."""
        return self.stop is not None and number >= self.stop

    def count(self, total: int) -> int:
        """Return how many of a clip's frames are among them."""
        last = total if self.stop is None else min(self.stop, total)
        return len(range(self.start, last, self.step))


ALL_FRAMES = FrameRange()
