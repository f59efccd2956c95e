"""Files: what is written is complete or not there, and what is read is what was meant."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pinchoff.support.errors import InputError


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file, with or without a byte order mark.

    Raises
    ------
    InputError
        It cannot be read or is not TOML.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError.of(str(path), "a readable file", reason, "check its name") from None
    except RecursionError:
        got = "brackets nested too deeply"
        raise InputError.of(str(path), "a TOML file", got, "correct it there") from None
    except ValueError as error:  # text that is not UTF-8 or not TOML, or an absurdly long number
        raise InputError.of(str(path), "a TOML file", str(error), "correct it there") from None


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
