"""Real films and pictures, by default, with no option but the scale.

They lie beside the project and belong to others; where they are not there, nothing is tested.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path

import cv2
import numpy as np
import pytest

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "films"
BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "films.py"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FOLDER.exists(), reason="the real films are not beside the project"),
]

# Counted by eye, once, on enlarged pictures: whole droplets, without those that the frame cuts.
# Beside each the least share that must be found.
SEEN = {
    "packed/droplets.png": (119, 0.9),
    "packed/snapshot_45.jpg": (284, 0.9),
    "packed/snapshot_22.jpg": (34, 0.85),
    "packed/snapshot_1991.png": (35, 0.7),
}
MOST_FALSE = 1.1
FEWEST_CELLS = 0.8 * 476  # of the foam; their number is an estimate, not a count
DROPLETS_IN_CHANNEL = 36  # that pass, told apart by eye in the annotated film, from first to last

SETS = {"plugs": 10, "junction": 16, "beads": 20, "grain": 6}  # frames, from the first
FRAME = 60  # pixels of black all round

# What is done to a picture, and by how much and whereto an outline grows and moves.
CHANGES = {
    "negative": (lambda image: 255 - image, 1.0, 0.0),
    "half as large": (
        lambda image: cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA),
        0.5,
        -0.25,
    ),
    "twice as large": (
        lambda image: cv2.resize(image, None, fx=2.0, fy=2.0, interpolation=cv2.INTER_CUBIC),
        2.0,
        0.5,
    ),
    "in a black frame": (
        lambda image: cv2.copyMakeBorder(image, *[FRAME] * 4, cv2.BORDER_CONSTANT),
        1.0,
        FRAME,
    ),
    "grainy": (
        lambda image: np.clip(
            image + np.random.default_rng(0).normal(0, 8, (*image.shape[:2], 1)), 0, 255
        ).astype(np.uint8),
        1.0,
        0.0,
    ),
}


@pytest.fixture(scope="module")
def films():
    spec = importlib.util.spec_from_file_location("benchmark_films", BENCHMARK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("name", "least", "false"), [("plugs", 0.98, 0.01), ("junction", 0.95, 0.02)]
)
def test_boxed_plugs(films, name, least, false):
    seen = films.measured(FOLDER / name)
    boxes, found, wrong = films.against_boxes(seen, FOLDER / name)
    assert found >= least * boxes
    assert wrong <= false * boxes
    assert (seen.obstacles, seen.collisions) == (0, 0)


def test_a_channel_of_plugs(films):
    seen = films.measured(FOLDER / "channel" / "plugs.mp4", 2.0)
    assert sum(seen.whole) >= 2300
    long = [length for length in seen.lengths if length >= 10]
    assert len(long) == DROPLETS_IN_CHANNEL
    assert sum(long) >= 0.99 * sum(seen.lengths)
    assert seen.collisions == 0
    assert not set(seen.events) - {"entry", "exit"}


def test_beads_and_a_grainy_droplet(films):
    beads = films.measured(FOLDER / "beads", 4.0)
    assert beads.whole == [5] * 20
    assert beads.lengths == [20] * 5
    assert beads.obstacles == 0
    grain = films.measured(FOLDER / "grain")
    assert (grain.whole, grain.cut) == ([1] * 6, [0] * 6)


@pytest.mark.parametrize("name", list(SEEN))
def test_packed_scenes(films, name, tmp_path):
    clip = tmp_path / "clip"
    clip.mkdir()
    (clip / Path(name).name).symlink_to(FOLDER / name)
    (whole,) = films.measured(clip).whole
    there, least = SEEN[name]
    assert least * there <= whole <= MOST_FALSE * there


def test_foam(films):
    seen = films.measured(FOLDER / "foam")
    assert min(seen.whole) >= FEWEST_CELLS
    assert not {"break-up", "coalescence"} & set(seen.events)


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    """Name of a set -> its first frames in a folder, changed by a function."""

    def written(name, change=lambda image: image):
        folder = tmp_path_factory.mktemp(name)
        pictures = sorted(path for path in (FOLDER / name).iterdir() if path.suffix != ".txt")
        for picture in pictures[: SETS[name]]:
            cv2.imwrite(str(folder / f"{picture.stem}.png"), change(cv2.imread(str(picture))))
        return folder

    return written


@pytest.fixture(scope="module")
def unchanged(films, frames):
    """Name of a set -> boxes of the whole outlines in each unchanged frame."""
    known = {}

    def boxes(name):
        if name not in known:
            known[name] = films.measured(frames(name), films.SCALES_UM.get(name, 1.0)).boxes
        return known[name]

    return boxes


@pytest.mark.parametrize("name", list(SETS))
@pytest.mark.parametrize("change", list(CHANGES))
def test_the_same_droplets_in_changed_pictures(films, frames, unchanged, name, change):
    function, scale, shift = CHANGES[change]
    seen = films.measured(frames(name, function), films.SCALES_UM.get(name, 1.0))
    wanted = found = false = 0
    for before, after in zip(unchanged(name), seen.boxes, strict=True):
        left = list(after)
        for box in before:
            expected = tuple(scale * side + shift for side in box)
            best = max(left, key=lambda each: films.overlap(expected, each), default=None)
            if best is not None and films.overlap(expected, best) > films.OVERLAP:
                left.remove(best)
                found += 1
        wanted += len(before)
        false += len(left)
    assert wanted > 0
    assert found >= 0.8 * wanted  # of six droplets one, at half the size
    assert false <= 0.05 * wanted + 1


@pytest.mark.parametrize("name", ["plugs", "junction"])
def test_the_same_plugs_in_part_of_the_picture(films, frames, unchanged, name):
    """A plug that nearly fills the frame is soon cut, which is not to be lost."""
    height, width = cv2.imread(str(next((FOLDER / name).glob("*.jpg")))).shape[:2]
    top, left, right = height // 10, width // 7, width - width // 9
    seen = films.measured(frames(name, lambda image: image[top:, left:right]))
    wanted = found = 0
    for before, after in zip(unchanged(name), seen.boxes, strict=True):
        inside = [box for box in before if box[0] > left + 2 and box[2] < right - 3]
        moved = [(a - left, b - top, c - left, d - top) for a, b, c, d in inside]
        wanted += len(moved)
        found += sum(
            any(films.overlap(box, each) > films.OVERLAP for each in after) for box in moved
        )
    assert wanted > 4
    assert found == wanted
    assert sum(map(len, seen.boxes)) <= wanted + 1  # that the edge nearly cuts
