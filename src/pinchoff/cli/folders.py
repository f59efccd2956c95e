"""The folder that a command writes its results to."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from pinchoff.support.errors import InputError
from pinchoff.support.locks import held_folder


def results_folder(text: str) -> Path:
    """Read the value of --out.

    Raises
    ------
    InputError
        It is empty, or has bytes that are no letters: some of the files could not be written.
    """
    if not text.strip() or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise InputError.of("--out", "the name of a folder", repr(text), "choose another")
    return Path(text)


@contextmanager
def results_in(
    out: Path,
    results: Sequence[str] = (),
    *,
    overwrite: bool = False,
    held: Callable[[Path], str] | None = None,
) -> Iterator[None]:
    """Hold the folder of --out for one command: made, writable, and closed to other runs.

    Earlier results stay: `remove_results` removes them once the new ones are there to be written.
    A folder that was made for this and gets no file is removed again.

    Parameters
    ----------
    out : Path
    results : sequence of str, optional
        Names of the files that the command writes there.
    overwrite : bool, optional
        Whether those that exist may be replaced.
    held : callable, optional
        Says of the folder what it holds, for the error; by default the name of the first result.

    Raises
    ------
    InputError
        It cannot be made or written to, another run writes to it, or it holds results that may
        not be replaced.
    """
    with held_folder(out, "--out"):
        _refuse_results(out, results, overwrite=overwrite, held=held)
        yield


def _refuse_results(
    out: Path, results: Sequence[str], *, overwrite: bool, held: Callable[[Path], str] | None = None
) -> None:
    present = next((name for name in results if os.path.lexists(out / name)), None)
    if present is not None and not overwrite:
        found = held(out) if held else f"it holds {present}"
        advice = "add --overwrite, or choose another folder"
        got = f"{out} ({found})"
        raise InputError.of("--out", "a folder without results", got, advice)


def require_new_file(option: str, *files: Path, overwrite: bool) -> None:
    """Refuse files that exist and may not be replaced, or whose folder does not exist."""
    for path in files:
        if os.path.lexists(path) and not overwrite:
            advice = "add --overwrite, or choose another name"
            raise InputError.of(option, "a new file", f"{path}, which exists", advice)
        if not path.parent.is_dir():
            got = f"{path}, whose folder does not exist"
            raise InputError.of(option, "a file in an existing folder", got, "make it first")


def remove_results(out: Path, results: Iterable[str]) -> None:
    """Remove earlier results, so that none of them stands beside new ones.

    Parameters
    ----------
    out : Path
    results : iterable of str
        Names of files, or patterns of them; what does not exist is passed over.
    """
    for pattern in results:
        for path in out.glob(pattern):
            path.unlink()


@contextmanager
def going_on_with(out: str) -> Iterator[None]:
    """Say after Ctrl-C that the same command goes on where it was stopped."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"stopped; the same command goes on with {out}", file=sys.stderr)
        raise
