"""Figures: one module per figure, outlines or a table in, matplotlib Axes out."""

from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.calibrated_line import calibrated_line, objective_landscape
from pinchoff.figures.daughters import daughter_areas
from pinchoff.figures.phase_diagram import phase_diagram, separated_outcomes, separating_line
from pinchoff.figures.sequences import collision_pairs
from pinchoff.figures.snapshots import snapshot_strip, write_snapshots

__all__ = [
    "breakup_probability",
    "calibrated_line",
    "collision_pairs",
    "daughter_areas",
    "objective_landscape",
    "phase_diagram",
    "separated_outcomes",
    "separating_line",
    "snapshot_strip",
    "write_snapshots",
]
