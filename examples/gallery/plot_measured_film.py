r"""
What is in a film?
==================

A clip measured: histograms of what was found, and when the droplets met the obstacle. The clip is
the small drawn one that ``pinchoff examples`` writes.
"""

import tempfile
from pathlib import Path

import pinchoff as po
from pinchoff.cli.examples import write_examples

folder = Path(tempfile.mkdtemp())
write_examples(folder)
settings = po.VideoSettings(
    pixel_size_um=5.28,
    laboratory={
        "obstacle_radius_um": 85,
        "thickness_um": 85,
        "viscosity_mPa_s": 48,
        "surface_tension_mN_m": 20,
    },
)
measured = po.measure_videos([folder / "clip.mp4"], folder / "measured", settings)
panels = po.figures.histograms(measured.collisions)

# %%
# A stroke for every collision, a line for every clip.

axes = po.figures.timeline(measured.collisions)
