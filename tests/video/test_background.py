"""The median that is counted bit by bit is the median."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff.video.background import pixel_median


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
