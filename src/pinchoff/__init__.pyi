"""The public names and the room each comes from; `__init__.py` loads them on first use."""

from . import chamber as chamber
from . import figures as figures
from .collisions.importing import ImportedCollisions as ImportedCollisions
from .collisions.importing import import_collisions as import_collisions
from .collisions.law import Line as Line
from .collisions.law import breakup_number as breakup_number
from .collisions.parquet import read_collisions as read_collisions
from .fits import LawFit as LawFit
from .fits import fit_law as fit_law
from .model import arrays as arrays
from .model import flow as flow
from .model.emulsion import simulate_emulsion as simulate_emulsion
from .model.emulsion_result import Emulsion as Emulsion
from .model.emulsion_scene import Coalescence as Coalescence
from .model.emulsion_scene import Inlet as Inlet
from .model.energy import term_forces as term_forces
from .model.energy import total_energy as total_energy
from .model.outlines import Outlines as Outlines
from .model.parameters import Parameters as Parameters
from .model.parameters import PhysicalScale as PhysicalScale
from .model.simulation import Collision as Collision
from .model.simulation import simulate as simulate
from .model.simulation import simulate_many as simulate_many
from .paper import reproduce as reproduce
from .studies.boundary import Boundary as Boundary
from .studies.boundary import boundary as boundary
from .studies.calibration import Calibration as Calibration
from .studies.calibration import CollisionsTarget as CollisionsTarget
from .studies.calibration import LineTarget as LineTarget
from .studies.calibration import calibrate as calibrate
from .studies.head_on import Drainage as Drainage
from .studies.head_on import calibrate_drainage as calibrate_drainage
from .studies.sweep import SweepDesign as SweepDesign
from .studies.sweep import sweep as sweep
from .studies.virtual import virtual_experiment as virtual_experiment
from .support import errors as errors
from .support.errors import InputError as InputError
from .support.errors import PinchoffError as PinchoffError
from .support.errors import SimulationError as SimulationError
from .video import microscope as microscope
from .video.batch import measure_videos as measure_videos
from .video.export import export_clip as export_clip
from .video.settings import VideoSettings as VideoSettings

__version__: str

__all__ = [
    "Boundary",
    "Calibration",
    "Coalescence",
    "Collision",
    "CollisionsTarget",
    "Drainage",
    "Emulsion",
    "ImportedCollisions",
    "Inlet",
    "InputError",
    "LawFit",
    "Line",
    "LineTarget",
    "Outlines",
    "Parameters",
    "PhysicalScale",
    "PinchoffError",
    "SimulationError",
    "SweepDesign",
    "VideoSettings",
    "__version__",
    "arrays",
    "boundary",
    "breakup_number",
    "calibrate",
    "calibrate_drainage",
    "chamber",
    "errors",
    "export_clip",
    "figures",
    "fit_law",
    "flow",
    "import_collisions",
    "measure_videos",
    "microscope",
    "read_collisions",
    "reproduce",
    "simulate",
    "simulate_emulsion",
    "simulate_many",
    "sweep",
    "term_forces",
    "total_energy",
    "virtual_experiment",
]
