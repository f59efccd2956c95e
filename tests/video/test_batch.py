"""One bad clip takes no other with it, and how many processes work does not show in the rows."""

from __future__ import annotations

import functools

import numpy as np
import pandas as pd
import pytest
import tifffile

from pinchoff.video import batch
from pinchoff.video.batch import clip_sources, measure_videos
from pinchoff.video.microscope import Scene, film
from pinchoff.video.settings import VideoSettings

OBSTACLE = (150.0, 80.0, 16.0)
SETTINGS = VideoSettings(pixel_size_um=5.0, fps=60.0, method="rings", obstacles=(OBSTACLE,))


@pytest.fixture
def good(tmp_path, disc, sliding, microscope):
    """A clip with one collision."""
    scene = Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE),))
    return film(scene, tmp_path / "good.mp4", 60, microscope=microscope).clip


def bad_ones(folder, good):
    """Write clips that libraries refuse in their own ways, and return them."""
    folder.mkdir()
    whole = good.read_bytes()
    (folder / "truncated.mp4").write_bytes(whole[: len(whole) // 2])
    (folder / "text.avi").write_text("no film")
    (folder / "empty.tif").write_bytes(b"")
    tifffile.imwrite(folder / "tiny.tif", np.zeros((5, 1, 1), np.uint8))
    tifffile.imwrite(folder / "huge.tif", np.zeros((16, 16), np.uint8))
    with tifffile.TiffFile(folder / "huge.tif", mode="r+") as file:
        for tag in ("ImageWidth", "ImageLength"):
            file.pages[0].tags[tag].overwrite(60000)
    (folder / "pictures").mkdir()
    (folder / "pictures" / "a0.png").write_bytes(b"\x89PNG\r\n")
    (folder / "film.mraw").write_bytes(b"\0" * 100)
    return sorted(folder.iterdir())


@pytest.mark.parametrize("processes", [1, 2])
def test_bad_clips_are_told_and_the_good_one_measured(tmp_path, good, processes):
    bad = bad_ones(tmp_path / "bad", good)
    out = tmp_path / "out"
    result = measure_videos([*bad, good], out, SETTINGS, processes=processes, overlay=False)
    assert len(result.collisions) == 1
    assert [clip.name for clip in result.clips if not clip.error] == ["good"]
    for clip, path in zip(result.clips, bad, strict=False):
        assert str(path) in clip.error
        assert " must be " in clip.error
    assert sorted(path.name for path in (out / "clips").iterdir()) == ["good"]


def test_no_numbers_in_a_clip(tmp_path, good):
    pages = np.full((5, 64, 64), 0.5, np.float32)
    pages[2, 3, 4] = np.nan
    tifffile.imwrite(tmp_path / "nan.tif", pages)
    result = measure_videos([tmp_path / "nan.tif", good], tmp_path / "out", SETTINGS, processes=1)
    assert not any(clip.error for clip in result.clips)
    assert "1 values are no numbers" in result.clips[0].result["warning"]


def test_an_error_that_nobody_foresaw_is_the_clips_own(tmp_path, good, monkeypatch):
    def fails(*_args, **_how):
        raise ZeroDivisionError("float\ndivision")

    monkeypatch.setattr("pinchoff.video.clips.measure_clip", fails)
    result = measure_videos([good], tmp_path / "out", SETTINGS, processes=1)
    assert result.clips[0].error == (
        f"{good} must be a clip that can be measured; got ZeroDivisionError: float division; see "
        "whether a player or Fiji opens it, and save it anew from there"
    )
    assert not (tmp_path / "out").exists()


def _segmentation(level):
    return lambda luma: [luma > level]


def test_a_segmentation_that_changes_is_another(tmp_path):
    """By a number in its file, by what it holds, and always where its source cannot be read."""

    def marked(text):
        (tmp_path / "mine.py").write_text(text)
        scope = {"__name__": "mine"}
        exec(compile(text, str(tmp_path / "mine.py"), "exec"), scope)
        return batch._function_mark(scope["find"])

    text = "LEVEL = 100\n\ndef find(luma):\n    return [luma > LEVEL]\n"
    assert marked(text) == marked(text) != marked(text.replace("100", "120"))
    one, other = (batch._function_mark(_segmentation(level)) for level in (1, 2))
    assert one == batch._function_mark(_segmentation(1)) != other
    flat, dented = np.zeros((300, 300)), np.zeros((300, 300))
    dented[150, 150] = 1.0  # where the repr of an array has three dots
    one, other = (batch._function_mark(_segmentation(level)) for level in (flat, dented))
    assert one == batch._function_mark(_segmentation(flat.copy())) != other
    held = functools.partial(_segmentation, 1)
    assert batch._function_mark(held) != batch._function_mark(held)


def test_a_clip_that_was_measured_stays_when_it_fails_later(tmp_path, good):
    out = tmp_path / "out"
    measure_videos([good], out, SETTINGS, processes=1)
    good.write_text("no film")
    again = measure_videos([good], out, SETTINGS, processes=1)
    assert again.clips[0].error
    assert (out / "clips" / "good" / "obstacles.toml").exists()


def test_a_damaged_result_is_measured_again(tmp_path, good):
    out = tmp_path / "out"
    measure_videos([good], out, SETTINGS, processes=1, overlay=False)
    tracks = out / "clips" / "good" / "tracks.parquet"
    content = bytearray(tracks.read_bytes())
    content[len(content) // 2] ^= 1  # a bit of the data: the file still opens
    tracks.write_bytes(content)
    again = measure_videos([good], out, SETTINGS, processes=1, overlay=False)
    assert not again.clips[0].reused
    assert not again.clips[0].error
    assert pd.read_parquet(tracks).attrs["units"]["area_um2"] == "µm²"


@pytest.mark.parametrize("overlay", [False, True])
def test_rows_do_not_depend_on_the_processes(tmp_path, good, overlay):
    tables = []
    for processes in (1, 2):
        out = tmp_path / f"out{processes}"
        measure_videos([good], out, SETTINGS, processes=processes, overlay=overlay)
        folder = out / "clips" / "good"
        names = ("collisions.parquet", "tracks.parquet", "events.parquet")
        tables.append([pd.read_parquet(folder / name) for name in names])
        tables[-1].append((folder / "outlines.gsd").read_bytes())
    for one, other in zip(*tables, strict=True):
        if isinstance(one, bytes):
            assert len(one) == len(other)
        else:
            pd.testing.assert_frame_equal(one, other)


@pytest.mark.parametrize("name", ["...mp4", "..mp4", ".mp4", "... .mp4"])
def test_names_stay_inside_the_results(tmp_path, name):
    (tmp_path / name).touch()
    ((found, _),) = clip_sources([tmp_path / name]).items()
    inside = (tmp_path / "out" / "clips" / found).resolve()
    assert inside.parent == (tmp_path / "out" / "clips").resolve()


def test_a_folder_of_stacks_stands_for_these(tmp_path):
    for name in ("b.tif", "a.tif"):
        tifffile.imwrite(tmp_path / name, np.zeros((5, 16, 16), np.uint8))
    assert list(clip_sources([tmp_path])) == ["a", "b"]
    (tmp_path / "singles").mkdir()
    for k in range(3):
        tifffile.imwrite(tmp_path / "singles" / f"{k}.tif", np.zeros((16, 16), np.uint8))
    assert list(clip_sources([tmp_path / "singles"])) == ["singles"]


def test_frames_and_crop_of_a_clip(tmp_path, good):
    moved = (OBSTACLE[0] - 20, OBSTACLE[1] - 10, OBSTACLE[2])
    part = SETTINGS.replace(frames="10:50", crop=(20, 10, 200, 150), obstacles=(moved,))
    whole = measure_videos([good], tmp_path / "whole", SETTINGS, processes=1, overlay=False)
    result = measure_videos([good], tmp_path / "part", part, processes=1, overlay=False)
    one, other = (each.collisions.iloc[0] for each in (whole, result))
    assert other["contact_frame"] == one["contact_frame"]
    assert other["contact_time_s"] == pytest.approx(one["contact_time_s"])
    assert other["speed_mm_s"] == pytest.approx(one["speed_mm_s"], rel=0.01)
    assert other["symmetry"] == pytest.approx(one["symmetry"], abs=0.02)
    assert result.clips[0].result["frames"] == 40
    assert batch.CLIPS in {path.name for path in (tmp_path / "part").iterdir()}
