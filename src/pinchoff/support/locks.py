"""Folders of results: one run at a time writes to each, and none stays that holds nothing."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from pinchoff.support.errors import InputError, refused_by_system
from pinchoff.support.files import hidden_name, is_at, remove_unfinished, require_writable

if sys.platform != "win32":
    import fcntl

_TRIES = 100  # to make a folder that other runs remove, as they do with empty ones

_mine: ContextVar[frozenset[tuple[int, int]]] = ContextVar("_mine", default=frozenset())
"""The folders that the work at hand holds: what it calls may hold them again."""


@contextmanager
def held_folder(path: Path, argument: str = "out") -> Iterator[None]:
    """Make a folder where there is none, and keep all other writers out of it.

    The system lets it go when the process ends, however that ends. What dead processes left half
    written is removed first. A folder that was made for this and holds nothing in the end is
    removed again. Errors call it by the argument's name.

    Raises
    ------
    InputError
        It cannot be made or written to, or another process or thread writes to it.
    """
    made: list[Path] = []
    with ExitStack() as held:
        try:
            descriptor = _opened(path, made, argument)
        except OSError as error:
            _remove_empty(made)
            if error.errno in (errno.ENAMETOOLONG, errno.ENOSPC):
                raise refused_by_system(error, argument) from None
            got = f"{path} ({error.strerror or error})"
            rule = "a folder that can be written to"
            raise InputError.of(argument, rule, got, "choose another") from None
        held.callback(os.close, descriptor)
        # While it is locked: nobody else has begun to write there.
        held.callback(_remove_empty, made)
        held.callback(_mine.reset, _mine.set(_mine.get() | {_identity(descriptor)}))
        yield


@contextmanager
def held_file(path: Path, argument: str = "out") -> Iterator[None]:
    """Keep other writers from a file, and from those beside it that belong to it.

    Raises
    ------
    InputError
        Its folder cannot be written to, or another process or thread writes to the file.
    """
    if sys.platform == "win32":
        yield
        return
    lock = path.with_name(hidden_name(path.name, ".lock"))
    try:
        descriptor = _file_lock(lock, path, argument)
    except OSError as error:
        got, rule = f"{path} ({error.strerror or error})", "a file that can be written"
        raise InputError.of(argument, rule, got, "choose an existing folder") from None
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)


def _file_lock(lock: Path, path: Path, argument: str) -> int:
    while True:
        descriptor = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        try:
            _lock(descriptor, path, argument)
        except BaseException:
            os.close(descriptor)
            raise
        if is_at(descriptor, lock):  # else the other run has just ended
            return descriptor
        os.close(descriptor)


@contextmanager
def made_folder(path: Path) -> Iterator[None]:
    """Make a folder inside one that is held; in the end it is removed if it holds nothing."""
    made: list[Path] = []
    _make(path, made)
    remove_unfinished(path)
    try:
        yield
    finally:
        _remove_empty(made)


def _opened(path: Path, made: list[Path], argument: str) -> int:
    """Make the folder, noting what was made, and lock it; return what holds the lock."""
    for attempt in range(_TRIES):
        try:
            _make(path, made)
            descriptor = _locked(path, argument)
        except FileNotFoundError:  # another run has just removed it, or nobody can make it
            if attempt == _TRIES - 1:
                raise
            continue
        if descriptor is not None:
            return descriptor
    raise FileNotFoundError(errno.ENOENT, "it is removed again and again", str(path))


def _locked(path: Path, argument: str) -> int | None:
    """Lock a folder; None where it was removed meanwhile."""
    if sys.platform == "win32":  # no locks on folders
        require_writable(path)
        return os.open(os.devnull, os.O_RDONLY)
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        if _identity(descriptor) not in _mine.get():
            _lock(descriptor, path, argument)
            remove_unfinished(path)
        if is_at(descriptor, path.resolve()):
            require_writable(path)
            return descriptor
    except BaseException:
        os.close(descriptor)
        raise
    os.close(descriptor)
    return None


def _make(path: Path, made: list[Path]) -> None:
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    for folder in reversed(missing):
        with suppress(FileExistsError):  # another run was faster
            folder.mkdir()
            made.append(folder)
    if path.is_dir():
        return
    try:
        path.mkdir()  # says why not
    except FileExistsError:
        # A file stands there, or another run has just made the folder, or removed it again: the
        # last of these is a FileNotFoundError, after which it is tried anew.
        if not stat.S_ISDIR(path.stat().st_mode):
            raise


def _lock(descriptor: int, path: Path, argument: str) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        rule = "what no other run writes to"
        advice = "wait for the other run, or choose another name"
        raise InputError.of(argument, rule, f"{path}, in use", advice) from None
    except OSError:
        pass  # a file system without locks: files still appear complete or not at all


def _identity(descriptor: int) -> tuple[int, int]:
    found = os.fstat(descriptor)
    return found.st_dev, found.st_ino


def _remove_empty(made: list[Path]) -> None:
    for folder in reversed(made):
        with suppress(OSError):  # it holds something, or is gone
            folder.rmdir()
