"""Every number of the paper that can be recomputed, ours beside it, with a verdict."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pinchoff.collisions.circle_segments import (
    SMALL_SEGMENT_EXPONENT,
    area_ratio_bound,
    segment_area,
)
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, transition_factor
from pinchoff.fits.intervals import PROFILE
from pinchoff.model.parameters import DEFAULTS
from pinchoff.paper.study import (
    Study,
    paper_breakup_number,
)
from pinchoff.studies.boundary.collapse import collapse_spread, slopes
from pinchoff.support import paper_constants as the_paper
from pinchoff.support.interval import Estimate
from pinchoff.support.numerals import numeral
from pinchoff.support.quantities import capillary_number, reynolds_number

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Verdict = Literal["agrees", "differs", "misprint", "needs the authors' data"]

ENGINE = "engine"
ARITHMETIC = "arithmetic"

_OIL_CST = (50.0, 100.0)


@dataclass(frozen=True)
class Number:
    """A number of the paper and ours.

    Attributes
    ----------
    name, place : str
        What it is, and where the paper has it.
    paper, ours, interval : str
        The texts that a reader sees; empty where there is none.
    how : str
        How ours was obtained.
    verdict : str
    value, low, high : float
        Ours as numbers; NaN: none.
    note : str
    """

    name: str
    place: str
    paper: str
    ours: str
    interval: str
    how: str
    verdict: Verdict
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    note: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold: what is not a finite number is None."""
        values = asdict(self)
        return {
            k: None if isinstance(v, float) and not math.isfinite(v) else v
            for k, v in values.items()
        }


def numbers(study: Study) -> list[Number]:
    """Compute all of them."""
    parts: tuple[Callable[[Study], Iterator[Number]], ...] = (
        _law,
        _exponents,
        _simulations,
        _breakup_number,
        _geometry,
        _necks_and_daughters,
        _scales,
    )
    return [number for part in parts for number in part(study)]


def _law(study: Study) -> Iterator[Number]:
    how = f"law on {data_name(study)}"
    names = {"alpha": "prefactor α", "beta": "exponent β", "w": "width w"}
    estimates = study.law.intervals[PROFILE]
    for key, (value, error) in the_paper.EXPERIMENT_FIT.items():
        paper = f"{_numeral(value)} ± {error:g}"
        yield _estimated(
            f"{names[key]}, experiments", "sec. 4.2", paper, (value, error), estimates[key], how
        )
    for key, (_, error) in the_paper.EXPERIMENT_FIT.items():
        if key in study.law.spread:
            yield _plain(
                f"error of {names[key]}",
                "sec. 4.2",
                f"± {error:g}",
                error,
                study.law.spread[key],
                f"bootstrap, {study.law.samples} parts of half, {how}",
                factor=1.5,
            )
    yield _plain(
        "collisions in a part of the bootstrap",
        "sec. 4.2",
        "2,528",
        2528,
        the_paper.COLLISION_COUNT / 2,
        ARITHMETIC,
    )


def _exponents(study: Study) -> Iterator[Number]:
    how = f"law on {data_name(study)}, with this exponent free"
    table = study.collisions.table
    geometric = [
        name
        for name, column in (("area", "normalized_area"), ("thickness", "normalized_thickness"))
        if np.ptp(table[column]) > 0
    ]
    found = dict(study.exponents(*geometric).estimates) if geometric else {}
    viscosity = table["viscosity_mPa_s"]
    if viscosity.notna().all() and np.ptp(viscosity) > 0:
        found |= study.exponents("viscosity").estimates
    for key, name, value in (
        ("epsilon_1", "exponent ε1 of A", 1.0),
        ("epsilon_2", "exponent ε2 of R", -3.0),
        ("epsilon_3", "exponent ε3 of z", 1.0),
        ("epsilon_mu", "exponent ε_μ of μ", 1.0),
    ):
        if key in found:
            yield _estimated(name, "sec. 4.2", _numeral(value), (value, 0.0), found[key], how)


def _simulations(study: Study) -> Iterator[Number]:
    fit = study.line.fit()
    how = f"{ENGINE}, {len(study.line.runs)} collisions"
    alpha, beta = the_paper.SIMULATION_ALPHA, the_paper.SIMULATION_BETA
    yield _estimated(
        "prefactor α, simulations", "sec. 4.1", f"{alpha:g}", (alpha, 0.0), fit.alpha, how
    )
    yield _estimated(
        "exponent β, simulations", "sec. 4.1", _numeral(beta), (beta, 0.0), fit.beta, how
    )
    conversion = study.conversion
    if conversion is not None:
        estimate = Estimate(conversion.value, conversion.low, conversion.high)
        yield _estimated(
            "Ca per Ca_sim",
            "eq. (conv)",
            "9.8e-5",
            (the_paper.CA_PER_CA_SIM, 0.0),
            estimate,
            f"{ENGINE}, onset of break-up at D0/R = 5.66; range over N_v",
            note="the paper's own argument makes it depend on D0",
        )
    found = study.tensions.found
    tilts = slopes(found).values()
    yield _estimated(
        "slope of ln S_c against ln μ̃",
        "appendix C",
        _numeral(beta),
        (beta, 0.0),
        study.tensions.fit().beta,
        f"{ENGINE}, {len(tilts)} line tensions",
        note=f"each alone: {_numeral(min(tilts))} to {_numeral(max(tilts))}",
    )
    spread = collapse_spread(found)
    yield Number(
        "collapse of S_c with μ̃/γ̃",
        "appendix C",
        "one curve",
        f"within {spread.largest:.2%}",
        "",
        ENGINE,
        "agrees" if spread.largest < 0.02 else "differs",
        spread.largest,
    )
    ratio = DEFAULTS["edge_stiffness"] / DEFAULTS["line_tension"]
    yield Number(
        "k̃_l/γ̃", "sec. 3.4", "< 0.05", f"{ratio:.3g}", "", "default preset", "agrees", ratio
    )


def _breakup_number(study: Study) -> Iterator[Number]:
    alpha, beta = PAPER_EXPERIMENT_LINE
    yield _plain(
        "prefactor of Bk",
        "eq. (Bkequation)",
        "28",
        28.0,
        alpha ** (1 / beta),
        ARITHMETIC,
        factor=1.05,
    )
    yield Number(
        "exponent of S in Bk",
        "eq. (Bkequation)",
        "−4/3",
        f"+{-1 / beta:.3f}",
        "",
        ARITHMETIC,
        "misprint",
        -1 / beta,
        note="from its definition; the abstract has +4/3",
    )
    yield _plain(
        "growth of P from 5 to 95 %, factor in Bk",
        "sec. 4.2",
        "≈ 2",
        2.0,
        transition_factor(the_paper.WIDTH),
        f"{ARITHMETIC}, from w = 0.098",
        factor=1.25,
    )
    used = study.collisions.table[study.collisions.table["symmetry"] > 0]
    number = study.law.fit.breakup_number(used)
    decades = float(np.log10(number.max() / number.min()))
    yield Number(
        "orders of magnitude of Bk",
        "sec. 4.2",
        "6",
        f"{decades:.1f}",
        "",
        data_name(study),
        "agrees" if decades > 5.5 else "differs",
        decades,
    )


def _geometry(study: Study) -> Iterator[Number]:
    heights = np.array([1e-3, 1.01e-3])  # h/D of two droplets that share one h
    logs = [
        np.log(2 * segment_area(1.0, 1 / heights) / (np.pi / 4 / heights**2)),
        -2 * np.log(heights),
    ]
    slope = float(np.diff(logs[0])[0] / np.diff(logs[1])[0])
    yield _plain(
        "β of one height h ≪ D0",
        "sec. 4.2",
        "−3/4",
        SMALL_SEGMENT_EXPONENT,
        slope,
        "circular segments",
        factor=1.002,
    )
    ratio = 4 ** (1 + PAPER_EXPERIMENT_LINE.beta)
    yield _plain(
        "A_small of twice the radius", "fig. 6", "1.4", 1.4, ratio, ARITHMETIC, factor=1.05
    )
    number = paper_breakup_number(0.02, 1.0)
    yield Number(
        "Bk of A = 0.02 mm² at 1.0 mm/s",
        "fig. 6",
        "1",
        f"{number:.2g} at most",
        "",
        ARITHMETIC,
        "misprint",
        number,
        note="head-on, standard conditions; A = 0.2 mm² has Bk = 1 at S = 0.62",
    )


def _necks_and_daughters(study: Study) -> Iterator[Number]:
    neck = DEFAULTS["neck_thickness"] * the_paper.MEDIAN_DIAMETER_UM
    yield _plain(
        "d_min-neck", "sec. 4.4", "80.3 µm", 80.3, neck, ARITHMETIC, unit=" µm", factor=1.001
    )
    broke = study.simulated[study.simulated["broke"].astype(bool)]
    below = broke["daughter_area_ratio"] <= area_ratio_bound(broke["symmetry"]) + 1e-9
    share = float(below.mean())
    yield Number(
        "simulated A1/A2 below S/(2 − S)",
        "sec. 4.3",
        "all",
        f"{share:.1%} of {len(broke)}",
        "",
        ENGINE,
        "agrees" if share == 1.0 else "differs",
        share,
    )
    for name, paper in (
        ("median diameter of droplets that broke", "481 µm"),
        ("thickest neck one frame before a break-up", "≈ 70 µm"),
        ("thinnest neck of droplets that did not break", "≈ 140 µm"),
        ("uncertainty of S", "± 0.088"),
    ):
        yield Number(name, "sec. 4", paper, "", "", "", "needs the authors' data")


def _scales(_: Study) -> Iterator[Number]:
    viscosity = [cst * 1e-6 * the_paper.OIL_DENSITY_KG_M3 * 1e3 for cst in _OIL_CST]
    yield Number(
        "viscosity of the oils",
        "sec. 2",
        "480, 960 Pa s",
        f"{viscosity[0]:g}, {viscosity[1]:g} mPa s",
        "",
        f"{ARITHMETIC}, 50 and 100 cSt at 960 kg/m³",
        "misprint",
        viscosity[0],
    )
    tension = the_paper.SURFACE_TENSION_MN_M
    ca = capillary_number(viscosity, the_paper.SPEEDS_MM_S, tension)
    yield _ordered("Ca", "sec. 3.4", "O(1e-3)", 1e-3, ca, factor=10)
    reynolds = reynolds_number(
        the_paper.OIL_DENSITY_KG_M3,
        max(the_paper.SPEEDS_MM_S),
        max(the_paper.OBSTACLE_RADII_UM),
        the_paper.VISCOSITY_MPA_S,
    )
    yield Number(
        "Re", "sec. 2", "≤ O(1e-2)", f"≤ {reynolds:.1e}", "", ARITHMETIC, "agrees", reynolds
    )
    film = ca ** (2 / 3)
    yield _ordered("δ/z = Ca^(2/3)", "sec. 3.4", "O(1e-2)", 1e-2, film, factor=5)
    typical = float(capillary_number(the_paper.VISCOSITY_MPA_S, 1.0, tension)) ** (2 / 3)
    wide = (typical * the_paper.OBSTACLE_RADIUS_UM / the_paper.MEDIAN_DIAMETER_UM) ** 2
    yield Number(
        "Ca/Ca_eff = (δ/D0)²",
        "sec. 3.4",
        "O(1e-4)",
        f"{typical**2:.1e}",
        "",
        f"{ARITHMETIC}, 1 mm/s, D0 = z",
        "agrees",
        typical**2,
        note=f"{wide:.1e} with D0 = 481 µm; the paper takes D0 and z to be of one order",
    )


def _numeral(value: float) -> str:
    return numeral(value, ".4g")


def data_name(study: Study) -> str:
    """Say which collisions the law is fitted to."""
    return "your collisions" if study.experiment is not None else "synthetic data"


def _estimated(
    name: str,
    place: str,
    paper: str,
    known: tuple[float, float],
    ours: Estimate,
    how: str,
    note: str = "",
) -> Number:
    """Compare an interval with a number and its error: they agree where they overlap."""
    value, error = known
    agrees = ours.low <= value + 2 * error and value - 2 * error <= ours.high
    return Number(
        name,
        place,
        paper,
        _numeral(ours.value),
        f"{_numeral(ours.low)} to {_numeral(ours.high)}",
        how,
        "agrees" if agrees else "differs",
        *ours[:3],
        note=note,
    )


def _plain(
    name: str,
    place: str,
    paper: str,
    known: float,
    ours: float,
    how: str,
    *,
    unit: str = "",
    factor: float = 1.0,
) -> Number:
    """Compare two numbers that agree if they are within a factor, for what the paper rounds."""
    ratio = ours / known
    agrees = ratio > 0 and max(ratio, 1 / ratio) <= factor + 1e-9
    shown = f"{_numeral(ours)}{unit}"
    return Number(name, place, paper, shown, "", how, "agrees" if agrees else "differs", ours)


def _ordered(
    name: str, place: str, paper: str, known: float, ours: ArrayLike, factor: float
) -> Number:
    """Compare a range with an order of magnitude."""
    values = np.asarray(ours, dtype=np.float64)
    low, high = float(values.min()), float(values.max())
    agrees = known / factor <= low and high <= known * factor
    shown = f"{low:.1e} to {high:.1e}"
    return Number(
        name,
        place,
        paper,
        shown,
        "",
        ARITHMETIC,
        "agrees" if agrees else "differs",
        math.sqrt(low * high),
        low,
        high,
    )
