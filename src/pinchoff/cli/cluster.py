"""The cluster that a sweep runs on: its option, and the way to it."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Annotated, TypeAlias

from pinchoff.cli.options import option
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

Scheduler: TypeAlias = Annotated[
    str | None,
    option(
        "ADDRESS",
        "Dask scheduler to run on, as tcp://10.0.0.1:8786",
        default="none: this machine",
    ),
]


def cluster_client(
    scheduler: str | None, workers: int | None
) -> AbstractContextManager[Client | None]:
    """Connect to a scheduler, if one is named.

    Raises
    ------
    InputError
        Threads are given beside it, or nothing answers there.
    """
    if scheduler is None:
        return nullcontext()
    if workers is not None:
        advice = "a cluster's workers have their own"
        raise InputError.of("threads", "left out beside --scheduler", workers, advice)
    from pinchoff.studies.sweep.cluster import connected

    return connected(scheduler)
