"""Files of outlines, by their suffix: arrays in, arrays out."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import numpy as np

from pinchoff.model.gsd import OutlineWriter, StoredOutlines, read_gsd
from pinchoff.support.errors import InputError, refused_by_system
from pinchoff.support.files import written_aside

TIME_UNITS = {"D0": "t0", "um": "s"}
"""The unit of time that goes with each unit of length."""


def write_outlines(path: Path, outlines: StoredOutlines) -> None:
    """Write a file, complete or not at all.

    Raises
    ------
    InputError
        The suffix is none of ours, or the file cannot be written.
    """
    writers = {".gsd": _write_gsd, ".npz": _write_npz, ".csv": _write_csv}
    if path.suffix not in writers:
        rule = f"a name ending in {', '.join(writers)}"
        raise InputError.of("path", rule, path, "choose one of them")
    try:
        with written_aside(path) as unfinished:
            writers[path.suffix](unfinished, outlines)
    except OSError as error:
        raise refused_by_system(error, "path") from error


def _write_gsd(path: Path, stored: StoredOutlines) -> None:
    ends = np.searchsorted(stored.frame, np.arange(len(stored.times) + 1))
    about, units = stored.parameters, stored.units
    with OutlineWriter(path, stored.obstacles, about, units=units, flush_every=None) as writer:
        for time, first, last in zip(stored.times, ends[:-1], ends[1:], strict=True):
            vertices = slice(stored.offsets[first], stored.offsets[last])
            writer.append_flat(
                time,
                stored.droplet_id[first:last],
                stored.generation[first:last],
                np.diff(stored.offsets[first : last + 1]),
                stored.vertices[vertices],
                stored.velocities[vertices],
            )


def _write_npz(path: Path, stored: StoredOutlines) -> None:
    arrays = vars(stored) | {"parameters": np.array(json.dumps(stored.parameters))}
    np.savez_compressed(path, **arrays)


def _write_csv(path: Path, stored: StoredOutlines) -> None:
    import pandas as pd

    length, time = stored.units, TIME_UNITS[stored.units]
    sizes = np.diff(stored.offsets)
    columns = {
        "frame": np.repeat(stored.frame, sizes),
        f"time_{time}": np.repeat(stored.times[stored.frame], sizes),
        "droplet_id": np.repeat(stored.droplet_id, sizes),
        "generation": np.repeat(stored.generation, sizes),
        "vertex": np.arange(len(stored.vertices)) - np.repeat(stored.offsets[:-1], sizes),
        f"x_{length}": stored.vertices[:, 0],
        f"y_{length}": stored.vertices[:, 1],
        f"vx_{length}_per_{time}": stored.velocities[:, 0],
        f"vy_{length}_per_{time}": stored.velocities[:, 1],
    }
    pd.DataFrame(columns).to_csv(path, index=False)


def _read_npz(path: Path) -> StoredOutlines:
    # By a file of ours: NumPy leaves its own open where the archive is damaged.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
        texts = {"parameters": json.loads(str(data["parameters"])), "units": str(data["units"])}
        arrays = {f.name: data[f.name] for f in fields(StoredOutlines) if f.name not in texts}
        return StoredOutlines(**arrays, **texts)


READERS = {".gsd": read_gsd, ".npz": _read_npz}
"""What reads a file, by its suffix; of damage it raises errors of every kind."""
