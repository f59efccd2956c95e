"""Many runs at once, into the columns of a table: the one way from parameters to rows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff import _core
from pinchoff.collisions.schema import COLUMNS, Column
from pinchoff.model.parameters import PARAMETERS, Parameters
from pinchoff.model.run_table import run_columns
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pinchoff.model.flow import Flow

CHUNK_SIZE = 4096
"""Runs that are prepared and held at once, so that a sweep's memory is that of its table."""


def run_batch(
    parameters: Sequence[Parameters],
    ids: Sequence[int],
    *,
    threads: int,
    flow: Flow | None = None,
    varied: Iterable[str] = (),
    show: Callable[[int], object] | None = None,
) -> dict[str, NDArray[Any]]:
    """Run one droplet against one obstacle for each set of parameters.

    Parameters
    ----------
    parameters, ids : sequences of n
        Of each run; its id is the ``collision_id``.
    threads : int
    flow : Flow, optional
        One for all runs; by default the Stokes flow around each run's own obstacle.
    varied : iterable of str, optional
        Names of parameters that differ between the runs of the table, which gets their columns.
    show : callable, optional
        Called with the number of runs that are done.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        Every column of `pinchoff.collisions.schema.COLUMNS` and of `varied_columns`.

    Raises
    ------
    InputError
        A given time step is unstable; the message names the run by its id.
    """
    models = np.array([_model_row(p, number) for p, number in zip(parameters, ids, strict=True)])
    results = _core.run_many(models, flow, threads, show)
    columns = run_columns(parameters, results, ids)
    for name, column in varied_columns(varied).items():
        kind = object if column.dtype == "str" else column.dtype
        if name != "time_step":
            # None, of another model's constants, is NaN
            columns[column.name] = np.array([getattr(p, name) for p in parameters], dtype=kind)
        else:  # "auto" stands for a number
            columns[column.name] = models[:, _core.MODEL_FIELDS.index(name)]
    return columns


def _model_row(parameters: Parameters, number: int) -> NDArray[np.float64]:
    try:
        return parameters.model_row()
    except InputError as error:
        raise error.within(f"parameters[{number}]") from None


def varied_columns(names: Iterable[str]) -> dict[str, Column]:
    """Return columns for the varied parameters that a table would not show otherwise.

    Names of physical quantities are passed over.
    """
    in_every_table = {column.name for column in COLUMNS}
    columns = {name: PARAMETERS[name].as_column() for name in names if name in PARAMETERS}
    return {name: column for name, column in columns.items() if column.name not in in_every_table}
