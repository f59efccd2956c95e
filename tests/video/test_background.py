"""The median that is counted bit by bit is the median."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff.video.background import median_background, pixel_median
from pinchoff.video.reading import Frame


@pytest.mark.parametrize("count", [1, 2, 3, 24, 47, 255])
def test_pixel_median_is_numpys(count):
    random = np.random.default_rng(count)
    images = random.integers(0, 256, (count, 7, 11), dtype=np.uint8)
    images[:, 0] //= 100  # many equal ones
    images[:, 1] = 255
    images[:, 2] = 0
    assert np.array_equal(pixel_median(images), np.median(images, axis=0))


def test_colour_planes_keep_their_shape():
    assert pixel_median(np.zeros((5, 2, 4, 6), dtype=np.uint8)).shape == (2, 4, 6)


def test_a_lamp_that_flickers_is_no_noise():
    random = np.random.default_rng(4)
    frames = []
    for number in range(30):
        light = 1.0 + 0.3 * np.sin(number)
        luma = light * (120.0 + np.linspace(-20.0, 20.0, 128)) + random.normal(0.0, 3.0, (96, 128))
        frames.append(Frame(number, 0.0, np.rint(luma).astype(np.uint8), None))
    background = median_background(frames)
    assert background.noise == pytest.approx(3.0, rel=0.3)
    for frame in frames:
        assert background.lamp(frame.luma) == pytest.approx(
            1.0 + 0.3 * np.sin(frame.number), rel=0.1
        )
