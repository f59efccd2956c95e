"""Single images, which have no empty chamber: their smoothed light stands for it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pinchoff.video.background import Background, median_background
from pinchoff.video.levels import Levels, calibrate
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.reading import Frame
from pinchoff.video.settings import VideoSettings


def droplets_of(luma, **settings):
    frame = Frame(0, 0.0, luma, None)
    chosen = VideoSettings(pixel_size_um=1.0, minimum_diameter_um=20.0, **settings)
    calibrated = calibrate([frame], chosen)
    return RingSegmenter(calibrated.background, calibrated.levels).droplets(frame)


def ringed(centres, radius=30, size=(400, 400)):
    """Grey discs with dark rims on uneven light."""
    rows, columns = np.mgrid[: size[0], : size[1]]
    luma = 180.0 + 0.08 * columns
    for x, y in centres:
        distance = np.hypot(columns - x, rows - y)
        luma = np.where((distance < radius) & (distance > radius - 6), 60.0, luma)
    return cv2.GaussianBlur(luma.astype(np.float32), (0, 0), 1.0).astype(np.uint8)


def test_ringed_discs_are_found_in_one_image():
    centres = [(90, 100), (250, 120), (170, 280), (320, 300)]
    found = droplets_of(ringed(centres))
    assert sorted((round(d.x), round(d.y)) for d in found) == sorted(centres)
    assert [d.area for d in found] == pytest.approx([np.pi * 30**2] * 4, rel=0.03)


def test_the_light_of_one_image_stands_for_the_chamber():
    background = median_background([Frame(0, 0.0, ringed([(200, 200)]), None)])
    assert background.luma.min() > 150  # the disc is not in it
    assert background.luma[:, -50:].mean() > background.luma[:, :50].mean() + 10  # the slope is


def test_very_many_cells_of_one_ring_come_apart():
    """A lattice of dark walls encloses 400 cells, more than a byte can number."""
    luma = np.full((500, 500), 200, dtype=np.uint8)
    luma[45:452:20, 45:452] = luma[45:452, 45:452:20] = 60
    luma = cv2.dilate(255 - luma, np.ones((3, 3), np.uint8))
    frame = Frame(0, 0.0, 255 - luma, None)
    even = np.full((500, 500), 200, dtype=np.float32)
    chamber = Background(even, None, np.ones_like(even), 1.0)
    levels = Levels(ring=140.0, edge=0.5, colour=np.zeros(3), interior=0.5, minimum_area=100.0)
    found = RingSegmenter(chamber, levels).droplets(frame)
    assert len(found) == 400
    assert len({d.group for d in found}) == 1
    assert sum(d.area for d in found) == pytest.approx(403**2, rel=0.05)
