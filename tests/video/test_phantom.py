"""Films of Phantom cameras, written here byte by byte after the published description."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from pinchoff.video.reading import Clip
from pinchoff.video.scale import described
from pinchoff.video.settings import VideoSettings

HEIGHT, WIDTH, COUNT = 24, 33, 4
SETUP = 0x163C
P10, P12L = 0x100, 0x400


def picture(number: int, bits: int) -> np.ndarray:
    """Return a ramp from black to white with its number in the corner at the top left."""
    white = 2**bits - 1
    image = np.rint(np.linspace(0, white, WIDTH))[None].repeat(HEIGHT, axis=0).astype(np.uint16)
    image[:4, :4] = number * white // 8
    return image


def stored(image: np.ndarray, bits: int, packing: int) -> bytes:
    if packing:  # from the top, the highest bit of each number first
        ones = (image.reshape(-1, 1) >> np.arange(bits - 1, -1, -1)) & 1
        return np.packbits(ones.astype(np.uint8)).tobytes()
    return image[::-1].astype("u1" if bits == 8 else "<u2").tobytes()


def write_cine(path, bits=12, packing=0, *, rate=4000, compression=0, version=1, colours=0):
    """Write a cine of `COUNT` frames; return the path."""
    pictures = [stored(picture(number, bits), bits, packing) for number in range(COUNT)]
    at_setup = 44 + 40
    at_offsets = at_setup + SETUP
    first = at_offsets + 8 * COUNT
    step = 8 + len(pictures[0])
    places = [first + step * number for number in range(COUNT)]
    setup = bytearray(SETUP)
    struct.pack_into("<2sH", setup, 140, b"ST", SETUP)
    struct.pack_into("<I", setup, 768, rate)
    struct.pack_into("<I", setup, 808, colours)
    struct.pack_into("<I", setup, 896, bits)
    container = 8 if bits == 8 else 16
    parts = [
        struct.pack("<2sHHHiIiI", b"CI", 44, compression, version, -3, COUNT, -3, COUNT),
        struct.pack("<IIIQ", 44, at_setup, at_offsets, 0),
        struct.pack("<IiiHHII", 40, WIDTH, HEIGHT, 1, container, packing, len(pictures[0])),
        struct.pack("<iiII", 0, 0, 0, 1 << bits),
        bytes(setup),
        struct.pack(f"<{COUNT}Q", *places),
        *(struct.pack("<II", 8, len(data)) + data for data in pictures),
    ]
    path.write_bytes(b"".join(parts))
    return path


@pytest.mark.parametrize(
    ("bits", "packing"), [(8, 0), (10, 0), (12, 0), (14, 0), (16, 0), (10, P10), (12, P12L)]
)
def test_frames_rate_and_depth(tmp_path, bits, packing):
    clip = Clip(write_cine(tmp_path / "a.cine", bits, packing))
    assert (clip.about.fps, clip.frame_count, clip.size) == (4000.0, COUNT, (WIDTH, HEIGHT))
    frames = list(clip.frames())
    assert [frame.number for frame in frames] == list(range(COUNT))
    assert [frame.time_s for frame in frames] == [number / 4000.0 for number in range(COUNT)]
    for frame in frames:
        expected = picture(frame.number, bits) * (255 / (2**bits - 1))
        assert np.abs(frame.luma - expected).max() <= 1.0
        assert frame.chroma is None


def test_the_rate_is_told_and_an_option_overrides_it(tmp_path):
    path = write_cine(tmp_path / "a.cine")
    (line,) = described({"a": path}, VideoSettings(pixel_size_um=2.0))
    assert "4 frames of 33 × 24 pixels, 4000 frames/s as the file says" in line
    assert [frame.time_s for frame in Clip(path, fps=100.0).frames()][1] == 0.01


def test_ffmpeg_reads_the_same(tmp_path):
    from pinchoff.video.formats.films import Film

    for bits, packing in ((8, 0), (16, 0), (10, P10)):
        path = write_cine(tmp_path / f"{bits}.cine", bits, packing)
        ours = [frame.luma for frame in Clip(path).frames()]
        for own, other in zip(ours, Film(path).pictures(), strict=True):
            assert np.abs(own - other.image * (255 / np.iinfo(other.image.dtype).max)).max() <= 1.0


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({"compression": 1}, "JPEG"),
        ({"version": 0}, "version 0"),
        ({"packing": 0x200}, "0x200"),
        ({"rate": 0}, "fps"),
    ],
)
def test_others_are_refused_by_name(tmp_path, refused, how, told):
    path = write_cine(tmp_path / "a.cine", **how)
    assert told in str(refused("fps" if told == "fps" else str(path), Clip, path))


def test_a_cut_file_costs_its_last_frames(tmp_path):
    path = write_cine(tmp_path / "a.cine")
    path.write_bytes(path.read_bytes()[:-100])
    clip = Clip(path)
    assert [frame.number for frame in clip.frames()] == [0, 1, 2]
    assert "frame 3" in clip.warning


def test_an_absurd_number_of_pictures_is_refused_at_once(tmp_path, refused):
    path = write_cine(tmp_path / "a.cine")
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, 20, 2**32 - 1)
    path.write_bytes(data)
    assert "4294967295 pictures" in refused(str(path), Clip, path).got


def test_colour_goes_through_ffmpeg_at_the_same_rate(tmp_path):
    path: Path = write_cine(tmp_path / "a.cine", 8, compression=2, colours=3)
    clip = Clip(path)
    frames = list(clip.frames())
    assert (len(frames), clip.about.fps, frames[1].time_s) == (COUNT, 4000.0, 1 / 4000.0)
    assert frames[0].chroma is not None
