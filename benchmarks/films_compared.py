"""Real films by three ways: a short script, trackpy, and `pinchoff video` by default.

    python benchmarks/films_compared.py FOLDER

FOLDER holds sets of frames as `tests/video/test_real_films.py` expects them. A droplet is found
where the centre of one find lies in its box; what lies in no box, and is not cut by the frame or
by the dark border of the view, is false. trackpy is told how large the droplets are, and that they
are dark.
Prints the table of docs/video.md.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cv2
import numpy as np
from films import boxes_in, measured
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WINDOW, DARKER, CONVEX = 41, 12.0, 0.9  # pixels; grey levels; of the hull
DIAMETERS = {"plugs": 201, "junction": 101, "beads": 41}  # odd, for trackpy
COUNTS = {"beads": 5}  # where there are no boxes: every frame shows as many


def by_script(grey: NDArray[np.uint8]) -> list[Floats]:
    """Holes in what is darker than the local mean, the convex ones: fifteen lines of OpenCV."""
    image = grey.astype(np.float32)
    dark = (cv2.blur(image, (WINDOW, WINDOW)) - image > DARKER).astype(np.uint8)
    walks, tree = cv2.findContours(dark, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    height, width = grey.shape
    found = []
    for k, walk in enumerate(walks):
        left, top, wide, high = cv2.boundingRect(walk)
        inside = left > 2 and top > 2 and left + wide < width - 2 and top + high < height - 2
        area, hull = cv2.contourArea(walk), cv2.contourArea(cv2.convexHull(walk))
        if tree[0, k, 3] >= 0 and inside and area > 200 and area > CONVEX * hull:
            found.append(walk[:, 0].mean(axis=0))
    return found


def by_trackpy(grey: NDArray[np.uint8], diameter: int) -> list[Floats]:
    import trackpy

    trackpy.quiet()
    shrunk = 4 if diameter > 60 else 1  # else it takes a minute a frame
    small = cv2.resize(grey, None, fx=1 / shrunk, fy=1 / shrunk, interpolation=cv2.INTER_AREA)
    table = trackpy.locate(small, diameter // shrunk | 1, invert=True)
    return list(shrunk * table[["x", "y"]].to_numpy())


def judged(
    places: list[Floats], boxes: list[tuple[float, ...]], view: tuple[float, float]
) -> tuple[int, int]:
    """Return how many boxes hold a place, and how many places in view are in none."""
    found = 0
    left = list(places)
    for x0, y0, x1, y1 in boxes:
        within = [place for place in left if x0 <= place[0] <= x1 and y0 <= place[1] <= y1]
        if within:
            found += 1
            nearest = min(
                within, key=lambda p: np.hypot(p[0] - (x0 + x1) / 2, p[1] - (y0 + y1) / 2)
            )
            left = [place for place in left if place is not nearest]
    return found, sum(view[0] <= place[0] <= view[1] for place in left)


def compared(name: str, folder: Path) -> None:
    pictures = sorted(p for p in folder.iterdir() if p.suffix in (".jpg", ".png", ".tif"))
    greys = [cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE) for picture in pictures]
    height, width = greys[0].shape
    boxed = pictures[0].with_suffix(".txt").exists()
    start = time.process_time()
    scripted = [by_script(grey) for grey in greys]
    took = [time.process_time() - start]
    start = time.process_time()
    tracked = [by_trackpy(grey, DIAMETERS[name]) for grey in greys]
    took.append(time.process_time() - start)
    seen = measured(folder, 4.0 if name == "beads" else 1.0)
    ours = [[outline.mean(axis=0) for outline in here] for here in seen.outlines]
    took.append(seen.seconds)
    labels = ("short script", "trackpy", "pinchoff video")
    for label, places, seconds in zip(labels, (scripted, tracked, ours), took, strict=True):
        if not boxed:
            wanted = COUNTS[name] * len(greys)
            found = sum(min(len(here), COUNTS[name]) for here in places)
            false = sum(max(0, len(here) - COUNTS[name]) for here in places)
        else:
            wanted = found = false = 0
            for picture, here in zip(pictures, places, strict=True):
                boxes = boxes_in(picture.with_suffix(".txt"), (width, height))
                # Plugs near the sides are cut by the frame or the border: they count neither way.
                sides = max((box[2] - box[0] for box in boxes), default=0.0) / 2.0
                there, wrong = judged(here, boxes, (sides, width - sides))
                wanted, found, false = wanted + len(boxes), found + there, false + wrong
        print(
            f"| {name} | {label} | {100 * found / wanted:.0f} % of {wanted} | {false} "
            f"| {1e3 * seconds / len(greys):.0f} ms |",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    for name in DIAMETERS:
        compared(name, parser.parse_args().folder / name)


if __name__ == "__main__":
    main()
