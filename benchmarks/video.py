"""Speed of `pinchoff video` and of `film`, on one core, in one run.

The clip is drawn here: 640×512 pixels, 20 droplets that pass pillars, noise of 4 grey levels, H.264
at crf 20. How fast it is drawn is one figure. Then pinchoff and a plain scikit-image pipeline both
read the file, find the background, segment, link and measure every droplet, and write a table; only
pinchoff also chooses among its methods and finds obstacles, collisions and necks. They take turns;
what counts is processor time, so that other work on the machine does not. The choice of the method,
a fixed time a clip, and the frames a second after it are figures of their own.

Real plugs of 1024×416 pixels are measured too, where they lie beside the project.

    python benchmarks/video.py [--quick]

Prints tables and writes every sample to benchmarks/results/.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import av
import cv2
import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table
from scipy.ndimage import binary_fill_holes
from scipy.spatial import cKDTree
from skimage.color import rgb2gray
from skimage.filters import threshold_otsu
from skimage.measure import find_contours, label, regionprops
from skimage.morphology import remove_small_objects

import pinchoff as po
from pinchoff.model.outlines import Outlines
from pinchoff.video.choice import Choice
from pinchoff.video.clips import Measured, measure_clip
from pinchoff.video.encounters import Laboratory, encounter_table, write_encounters
from pinchoff.video.microscope import Microscope, Passage, Scene, film

HERE = Path(__file__).parent
PLUGS = HERE.parents[1] / "shared" / "data" / "films" / "plugs"
PIXEL_UM = 5.28
LANES, PER_LANE, SPACING, SPEED = 4, 5, 140.0, 3.0  # pixels, and pixels a frame


def draw(path: Path, frames: int) -> None:
    """Film discs that glide past pillars, one after the other in four lanes."""
    look = Microscope(pixel_size_um=PIXEL_UM, noise=4, crf=20)
    angles = np.linspace(0.0, 2 * np.pi, 96, endpoint=False)
    passages = []
    for lane in range(LANES):
        y = (lane + 0.5) * look.height / LANES
        for k in range(-int(frames * SPEED / SPACING) - 2, PER_LANE):
            radius = 16.0 + 3.0 * ((5 * lane + 3 * k) % 4)
            ring = radius * np.column_stack([np.cos(angles), np.sin(angles)])
            start = np.array([SPACING * k + 35.0 * lane, -y])
            velocity = np.tile([SPEED * look.fps, 0.0], (len(ring), 1))
            records = [[(0, 0, ring + start + velocity[0] * t, velocity)] for t in (0.0, 60.0)]
            pillar = [[320.0, -y - 43.0, 16.0]]  # the largest droplets graze it
            passages.append(Passage(Outlines.from_frames([0, 60], records, pillar, {}), 1.0, 1.0))
    film(Scene(tuple(passages)), path, frames, microscope=look)


class Timed(NamedTuple):
    """Processor time of one measurement: the choice of the method, seconds, and frames a second."""

    choice_s: float
    after: float  # frames a second, once the method is chosen
    whole: float  # frames a second, with the choice


def timed(clip: Path, settings: po.VideoSettings, out: Path) -> Timed:
    """Measure a clip, from the file to the table."""
    chosen = [0.0]

    def begin(choice: Choice, obstacles: Any) -> Callable[[Measured], object]:
        chosen[0] = time.process_time()
        return lambda seen: None

    start = time.process_time()
    result = measure_clip(clip, settings, begin)
    table = encounter_table(result.encounters, settings.laboratory, "video", clip.stem)
    write_encounters(table, out / "collisions.parquet")
    end = time.process_time()
    count = result.frame_count
    return Timed(chosen[0] - start, count / (end - chosen[0]), count / (end - start))


def drawn_settings() -> po.VideoSettings:
    """Return what is told of the drawn clip."""
    laboratory = Laboratory(
        obstacle_radius_um=16 * PIXEL_UM,
        thickness_um=85,
        viscosity_mPa_s=48,
        surface_tension_mN_m=20,
    )
    return po.VideoSettings(pixel_size_um=PIXEL_UM, laboratory=laboratory)


def plain_rate(clip: Path, out: Path) -> float:
    """The same of a script as a researcher writes it, with scikit-image and a KD-tree."""
    start = time.process_time()
    with av.open(str(clip)) as container:
        every = [
            f.to_ndarray(format="rgb24")
            for k, f in enumerate(container.decode(video=0))
            if k % 40 == 0
        ]
    background = np.median([rgb2gray(frame) for frame in every], axis=0)
    rows: list[tuple[Any, ...]] = []
    before: tuple[Any, list[int]] | None = None
    tracks = count = 0
    with av.open(str(clip)) as container:
        for number, frame in enumerate(container.decode(video=0)):
            dark = background - rgb2gray(frame.to_ndarray(format="rgb24"))
            mask = binary_fill_holes(dark > threshold_otsu(dark))
            found = regionprops(label(remove_small_objects(mask, max_size=100)))
            numbers = []
            for region in found:
                top, left, bottom, right = region.bbox
                part = np.pad(dark[top:bottom, left:right], 1)
                contours = find_contours(part, 0.25)
                numbers.append(-1)
                y, x = region.centroid
                rows.append((number, x, y, region.area, max(map(len, contours), default=0)))
            places = np.array([region.centroid for region in found]).reshape(-1, 2)
            if before is not None and len(places) and before[0].n:
                away, nearest = before[0].query(places)
                numbers = [
                    before[1][k] if d < 15 else -1 for d, k in zip(away, nearest, strict=True)
                ]
            for k, each in enumerate(numbers):
                if each < 0:
                    numbers[k], tracks = tracks, tracks + 1
            before = (cKDTree(places), numbers) if len(places) else None
            count += 1
    pd.DataFrame(rows, columns=["frame", "x", "y", "area", "points"]).to_parquet(
        out / "plain.parquet"
    )
    return count / (time.process_time() - start)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a short clip, two rounds")
    quick = parser.parse_args().quick
    frames, rounds = (150, 2) if quick else (600, 5)
    cv2.setNumThreads(1)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    samples: dict[str, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        clip = out / "clip.mp4"
        start = time.process_time()
        draw(clip, frames)
        samples["film, drawn"].append(frames / (time.process_time() - start))
        for _ in range(rounds):
            add(samples, "clip", timed(clip, drawn_settings(), out))
            samples["plain scikit-image"].append(plain_rate(clip, out))
            if PLUGS.exists():
                add(samples, "plugs", timed(PLUGS, po.VideoSettings(pixel_size_um=1.0), out))
        size = clip.stat().st_size / frames / 1024
    samples["ratio"] = ratios(samples["clip, frames/s"], samples["plain scikit-image"])
    samples["ratio after the choice"] = ratios(
        samples["clip, frames/s after it"], samples["plain scikit-image"]
    )
    table = Table(title=f"640×512, 20 droplets, {frames} frames of {size:.1f} KiB, one core")
    for column in ("", "median", "least", "greatest"):
        table.add_column(column, justify="left" if not column else "right")
    for name, values in samples.items():
        numbers = (statistics.median(values), min(values), max(values))
        table.add_row(name, *(f"{value:.3g}" for value in numbers))
    Console().print(table)
    if not PLUGS.exists():
        print(f"real plugs were left out: {PLUGS} is not there")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory of this process, with the plain pipeline's: {memory:.0f} MiB")
    results = HERE / "results"
    results.mkdir(exist_ok=True)
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    path = results / f"video-{stamp}.json"
    path.write_text(json.dumps({"frames": frames, "samples": samples}, indent=2) + "\n")
    print(f"wrote {path}")


def add(samples: dict[str, list[float]], name: str, seen: Timed) -> None:
    """Add the figures of one measurement."""
    samples[f"{name}, choice of the method, s"].append(seen.choice_s)
    samples[f"{name}, frames/s after it"].append(seen.after)
    samples[f"{name}, frames/s"].append(seen.whole)


def ratios(ours: list[float], others: list[float]) -> list[float]:
    """Return by how much we are faster, round by round."""
    return [one / other for one, other in zip(ours, others, strict=True)]


if __name__ == "__main__":
    main()
