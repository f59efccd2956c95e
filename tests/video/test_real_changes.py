"""Real frames, changed as another camera or screen would show them: the same droplets are found.

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
def test_the_same_droplets(films, frames, unchanged, name, change):
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
