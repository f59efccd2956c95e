"""Constants of the model, chosen so that a given separating line or given collisions come out."""

from pinchoff.studies.calibration.fitting import Calibration, calibrate
from pinchoff.studies.calibration.targets import CollisionsTarget, LineTarget

__all__ = ["Calibration", "CollisionsTarget", "LineTarget", "calibrate"]
