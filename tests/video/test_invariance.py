"""What is found does not depend on how the picture lies, nor on how its grey levels are written."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from pinchoff.video.background import sample
from pinchoff.video.choice import choose
from pinchoff.video.scale import clip_of
from pinchoff.video.settings import VideoSettings

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "films"
SETTINGS = VideoSettings(pixel_size_um=1.0, fps=100.0)
SIDE = 150
ROWS, COLUMNS = np.mgrid[:SIDE, : SIDE + 30].astype(float)
NAMES = ("beads", "plugs", "junction")

Picture = np.ndarray


def turned(image: Picture) -> Picture:
    return np.ascontiguousarray(np.rot90(image))


def mirrored(image: Picture) -> Picture:
    return np.ascontiguousarray(image[:, ::-1])


# What is done to a picture, and where a point x, y of one of some width goes.
CHANGES = {
    "turned": (
        turned,
        lambda points, width: np.column_stack([points[:, 1], width - 1 - points[:, 0]]),
    ),
    "mirrored": (mirrored, lambda points, width: points * (-1, 1) + (width - 1, 0)),
    "negative": (lambda image: 255 - image, lambda points, width: points),
    "at 0.6 of the light": (
        lambda image: np.rint(0.6 * image).astype(np.uint8),
        lambda points, width: points,
    ),
    "16 bits": (lambda image: image.astype(np.uint16) * 257, lambda points, width: points),
    "12 bits in 16": (lambda image: image.astype(np.uint16) * 16, lambda points, width: points),
    "in colour": (lambda image: cv2.merge([image] * 3), lambda points, width: points),
}


def drawn() -> list[Picture]:
    """Five frames of three ringed droplets of different sizes that pass a wall, with noise."""
    generator = np.random.default_rng(4)
    frames = []
    for k in range(5):
        image = 160.0 - 70.0 * np.exp(-((ROWS - 140.0) ** 2) / 8.0)
        for x, y, radius in ((30, 30, 13), (60, 75, 17), (100, 35, 10)):
            off = np.hypot(COLUMNS - x - 6 * k, ROWS - y) - radius
            image -= 75.0 * np.exp(-((off + 1.5) ** 2) / 3.0)
        noisy = image + 2.0 * generator.standard_normal(image.shape)
        frames.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return frames


def real(name: str) -> list[Picture]:
    """Four frames of a real film, grey."""
    pictures = sorted(path for path in (FOLDER / name).iterdir() if path.suffix != ".txt")[:4]
    return [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in pictures]


def found_in(frames: list[Picture], folder: Path) -> tuple[str, list[list]]:
    """Return the method that is chosen, and the whole droplets in each frame."""
    folder.mkdir()
    for k, frame in enumerate(frames):
        cv2.imwrite(str(folder / f"{k}.png"), frame)
    clip = clip_of(folder, SETTINGS)
    choice = choose(sample(clip.frames(sparse=True)), SETTINGS)
    seen = [choice.segmenter.droplets(frame) for frame in clip.frames()]
    return choice.method, [[each for each in here if not each.cut] for here in seen]


def assert_unchanged(frames: list[Picture], change: str, folder: Path) -> None:
    function, moved = CHANGES[change]
    method, before = found_in(frames, folder / "before")
    changed, after = found_in([function(frame) for frame in frames], folder / "after")
    assert changed == method
    assert sum(map(len, before)) >= len(frames)
    for old, new in zip(before, after, strict=True):
        assert len(new) == len(old)
        centres = np.array([[each.x, each.y] for each in new]).reshape(-1, 2)
        for droplet in old:
            place = moved(np.array([[droplet.x, droplet.y]]), frames[0].shape[1])[0]
            away = np.hypot(*(centres - place).T)
            assert away.min() < max(0.25, 0.02 * np.sqrt(droplet.area))
            assert new[int(away.argmin())].area == pytest.approx(droplet.area, rel=0.03)


@pytest.mark.parametrize("change", list(CHANGES))
def test_drawn_droplets(change, tmp_path):
    assert_unchanged(drawn(), change, tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(not FOLDER.exists(), reason="the real films are not beside the project")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("change", list(CHANGES))
def test_real_droplets(name, change, tmp_path):
    assert_unchanged(real(name), change, tmp_path)
