"""Every number of the paper that can be recomputed, ours beside it, with a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from pinchoff.collisions.circle_segments import (
    SMALL_SEGMENT_EXPONENT,
    area_ratio_bound,
    segment_area,
)
from pinchoff.collisions.law import PAPER_EXPERIMENT_LINE, transition_factor
from pinchoff.fits.intervals import PROFILE
from pinchoff.model.parameters import DEFAULTS
from pinchoff.paper.study import Study, paper_breakup_number
from pinchoff.paper.verdicts import (
    MEASURED,
    NEEDS_DATA,
    RECOVERED,
    SIMULATED,
    Kind,
    Number,
    beside,
    estimated,
    four_digits,
    judged,
    misprint,
    ordered,
    plain,
)
from pinchoff.studies.boundary.collapse import collapse_spread, slopes
from pinchoff.support import paper_constants as the_paper
from pinchoff.support.interval import Estimate
from pinchoff.support.numerals import numeral
from pinchoff.support.quantities import capillary_number, reynolds_number

ENGINE = "engine"

_OIL_CST = (50.0, 100.0)

_CALIBRATED = (
    "k̃_l and the reading of the arc threshold were chosen so that this line comes out; the "
    "exponent then follows from the arc threshold"
)


def numbers(study: Study) -> list[Number]:
    """Compute all of them."""
    parts: tuple[Callable[[Study], Iterator[Number]], ...] = (
        _law,
        _exponents,
        _simulations,
        _springs,
        _breakup_number,
        _geometry,
        _necks,
        _scales,
    )
    return [number for part in parts for number in part(study)]


def _simulations(study: Study) -> Iterator[Number]:
    """What both models simulate, side by side."""
    fronts = study.with_fronts()
    for part in (_line, _daughters):
        front = {number.name: number for number in part(fronts)}
        for number in part(study):
            yield beside(number, front.get(number.name))


def _law(study: Study) -> Iterator[Number]:
    how = f"law on {data_name(study)}"
    names = {"alpha": "prefactor α", "beta": "exponent β", "w": "width w"}
    kind = _kind_of_data(study)
    estimates = study.law.intervals[PROFILE]
    for key, (value, error) in the_paper.EXPERIMENT_FIT.items():
        paper = f"{four_digits(value)} ± {error:g}"
        name = f"{names[key]}, experiments"
        yield estimated(name, "sec. 4.2", paper, (value, error), estimates[key], how, kind)
    for key, (_, error) in the_paper.EXPERIMENT_FIT.items():
        if key in study.law.spread:
            yield plain(
                f"error of {names[key]}",
                "sec. 4.2",
                f"± {error:g}",
                error,
                study.law.spread[key],
                f"bootstrap, {study.law.samples} parts of half, {how}",
                kind,
                factor=1.5,
            )
    half = the_paper.COLLISION_COUNT / 2
    name = "collisions in a part of the bootstrap"
    yield plain(name, "sec. 4.2", "2,528", 2528, half, "half of 5,056")


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
            paper = four_digits(value)
            kind = _kind_of_data(study)
            yield estimated(name, "sec. 4.2", paper, (value, 0.0), found[key], how, kind)


def _line(study: Study) -> Iterator[Number]:
    fit = study.line.fit()
    how = f"{ENGINE}, {len(study.line.runs)} collisions"
    alpha, beta = the_paper.SIMULATION_ALPHA, the_paper.SIMULATION_BETA
    for name, known, ours in (
        ("prefactor α, simulations", alpha, fit.alpha),
        ("exponent β, simulations", beta, fit.beta),
    ):
        paper = four_digits(known)
        yield estimated(name, "sec. 4.1", paper, (known, 0.0), ours, how, SIMULATED, _CALIBRATED)
    conversion = study.conversion
    if conversion is not None:
        estimate = Estimate(conversion.value, conversion.low, conversion.high)
        yield estimated(
            "Ca per Ca_sim",
            "eq. (conv)",
            "9.8×10⁻⁵",
            (the_paper.CA_PER_CA_SIM, 0.0),
            estimate,
            f"{ENGINE}, onset of break-up at D0/R = 5.66; range over N_v",
            SIMULATED,
            "what brings the onset onto the paper's line; the paper's own argument makes it "
            "depend on D0",
        )


def _springs(study: Study) -> Iterator[Number]:
    """What has no meaning with front tracking, in which line tension is the unit."""
    found, beta = study.tensions.found, the_paper.SIMULATION_BETA
    tilts = slopes(found).values()
    yield estimated(
        "slope of ln S_c against ln μ̃",
        "appendix C",
        four_digits(beta),
        (beta, 0.0),
        study.tensions.fit().beta,
        f"{ENGINE}, {len(tilts)} line tensions",
        SIMULATED,
        f"each alone: {four_digits(min(tilts))} to {four_digits(max(tilts))}",
    )
    spread = collapse_spread(found)
    yield judged(
        "collapse of S_c with μ̃/γ̃",
        "appendix C",
        "one curve",
        f"within {spread.largest:.2%}",
        spread.largest,
        spread.largest < 0.02,
        ENGINE,
        SIMULATED,
    )
    ratio = DEFAULTS["edge_stiffness"] / DEFAULTS["line_tension"]
    yield judged(
        "k̃_l/γ̃",
        "sec. 3.4",
        "< 0.05",
        f"{ratio:.3g}",
        ratio,
        ratio < 0.05,
        "default preset",
        note="a choice; at break-up the springs pull several times as hard as line tension",
    )


def _breakup_number(study: Study) -> Iterator[Number]:
    alpha, beta = PAPER_EXPERIMENT_LINE
    place, prefactor = "eq. (Bkequation)", alpha ** (1 / beta)
    yield plain("prefactor of Bk", place, "28", 28.0, prefactor, "α^(1/β)", factor=1.05)
    note = "from its definition; the abstract has +4/3"
    shown = f"{-1 / beta:.3f}"
    yield misprint("exponent of S in Bk", place, "−4/3", shown, -1 / beta, "−1/β", note)
    yield plain(
        "growth of P from 5 to 95 %, factor in Bk",
        "sec. 4.2",
        "≈ 2",
        2.0,
        transition_factor(the_paper.WIDTH),
        "from w = 0.098",
        factor=1.25,
    )
    used = study.collisions.table[study.collisions.table["symmetry"] > 0]
    number = study.law.fit.breakup_number(used)
    decades = float(np.log10(number.max() / number.min()))
    yield judged(
        "orders of magnitude of Bk",
        "sec. 4.2",
        "6",
        f"{decades:.1f}",
        decades,
        decades > 5.5,
        data_name(study),
        _kind_of_data(study),
    )


def _geometry(study: Study) -> Iterator[Number]:
    heights = np.array([1e-3, 1.01e-3])  # h/D of two droplets that share one h
    areas = np.pi / 4 / heights**2
    symmetries = 2 * segment_area(1.0, 1 / heights) / areas
    slope = float(np.diff(np.log(symmetries))[0] / np.diff(np.log(areas))[0])
    name, how, known = "β of one height h ≪ D0", "circular segments", SMALL_SEGMENT_EXPONENT
    yield plain(name, "sec. 4.2", "−3/4", known, slope, how, factor=1.002)
    ratio = 4 ** (1 + PAPER_EXPERIMENT_LINE.beta)
    yield plain(
        "A_small of twice the radius", "fig. 6", "1.4", 1.4, ratio, "4^(1 + β)", factor=1.05
    )
    number = paper_breakup_number(0.02, 1.0)
    yield misprint(
        "Bk of A = 0.02 mm² at 1.0 mm/s",
        "fig. 6",
        "1",
        f"{number:.2g} at most",
        number,
        "its definition",
        "head-on, standard conditions; A = 0.2 mm² has Bk = 1 at S = 0.62",
    )


def _necks(_: Study) -> Iterator[Number]:
    neck = DEFAULTS["neck_thickness"] * the_paper.MEDIAN_DIAMETER_UM
    yield plain(
        "d_min-neck", "sec. 4.4", "80.3 µm", 80.3, neck, "0.167 D0", unit=" µm", factor=1.001
    )
    for name, paper in (
        ("median diameter of droplets that broke", "481 µm"),
        ("thickest neck one frame before a break-up", "≈ 70 µm"),
        ("thinnest neck of droplets that did not break", "≈ 140 µm"),
        ("uncertainty of S", "± 0.088"),
    ):
        yield Number(name, "sec. 4", paper, "", "", "", NEEDS_DATA, "")


def _daughters(study: Study) -> Iterator[Number]:
    broke = study.simulated[study.simulated["broke"].astype(bool)]
    below = broke["daughter_area_ratio"] <= area_ratio_bound(broke["symmetry"]) + 1e-9
    share = float(below.mean())
    name, shown = "simulated A1/A2 below S/(2 − S)", f"{share:.1%} of {len(broke)}"
    yield judged(name, "sec. 4.3", "all", shown, share, share == 1.0, ENGINE, SIMULATED)


def _scales(_: Study) -> Iterator[Number]:
    viscosity = [cst * 1e-6 * the_paper.OIL_DENSITY_KG_M3 * 1e3 for cst in _OIL_CST]
    yield misprint(
        "viscosity of the oils",
        "sec. 2",
        "480, 960 Pa s",
        f"{viscosity[0]:g}, {viscosity[1]:g} mPa s",
        viscosity[0],
        "50 and 100 cSt at 960 kg/m³",
    )
    tension = the_paper.SURFACE_TENSION_MN_M
    ca = capillary_number(viscosity, the_paper.SPEEDS_MM_S, tension)
    yield ordered("Ca", "sec. 3.4", "O(10⁻³)", 1e-3, ca, factor=10)
    reynolds = reynolds_number(
        the_paper.OIL_DENSITY_KG_M3,
        max(the_paper.SPEEDS_MM_S),
        max(the_paper.OBSTACLE_RADII_UM),
        the_paper.VISCOSITY_MPA_S,
    )
    shown = f"≤ {numeral(reynolds, '.1e')}"
    yield judged("Re", "sec. 2", "≤ O(10⁻²)", shown, reynolds, reynolds < 1e-1, "ρ v R/μ")
    film = ca ** (2 / 3)
    yield ordered("δ/z = Ca^(2/3)", "sec. 3.4", "O(10⁻²)", 1e-2, film, factor=5)
    typical = float(capillary_number(the_paper.VISCOSITY_MPA_S, 1.0, tension)) ** (2 / 3)
    wide = (typical * the_paper.OBSTACLE_RADIUS_UM / the_paper.MEDIAN_DIAMETER_UM) ** 2
    yield judged(
        "Ca/Ca_eff = (δ/D0)²",
        "sec. 3.4",
        "O(10⁻⁴)",
        numeral(typical**2, ".1e"),
        typical**2,
        1e-5 < typical**2 < 1e-3,
        "1 mm/s, D0 = z",
        note=f"{numeral(wide, '.1e')} with D0 = 481 µm; the paper takes both to be of one order",
    )


def data_name(study: Study) -> str:
    """Say which collisions the law is fitted to."""
    return "your collisions" if study.experiment is not None else "synthetic data"


def _kind_of_data(study: Study) -> Kind:
    """Return the kind of a number that rests on the law's collisions."""
    return MEASURED if study.measured else RECOVERED
