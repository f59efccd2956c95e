"""A virtual experiment: collisions like the paper's, drawn from a law or computed by the engine.

Its tables are synthetic and say so in the source of every row.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from pinchoff.collisions.circle_segments import symmetry_of_impact
from pinchoff.collisions.law import (
    PAPER_EXPERIMENT_LINE,
    Line,
    LineLike,
    as_line,
    breakup_number,
    breakup_number_of,
    breakup_probability,
)
from pinchoff.collisions.schema import SYNTHETIC, Column, measured_table
from pinchoff.model.parameters import Parameters, require_parameters
from pinchoff.support import paper_constants as paper
from pinchoff.support.arguments import checked_number, checked_whole
from pinchoff.support.errors import InputError
from pinchoff.support.quantities import FIXED_FILM, capillary_number

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TRUE_SYMMETRY = Column("true_symmetry", "1", "float64", "S without the error of its measurement")
"""Column of a virtual experiment that a real one does not have."""

Outcomes = Literal["law", "engine"]


class Condition(NamedTuple):
    """Parameters of one series of experiments, and its share of the collisions."""

    obstacle_radius_um: float
    thickness_um: float
    viscosity_mPa_s: float  # noqa: N815
    share: float


_MOST_TRIES = 50  # droplets for each that touches its obstacle

_STANDARD = Condition(
    paper.OBSTACLE_RADIUS_UM, paper.THICKNESS_UM, paper.VISCOSITY_MPA_S, share=1 / 3
)
_SMALL_RADIUS, _, _LARGE_RADIUS = paper.OBSTACLE_RADII_UM
CONDITIONS = (
    _STANDARD,
    _STANDARD._replace(viscosity_mPa_s=paper.THICK_VISCOSITY_MPA_S, share=1 / 6),
    _STANDARD._replace(obstacle_radius_um=_SMALL_RADIUS, share=1 / 6),
    _STANDARD._replace(obstacle_radius_um=_LARGE_RADIUS, share=1 / 6),
    _STANDARD._replace(thickness_um=min(paper.THICKNESSES_UM), share=1 / 6),
)
"""The paper's standard experiment, and those that vary one parameter of it. The shares are ours.

Speeds and diameters are drawn evenly from the paper's ranges, which is ours too."""


def virtual_experiment(
    seed: int,
    n: int = paper.COLLISION_COUNT,
    *,
    outcomes: Outcomes = "law",
    line: LineLike = PAPER_EXPERIMENT_LINE,
    width: float = paper.WIDTH,
    symmetry_noise: float = paper.SYMMETRY_NOISE,
    base: Parameters | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> pd.DataFrame:
    """Make a synthetic table of collisions under the paper's five conditions.

    Speeds and diameters are drawn evenly from the paper's ranges, and impact parameters from 0 to
    half a diameter, beyond which the centreline misses the droplet.

    Parameters
    ----------
    seed : int
        The same seed gives the same table.
    n : int, optional
        Collisions.
    outcomes : "law" or "engine", optional
        "law": S of a circle, and break-up with P = x/(1 + x), x = Bk^(1/w). "engine": every
        collision is simulated, from the impact parameter on as its start; that gives S, outcome,
        daughters and necks, and droplets that never touch the obstacle are drawn anew. The engine
        is two-dimensional: a chamber's thickness acts in it as in the law, through Ca z̃.
    line : Line, fitted law or str, optional
        Of the law; as of `pinchoff.breakup_number`.
    width : float, optional
        w of the law; 0: a step.
    symmetry_noise : float, optional
        Standard error of the measured S, reflected at 0 and 1.
    base : Parameters, optional
        Of the engine: the constants of its model, and what Ca stands for, ``ca_conversion`` and
        ``ca_speed``; sizes, Ca_sim and offsets are drawn. By default the preset ``default``.
    threads, progress
        As of `pinchoff.simulate_many`.

    Returns
    -------
    DataFrame
        With `pinchoff.collisions.schema.SHARED_COLUMNS`, and ``true_symmetry`` behind them; the
        source of every row begins with "synthetic".

    Raises
    ------
    InputError
        An argument is wrong.

    Examples
    --------
    >>> table = virtual_experiment(seed=1, n=1000)
    >>> len(table), table["source"].iloc[0]
    (1000, 'synthetic, by law')
    """
    checked_whole("seed", seed, "use 1", low=0)
    n = checked_whole("n", n, f"use {paper.COLLISION_COUNT}", low=1, high=10_000_000)
    if outcomes not in get_args(Outcomes):
        raise InputError.of("outcomes", "'law' or 'engine'", outcomes, "use 'law'")
    advice = f"use {paper.WIDTH} or 0"
    width = checked_number("width", width, advice, low=0.0, high=10.0)
    advice = f"use {paper.SYMMETRY_NOISE} or 0"
    symmetry_noise = checked_number("symmetry_noise", symmetry_noise, advice, low=0.0, high=0.5)
    generator = np.random.default_rng(seed)
    if outcomes == "engine":
        base = Parameters() if base is None else base
        require_parameters("base", base)
        columns = _simulated(generator, n, base, threads, progress)
    else:
        columns = _by_law(generator, n, as_line(line), width)
    noise = generator.normal(0.0, symmetry_noise, n) if symmetry_noise else np.zeros(n)
    columns["symmetry"] = _reflected(columns["true_symmetry"] + noise)
    columns["source"] = np.full(n, f"{SYNTHETIC}, by {outcomes}", dtype=object)
    columns["breakup_number"] = breakup_number_of(columns)
    return measured_table(columns, [TRUE_SYMMETRY])


def _drawn(generator: np.random.Generator, n: int) -> dict[str, NDArray[Any]]:
    """Draw what an experimenter sets, and what follows from it."""
    which = generator.choice(len(CONDITIONS), n, p=[condition.share for condition in CONDITIONS])
    of_condition = np.array(CONDITIONS)[which]
    radius, thickness, viscosity = of_condition[:, :3].T
    speed = generator.uniform(*paper.SPEEDS_MM_S, n)
    area = math.pi / 4.0 * generator.uniform(*paper.DIAMETERS_UM, n) ** 2
    tension = np.full(n, paper.SURFACE_TENSION_MN_M)
    return {
        "obstacle_radius_um": radius,
        "thickness_um": thickness,
        "viscosity_mPa_s": viscosity,
        "surface_tension_mN_m": tension,
        "speed_mm_s": speed,
        "area_um2": area,
        "capillary_number": capillary_number(viscosity, speed, tension),
        "normalized_area": area / radius**2,
        "normalized_thickness": thickness / radius,
    }


def _by_law(
    generator: np.random.Generator, n: int, line: Line, width: float
) -> dict[str, NDArray[Any]]:
    drawn = _drawn(generator, n)
    impact = generator.uniform(0.0, 0.5, n)
    symmetry = symmetry_of_impact(impact)
    bk = breakup_number(
        drawn["capillary_number"],
        normalized_area=drawn["normalized_area"],
        symmetry=symmetry,
        normalized_thickness=drawn["normalized_thickness"],
        line=line,
    )
    probability = breakup_probability(bk, width) if width else bk > 1.0
    broke = generator.random(n) < probability
    return {**drawn, "true_symmetry": symmetry, "impact_parameter": impact, "broke": broke}


def _simulated(
    generator: np.random.Generator,
    n: int,
    base: Parameters,
    threads: int | None,
    progress: bool | None,
) -> dict[str, NDArray[Any]]:
    """Simulate until n droplets have touched their obstacle."""
    parts: list[dict[str, NDArray[Any]]] = []
    count = tried = 0
    while count < n:
        if tried >= _MOST_TRIES * n:
            rule, got = "a model whose droplets touch the obstacle", f"{count} of {tried} that did"
            advice = "raise time_limit, or lower start_distance"
            raise InputError.of("base", rule, got, advice)
        tries = 2 * (n - count)  # about half of them touch
        tried += tries
        drawn = _drawn(generator, tries)
        offsets = generator.uniform(0.0, 0.5, tries)
        columns = {**drawn, **_runs(drawn, offsets, base, threads, progress)}
        touched = np.flatnonzero(np.isfinite(columns["true_symmetry"]))[: n - count]
        parts.append({name: column[touched] for name, column in columns.items()})
        count += len(touched)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _runs(
    drawn: dict[str, NDArray[Any]],
    offsets: Floats,
    base: Parameters,
    threads: int | None,
    progress: bool | None,
) -> dict[str, NDArray[Any]]:
    from pinchoff.model.simulation import simulate_many

    diameter = np.sqrt(4.0 / math.pi * drawn["area_um2"])
    forcing = drawn["capillary_number"] * drawn["normalized_thickness"]
    ratio = diameter / drawn["obstacle_radius_um"]
    film = base.ca_conversion == FIXED_FILM
    sizes = diameter / paper.MEDIAN_DIAMETER_UM if film else np.ones_like(diameter)
    forcing = forcing / (base.conversion_constant / sizes**2)
    parameters = [
        base.replace(
            size_ratio=size, simulation_capillary_number=ca, offset=y, follow_daughters=False
        )
        for size, ca, y in zip(ratio.tolist(), forcing.tolist(), offsets.tolist(), strict=True)
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # such rows say why they are rejected
        runs = simulate_many(parameters, threads=threads, progress=progress)
    names = ("accepted", "reject_reason", "impact_parameter", "daughter_area_ratio")
    own = runs["contact_speed"].to_numpy() if base.ca_speed == "contact" else 1.0
    return {
        "speed_mm_s": drawn["speed_mm_s"] * own,
        "capillary_number": drawn["capillary_number"] * own,
        "true_symmetry": runs["symmetry"].to_numpy(),
        "broke": runs["broke"].to_numpy(dtype=object),
        "neck_thickness": runs["neck_thickness"].to_numpy(),
        "neck_um": runs["neck_thickness"].to_numpy() * diameter,
        **{name: runs[name].to_numpy() for name in names},
    }


def _reflected(symmetry: Floats) -> Floats:
    above = np.abs(symmetry)
    return np.where(above > 1.0, 2.0 - above, above)
