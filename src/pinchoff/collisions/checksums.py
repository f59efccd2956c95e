"""Checksums of a folder's parts: what is read back is what was written, to the last bit.

Those of a sweep stand in a file of lines as ``sha256sum`` writes and checks them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from pinchoff.support.errors import InputError
from pinchoff.support.files import write_text

CHECKSUMS = "_checksums.sha256"


def record_checksum(folder: Path, name: str, content: bytes) -> None:
    """Note a file's checksum, before the file appears: one without it was never complete."""
    with (folder / CHECKSUMS).open("a", encoding="ascii") as file:
        file.write(f"{hashlib.sha256(content).hexdigest()}  {name}\n")


def settle_checksums(folder: Path) -> None:
    """Leave one line for each file that is there, in the order of names, and no other."""
    found = recorded_checksums(folder)
    if found is None:
        return
    names = sorted({path.name for path in folder.iterdir()} & found.keys())
    text = "".join(f"{found[name]}  {name}\n" for name in names)
    if text != (folder / CHECKSUMS).read_text(encoding="ascii", errors="replace"):
        write_text(folder / CHECKSUMS, text)


def recorded_checksums(folder: Path) -> dict[str, str] | None:
    """Return the checksums by the files' names, the last of each; None where there are none."""
    try:
        text = (folder / CHECKSUMS).read_text(encoding="ascii", errors="replace")
    except OSError:
        return None
    lines = (line.split("  ", 1) for line in text.splitlines())
    return {pair[1]: pair[0] for pair in lines if len(pair) == 2}


def checksum_of(path: Path) -> str:
    """Return the checksum of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_whole(path: Path, checksums: Mapping[str, str]) -> bool:
    """Return whether a file is there as it was written."""
    try:
        return checksums.get(path.name) == checksum_of(path)
    except OSError:
        return False


def require_whole(folder: Path, files: list[Path]) -> None:
    """Refuse files of a folder that are not as they were written.

    Raises
    ------
    InputError
        Names the first.
    """
    checksums = recorded_checksums(folder)
    if checksums is None:
        return
    for path in files:
        if not is_whole(path, checksums):
            advice = "give the sweep's command again: it sets it aside and computes it anew"
            raise InputError.of(str(path), "as it was written", "other bytes", advice)
