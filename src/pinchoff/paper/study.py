"""The sources of figures and numbers, each computed once, when it is first needed."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.collisions.importing import ImportedCollisions, import_collisions
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, breakup_number
from pinchoff.fits.law_fit import fit_law
from pinchoff.fits.law_study import study_law
from pinchoff.model.parameters import FRONT, SPRINGS, Model, Parameters, PhysicalScale
from pinchoff.model.simulation import simulate, simulate_many
from pinchoff.studies.boundary import boundary
from pinchoff.studies.calibration.conversions import Conversion, match_onset
from pinchoff.studies.calibration.targets import PRESETS
from pinchoff.studies.virtual import virtual_experiment
from pinchoff.support import paper_constants as the_paper
from pinchoff.support.quantities import capillary_number

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.fits import LawFit
    from pinchoff.fits.law_study import LawStudy
    from pinchoff.model.results import Collision
    from pinchoff.studies.boundary.search import Boundary

CAPILLARY = (16, 20, 25, 32, 40, 50, 64, 80)
"""Ca_sim of the paper's separating line."""

_QUICK_VERTICES = 64  # of a quick study with front tracking, half of what it takes otherwise


@dataclass(frozen=True, eq=False)
class Study:
    """The sources of a reproduction.

    Attributes
    ----------
    seed : int
        Seed of the virtual experiment, the bootstrap and the simulated collisions.
    quick : bool
        Fewer and coarser simulations.
    experiment : ImportedCollisions or None
        Real collisions. They replace the virtual experiment.
    folder : Path
        Where films and what is measured on them are kept.
    model : str
        What the simulations' outlines are made of.
    """

    seed: int = 1
    quick: bool = False
    experiment: ImportedCollisions | None = None
    folder: Path = Path()
    model: Model = SPRINGS

    @property
    def base(self) -> Parameters:
        """The default constants of its model; if quick, fronts are as coarse as springs."""
        coarse = {"vertex_count": _QUICK_VERTICES} if self.quick and self.model == FRONT else {}
        return Parameters(model=self.model, **coarse)

    def with_fronts(self) -> Study:
        """Return the same study with front tracking."""
        return replace(self, model=FRONT)

    @property
    def measured(self) -> bool:
        """Whether the collisions are real ones."""
        return self.experiment is not None and not self.experiment.synthetic

    @cached_property
    def collisions(self) -> ImportedCollisions:
        """The experiment; a virtual one if there is no other."""
        if self.experiment is not None:
            return self.experiment
        return import_collisions(virtual_experiment(self.seed, symmetry_noise=0.0))

    @cached_property
    def law(self) -> LawStudy:
        """The law fitted to the experiment with the paper's exponents."""
        return study_law(self.collisions, seed=self.seed)

    def exponents(self, *free: str) -> LawFit:
        """Return the law with exponents of some quantities free."""
        return fit_law(self.collisions, free=free)

    @cached_property
    def line(self) -> Boundary:
        """The separating line of the simulations at D0/R = 5.66."""
        vary = {"simulation_capillary_number": list(CAPILLARY)}
        return boundary(self.base, vary, width=0.01 if self.quick else 0.002, progress=False)

    @cached_property
    def tensions(self) -> Boundary:
        """Separating lines of several line tensions."""
        vary: dict[str, Any] = {
            "line_tension": [60, 190, 600] if self.quick else [60, 190, 600, 1900],
            "simulation_capillary_number": list(CAPILLARY[1::2] if self.quick else CAPILLARY),
        }
        return boundary(Parameters(), vary, width=0.01 if self.quick else 0.002, progress=False)

    @cached_property
    def conversion(self) -> Conversion | None:
        """Ca per Ca_sim by the onset of break-up."""
        return match_onset(PRESETS["paper-experiment"], self.base)

    @cached_property
    def simulated(self) -> pd.DataFrame:
        """Simulated collisions under the paper's conditions, checked."""
        count = 300 if self.quick else 3000
        if self.model == FRONT:  # each takes far longer
            count //= 5
        table = virtual_experiment(
            self.seed,
            count,
            outcomes="engine",
            symmetry_noise=0.0,
            base=self.base,
            progress=False,
        )
        return import_collisions(table).table

    @cached_property
    def daughters(self) -> pd.DataFrame:
        """Simulated break-ups of the median droplet at several Ca_sim, from head-on to glancing."""
        offsets = [0.002 + 0.01 * k for k in range(12 if self.quick else 24)]
        runs = [
            Parameters(simulation_capillary_number=ca, offset=offset, follow_daughters=False)
            for ca in (20, 25, 32, 46, 64, 100)
            for offset in offsets
        ]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # a stopped run has no daughters
            table = simulate_many(runs, progress=False)
        return table[table["broke"].fillna(False).astype(bool)]

    @cached_property
    def median_collision(self) -> Collision:
        """The paper's median breaking droplet at 1 mm/s, a little off-centre, with outlines."""
        return simulate(droplet(the_paper.MEDIAN_DIAMETER_UM, 1.0, 20.0), outlines=0.01)

    @cached_property
    def sequences(self) -> list[Collision]:
        """Collisions like those of figure 1: speed and S as there, sizes chosen."""
        found = []
        for diameter, speed, symmetry in ((520.0, 1.8, 1.0), (540.0, 1.4, 0.5), (260.0, 1.1, 0.5)):
            offset = offset_of_symmetry(diameter, speed, symmetry)
            found.append(simulate(droplet(diameter, speed, offset), outlines=0.02))
        return found


def droplet(diameter_um: float, speed_mm_s: float, offset_um: float) -> Parameters:
    """Return the parameters of a droplet under the paper's standard conditions."""
    scale = PhysicalScale(
        diameter_um=diameter_um,
        obstacle_radius_um=the_paper.OBSTACLE_RADIUS_UM,
        speed_mm_s=speed_mm_s,
        viscosity_mPa_s=the_paper.VISCOSITY_MPA_S,
        surface_tension_mN_m=the_paper.SURFACE_TENSION_MN_M,
        thickness_um=the_paper.THICKNESS_UM,
    )
    return Parameters.of_scale(scale, offset_um=offset_um)


def offset_of_symmetry(diameter_um: float, speed_mm_s: float, symmetry: float) -> float:
    """Return the start offset [µm] with which a droplet has this S at first contact."""
    if symmetry == 1.0:
        # not exactly head-on: there round-off would decide to which side the droplet goes
        return 1e-3 * diameter_um
    low, high = 0.0, 0.5
    for _ in range(3):
        offsets = [low + (high - low) * k / 16 for k in range(17)]
        runs = simulate_many(
            [
                droplet(diameter_um, speed_mm_s, y * diameter_um).replace(follow_daughters=False)
                for y in offsets
            ],
            progress=False,
        )
        above = [s for s in runs["symmetry"].fillna(0.0) if s > symmetry]
        low, high = offsets[len(above) - 1], offsets[len(above)]
    return 0.5 * (low + high) * diameter_um


def paper_breakup_number(area_mm2: float, speed_mm_s: float, symmetry: float = 1.0) -> float:
    """Return Bk of a droplet under the standard conditions, with the paper's exact constants.

    Examples
    --------
    >>> round(paper_breakup_number(0.2, 1.0), 2)
    1.92
    """
    capillary = capillary_number(
        the_paper.VISCOSITY_MPA_S, speed_mm_s, the_paper.SURFACE_TENSION_MN_M
    )
    area = area_mm2 * 1e6 / the_paper.OBSTACLE_RADIUS_UM**2
    bk: float = breakup_number(
        capillary, normalized_area=area, symmetry=symmetry, line=PAPER_EXPERIMENT_LINE
    )
    return bk
