"""The page of a fitted law: its numbers, other laws, figures, and the rows set aside."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pinchoff.collisions.law import transition_factor
from pinchoff.explorer.page import LINK, NO_PAGE
from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.constant_height import constant_height
from pinchoff.figures.daughters import daughter_areas
from pinchoff.figures.html_page import Page
from pinchoff.figures.neck_histograms import neck_histograms
from pinchoff.figures.phase_diagram import separated_outcomes
from pinchoff.fits.form import MEANINGS, SYMBOLS
from pinchoff.fits.intervals import BOOTSTRAP, DELTA, PROFILE
from pinchoff.studies.necks import median_history
from pinchoff.support import paper_constants as paper
from pinchoff.support.numerals import counted, numeral

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pinchoff.figures.html_page import Picture
    from pinchoff.fits.law_study import LawStudy
    from pinchoff.support.interval import Estimate

PAPER = {
    **{
        key: f"{numeral(value, 'g')} ± {error}"
        for key, (value, error) in paper.EXPERIMENT_FIT.items()
    },
    "epsilon_1": "1",
    "epsilon_2": "−3",
    "epsilon_3": "1",
    "epsilon_mu": "1",
    "epsilon_gamma": "1",
    "epsilon_v": "1",
    "dimension": "0",
}
"""What the paper finds in its experiments."""

MOST_SET_ASIDE = 200
"""Rows that the page lists one by one."""


def signed_number(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits; large ones in full.

    Examples
    --------
    >>> signed_number(-0.73894), signed_number(123456.7)
    ('−0.7389', '123,457')
    """
    return numeral(value, ",.0f" if 10**digits <= abs(value) < 1e9 else f".{digits}g")


def interval(estimate: Estimate) -> str:
    """Write an interval."""
    return f"{signed_number(estimate.low)} to {signed_number(estimate.high)}"


def law_rows(study: LawStudy) -> Iterator[tuple[str, ...]]:
    """Return a row for each number: symbol, meaning, value, intervals, spread, the paper's.

    The columns are those of `law_columns`.
    """
    for name, estimate in study.estimates.items():
        several = [
            interval(study.intervals[method][name]) if method in study.intervals else "—"
            for method in (PROFILE, DELTA, BOOTSTRAP)
        ]
        spread = f"± {signed_number(study.spread[name], 2)}" if name in study.spread else "—"
        value = signed_number(estimate.value)
        yield SYMBOLS[name], MEANINGS[name], value, *several, spread, PAPER[name]


def law_columns(study: LawStudy) -> tuple[str, ...]:
    """Return the headings of `law_rows`."""
    confidence = f"{study.fit.confidence:.0%}"
    return (
        "",
        "",
        "value",
        f"{confidence}, profile likelihood",
        f"{confidence}, delta method",
        f"{confidence}, bootstrap",
        "spread of the bootstrap's parts",
        "paper",
    )


def law_figures(study: LawStudy) -> dict[str, tuple[Axes, str]]:
    """Draw the figures for which the table has the data: axes and caption, by name."""
    table, fit = study.collisions.table, study.fit
    drawn = {
        "separated_outcomes": (
            separated_outcomes(table, fit)[0],
            "S against Ca Ã z̃ of collisions that broke, of all, and of those that did not, with "
            "the fitted separating line and that of the paper's experiments.",
        ),
        "breakup_probability": (
            breakup_probability(table, fit),
            "Share of collisions that broke against the breakup number, with binomial intervals; "
            "the fitted law and a step.",
        ),
    }
    if (table["daughter_area_ratio"].notna() & table["broke"]).any():
        caption = (
            "Ratio of the daughters' areas against S. Dotted: S/(2 − S), without exchange between "
            "the two sides."
        )
        drawn["daughter_areas"] = (daughter_areas(table), caption)
    if table[["neck_um", "neck_thickness"]].notna().any(axis=None):
        caption = (
            "Thinnest necks. Right: what cameras see in the last frame before the break-up of the "
            "median droplet, simulated to 0.167 D0 and then thinning to nothing at 4.2 mm/s, the "
            "slowest that the paper's frames allow (an assumption)."
        )
        drawn["neck_histograms"] = (neck_histograms(table, median_history())[0], caption)
    drawn["constant_height"] = (
        constant_height(fit)[0],
        "Left: two droplets on the separating line, one twice as wide as the other; their smaller "
        "parts are nearly as high. Right: the exponent that one height gives.",
    )
    return drawn


def law_page(
    study: LawStudy, source: str, figures: list[tuple[Picture, str]], explorer: str = ""
) -> Page:
    """Return the page.

    Parameters
    ----------
    study : LawStudy
    source : str
        What the table is called.
    figures : list of (picture, caption)
    explorer : str, optional
        Name of the page beside it in which the collisions can be explored; empty: there is none.
    """
    fit = study.fit
    notice = (
        "These collisions are synthetic: they were drawn, not measured." if fit.synthetic else ""
    )
    summary = (
        f"{source}: {counted(fit.count, 'collision')}, {fit.broke_count:,} of which broke. "
        "On the separating line $S = α (Ca Ã z̃)^β$ the breakup number Bk is 1."
    )
    page = Page("The break-up law", summary, notice)
    if explorer:
        page.link(LINK, explorer)
    else:
        page.paragraph(NO_PAGE)
    for line in ("P = x/(1 + x)", "x = Bk^(1/w)", "Bk = Ca Ã z̃ (S/α)^(−1/β)"):
        page.formula(line)
    page.section("Numbers")
    page.table(law_columns(study), law_rows(study))
    for text in _remarks(study):
        page.paragraph(text)
    page.section("Figures")
    for picture, caption in figures:
        page.figure(picture, caption)
    page.section("What the data need")
    _compare(page, study)
    page.section("Rows that were set aside")
    _list_set_aside(page, study)
    return page


def _remarks(study: LawStudy) -> Iterator[str]:
    fit, w = study.fit, study.estimates["w"]
    if fit.step:
        factor = transition_factor(w.high)
        yield (
            f"w = 0: {fit.step}. The likelihood then has no maximum, and neither the delta method "
            "nor the bootstrap applies. α and β are those of the line in the middle of the widest "
            f"gap; the interval of w is an upper bound, with which the probability would grow from "
            f"5 to 95 % within a factor {factor:.3g} in Bk."
        )
    else:
        yield (
            "The probability of break-up grows from 5 to 95 % within a factor "
            f"{transition_factor(w.value):.2f} in Bk; the paper says about 2, and its w gives 1.78."
        )
        yield (
            f"Bootstrap: {study.samples} parts, each {study.fraction:.0%} of the collisions, drawn "
            f"without replacement (seed {study.seed})."
        )
    if fit.symmetry_noise:
        yield f"The fit accounts for a standard error of {fit.symmetry_noise:g} in S."
    if fit.free:
        yield (
            "Exponents: $Bk ∝ μ^ε_μ v^ε_v γ^(−ε_γ) A^ε_1 R^ε_2 z^ε_3$ with "
            "$2ε_1 + ε_2 + ε_3 = 0$; those not listed are 1, and $ε_2 = −3$. "
            "μ, v and γ are relative to 48 mPa s, 1 mm/s, 20 mN/m."
        )


def _compare(page: Page, study: LawStudy) -> None:
    if study.comparison is None:
        page.paragraph(f"No comparison: {study.missing['comparison']}")
        return
    page.table(
        ("law", "claim", "parameters", "ln L", "ΔAIC", "likelihood ratio", "degrees", "p"),
        [
            (
                row["law"],
                row["claim"],
                row["parameters"],
                signed_number(row["log_likelihood"], 6),
                signed_number(row["delta_aic"], 3),
                signed_number(row["likelihood_ratio"], 3),
                row["freedom"] or "",
                _p_value(row["p_value"]),
            )
            for row in study.comparison.to_dict("records")
        ],
    )
    page.paragraph(
        "Each law is the full one with some numbers fixed. A small p speaks against the claim; the "
        "smallest AIC, ΔAIC = 0, is the law that predicts best for its number of parameters."
    )


def _p_value(value: float) -> str:
    if math.isnan(value):
        return ""
    return numeral(value, ".2g") if value > 1e-300 else "< 10⁻³⁰⁰"


def _list_set_aside(page: Page, study: LawStudy) -> None:
    rows, left_out = study.collisions.set_aside, study.fit.left_out
    for message in study.collisions.messages():
        page.paragraph(f"{message}.")
    for reason, count in left_out.items():
        page.paragraph(f"{count:,} rows of the table are not used in the fit: {reason}.")
    if rows.empty:
        if not left_out:
            page.paragraph("None.")
        return
    shown = rows.head(MOST_SET_ASIDE)
    more = f"the first {MOST_SET_ASIDE} of {len(rows):,}" if len(rows) > len(shown) else ""
    page.table(("row", "column", "value", "reason"), shown.itertuples(index=False), more)
