"""What `pinchoff video` makes of droplets that touch or merge: drawn clips with known truth.

    python examples/video_neighbours.py [--quick] [--out DIR]

Collisions of the engine in which the droplet slips off are filmed with a companion beside each
droplet, at a gap of none to six pixels; others with two droplets that become one, before they meet
the obstacle or while in contact with it. Prints the figures of docs/video.md and writes them to
DIR.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import pinchoff as po
from pinchoff import _core
from pinchoff.model.outlines import Outlines
from pinchoff.model.simulation import thread_count
from pinchoff.video.clips import measure_clip
from pinchoff.video.encounters import (
    CONTACT_DISTANCE_UM,
    Laboratory,
    encounter_table,
    gap_to_circle,
)
from pinchoff.video.microscope import Microscope, Passage, Scene, film, lane_scene, passage_of

Floats = NDArray[np.float64]

Shapes: TypeAlias = dict[int, Floats]
"""The outline of one droplet in each frame, pixels."""

LABORATORY = Laboratory(
    obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
)
LOOK = Microscope(pixel_size_um=5.28, noise=4, crf=20)
GAPS_PX = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
RUNS = 24  # of the engine, in a clip
ROOM_PX = 64.0  # between the boxes of droplets: enough for a companion
CONTACT_PX = CONTACT_DISTANCE_UM / LOOK.pixel_size_um
CLEARLY_PX = 0.3  # nearer than that is a contact that a camera sees
LATE_FRAMES = 3  # by which a contact may differ


class Meeting(NamedTuple):
    """A collision that a clip shows: its obstacle, µm, and the frame of the contact."""

    x_um: float
    y_um: float
    frame: int


Expected: TypeAlias = tuple[Scene, list[Meeting]]


def slipping(count: int, seed: int) -> list[Passage]:
    """Simulate collisions in which the droplet stays whole."""
    random = np.random.default_rng(seed)
    found: list[Passage] = []
    while len(found) < count:
        parameters = po.Parameters(
            size_ratio=random.uniform(2.4, 4.2),
            simulation_capillary_number=math.exp(random.uniform(math.log(8), math.log(30))),
            offset=random.choice([-1, 1]) * random.uniform(0.15, 0.4),
        )
        passage = passage_of(parameters, LOOK, LABORATORY)
        if len(list(passage.outlines)[-1]) == 1:
            found.append(passage)
    return found


def disc(centre: Floats, area: float) -> Floats:
    """Return a polygon of some area."""
    angles = np.linspace(0.0, 2.0 * np.pi, 96, endpoint=False)
    radius = math.sqrt(area / (0.5 * len(angles) * math.sin(2.0 * np.pi / len(angles))))
    return centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def filmed(shapes: Sequence[dict[int, Floats]], first_frame: int, obstacle: Floats) -> Passage:
    """Return droplets whose outlines, pixels, are given frame by frame."""
    flip = np.array([1.0, -1.0])  # passages have y up
    records = []
    for now, then in zip(shapes, [*shapes[1:], shapes[-1]], strict=True):
        moves = {
            k: np.subtract(_core.centroid(then.get(k, now[k])), _core.centroid(now[k])) for k in now
        }
        records.append(
            [
                (k, 0, outline * flip, np.tile(moves[k] * LOOK.fps * flip, (len(outline), 1)))
                for k, outline in now.items()
            ]
        )
    # A trifle early, so that rounding shows no frame the record before.
    times = (np.arange(len(shapes)) - 1e-3) / LOOK.fps
    run = Outlines.from_frames(times, records, [obstacle * (1.0, -1.0, 1.0)], {})
    return Passage(run, 1.0, 1.0, start_s=first_frame / LOOK.fps)


def in_view(passage: Passage, frame_count: int) -> Shapes:
    """Return the outline of a droplet in each frame in which it is in the picture or near it."""
    size, found = np.array(LOOK.size), {}
    for frame in range(frame_count):
        ((_, outline),) = passage.droplets_at(frame / LOOK.fps)
        low, high = outline.min(axis=0), outline.max(axis=0)
        if np.all(high > -ROOM_PX) and np.all(low < size + ROOM_PX):
            found[frame] = outline
    return found


def contact(shapes: Shapes, obstacle: Floats) -> int | None:
    """Return the first frame in which an outline is in contact.

    None where it is not, or comes so little nearer that a camera may miss it.
    """
    gaps = {frame: gap_to_circle(outline, obstacle) for frame, outline in shapes.items()}
    if min(gaps.values()) > CONTACT_PX - CLEARLY_PX:
        return None
    return next(frame for frame, gap in gaps.items() if gap <= CONTACT_PX)


def meeting(frame: int, obstacle: Floats) -> Meeting:
    """Return a collision with an obstacle that is given in pixels."""
    return Meeting(*(obstacle[:2] * LOOK.pixel_size_um).tolist(), frame)


def companion(shapes: Shapes, obstacle: Floats, gap: float, seed: int) -> Passage | None:
    """Return a disc that stays at a gap behind or beside a droplet, clear of the obstacle."""
    random = np.random.default_rng(seed)
    radius = random.uniform(11.0, 15.0)
    for angle in np.pi * random.permutation(np.linspace(0.6, 1.4, 9)):
        away = np.array([math.cos(angle), math.sin(angle)])
        discs = [
            disc(outline[np.argmax(outline @ away)] + (radius + gap) * away, math.pi * radius**2)
            for outline in shapes.values()
        ]
        if min(gap_to_circle(each, obstacle) for each in discs) > 1.0:
            return filmed([{0: each} for each in discs], min(shapes), obstacle)
    return None


def merging(
    shapes: Shapes, obstacle: Floats, in_contact: bool, seed: int
) -> tuple[Passage, Meeting] | None:
    """Return two discs that touch and in one frame become the droplet, and the collision.

    The front one is in contact before, or the merged one meets the obstacle some frames later.
    """
    random = np.random.default_rng(seed)
    share = random.uniform(0.4, 0.6)

    def pair(outline: Floats) -> dict[int, Floats]:
        area, centre = _core.area(outline), np.array(_core.centroid(outline))
        ahead = obstacle[:2] - centre
        ahead /= np.hypot(*ahead)
        apart = sum(math.sqrt(part * area / math.pi) for part in (share, 1.0 - share))
        return {
            1: disc(centre + (1.0 - share) * apart * ahead, share * area),
            2: disc(centre - share * apart * ahead, (1.0 - share) * area),
        }

    if in_contact:
        fronts = {frame: pair(outline)[1] for frame, outline in shapes.items()}
        met = contact(fronts, obstacle)
        if met is None or not 0.2 < gap_to_circle(fronts[met], obstacle) < CONTACT_PX - CLEARLY_PX:
            return None  # the obstacle is in the way, or one frame does not show the contact
        merged = met + 1
    else:
        met = contact(shapes, obstacle)
        if met is None:
            return None
        merged = met - int(random.integers(6, 14))
    history = [{0: r} if frame >= merged else pair(r) for frame, r in shapes.items()]
    return filmed(history, min(shapes), obstacle), meeting(met, obstacle)


def with_companions(gap: float, scene: Scene, shapes: Sequence[Shapes]) -> Expected:
    """Give each droplet a companion; droplets for which there is no room are left out."""
    passages, expected = [], []
    for k, (passage, own) in enumerate(zip(scene.passages, shapes, strict=True)):
        obstacle = passage.obstacles[0]
        met, beside = contact(own, obstacle), companion(own, obstacle, gap, k)
        if met is not None and beside is not None:
            passages += [passage, beside]
            expected.append(meeting(met, obstacle))
    return Scene(tuple(passages)), expected


def that_merge(in_contact: bool, scene: Scene, shapes: Sequence[Shapes]) -> Expected:
    """Let each droplet be two at first."""
    made = [
        merging(own, passage.obstacles[0], in_contact, k)
        for k, (passage, own) in enumerate(zip(scene.passages, shapes, strict=True))
    ]
    kept = [each for each in made if each is not None]
    return Scene(tuple(p for p, _ in kept)), [m for _, m in kept]


CASES: dict[str, Callable[[Scene, Sequence[Shapes]], Expected]] = {
    **{f"gap {gap:g} px": partial(with_companions, gap) for gap in GAPS_PX},
    "merge before contact": partial(that_merge, False),
    "merge in contact": partial(that_merge, True),
}


def studied(name: str, folder: Path, runs: int) -> pd.DataFrame:
    """Film one case and return what was made of every collision: one row each."""
    rows = []
    for seed in (1, 2):
        scene, count = lane_scene(slipping(runs, seed), LOOK, gap_px=ROOM_PX, seed=seed)
        shapes = [in_view(passage, count) for passage in scene.passages]
        scene, expected = CASES[name](scene, shapes)
        clip = folder / f"{name.replace(' ', '-')}-{seed}.mp4"
        film(scene, clip, count, microscope=LOOK, laboratory=LABORATORY)
        settings = po.VideoSettings(pixel_size_um=LOOK.pixel_size_um, laboratory=LABORATORY)
        found = encounter_table(measure_clip(clip, settings).encounters, LABORATORY, "video", name)
        rows += [(name, *each, _reason(found, each)) for each in expected]
    return pd.DataFrame(rows, columns=["case", "x_um", "y_um", "contact_frame", "verdict"])


def _reason(found: pd.DataFrame, expected: Meeting) -> str:
    """Return why a collision was rejected, "accepted", or "missed"."""
    away = np.hypot(found["obstacle_x_um"] - expected.x_um, found["obstacle_y_um"] - expected.y_um)
    late = (found["contact_frame"] - expected.frame).abs()
    near = found[(away < 40.0) & (late <= LATE_FRAMES)]
    if near.empty:
        return "missed"
    row = near.loc[late[near.index].idxmin()]
    return "accepted" if row["accepted"] else str(row["reject_reason"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a few collisions of each kind")
    parser.add_argument("--out", type=Path, default=Path("video-neighbours"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    runs = 6 if arguments.quick else RUNS
    with ProcessPoolExecutor(thread_count(None), mp_context=get_context("spawn")) as pool:
        jobs = [pool.submit(studied, name, arguments.out, runs) for name in CASES]
        table = pd.concat([job.result() for job in jobs], ignore_index=True)
    counts = table.groupby(["case", "verdict"], sort=False).size()
    for name in CASES:
        verdicts = counts[name].sort_values(ascending=False)
        told = ", ".join(f"{verdict} {count}" for verdict, count in verdicts.items())
        print(f"{name:24s}{verdicts.sum():5d}   {told}")
    report = arguments.out / "neighbours.json"
    by_case = {name: counts[name].to_dict() for name in CASES}
    report.write_text(json.dumps(by_case, indent=2) + "\n")
    print(f"wrote {report}")


if __name__ == "__main__":
    main()
