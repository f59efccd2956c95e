"""Sweeps: very many collisions, written as a dataset that survives any interruption."""

from pinchoff.studies.sweep.design import SweepDesign
from pinchoff.studies.sweep.execution import SweepResult, sweep

__all__ = ["SweepDesign", "SweepResult", "sweep"]
