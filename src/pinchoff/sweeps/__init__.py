"""Sweeps: very many collisions, written as a dataset that survives any interruption."""

from pinchoff.sweeps.design import SweepDesign
from pinchoff.sweeps.execution import SweepResult, sweep

__all__ = ["SweepDesign", "SweepResult", "sweep"]
