"""Processes: clips side by side, and the frames of one clip; what comes back is in order.

A worker that a damaged file ends, as some libraries let happen, takes neither the other clips
nor this process with it.
"""

from __future__ import annotations

import _thread
import ctypes
import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import wait as wait_for
from multiprocessing.context import SpawnContext
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from pinchoff.video.droplets import Droplet, Segmenter
    from pinchoff.video.reading import Frame

Job = TypeVar("Job")
Result = TypeVar("Result")

_LOOK_S = 0.2  # between two looks at how far the workers are
_AHEAD = 4  # frames a worker that wait for it
_GRACE_S = 5.0  # for a worker to leave its work in order

# Not forked: the libraries of video and pictures have threads of their own.
_CONTEXT: SpawnContext = multiprocessing.get_context("spawn")


class _Worker:
    """What a process knows of its work; set when it starts."""

    counts: Any = None
    segmenter: Segmenter
    busy = False
    stopping = False


def all_done(
    jobs: Sequence[Job],
    work: Callable[[Job, Callable[[int], object]], Result],
    broken: Callable[[Job], Result],
    processes: int,
    show: Callable[[float], object] | None = None,
) -> Generator[Result, None, None]:
    """Do jobs in processes, and yield what comes of each as soon as it is there.

    Parameters
    ----------
    work : callable
        Function of a module that does a job. Its second argument is to be called with how much
        of it is done.
    broken : callable
        Gives the result of a job whose process ended.
    processes : int
        How many work at a time; with one they are done here.
    show : callable, optional
        Called now and then with how much is done of all jobs.
    """
    if processes <= 1:
        counts = [0] * len(jobs)

        def count(k: int, frames: int) -> None:
            counts[k] = frames
            if show is not None:
                show(sum(counts))

        for k, job in enumerate(jobs):
            yield work(job, partial(count, k))
        return
    done = _CONTEXT.RawArray(ctypes.c_int64, [-1] * len(jobs))  # -1: not begun
    left = list(range(len(jobs)))
    while left:
        finished: set[int] = set()
        for k, result in _in_pool(jobs, left, work, processes, done, show):
            finished.add(k)
            yield result
        left = [k for k in left if k not in finished]
        # The process of one of those that had begun ended, and all others with it: each alone.
        suspects = [k for k in left if done[k] >= 0]
        for k in suspects or ([] if finished else list(left)):
            left.remove(k)
            alone = [result for _, result in _in_pool(jobs, [k], work, 1, done, show)]
            yield alone[0] if alone else broken(jobs[k])


def _in_pool(
    jobs: Sequence[Job],
    chosen: Sequence[int],
    work: Callable[[Job, Callable[[int], object]], Result],
    processes: int,
    done: Any,
    show: Callable[[float], object] | None,
) -> Iterator[tuple[int, Result]]:
    """Yield the results of some jobs until all are done or a process has ended by itself."""
    with _pool(min(processes, len(chosen)), done, b"") as pool:
        futures = {pool.submit(_counted, work, jobs[k], k): k for k in chosen}
        waiting: set[Future[Result]] = set(futures)
        while waiting:
            ready, waiting = wait(waiting, _LOOK_S, FIRST_COMPLETED)
            if show is not None:
                show(sum(max(0, count) for count in done))
            for future in ready:
                try:
                    result = future.result()
                except BrokenProcessPool:
                    continue
                yield futures[future], result


@contextmanager
def _pool(processes: int, counts: Any, segmenter: bytes) -> Iterator[ProcessPoolExecutor]:
    """Give processes for some jobs; where this one is interrupted, they leave theirs too."""
    stop = _CONTEXT.RawValue(ctypes.c_bool, False)
    with ProcessPoolExecutor(
        processes, _CONTEXT, initializer=_begin, initargs=(counts, segmenter, stop)
    ) as pool:
        try:
            yield pool
        except BaseException:
            stop.value = True
            pool.shutdown(cancel_futures=True)  # waits: they may have files to remove
            raise


def _begin(counts: Any, segmenter: bytes, stop: Any) -> None:
    """Prepare a process: it is stopped by its parent alone, or by that one's end."""
    _Worker.counts = counts
    if segmenter:
        _Worker.segmenter = pickle.loads(segmenter)
    signal.signal(signal.SIGINT, _stop_if_told)
    signal.signal(signal.SIGTERM, _stop)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent, stop), daemon=True).start()


def _stop_if_told(number: int, frame: FrameType | None) -> None:
    """Leave the work at hand; Ctrl-C, which reaches workers too, is for the parent to answer."""
    if _Worker.stopping:
        _stop(number, frame)


def _stop(number: int, frame: FrameType | None) -> None:
    if _Worker.busy:
        raise KeyboardInterrupt


def _end_with(parent: Any, stop: Any) -> None:
    """Wait for the parent's word or end; then end too, once the work is left in order."""
    alone = False
    while not (alone or stop.value):
        alone = bool(wait_for([parent.sentinel], _LOOK_S))
    _Worker.stopping = True
    deadline = time.monotonic() + _GRACE_S
    _thread.interrupt_main()
    while (_Worker.busy or not alone) and time.monotonic() < deadline:
        time.sleep(0.05)
    os._exit(1)


@contextmanager
def _at_work() -> Iterator[None]:
    """Say that a process works, so that an interruption has something to leave."""
    _Worker.busy = True
    try:
        if _Worker.stopping:  # of the jobs that wait one is handed out all the same
            raise KeyboardInterrupt
        yield
    finally:
        _Worker.busy = False


def _counted(work: Callable[[Job, Callable[[int], object]], Result], job: Job, k: int) -> Result:
    count = partial(_Worker.counts.__setitem__, k)
    count(0)
    with _at_work():
        return work(job, count)


def segmented(
    frames: Iterable[Frame], segmenter: Segmenter, processes: int
) -> Iterator[tuple[Frame, list[Droplet]]]:
    """Yield every frame with its droplets, in order; with one process all is done here.

    The segmenter is copied to the processes; one that cannot be, as a function of a user's script,
    works here.
    """
    copied = _copied(segmenter) if processes > 1 else b""
    if not copied:
        for frame in frames:
            yield frame, segmenter.droplets(frame)
        return
    waiting: deque[tuple[Frame, Future[list[Droplet]]]] = deque()
    with _pool(processes, None, copied) as pool:
        for frame in frames:
            waiting.append((frame, pool.submit(_droplets, frame)))
            if len(waiting) >= _AHEAD * processes:
                first, found = waiting.popleft()
                yield first, found.result()
        while waiting:
            first, found = waiting.popleft()
            yield first, found.result()


def _copied(segmenter: Segmenter) -> bytes:
    try:
        return pickle.dumps(segmenter)
    except (pickle.PicklingError, AttributeError, TypeError):
        return b""


def _droplets(frame: Frame) -> list[Droplet]:
    import cv2

    cv2.setNumThreads(1)  # frames are looked at side by side
    with _at_work():
        return _Worker.segmenter.droplets(frame)
