"""Figures: one module per figure, outlines or a table in, matplotlib Axes out.

Those of a chamber, of an array and of a film beside its simulation need an extra; they stand in
their own modules.
"""

from pinchoff.figures.appendix_c import appendix_c
from pinchoff.figures.area_collapse import area_collapse
from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.calibrated_line import calibrated_line, objective_landscape
from pinchoff.figures.constant_height import constant_height
from pinchoff.figures.construction import model_schematic, symmetry_construction
from pinchoff.figures.daughters import daughter_areas
from pinchoff.figures.neck_histograms import neck_histograms
from pinchoff.figures.phase_diagram import phase_diagram, separated_outcomes, separating_line
from pinchoff.figures.sequences import collision_pairs
from pinchoff.figures.snapshots import snapshot_strip, write_snapshots
from pinchoff.figures.style import save
from pinchoff.figures.video_histograms import histograms, timeline

__all__ = [
    "appendix_c",
    "area_collapse",
    "breakup_probability",
    "calibrated_line",
    "collision_pairs",
    "constant_height",
    "daughter_areas",
    "histograms",
    "model_schematic",
    "neck_histograms",
    "objective_landscape",
    "phase_diagram",
    "save",
    "separated_outcomes",
    "separating_line",
    "snapshot_strip",
    "symmetry_construction",
    "timeline",
    "write_snapshots",
]
