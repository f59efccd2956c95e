"""Progress of long work, on stderr."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeAlias

Show: TypeAlias = Callable[[float], object]
"""Moves a bar to the amount that is done."""


class Bar(Protocol):
    """Moves a bar; what it counts to, and what stands before it, may change on the way."""

    def __call__(self, done: float, total: float | None = None, label: str | None = None) -> object:
        """Move the bar to what is done."""


@contextmanager
def progress_bar(
    wanted: bool, label: str, total: float | None, *, start: int = 0, unit: str = ""
) -> Iterator[Bar | None]:
    """Show a bar with the time left and give the function that moves it.

    Parameters
    ----------
    wanted : bool
        Whether to show it; if not, None is given.
    label : str
        What stands before it.
    total : float or None
        All there is to do, where that is known.
    start : float, optional
        What had been done before.
    unit : str, optional
        Of what is counted: then the count and the rate are shown too.
    """
    if not wanted:
        yield None
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


def shifted(show: Show | None, done: float) -> Show | None:
    """Return a function that moves the bar beyond what was done before."""
    return None if show is None else lambda more: show(done + more)
