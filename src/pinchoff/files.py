"""Files that are complete or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_aside(path: Path, suffix: str | None = None) -> Iterator[Path]:
    """Give a name beside `path` to write to; rename it to `path` once it is written.

    So whoever opens `path` finds the old file or the new one, complete. On an error the
    unfinished file is removed and `path` stays as it was. It has the suffix of `path`, or another
    one, where readers that look for files by suffix must not find it.
    """
    ending = path.suffix if suffix is None else suffix
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}{ending}")
    try:
        yield unfinished
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
