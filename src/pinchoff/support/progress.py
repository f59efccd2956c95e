"""Progress of long work, on stderr."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, TypeAlias

Show: TypeAlias = Callable[[float], object]
"""Moves a bar to the amount that is done."""


_BETWEEN_UPDATES = 0.2  # s


class Bar(Protocol):
    """Moves a bar; what it counts to, and what stands before it, may change on the way."""

    def __call__(self, done: float, total: float | None = None, label: str | None = None) -> object:
        """Move the bar to what is done."""


def _shell() -> Any:
    """Return IPython's shell, if this program runs in one; it is not imported for that."""
    ipython = sys.modules.get("IPython")
    return None if ipython is None else ipython.get_ipython()


def on_display() -> bool:
    """Tell whether somebody looks on through IPython: in its shell or in a notebook."""
    return _shell() is not None


def in_notebook() -> bool:
    """Tell whether a notebook shows what is displayed."""
    return getattr(_shell(), "kernel", None) is not None


def wanted_progress(progress: bool | None) -> bool:
    """Return what a caller says of the bar; unsaid, whether somebody is there to see it."""
    return sys.stderr.isatty() or in_notebook() if progress is None else progress


@contextmanager
def progress_bar(
    wanted: bool, label: str, total: float | None, *, start: int = 0, unit: str = ""
) -> Iterator[Bar | None]:
    """Show a bar with the time left, if wanted, and give the function that moves it.

    `total` is all there is to do, where that is known, and `start` what had been done before. With
    the unit of what is counted, the count and the rate are shown too.
    """
    if not wanted:
        yield None
        return
    if in_notebook():
        yield from _notebook_bar(label, total, start, unit)
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text("" if speed is None else f"{speed:.3g} {unit}/s")

    counted = (MofNCompleteColumn(), Rate()) if unit else (TaskProgressColumn(),)
    columns = (TextColumn("{task.description}"), BarColumn(), *counted, TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(label, total=total, completed=start)

        def move(done: float, total: float | None = None, label: str | None = None) -> None:
            bar.update(task, completed=start + done, total=total, description=label)

        yield move
        # A run may end before its time limit, and a generator has no length.
        whole = bar.tasks[task].total or 1
        bar.update(task, total=whole, completed=whole)


def _notebook_bar(label: str, total: float | None, start: int, unit: str) -> Iterator[Bar]:
    """Show a bar of HTML, which every notebook has without a further package."""
    from html import escape
    from time import monotonic

    shell: Any = importlib.import_module("IPython.display")  # in a notebook it is there
    name, whole = label, total
    began, updated = monotonic(), -1.0
    place = shell.display(shell.HTML(escape(label)), display_id=True)

    def move(done: float, total: float | None = total, label: str | None = None) -> None:
        nonlocal updated, name, whole
        name, whole = label or name, total or whole
        now = monotonic() - began
        if now - updated < _BETWEEN_UPDATES and (whole is None or start + done < whole):
            return
        updated = now
        rest = f", {now / done * (whole - start - done):.0f} s left" if whole and done else ""
        counted = f"{start + done:,.0f}" + (f" of {whole:,.0f}" if whole else "") if unit else ""
        share = f" value={min(1.0, (start + done) / whole):.4f}" if whole else ""
        text = escape(" ".join(filter(None, (counted, unit))) + rest)
        place.update(shell.HTML(f"{escape(name)} <progress{share}></progress> {text}"))

    yield move
    done = f"{escape(name)} <progress value=1></progress> done in {monotonic() - began:.1f} s"
    place.update(shell.HTML(done))


def shifted(show: Show | None, done: float) -> Show | None:
    """Return a function that moves the bar beyond what was done before."""
    return None if show is None else lambda more: show(done + more)
