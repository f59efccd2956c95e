"""Tables with units as Parquet or CSV, and collisions tables read back."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pinchoff.collisions.checksums import require_whole
from pinchoff.collisions.schema import COLUMNS, SHARED_COLUMNS, Column, pandas_type
from pinchoff.support.errors import InputError, refused_by_system
from pinchoff.support.files import HoldsFiles, written_aside

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow.dataset as pads
    from numpy.typing import NDArray

_ARROW_TYPES = {
    "str": pa.string(),
    "bool": pa.bool_(),
    "boolean": pa.bool_(),
    "float64": pa.float64(),
    "int64": pa.int64(),
    "int64s": pa.list_(pa.int64()),
    "category": pa.dictionary(pa.int8(), pa.string()),
}

_ROWS_HELD = 20_000


def arrow_schema(columns: Sequence[Column]) -> pa.Schema:
    """Return the schema of a table with such columns.

    Every field carries its ``unit`` and ``meaning`` as metadata; pandas finds the units in
    ``attrs["units"]``.
    """
    units = {column.name: column.unit for column in columns}
    return pa.schema(
        [
            pa.field(
                column.name,
                _ARROW_TYPES[column.dtype],
                metadata={"unit": column.unit, "meaning": column.meaning},
            )
            for column in columns
        ],
        metadata={"PANDAS_ATTRS": json.dumps({"units": units}, ensure_ascii=False)},
    )


class TableWriter(HoldsFiles):
    """Write a Parquet file as its rows come, with units and meanings; few are held at a time.

    It is entered while it writes. As it is left the file is there, whole, or not at all.
    """

    def __init__(self, target: Path | pa.NativeFile, columns: Sequence[Column]) -> None:
        self._columns = columns
        self._schema = arrow_schema(columns)
        self._rows: list[tuple[Any, ...]] = []
        with ExitStack() as files:
            if isinstance(target, Path):
                target = files.enter_context(written_aside(target))
            self._writer = files.enter_context(pq.ParquetWriter(target, self._schema))
            files.push(self._finish)
            self._files = files.pop_all()

    def append(self, row: tuple[Any, ...]) -> None:
        """Add one row, a value for every column."""
        self._rows.append(row)
        if len(self._rows) >= _ROWS_HELD:
            self._write_rows()

    def append_columns(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Add many rows: an array for every column, by its name."""
        arrays = [_array(columns[column.name], column) for column in self._columns]
        self._writer.write_table(pa.table(arrays, schema=self._schema))

    def append_batch(self, batch: pa.RecordBatch) -> None:
        """Add rows that another file with these columns holds."""
        self._writer.write_batch(batch.cast(self._schema))

    def _write_rows(self) -> None:
        columns = zip(*self._rows, strict=True)
        arrays = [pa.array(c, f.type) for c, f in zip(columns, self._schema, strict=True)]
        self._writer.write_table(pa.table(arrays, schema=self._schema))
        self._rows.clear()

    def _finish(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None and self._rows:
            self._write_rows()


def parquet_bytes(columns: Mapping[str, NDArray[Any]], schema: Sequence[Column]) -> bytes:
    """Return a table, an array of shape (rows,) for every column of the schema, as Parquet."""
    sink = pa.BufferOutputStream()
    with TableWriter(sink, schema) as table:
        table.append_columns(columns)
    return bytes(sink.getvalue())


def write_table(
    frame: pd.DataFrame, path: str | os.PathLike[str], columns: Sequence[Column]
) -> None:
    """Write a table, complete or not at all.

    The suffix chooses the format: ``.parquet``, with units and meanings; or ``.csv``. Columns stand
    in the order of `columns`; those that the frame lacks are left out.

    Raises
    ------
    InputError
        The suffix is another one, or the file cannot be written.
    """
    target = Path(path)
    require_table_name(str(path), target)
    schema = [column for column in columns if column.name in frame]
    try:
        if target.suffix == ".csv":
            with written_aside(target) as unfinished:
                frame[[column.name for column in schema]].to_csv(unfinished, index=False)
        else:
            with TableWriter(target, schema) as table:
                table.append_columns(
                    {c.name: frame[c.name].to_numpy(na_value=np.nan) for c in schema}
                )
    except OSError as error:
        raise refused_by_system(error) from None


def write_collisions(
    frame: pd.DataFrame, path: str | os.PathLike[str], more: Sequence[Column] = ()
) -> None:
    """Write a table of collisions, as `write_table`; `more` says what further columns are.

    Numbers of `SHARED_COLUMNS` that it lacks were not measured.
    """
    lacking = {
        c.name: np.nan for c in SHARED_COLUMNS if c.dtype == "float64" and c.name not in frame
    }
    write_table(frame.assign(**lacking), path, (*COLUMNS, *more))


def require_table_name(argument: str, path: Path) -> None:
    """Refuse a name for a table that does not say its format.

    Raises
    ------
    InputError
        It ends neither in ``.parquet`` nor in ``.csv``.
    """
    if path.suffix not in (".parquet", ".csv"):
        rule = "a name ending in .parquet or .csv"
        raise InputError.of(argument, rule, path.name, "rename it")


def _array(values: NDArray[Any], column: Column) -> pa.Array:
    kind = _ARROW_TYPES[column.dtype]
    if column.categories:
        codes = {name: code for code, name in enumerate(column.categories)}
        indices = pa.array([codes[value] for value in values], pa.int8())
        return pa.DictionaryArray.from_arrays(indices, pa.array(column.categories))
    if column.dtype == "boolean":  # NaN where it is not known
        missing = np.array([value != value for value in values], dtype=bool)
        return pa.array(np.where(missing, False, values).astype(bool), kind, mask=missing)
    # Not measured stays NaN: a missing value of Parquet would be a second way to say it.
    return pa.array(values, kind, from_pandas=False)


def open_collisions(path: str | os.PathLike[str]) -> pads.Dataset:
    """Open a Parquet file or a folder of them without reading the rows.

    Raises
    ------
    InputError
        There is none, or it is not a collisions table.
    """
    import pyarrow.dataset as pads  # slow to import

    place = Path(path)
    advice = "give the folder of a sweep, or a Parquet file of collisions"
    if place.is_dir():
        require_whole(place, sorted(place.glob("part-*.parquet")))
    try:
        dataset = pads.dataset(place, format="parquet")
    except (OSError, pa.ArrowException) as error:
        reason = "nothing there" if isinstance(error, FileNotFoundError) else "something else"
        raise InputError.of(str(place), "a collisions table", reason, advice) from None
    if not dataset.files:
        raise InputError.of(str(place), "a collisions table", "a folder without parts", advice)
    missing = [column.name for column in SHARED_COLUMNS if column.name not in dataset.schema.names]
    if missing:
        got = f"a table without the columns {', '.join(missing)}"
        raise InputError.of(str(place), "a collisions table", got, advice)
    return dataset


def collision_batches(dataset: pads.Dataset) -> Iterator[pa.RecordBatch]:
    """Read what `open_collisions` returned little by little, in the order of its files."""
    for path in dataset.files:  # one after the other: an opened dataset keeps all their footers
        with pq.ParquetFile(path) as part:
            yield from part.iter_batches()


def read_collisions(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a collisions table.

    Parameters
    ----------
    path : str or path-like
        A Parquet file, or a folder of them as a sweep writes, finished or not.

    Returns
    -------
    DataFrame
        As `simulate_many` returns it, or with `SHARED_COLUMNS` at least, where it does not come
        from simulations. The units are in ``attrs["units"]``.

    Raises
    ------
    InputError
        There is none, or it is not a collisions table.

    Examples
    --------
    >>> import pinchoff as po
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = po.sweep({"vary": {"offset": [0, 0.4]}, "time_limit": 3}, folder)
    ...     read_collisions(done.path)["offset"].tolist()
    [0.0, 0.4]
    """
    dataset = open_collisions(path)
    frame: pd.DataFrame = dataset.to_table().to_pandas()
    for column in COLUMNS:
        if column.name in frame:
            frame[column.name] = frame[column.name].astype(pandas_type(column))
    frame.attrs["units"] = units_of(dataset.schema)
    return frame


def units_of(schema: pa.Schema) -> dict[str, str]:
    """Return the unit of every column that says one, by name."""
    return {
        field.name: field.metadata[b"unit"].decode()
        for field in schema
        if field.metadata and b"unit" in field.metadata
    }
