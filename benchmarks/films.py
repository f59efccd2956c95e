"""How `pinchoff video` fares on real films: by default, with no option but the scale.

    python benchmarks/films.py FOLDER [SET ...]

FOLDER holds sets of frames as `tests/video/test_real_films.py` expects them. Prints for each set
the method that the clip chose, what was found and what was not, and processor time.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import pinchoff as po
from pinchoff.video.clips import Measured, measure_clip

Floats = NDArray[np.float64]

SCALES_UM = {"beads": 4.0, "channel": 2.0}
OVERLAP = 0.7  # of two boxes, their intersection over their union


class Seen(NamedTuple):
    """What was measured in a clip.

    Attributes
    ----------
    method : str
    boxes : list of list of (x0, y0, x1, y1)
        Of the whole outlines in each frame, pixels.
    whole, cut : list of int
        Outlines in each frame.
    lengths : list of int
        Frames in each track.
    events : Counter
        Kinds of event.
    obstacles, collisions : int
    seconds : float
        Of processor time.
    """

    method: str
    boxes: list[list[tuple[float, float, float, float]]]
    whole: list[int]
    cut: list[int]
    lengths: list[int]
    events: Counter[str]
    obstacles: int
    collisions: int
    seconds: float
    outlines: list[list[Floats]]


def measured(clip: Path, pixel_size_um: float = 1.0, **settings: Any) -> Seen:
    """Measure a clip and return what was seen."""
    frames: list[list[Any]] = []
    tracks: Counter[int] = Counter()
    events: Counter[str] = Counter()

    def begin(choice: Any, obstacles: Any) -> Any:
        return record

    def record(seen: Measured) -> None:
        frames.append(list(seen.droplets))
        tracks.update(seen.tracks)
        events.update(event.kind for event in seen.events)

    start = time.process_time()
    told = po.VideoSettings(pixel_size_um=pixel_size_um, **settings)
    result = measure_clip(clip, told, begin)
    whole = [[each.outline for each in here if not each.cut] for here in frames]
    return Seen(
        result.choice.method,
        [[box_of(outline) for outline in here] for here in whole],
        [len(here) for here in whole],
        [sum(each.cut for each in here) for here in frames],
        sorted(tracks.values(), reverse=True),
        events,
        len(result.obstacles),
        len(result.encounters),
        time.process_time() - start,
        whole,
    )


def box_of(outline: Floats) -> tuple[float, float, float, float]:
    (x0, y0), (x1, y1) = outline.min(axis=0).tolist(), outline.max(axis=0).tolist()
    return x0, y0, x1, y1


def boxes_in(path: Path, size: tuple[int, int]) -> list[tuple[float, float, float, float]]:
    """Read boxes: class, centre x, y, width and height as fractions of the frame's size."""
    boxes = []
    for line in path.read_text().splitlines():
        _, x, y, wide, high = map(float, line.split())
        boxes.append(
            (
                (x - wide / 2) * size[0],
                (y - high / 2) * size[1],
                (x + wide / 2) * size[0],
                (y + high / 2) * size[1],
            )
        )
    return boxes


def overlap(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    wide = min(one[2], other[2]) - max(one[0], other[0])
    high = min(one[3], other[3]) - max(one[1], other[1])
    if wide <= 0 or high <= 0:
        return 0.0
    areas = [(box[2] - box[0]) * (box[3] - box[1]) for box in (one, other)]
    return wide * high / (sum(areas) - wide * high)


def against_boxes(seen: Seen, folder: Path) -> tuple[int, int, int]:
    """Return how many boxes there are, are found, and how many whole outlines are in none."""
    import cv2

    pictures = sorted(path for path in folder.iterdir() if path.suffix == ".jpg")
    height, width = cv2.imread(str(pictures[0])).shape[:2]
    wanted = found = false = 0
    for picture, outlines in zip(pictures, seen.boxes, strict=True):
        boxes = boxes_in(picture.with_suffix(".txt"), (width, height))
        left = list(outlines)
        wanted += len(boxes)
        for box in boxes:
            best = max(left, key=lambda each: overlap(box, each), default=None)
            if best is not None and overlap(box, best) > OVERLAP:
                left.remove(best)
                found += 1
        false += len(left)
    return wanted, found, false


def line_of(name: str, folder: Path) -> str:
    """Measure one set and return its figures as a line."""
    clip = folder / "plugs.mp4" if name == "channel" else folder
    seen = measured(clip, SCALES_UM.get(name, 1.0))
    told = f"{name:10s} {seen.method:9s}"
    if name in ("plugs", "junction"):
        wanted, found, false = against_boxes(seen, folder)
        told += f" found {found}/{wanted} = {100 * found / wanted:.1f} %, false {false}"
    long = sum(length >= 10 for length in seen.lengths)
    told += f" whole {sum(seen.whole)} cut {sum(seen.cut)} in {len(seen.whole)} frames,"
    told += f" {len(seen.lengths)} tracks, {long} of ten frames or more,"
    told += f" obstacles {seen.obstacles}, collisions {seen.collisions}, {dict(seen.events)},"
    return told + f" {seen.seconds:.1f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("sets", nargs="*")
    arguments = parser.parse_args()
    for name in arguments.sets or ("plugs", "junction", "channel", "beads", "grain", "foam"):
        print(line_of(name, arguments.folder / name), flush=True)


if __name__ == "__main__":
    main()
