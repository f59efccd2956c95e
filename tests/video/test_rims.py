"""Packed scenes, told by dark rims alone: drawn ones of known outlines, and real bubbles."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from pinchoff.video.background import Sample
from pinchoff.video.choice import choose
from pinchoff.video.clips import measure_clip
from pinchoff.video.microscope.drawing import coverage
from pinchoff.video.reading import Frame
from pinchoff.video.settings import VideoSettings

BUBBLES = Path(__file__).parents[3] / "shared" / "data" / "bubbles"
LARGE = 400  # pixels: smaller objects are not counted
NEAR = 40.0  # pixels from a label: where labelling was done
SIZE = (400, 300)
SETTINGS = VideoSettings(pixel_size_um=1.0, minimum_diameter_um=20.0, packed=True)


def droplets_of(luma, told=SETTINGS, obstacles=()):
    frame = Frame(0, 0.0, luma, None)
    told = told.replace(obstacles=tuple(obstacles))
    return choose(Sample([frame]), told).segmenter.droplets(frame)


def packed(discs, *, noise=4.0, blur=1.0, size=SIZE):
    """Discs (x, y, radius), the later before the earlier, with rims a fifth of the radius wide."""
    rows, columns = np.mgrid[: size[1], : size[0]]
    image = (170.0 + 0.1 * columns - 0.05 * rows).astype(np.float32)
    angles = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    for x, y, radius in discs:
        outline = np.array([x, y]) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
        window, inside, core = coverage(outline, size, 0.2 * radius)
        image[window] += inside * (25.0 - image[window]) + core * 120.0
    image = cv2.GaussianBlur(image, (0, 0), blur)
    image += noise * np.random.default_rng(1).standard_normal(image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def test_discs_that_touch_and_overlap():
    discs = [
        (60, 60, 24),
        (108, 60, 24),
        (250, 80, 40),
        (306, 110, 30),
        (100, 200, 16),
        (200, 210, 50),
    ]
    found = droplets_of(packed(discs))
    assert len(found) == len(discs)
    for x, y, radius in discs:
        nearest = min(found, key=lambda each: math.hypot(each.x - x, each.y - y))
        assert math.hypot(nearest.x - x, nearest.y - y) < 1.0
        assert nearest.area == pytest.approx(math.pi * radius**2, rel=0.06)


@pytest.mark.parametrize("noise", [0.0, 6.0, 12.0])
@pytest.mark.parametrize("radius", [20.0, 45.0])
def test_outline_is_right_to_a_fraction_of_a_pixel(radius, noise):
    (found,) = droplets_of(packed([(200.3, 150.6, radius)], noise=noise))
    assert (found.x, found.y) == pytest.approx((200.3, 150.6), abs=0.25)
    assert math.sqrt(found.area / math.pi) == pytest.approx(radius, abs=0.3)
    x, y = found.outline.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0  # clockwise as seen: y is down


def test_cut_droplets_are_marked():
    found = droplets_of(packed([(200, 150, 40), (392, 150, 30)]))
    assert [each.cut for each in sorted(found, key=lambda each: each.x)] == [False, True]
    assert max(each.outline[:, 0].max() for each in found) <= SIZE[0] - 1


@pytest.mark.parametrize("level", [0, 90, 255])
def test_nothing_is_found_in_noise(level):
    noise = np.random.default_rng(2).normal(level, 8.0, SIZE[::-1])
    assert droplets_of(np.clip(noise, 0, 255).astype(np.uint8)) == []


def test_obstacles_are_no_droplets():
    luma = packed([(100, 100, 30), (160, 100, 28)])
    (found,) = droplets_of(luma, obstacles=[(100.0, 100.0, 30.0)])
    assert (found.x, found.y) == pytest.approx((160, 100), abs=0.5)


def test_larger_or_smaller_droplets_are_left_out():
    luma = packed([(60, 60, 8), (250, 150, 90)])
    assert droplets_of(luma) == []
    told = SETTINGS.replace(maximum_diameter_um=200.0, minimum_diameter_um=14.0)
    found = droplets_of(luma, told)
    assert sorted(round(math.sqrt(each.area / math.pi)) for each in found) == [8, 90]


def test_a_clip_of_a_packed_scene(tmp_path):
    """The chamber is never seen empty: four droplets glide in a row that has no gaps."""
    folder = tmp_path / "clip"
    folder.mkdir()
    for frame in range(8):
        discs = [(20.0 + 58.0 * k + 4.0 * frame, 150.0, 28.0) for k in range(7)]
        cv2.imwrite(str(folder / f"{frame}.png"), packed(discs))
    result = measure_clip(folder, SETTINGS)
    assert result.frame_count == 8
    assert 7 <= result.track_count <= 9
    assert result.choice.method == "packed"


class Labelled(NamedTuple):
    """One labelled object: its pixels in a window of the frame."""

    left: int
    top: int
    mask: np.ndarray

    @property
    def area(self):
        return int(self.mask.sum())

    @property
    def middle(self):
        return self.left + self.mask.shape[1] / 2, self.top + self.mask.shape[0] / 2

    def overlap(self, other):
        """Return the area in common, of the area of both."""
        left, top = max(self.left, other.left), max(self.top, other.top)
        right = min(self.left + self.mask.shape[1], other.left + other.mask.shape[1])
        bottom = min(self.top + self.mask.shape[0], other.top + other.mask.shape[0])
        if right <= left or bottom <= top:
            return 0.0
        a, b = (
            each.mask[top - each.top : bottom - each.top, left - each.left : right - each.left]
            for each in (self, other)
        )
        common = int((a & b).sum())
        return common / (self.area + other.area - common)


def filled(outline):
    points = np.rint(outline).astype(np.int32)
    left, top, wide, high = cv2.boundingRect(points)
    mask = np.zeros((high, wide), dtype=np.uint8)
    cv2.fillPoly(mask, [points - (left, top)], 1)
    return Labelled(left, top, mask)


def labelled(labels, upper):
    """Return the masks of a frame, and the circles of which only a radius was drawn.

    Hundreds of labels are lines one pixel wide: circles, of which the line from the centre to a
    point of the rim came out. The lower end is the centre, in one frame the upper one.
    """
    masks, circles = [], []
    angles = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    for number in np.unique(labels)[1:]:
        rows, columns = np.nonzero(labels == number)
        length = math.hypot(np.ptp(rows), np.ptp(columns))
        if len(rows) >= 2.5 * (length + 1.0) or length <= 2.0:
            left, top = int(columns.min()), int(rows.min())
            mask = (labels[top : rows.max() + 1, left : columns.max() + 1] == number).astype(
                np.uint8
            )
            masks.append(Labelled(left, top, mask))
        elif length >= 4.0:
            end = rows.min() if upper else rows.max()
            centre = np.array([columns[rows == end].mean(), end])
            ring = np.column_stack([np.cos(angles), np.sin(angles)])
            circles.append(filled(centre + (length + 0.5) * ring))
    return masks, circles


@pytest.mark.skipif(not BUBBLES.exists(), reason="the frames of bubbles are not beside the project")
@pytest.mark.parametrize(
    ("frames", "count"),
    [
        pytest.param("00.png", 68, id="one frame"),
        pytest.param("*.png", 273, id="all frames", marks=pytest.mark.slow),  # half a minute
    ],
)
def test_real_bubbles(frames, count):
    """The figures of docs/video.md: masks found, and what is right where labelling was done."""
    hits = objects = right = near = 0
    for path in sorted((BUBBLES / "images").glob(frames)):
        labels = cv2.imread(str(BUBBLES / "labels" / path.name), cv2.IMREAD_UNCHANGED)
        masks, circles = labelled(labels, upper=path.stem == "03")
        found = [
            filled(d.outline) for d in droplets_of(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE))
        ]
        found = [each for each in found if each.area >= LARGE]
        large = [each for each in masks if each.area >= LARGE]
        objects += len(large)
        hits += sum(any(each.overlap(d) > 0.5 for d in found) for each in large)
        every = [*masks, *circles]
        middles = np.array(
            [(e.left + e.mask.shape[1] / 2, e.top + e.mask.shape[0] / 2) for e in every]
        )
        for each in found:
            place = (each.left + each.mask.shape[1] / 2, each.top + each.mask.shape[0] / 2)
            if np.hypot(*(middles - place).T).min() <= NEAR:
                near += 1
                right += any(each.overlap(other) > 0.5 for other in every)
    print(f"recall {hits / objects:.3f} of {objects}, precision {right / near:.3f} of {near}")
    assert objects == count
    assert hits / objects >= 0.80
    assert right / near >= 0.60
