"""The microscope: known outlines in, a video out, with the truth beside it.

For tests of measurements, for tutorials, and to see what a measurement does to the truth.
"""

from __future__ import annotations

from pinchoff.video.microscope.appearance import Microscope
from pinchoff.video.microscope.films import Film, film, frames, passage_of, truth_of
from pinchoff.video.microscope.passages import Passage, PlacedDroplet
from pinchoff.video.microscope.scenes import Scene, lane_scene
from pinchoff.video.microscope.truth import scene_encounters

__all__ = [
    "Film",
    "Microscope",
    "Passage",
    "PlacedDroplet",
    "Scene",
    "film",
    "frames",
    "lane_scene",
    "passage_of",
    "scene_encounters",
    "truth_of",
]
