"""The folder of a sweep: a manifest, and the collisions table in parts.

A part holds a fixed range of point numbers and is either there, complete, or not there. Names of
other files begin with ``_`` or ``.``, which readers of Parquet datasets pass over.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import PositiveInt

from pinchoff.collisions.checksums import (
    CHECKSUMS,
    is_whole,
    record_checksum,
    recorded_checksums,
    settle_checksums,
)
from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.support.errors import InputError, PinchoffError, refused_by_system
from pinchoff.support.files import written_aside
from pinchoff.support.locks import held_folder
from pinchoff.support.records import Shape, read_record, write_json

MANIFEST = "_sweep.json"

_FORMAT = 1
_ELSEWHERE = "choose another folder"


class _Manifest(Shape):
    format: Literal[1]
    pinchoff_version: str
    configuration_hash: str
    configuration: dict[str, Any]
    count: PositiveInt
    part_size: PositiveInt
    last_point: dict[str, Any]


@dataclass(frozen=True)
class SweepDataset:
    """The folder of one sweep: `count` rows in the end, `part_size` in each part but the last."""

    path: Path
    count: int
    part_size: int

    @property
    def part_count(self) -> int:
        """How many parts the finished sweep has."""
        return -(-self.count // self.part_size)

    def rows_of(self, part: int) -> range:
        """Return the numbers of the points in a part."""
        start = part * self.part_size
        return range(start, min(start + self.part_size, self.count))

    def missing_parts(self) -> list[int]:
        """Return the parts that are not there; warn of what was damaged and is set aside."""
        checksums = recorded_checksums(self.path)
        missing = []
        for part in range(self.part_count):
            path = self._part_path(part)
            if not path.exists():
                missing.append(part)
            elif not self._is_complete(part, checksums):
                missing.append(part)
                path.replace(path.with_name(f"_damaged-{path.name}"))
                text = f"{path.name} is damaged: it is set aside and computed again"
                warnings.warn(text, UserWarning, stacklevel=3)
        return missing

    def write(self, part: int, content: bytes) -> None:
        """Write a part so that it appears at once, complete; a full disk is a `PinchoffError`."""
        path = self._part_path(part)
        try:
            with written_aside(path, suffix=".unfinished") as unfinished:
                unfinished.write_bytes(content)
                record_checksum(self.path, path.name, content)
        except OSError as error:
            raise PinchoffError(
                f"{self.path} must be a folder that can take {len(content)} bytes more; got "
                f"'{error.strerror}'; make room and start again: what is "
                "there stays"
            ) from error

    def settle(self) -> None:
        """Let nothing tell how often the sweep was stopped."""
        settle_checksums(self.path)

    def _part_path(self, part: int) -> Path:
        return self.path / f"part-{part:06d}.parquet"

    def _is_complete(self, part: int, checksums: dict[str, str] | None) -> bool:
        path = self._part_path(part)
        if checksums is not None:
            return is_whole(path, checksums)
        try:  # the file of checksums is gone
            return bool(pq.read_metadata(path).num_rows == len(self.rows_of(part)))
        except (OSError, pa.ArrowException):
            return False


def part_size_of(count: int) -> int:
    """Return the rows of a part: some dozens of parts, of a size that is quick to compute."""
    return min(1024, max(16, -(-count // 64)))


def read_manifest(path: Path) -> dict[str, Any] | None:
    """Return the manifest in a folder, or None where there is none; refuse one that is damaged."""
    place = path / MANIFEST
    try:
        if not place.exists():
            return None
    except OSError:
        return None  # say, a name too long: whoever makes the folder says so
    return read_record(place, _Manifest, "a sweep's manifest", _ELSEWHERE)


@contextmanager
def opened(path: Path, design: SweepDesign) -> Iterator[SweepDataset]:
    """Open the folder of a sweep for writing, alone, and make it where there is none.

    Raises
    ------
    InputError
        The folder cannot be written to, holds something else, or another process writes to it.
    """
    with held_folder(path):
        manifest = read_manifest(path)
        if manifest is None:
            _require_empty(path)
            manifest = manifest_of(design)
            try:
                write_json(path / MANIFEST, manifest)
            except OSError as error:
                raise refused_by_system(error) from error
        require_same(manifest, design, path)
        yield SweepDataset(path, manifest["count"], manifest["part_size"])


def manifest_of(design: SweepDesign) -> dict[str, Any]:
    """Return the manifest of a sweep that begins."""
    from pinchoff import __version__

    return {
        "format": _FORMAT,
        "pinchoff_version": __version__,
        "configuration_hash": design.fingerprint,
        "configuration": design.configuration,
        "count": len(design),
        "part_size": part_size_of(len(design)),
        "last_point": _probe(design),
    }


def require_same(manifest: Mapping[str, Any], design: SweepDesign, path: Path) -> None:
    """Refuse to go on with a sweep of another version, configuration or sample; say which."""
    from pinchoff import __version__

    version = manifest["pinchoff_version"]
    if version != __version__:
        raise InputError.of(
            "out",
            f"a folder of pinchoff {__version__}, or a new one",
            f"{path} of pinchoff {version}",
            f"finish it with pinchoff {version}, or choose another folder: versions do not mix",
        )
    if manifest["configuration_hash"] != design.fingerprint:
        before, now = _flat(manifest["configuration"]), _flat(design.configuration)
        changes = [
            f"{key} = {_text_of(now, key)}, there {_text_of(before, key)}"
            for key in dict.fromkeys([*before, *now])
            if before.get(key) != now.get(key)
        ] or ["the order of the varied parameters differs"]
        more = f" (and {len(changes) - 1} more changes)" if len(changes) > 1 else ""
        raise InputError.of(
            "out",
            "a new folder, or one with a sweep of this very configuration",
            f"{changes[0]}{more}",
            f"undo the change, or choose another folder than {path}",
        )
    if manifest["count"] != len(design):
        got, advice = f"{manifest['count']} points there", f"choose another folder than {path}"
        raise InputError.of("out", f"a folder for {len(design)} points", got, advice)
    if manifest["last_point"] != _probe(design):
        raise InputError.of(
            "out",
            "a folder whose sample is drawn like this one",
            "other points for the same seed",
            "use the version of scipy that began the sweep, or choose another folder",
        )


def _probe(design: SweepDesign) -> dict[str, Any]:
    """Return what tells two drawings of a sample apart: its last point."""
    last = design.point(len(design) - 1).model_dump(mode="json", exclude_none=True)
    varied = {axis.name for axis in design.axes}
    return {name: value for name, value in last.items() if name in varied or name == "scale"}


def _flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    leaves: dict[str, Any] = {}
    for key, value in tree.items():
        if isinstance(value, Mapping):
            leaves |= _flat(value, f"{prefix}{key}.")
        else:
            leaves[prefix + key] = value
    return leaves


def _text_of(leaves: Mapping[str, Any], key: str) -> str:
    return repr(leaves[key]) if key in leaves else "nothing"


def _require_empty(path: Path) -> None:
    found = [entry.name for entry in path.iterdir() if not entry.name.startswith(".")]
    if found:
        got = f"{path}, which holds {sorted(found)[0]}"
        rule = "a new or empty folder, or that of a sweep"
        raise InputError.of("out", rule, got, _ELSEWHERE)


def remove_sweep(path: Path) -> None:
    """Remove a sweep from a folder, its manifest last, and nothing else."""
    for files in ("part-*.parquet", "_damaged-part-*.parquet", CHECKSUMS, MANIFEST):
        for file in path.glob(files):
            file.unlink()
