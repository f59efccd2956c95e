"""How work is stopped: signals that end a program end it as Ctrl-C does, tidily."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_NAMES = ("SIGTERM", "SIGHUP")  # of batch systems and service managers; of a closed terminal


@contextmanager
def interrupted_by_signals() -> Iterator[list[int]]:
    """Turn the first SIGTERM or SIGHUP into a KeyboardInterrupt; a second one ends at once.

    Signals that are ignored or handled already stay so, and so do all outside the main thread.

    Yields
    ------
    list of int
        The number of the signal, once it has come.
    """
    came: list[int] = []
    mine: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        came.append(number)
        leave()
        raise KeyboardInterrupt

    def leave() -> None:
        while mine:
            signal.signal(mine.pop(), signal.SIG_DFL)

    if threading.current_thread() is threading.main_thread():
        for name in _NAMES:
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            if number is not None and signal.getsignal(number) == signal.SIG_DFL:
                signal.signal(number, interrupt)
                mine.append(number)
    try:
        yield came
    finally:
        leave()
