"""Constants of the model, chosen so that a given separating line or given collisions come out."""

from pinchoff.calibrations.fitting import Calibration, calibrate
from pinchoff.calibrations.targets import CollisionsTarget, LineTarget

__all__ = ["Calibration", "CollisionsTarget", "LineTarget", "calibrate"]
