"""Clips of every kind come frame by frame, with exact times; damaged ones as far as they go."""

from __future__ import annotations

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from pinchoff.video.background import SAMPLE_SIZE, sample
from pinchoff.video.reading import Clip, Frame
from pinchoff.video.writing import ClipWriter


def picture(number: int, size=(64, 48)) -> np.ndarray:
    """Return a frame that tells its number: grey, with a red square that moves."""
    image = np.full((size[1], size[0], 3), 100 + number, dtype=np.uint8)
    image[8:24, number : number + 16] = (220, 40, 40)
    return image


def write(path, count=10, fps=25.0):
    with ClipWriter(path, (64, 48), fps, crf=10) as writer:
        for number in range(count):
            writer.append(picture(number))
    return path


def test_frames_in_order_with_colour(tmp_path):
    found = list(Clip(write(tmp_path / "clip.mp4")).frames())
    assert [frame.number for frame in found] == list(range(10))
    assert [frame.time_s for frame in found] == pytest.approx(np.arange(10) / 25.0, abs=1e-6)
    for number, frame in enumerate(found):
        assert frame.luma.shape == (48, 64)
        assert frame.chroma.shape == (2, 24, 32)
        grey = cv2.cvtColor(picture(number), cv2.COLOR_RGB2YUV)[:, :, 0]
        # The file holds 16 to 235 for black to white.
        assert frame.luma[40, 5] == pytest.approx(16 + int(grey[40, 5]) * 219 / 255, abs=2)
        assert frame.chroma[1, 8, (number + 8) // 2] > 150
        assert abs(int(frame.chroma[1, 20, 2]) - 128) < 4


def test_given_rate_replaces_the_files(tmp_path):
    times = [frame.time_s for frame in Clip(write(tmp_path / "clip.mp4"), fps=60.0).frames()]
    assert times == pytest.approx(np.arange(10) / 60.0)


@pytest.mark.parametrize("fps", [None, 60.0])
def test_frames_left_out_keep_the_others_numbers(tmp_path, fps):
    clip = Clip(write(tmp_path / "clip.mp4", count=40), fps)
    every = {frame.number: frame for frame in clip.frames()}
    some = list(clip.frames(sparse=True))
    assert 5 < len(some) < 40  # x264 codes frames on which no others depend
    for frame in some:
        assert np.array_equal(frame.luma, every[frame.number].luma)
        assert frame.time_s == pytest.approx(every[frame.number].time_s, abs=1e-9)


def test_variable_frame_rate(tmp_path):
    """Times are those at which frames are shown, also with another time base and a late start."""
    path = tmp_path / "uneven.mkv"
    shown = [5, 7, 8, 15, 16, 40]
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=100)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 100)
        for number, when in enumerate(shown):
            frame = av.VideoFrame.from_ndarray(picture(number), format="rgb24")
            frame.pts, frame.time_base = when, Fraction(1, 100)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    times = [frame.time_s for frame in Clip(path).frames()]
    assert times == pytest.approx((np.array(shown) - 5) / 100, abs=1.1e-3)


def test_one_frame(tmp_path):
    (frame,) = Clip(write(tmp_path / "one.mp4", count=1)).frames()
    assert frame.time_s == 0.0


@pytest.mark.parametrize("suffix", [".png", ".tif"])
def test_folder_of_images_in_natural_order(tmp_path, suffix):
    for number in (0, 1, 2, 10):
        cv2.imwrite(str(tmp_path / f"image{number}{suffix}"), picture(number)[:, :, ::-1])
    found = list(Clip(tmp_path, fps=10.0).frames())
    assert [frame.luma[40, 5] for frame in found] == [100, 101, 102, 110]
    assert [frame.time_s for frame in found] == pytest.approx([0.0, 0.1, 0.2, 1.0])  # as numbered
    assert found[0].chroma[1, 8, 4] > 150


def test_truncated_file_gives_what_is_readable(tmp_path):
    # A transport stream needs no index at its end.
    whole = tmp_path / "whole.ts"
    with av.open(str(whole), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        random = np.random.default_rng(0)
        for _ in range(60):
            noise = random.integers(0, 255, (48, 64, 3), dtype=np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(noise, format="rgb24")))
        container.mux(stream.encode(None))
    data = whole.read_bytes()
    (tmp_path / "cut.ts").write_bytes(data[: len(data) // 2])
    found = list(Clip(tmp_path / "cut.ts").frames())
    assert 5 < len(found) < 60
    assert [frame.number for frame in found] == list(range(len(found)))


def test_a_film_of_an_unknown_codec_is_refused(tmp_path, refused):
    film = write(tmp_path / "clip.mp4")
    film.write_bytes(film.read_bytes().replace(b"avc1", b"none"))
    refused(str(film), Clip, film)


def test_an_empty_folder_and_what_is_not_there_are_refused(tmp_path, refused):
    refused(str(tmp_path), Clip, tmp_path)
    refused(str(tmp_path / "none.mp4"), Clip, tmp_path / "none.mp4")


@pytest.mark.parametrize("count", [1, 31, 32, 63, 64, 65, 1000])
def test_sample_is_even_and_bounded(count):
    empty = np.zeros((2, 2), dtype=np.uint8)
    kept, pairs, seen = sample(Frame(n, 0.0, empty, None) for n in range(count))
    numbers = [frame.number for frame in kept]
    assert seen == count
    assert all(after.number == before.number + 1 for before, after in pairs)
    assert len(pairs) >= (len(kept) - 1) // 4
    assert min(count, SAMPLE_SIZE) <= len(kept) < 2 * SAMPLE_SIZE
    assert len(set(np.diff(numbers))) <= 1
    assert numbers[-1] >= count - max(1, 2 * count // SAMPLE_SIZE)
