"""Parts of a sweep, or whole runs, as tasks on a Dask cluster."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from pinchoff.studies.sweep.dataset import SweepDataset
from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.studies.sweep.parts import Part, compute_parts
from pinchoff.support.errors import InputError, PinchoffError
from pinchoff.support.progress import Show

if TYPE_CHECKING:
    from distributed import Client

Result = TypeVar("Result")

_TASKS_A_THREAD = 4  # tasks that wait for each thread, so that no worker runs dry
_SECONDS_TO_CONNECT = 10


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """Connect to a scheduler, such as ``tcp://127.0.0.1:8786``, until the block ends.

    Raises
    ------
    InputError
        Nothing answers there, or Dask is not installed.
    """
    try:
        from distributed import Client
    except ImportError:
        advice = "install pinchoff[cluster]"
        raise InputError.of("scheduler", "left out without Dask", address, advice) from None
    try:
        client = Client(address, timeout=_SECONDS_TO_CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError.of(
            "scheduler",
            "the address of a Dask scheduler that runs",
            f"{address} ({type(error).__name__})",
            "start one with 'dask scheduler' and give the address that it prints",
        ) from None
    with client:
        yield client


def on_cluster(
    design: SweepDesign,
    dataset: SweepDataset,
    missing: Sequence[int],
    client: Client,
    show: Show | None,
) -> Generator[Part, None, None]:
    """Compute parts on a cluster, and yield them as they arrive; raises as `computed_on`."""
    done = 0
    given = ((design, part, dataset.rows_of(part)) for part in missing)
    with closing(computed_on(client, _compute_part, given)) as parts:
        for part in parts:
            done += len(dataset.rows_of(part.number))
            if show is not None:
                show(done)
            yield part


def computed_on(
    client: Client, compute: Callable[..., Result], given: Iterable[tuple[Any, ...]]
) -> Generator[Result, None, None]:
    """Call a function on a cluster, and yield what it returns as it arrives.

    The function stands in a module of this package; `given` holds the arguments of each call. Only
    a few tasks per thread wait on the cluster at any time, and what a call returned stays in no
    memory once it has been yielded. The tasks of a worker that dies are computed anew by another.

    Raises
    ------
    InputError
        The cluster has no workers, or they have another version of the package.
    PinchoffError
        The scheduler was lost, or a task took one worker after the other with it.
    """
    from distributed import KilledWorker, as_completed

    waiting = iter(given)
    first = next(waiting, None)
    if first is None:
        return
    waiting = itertools.chain((first,), waiting)
    futures = as_completed(loop=client.loop)
    pending: set[object] = set()

    def submit() -> None:
        for arguments in waiting:
            future = client.submit(_task, compute, _version(), *arguments, pure=False)
            pending.add(future)
            futures.add(future)
            return

    try:
        for _ in range(_TASKS_A_THREAD * _threads_of(client)):
            submit()
        for future in futures:
            result: Result = future.result()
            pending.discard(future)
            future.release()
            submit()
            yield result
    except KilledWorker as error:
        raise _lost("no worker survived a part", "see the logs of the workers") from error
    except (CancelledError, OSError) as error:
        raise _lost("the scheduler was lost", "start it again") from error
    finally:
        if pending and client.status == "running":
            client.cancel(list(pending))


def _task(compute: Callable[..., Result], version: str, *arguments: Any) -> Result:
    """Call on a worker; Dask runs as many of these at once as the worker has threads."""
    here = _version()
    if here != version:
        advice = f"install pinchoff {version} on all of them"
        raise InputError.of("client", f"of workers with pinchoff {version}", here, advice)
    return compute(*arguments)


def _compute_part(design: SweepDesign, part: int, rows: range) -> Part:
    return compute_parts(design, {part: rows}, threads=1)[0]


def _version() -> str:
    from pinchoff import __version__

    return __version__


def _threads_of(client: Client) -> int:
    """Return how many threads the workers have, waiting a little for the first worker."""
    try:
        client.wait_for_workers(1, timeout=_SECONDS_TO_CONNECT)
    except TimeoutError:
        advice = "start some with 'dask worker ADDRESS'"
        raise InputError.of("client", "of a cluster with workers", "none", advice) from None
    return max(1, int(sum(client.nthreads().values())))


def _lost(what: str, advice: str) -> PinchoffError:
    return PinchoffError(
        f"the cluster must be there until the sweep ends; got '{what}'; {advice}, and begin the "
        "sweep again: what was written stays"
    )
