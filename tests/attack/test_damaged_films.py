"""Films and stacks, damaged at random, through the command line's entry point.

Whatever is wrong with one is its error and takes no other with it. ``--attacks N`` sets how many.
"""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

av = pytest.importorskip("av", reason="the extra 'video' is not installed")
tifffile = pytest.importorskip("tifffile", reason="the extra 'video' is not installed")

TOGETHER = 10  # films of a command
LONGEST_S = 20  # of CPU time, for a film


def drawn(count: int = 12, side: int = 96) -> np.ndarray:
    """Return frames of a bright background with two dark rings that move."""
    y, x = np.mgrid[:side, :side]
    frames = np.full((count, side, side), 200, np.uint8)
    for k, frame in enumerate(frames):
        for cx, cy in ((20 + 4 * k, 34), (70 - 3 * k, 66)):
            distance = np.hypot(x - cx, y - cy)
            frame[(distance > 10) & (distance < 13)] = 60
    return frames


def written(path, codec: str = "libx264") -> bytes:
    frames = drawn()
    if path.suffix == ".tif":
        tifffile.imwrite(path, frames, photometric="minisblack")
    else:
        with av.open(str(path), "w") as film:
            stream = film.add_stream(codec, rate=Fraction(30))
            stream.height, stream.width = frames.shape[1:]
            stream.pix_fmt = "yuv420p"
            for frame in frames:
                shown = av.VideoFrame.from_ndarray(frame, format="gray")
                film.mux(stream.encode(shown.reformat(format="yuv420p")))
            film.mux(stream.encode(None))
    return path.read_bytes()


def damaged(draw: random.Random, content: bytes) -> bytes:
    """Flip bits, cut, double or blank some bytes: often in the header, where it hurts most."""
    data = bytearray(content)
    for _ in range(draw.choice([1, 1, 4, 30])):
        where = min(len(data) - 1, int(len(data) * draw.random() ** draw.choice([1, 3])))
        kind = draw.randrange(6)
        if kind <= 2:
            data[where] ^= 1 << draw.randrange(8)
        elif kind == 3:
            data[where : where + 4] = draw.choice([b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff"])
        elif kind == 4:
            del data[where : where + draw.choice([1, 100, len(data)])]
        else:
            data[where:where] = data[where : where + draw.randrange(1, 200)]
        if not data:
            break
    return bytes(data)


@pytest.mark.parametrize("suffix", [".mp4", ".avi", ".mkv", ".tif"])
def test_damaged_films(attack, attacks, tmp_path, suffix):
    draw = random.Random(suffix)
    whole = tmp_path / f"whole{suffix}"
    content = written(whole)
    for batch in range(max(1, attacks // 4 // TOGETHER)):
        films = [tmp_path / f"{batch}-{k}{suffix}" for k in range(TOGETHER)]
        for film in films:
            film.write_bytes(damaged(draw, content))
        out = tmp_path / f"out{batch}"
        options = ["--pixel-size", "5 um", "--fps", "30", "--workers", "1", "--no-overlay"]
        arguments = ["video", *map(str, films), str(whole), *options, "--out", str(out)]
        assert attack(arguments, out, LONGEST_S * (TOGETHER + 1)) == []
        assert (out / "clips" / "whole" / "clip.json").exists()
        for film in films:
            film.unlink()
