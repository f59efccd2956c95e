"""Other tools find what was measured where it was measured."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
import roifile

from pinchoff import _core
from pinchoff.cli import main
from pinchoff.model.outlines import Outlines
from pinchoff.video.batch import measure_videos
from pinchoff.video.export import export_clip
from pinchoff.video.microscope import Scene, film
from pinchoff.video.settings import VideoSettings

CROP = (20, 10, 200, 160)


@pytest.fixture(scope="module")
def look():
    from pinchoff.video.microscope import Microscope

    return Microscope(width=240, height=180, pixel_size_um=5.0, noise=2.0, unevenness=0.1)


@pytest.fixture(scope="module")
def measured(look, tmp_path_factory):
    """The folder of a clip in which a disc of 20 pixels glides from (60, 90) to the right."""
    angles = 2 * np.pi * np.arange(128) / 128
    outline = 20.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    frames = [
        [(0, 0, outline + np.array([x, -90.0]), np.tile((180.0, 0.0), (128, 1)))] for x in (60, 240)
    ]
    from pinchoff.video.microscope import Passage

    run = Outlines.from_frames(np.array([0.0, 1.0]), frames, [(1e6, 1e6, 1.0)], {})
    folder = tmp_path_factory.mktemp("export")
    clip = film(Scene((Passage(run, 1.0, 1.0),)), folder / "a.mp4", 30, microscope=look).clip
    settings = VideoSettings(pixel_size_um=5.0, crop=CROP, frames="4:30", method="rings")
    result = measure_videos([clip], folder / "out", settings, processes=1, overlay=False)
    assert not result.clips[0].error
    return result.clips[0].folder


def test_rois_lie_on_the_droplet_in_imagej(measured, tmp_path):
    rois, _, _ = export_clip(measured, tmp_path)
    found = roifile.roiread(rois)
    tracks = pd.read_parquet(measured / "tracks.parquet")
    assert len(found) == len(tracks) > 15
    for roi, row in zip(found, tracks.itertuples(), strict=True):
        assert roi.name == f"{row.frame:05d}-{row.track_id:04d}"
        assert roi.position == row.frame + 1  # slices are counted from 1
        points = roi.coordinates().astype(float)
        if row.cut:
            continue
        # The disc as it was drawn in the whole film; the corner of a pixel is ImageJ's origin.
        x, y = points.mean(axis=0) - 0.5
        assert x == pytest.approx(60.0 + 3.0 * row.frame, abs=0.2)
        assert y == pytest.approx(90.0, abs=0.2)
        assert abs(_core.area(points)) == pytest.approx(math.pi * 400, rel=0.01)


@pytest.mark.filterwarnings("ignore:The inplace keyword")
def test_trackpy_reads_the_speed(measured, tmp_path):
    trackpy = pytest.importorskip("trackpy")
    _, path, _ = export_clip(measured, tmp_path)
    table = pd.read_csv(path)
    assert list(table.columns[:5]) == ["frame", "particle", "x", "y", "area"]
    whole = table[table["cut"] == 0]
    drift = trackpy.compute_drift(whole)
    assert np.diff(drift["x"]) == pytest.approx(3.0, abs=0.1)
    assert np.diff(drift["y"]) == pytest.approx(0.0, abs=0.1)
    displaced = trackpy.imsd(whole, mpp=5.0, fps=60.0, max_lagtime=5)
    assert displaced.iloc[0].to_numpy() == pytest.approx((3.0 * 5.0) ** 2, rel=0.01)
    assert whole["area"].to_numpy() == pytest.approx(math.pi * 400, rel=0.01)


def test_spots_are_in_micrometres(measured, tmp_path):
    _, _, path = export_clip(measured, tmp_path)
    table = pd.read_csv(path)
    tracks = pd.read_parquet(measured / "tracks.parquet")
    assert table["POSITION_X"].to_numpy() == pytest.approx(tracks["x_um"].to_numpy(), rel=1e-6)
    assert table["POSITION_T"].to_numpy() == pytest.approx(table["FRAME"] / 60.0, abs=1e-3)
    assert table["RADIUS"][len(table) // 2] == pytest.approx(100.0, rel=0.01)
    assert list(table["TRACK_ID"]) == list(tracks["track_id"])


def test_command(measured, tmp_path, capsys):
    batch = measured.parent.parent
    for given, out in ((batch, tmp_path / "one"), (measured, tmp_path / "two")):
        assert main(["export", str(given), "--out", str(out)]) == 0
        names = sorted(path.name for path in out.iterdir())
        assert names == ["a.rois.zip", "a.trackmate.csv", "a.tracks.csv"]
    capsys.readouterr()
    assert main(["export", str(batch), "--out", str(tmp_path / "one")]) == 2
    assert "add --overwrite" in capsys.readouterr().err
    assert main(["export", str(batch), "--out", str(tmp_path / "one"), "--overwrite"]) == 0
    assert len(roifile.roiread(tmp_path / "one" / "a.rois.zip")) > 15
    assert main(["export", str(tmp_path), "--out", str(tmp_path / "none")]) == 2
    assert "must be the folder of a measured clip" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
