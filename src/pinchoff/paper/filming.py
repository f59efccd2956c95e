"""Appendix B without a laboratory: collisions that are simulated, filmed, measured and compared.

What agrees there is the measurement with what was filmed, not the model with an experiment.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from pinchoff.paper.study import droplet
from pinchoff.support import paper_constants as the_paper
from pinchoff.support.errors import InputError
from pinchoff.video.batch import measure_videos
from pinchoff.video.comparison import Comparison, compare_collision
from pinchoff.video.encounters import PAPER_LABORATORY
from pinchoff.video.microscope import Microscope, film, lane_scene, passage_of
from pinchoff.video.settings import VideoSettings

_SMALLEST_UM = 40.0  # diameter of the smallest droplet that is measured


class Filmed(NamedTuple):
    """A droplet that is filmed: D0/R is the paper's; the other numbers are ours.

    The small droplet is 12 pixels wide at the paper's 5.28 µm a pixel, of which the dark ring
    leaves 6; there the measurement loses it.
    """

    size_ratio: float
    speed_mm_s: float
    offset: float
    pixel_size_um: float


DROPLETS = {
    "B1": Filmed(0.78, 1.0, 0.02, the_paper.PIXEL_SIZE_UM / 2),
    "B2": Filmed(2.5, 1.0, 0.03, the_paper.PIXEL_SIZE_UM),
}
"""The droplets of appendix B by their figures."""


def filmed_comparison(folder: Path, figure: str, seed: int) -> Comparison:
    """Film one of the `DROPLETS`, measure the clip, and simulate what was measured.

    The folder takes the clip and its measurements; an existing clip is not made again. The seed is
    that of the camera's noise.
    """
    wanted = DROPLETS[figure]
    microscope = Microscope(seed=seed, pixel_size_um=wanted.pixel_size_um)
    clip = folder / f"film_{figure}.mp4"
    if not clip.exists():
        diameter = wanted.size_ratio * the_paper.OBSTACLE_RADIUS_UM
        parameters = droplet(diameter, wanted.speed_mm_s, wanted.offset * diameter)
        passage = passage_of(parameters, microscope, PAPER_LABORATORY)
        scene, frame_count = lane_scene([passage], microscope, lanes=1, seed=seed)
        film(scene, clip, frame_count, microscope=microscope, laboratory=PAPER_LABORATORY)
    settings = VideoSettings(
        pixel_size_um=wanted.pixel_size_um,
        minimum_diameter_um=_SMALLEST_UM,
        method="rings",  # as the microscope draws droplets
        laboratory=PAPER_LABORATORY,
    )
    result = measure_videos([clip], folder / f"film_{figure}", settings, overlay=False)
    accepted = result.collisions[result.collisions["accepted"].astype(bool)]
    if accepted.empty:
        got, advice = "none", f"look at {result.clips[0].folder}"
        raise InputError.of(f"film {figure}", "one with an accepted collision", got, advice)
    return compare_collision(result.clips[0].folder, int(accepted["collision_id"].iloc[0]))
