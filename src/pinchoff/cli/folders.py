"""The folder that a command writes its results to, and single files."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pinchoff.cli.options import OUTPUT, AsJson, Overwrite, option, switch
from pinchoff.cli.output import announce
from pinchoff.support.errors import InputError
from pinchoff.support.locks import held_folder


@dataclass(frozen=True)
class ResultsFolder:
    """The folder that a command writes to, and how it tells what came of it."""

    out: Annotated[str, option("DIR", "Folder for the results", panel=OUTPUT)]
    as_json: AsJson = False

    def __post_init__(self) -> None:
        """Refuse no name, and bytes that are no letters: some of the files could not be written."""
        if not self.out.strip() or any("\ud800" <= letter <= "\udfff" for letter in self.out):
            rule, got = "the name of a folder", repr(self.out)
            raise InputError.of("--out", rule, got, "choose another")

    @contextmanager
    def held(self) -> Iterator[Path]:
        """Hold the folder for one command: made, writable, and closed to other runs.

        A folder that was made for this and gets no file is removed again.
        """
        folder = Path(self.out)
        with held_folder(folder, "--out"):
            yield folder

    @contextmanager
    def resumed(self) -> Iterator[Path]:
        """Hold the folder, and say after Ctrl-C that the same command goes on from there."""
        with self.held() as folder:
            try:
                yield folder
            except KeyboardInterrupt:
                print(f"stopped; the same command goes on with {self.out}", file=sys.stderr)
                raise

    def announce(
        self, report: Mapping[str, Any], tell: Callable[[], object], files: Iterable[Path]
    ) -> None:
        """Say what came of the command, as `output.announce`."""
        announce(report, tell, files, as_json=self.as_json)


@dataclass(frozen=True)
class Results(ResultsFolder):
    """The folder of a command that makes all of its results anew."""

    overwrite: Overwrite = False

    @contextmanager
    def held_for(
        self, names: Sequence[str], found: Callable[[Path], str] | None = None
    ) -> Iterator[Path]:
        """Hold the folder for files of some names; those that exist are refused or replaced.

        Earlier results stay: `remove_results` removes them once the new ones are there to be
        written. `found` says of the folder what it holds, for the error; by default the name of the
        first file is said.
        """
        with self.held() as folder:
            present = next((name for name in names if os.path.lexists(folder / name)), None)
            if present is not None and not self.overwrite:
                got = f"{folder} ({found(folder) if found else f'it holds {present}'})"
                advice = "add --overwrite, or choose another folder"
                raise InputError.of("--out", "a folder without results", got, advice)
            yield folder


@dataclass(frozen=True)
class ResumableResults(ResultsFolder):
    """The folder of a command that goes on where it was stopped."""

    overwrite: Annotated[
        bool, switch("--overwrite", "Begin anew, and replace earlier results", panel=OUTPUT)
    ] = False


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
    """Remove earlier results, by names or patterns, so that none stands beside new ones."""
    for pattern in results:
        for path in out.glob(pattern):
            path.unlink()
