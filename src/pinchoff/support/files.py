"""Files: what is written is complete or not there, and what is read is what was meant.

What is being written has a hidden name of its own and is locked by the process that writes it.
So a later run can tell what a run that died has left, and removes it.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import secrets
import sys
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

if sys.platform != "win32":
    import fcntl

_UNFINISHED = re.compile(r"\.pinchoff-[0-9a-f]{16}(\..*)?")
_FLAGS = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
_LARGEST_TOML = 16_000_000  # bytes
_ORDINARY = 0o666  # as of any new file; the user's umask takes from it


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file, with or without a byte order mark.

    Raises
    ------
    InputError
        It cannot be read or is not TOML.
    """
    try:
        return tomllib.loads(bounded_bytes(path, _LARGEST_TOML).decode("utf-8-sig"))
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError.of(str(path), "a readable file", reason, "check its name") from None
    except RecursionError:
        got = "brackets nested too deeply"
        raise InputError.of(str(path), "a TOML file", got, "correct it there") from None
    except ValueError as error:  # text that is not UTF-8 or not TOML, or an absurdly long number
        raise InputError.of(str(path), "a TOML file", str(error), "correct it there") from None


def put_in_table(config: dict[str, Any], key: str, value: object) -> None:
    """Put a value where its dotted key says, leaving the other values of its table alone.

    Raises
    ------
    InputError
        What stands before the dot is no table.

    Examples
    --------
    >>> config = {"array": {"rows": 2}}
    >>> put_in_table(config, "array.gap", 0.5)
    >>> config
    {'array': {'rows': 2, 'gap': 0.5}}
    """
    place, dot, name = key.partition(".")
    table = config.setdefault(place, {}) if dot else config
    if not isinstance(table, dict):
        raise InputError.of(place, "a table", table, f"write it as [{place}]")
    table[name if dot else place] = value


def bounded_bytes(path: Path, most: int) -> bytes:
    """Read a file of no more than so many bytes; one such as /dev/zero has no end.

    Raises
    ------
    OSError
        It cannot be read, or is larger.
    """
    with path.open("rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"more than {most / 1e6:g} MB", str(path))
    return content


@contextmanager
def written_aside(path: Path, suffix: str | None = None) -> Iterator[Path]:
    """Make an empty file beside `path` to write to; rename it to `path` once it is written.

    So whoever opens `path` finds the old file or the new one, complete, also after the power
    failed. On an error the unfinished file is removed and `path` stays as it was; what dead
    processes left in the folder is removed, too. It has the suffix of `path`, or another one,
    where readers that look for files by suffix must not find it. Whoever writes to it must write
    into the file that is there, not make another in its place.
    """
    remove_unfinished(path.parent)
    made: list[Path] = []
    descriptor = None
    try:
        ending = path.suffix if suffix is None else suffix
        try:
            unfinished, descriptor = _new_file(path.parent, ending, made)
        except OSError as error:
            error.filename = str(path)  # the name that its reader knows
            raise
        yield unfinished
        if descriptor is None:  # Windows renames no file that is open
            descriptor = os.open(unfinished, os.O_RDWR)
        os.fsync(descriptor)
        if sys.platform == "win32":
            os.close(descriptor)
            descriptor = None
        unfinished.replace(path)
    except OSError as error:
        if error.filename is None or Path(os.fsdecode(error.filename)) in made:
            with suppress(AttributeError):  # an error of PyAV keeps its name
                error.filename = str(path)  # the one that its reader knows
        raise
    finally:
        _remove(made, descriptor)


def write_text(path: Path, text: str) -> None:
    """Write a text in UTF-8, complete or not at all."""
    with written_aside(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def write_csv(path: Path, table: pd.DataFrame, **form: Any) -> None:
    """Write a table without its index, complete or not at all; `form` is as `to_csv` takes it."""
    with written_aside(path) as unfinished:
        table.to_csv(unfinished, index=False, **form)


def hidden_name(seed: str, ending: str) -> str:
    """Return a name that `remove_unfinished` knows; of one length, whatever is being written."""
    return f".pinchoff-{hashlib.sha256(seed.encode(errors='replace')).hexdigest()[:16]}{ending}"


def _new_file(folder: Path, ending: str, made: list[Path]) -> tuple[Path, int | None]:
    """Make a hidden file of a random name; return it with its descriptor, which locks it.

    Its name is noted in `made` before it is there: an interruption may come at any moment.
    """
    while True:
        path = folder / hidden_name(secrets.token_hex(), ending)
        made.append(path)
        try:
            descriptor = os.open(path, _FLAGS, _ORDINARY)
        except OSError:
            made.remove(path)  # what stands there is another's
            raise
        if sys.platform == "win32":
            os.close(descriptor)
            return path, None
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if is_at(descriptor, path):  # else another process took it for a dead one's
            return path, descriptor
        os.close(descriptor)


def _remove(made: list[Path], descriptor: int | None) -> None:
    for path in made:
        path.unlink(missing_ok=True)
    if descriptor is not None:
        os.close(descriptor)


def require_writable(folder: Path) -> None:
    """Make a hidden file in a folder and remove it again.

    Raises
    ------
    OSError
        That cannot be done.
    """
    made: list[Path] = []
    descriptor = None
    try:
        _, descriptor = _new_file(folder, "", made)
    finally:
        _remove(made, descriptor)


def is_at(descriptor: int, path: Path) -> bool:
    """Tell whether an open file, or folder, still stands at a path."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.lstat(path))
    except OSError:
        return False


def remove_unfinished(folder: Path) -> None:
    """Remove the hidden files in a folder whose writers are dead; a living one's are locked."""
    if sys.platform == "win32":
        return
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _UNFINISHED.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                _remove_if_dead(Path(entry.path))


def _remove_if_dead(path: Path) -> None:
    with suppress(OSError):  # locked by a living process, or removed by another
        descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()
        finally:
            os.close(descriptor)


class HoldsFiles:
    """What has files open while it is entered: they are finished, or removed, as it is left."""

    _files: ExitStack

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._files.__exit__(kind, error, trace)
