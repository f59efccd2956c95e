"""A picture that moves is seen by what is no droplet, wherever droplets are."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pinchoff.video.droplets import Droplet
from pinchoff.video.reading import Frame
from pinchoff.video.steadiness import picture_moved

SIZE, SHIFT, RADIUS = 200, 24, 40
CENTRE = (90.0, 100.0)  # of the droplet, where there is one
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]


class Known:
    """A segmentation that knows in which frames the droplet is."""

    def __init__(self, shown):
        self._shown = shown

    def droplets(self, frame):
        if frame.number not in self._shown:
            return []
        turn = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
        outline = RADIUS * np.column_stack([np.cos(turn), np.sin(turn)]) + CENTRE
        return [Droplet(outline, np.pi * RADIUS**2, *CENTRE, False, -1)]


def pair(shift, shown):
    """Return two frames of dirt that goes to the right, with a droplet in some of them."""
    dirt = np.random.default_rng(3).normal(0.0, 60.0, (SIZE, SIZE))
    picture = 150.0 + cv2.GaussianBlur(dirt, (0, 0), 2.0)
    frames = []
    for number in range(2):
        image = np.roll(picture, number * shift, axis=1)
        if number in shown:
            image[np.hypot(COLUMNS - CENTRE[0], ROWS - CENTRE[1]) < RADIUS] = 60.0
        frames.append(Frame(number, 0.1 * number, image.clip(0, 255).astype(np.uint8), None))
    return tuple(frames)


@pytest.mark.parametrize("shown", [(), (0,), (1,)])
def test_a_droplet_that_comes_or_goes_hides_no_moving_picture(shown):
    moved = picture_moved([pair(SHIFT, shown)], Known(shown))
    assert moved is not None
    assert moved.pixels == pytest.approx(SHIFT, abs=0.2)
    assert (moved.first, moved.last) == (0, 1)


@pytest.mark.parametrize("shown", [(), (0,), (0, 1)])
def test_a_picture_that_stands_is_steady_whatever_droplets_do(shown):
    assert picture_moved([pair(0, shown)], Known(shown)) is None


def test_one_frame_alone_is_steady():
    assert picture_moved([], Known(())) is None
