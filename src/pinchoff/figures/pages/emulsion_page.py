"""The page about droplets that were sent through an array."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING

import numpy as np

from pinchoff.figures import emulsion_figures as figures
from pinchoff.figures.html_page import Page
from pinchoff.studies.emulsion_contacts import contact_outcomes
from pinchoff.studies.emulsion_sizes import lineage

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.emulsion_trust import Trust
    from pinchoff.model.emulsion import Coalescence, Emulsion
    from pinchoff.studies.emulsion_sizes import SizeStudy

_STEADY = {
    True: "Steady: gains and losses balance within 2σ, and the mean area has no trend.",
    False: "Not steady: droplets are gained or lost, or the mean area has a trend.",
    None: "Whether sizes are steady cannot be told from this run.",
}


def emulsion_page(
    design: EmulsionDesign, run: Emulsion, study: SizeStudy, trust: Trust | None
) -> Page:
    """Return the page.

    Parameters
    ----------
    design : EmulsionDesign
    run : Emulsion
    study : SizeStudy
    trust : Trust or None
        None: outlines were not kept.
    """
    counts = run.balance
    page = Page(
        "Droplets through an array of pillars",
        f"{counts['start'] + counts['entered']:.0f} droplets in {run.time:.4g} t0: "
        f"{counts['breakups']:.0f} break-ups, {counts['merges']:.0f} merges, "
        f"{counts['present']:.0f} droplets present. "
        f"{_STEADY[study.steady]}",
    )
    events, array = run.events, design.array
    page.section("The array")
    for last in deque(run.outline_pieces(), maxlen=1):
        for color in ("generation", "size"):
            axes = figures.droplets_in_array(last[-1], array, float(last.times[-1]), color)
            page.figure(axes, f"The last frame, coloured by {color}.")
    page.section("Sizes")
    drawn = figures.sizes_over_time(run.sizes, study)
    page.figure(
        drawn, "Shares of the area by diameter against time. Means are taken from the dots on."
    )
    page.figure(figures.size_distribution(study), "Distribution of diameters, standard errors.")
    page.facts(
        {
            "mean diameter (D0)": study.mean_diameter,
            "the same, weighted by area": study.weighted_diameter,
            "mean area (D0²)": study.mean_area,
            "<A²>/<A>²": study.dispersity,
            "correlation time (t0)": f"{study.correlation_time:.3g}",
            "blocks": study.blocks,
            "residence time (t0)": f"{study.residence_time:.3g}",
            "trend of the mean area, share": study.trend,
        }
    )
    for remark in study.remarks:
        page.paragraph(remark)
    page.section("Rates")
    page.figure(figures.rates_over_time(events, study), "What happens per t0.")
    page.facts(
        {
            **{f"{k} (1/t0)": v for k, v in study.rates.items()},
            "growth": study.growth,
            "merges per break-up": study.exchange,
        }
    )
    if design.coalescence is not None:
        _tell_contacts(page, events, design.coalescence, counts)
    page.section("Contacts and the break-up law")
    width = array.width
    contacts = contact_outcomes(events, array.circles, run.parameters, run.time, width)
    page.figure(
        figures.contact_breakups(contacts),
        "Share of the first contacts of a droplet with a pillar that broke it, against Bk of the "
        "droplet's area and speed at contact; the line is the law of isolated collisions, with the "
        "separating line of the paper's simulations and w of its experiments.",
    )
    page.paragraph(f"{np.sum(~contacts['settled'])} contacts were not settled when the run ended.")
    page.section("Lineage")
    page.figure(
        figures.lineage_tree(lineage(events), run.time),
        "The largest family, up to its first 60 droplets. A merged droplet goes on in the line of "
        "the larger of the two; dotted: the smaller one joins it.",
    )
    page.section("How far this can be trusted")
    _tell_trust(page, trust, run)
    return page


def _tell_contacts(
    page: Page, events: pd.DataFrame, how: Coalescence, counts: dict[str, float]
) -> None:
    page.section("Contacts of droplets, and merging")
    page.paragraph(
        f"Films drain with K = {how.drainage:g}, which is fitted and not predicted; pairs that part "
        f"merge at C ≥ {1 - how.separation:g}"
        + (" times a random number of mean 1." if how.stochastic else ".")
    )
    drawn = figures.pair_contacts(events)
    page.figure(
        drawn,
        "How long droplets were in contact, and the clock C of their film at the end, for those "
        "that merged and those that parted.",
    )
    ended = events[events["kind"].isin(("parted", "merge"))]
    merged = ended[ended["kind"] == "merge"]
    page.facts(
        {
            "contacts of two droplets": f"{counts['touches']:.0f}",
            "of these merged": f"{len(merged)}",
            "merges refused, as the droplet would close round a pillar or cross itself": (
                f"{counts['unmerged']:.0f}"
            ),
            "duration of a contact, median (t0)": _median(ended["time"] - ended["since"]),
            "facing length L at most, median (D0)": _median(ended["facing_length"]),
        }
    )


def _median(values: pd.Series[float]) -> str:
    return f"{values.median():.3g}" if len(values) else "no contact ended"


def _tell_trust(page: Page, trust: Trust | None, run: Emulsion) -> None:
    if trust is None or math.isnan(trust.slip):
        page.paragraph("Not measured: no outlines were kept. Set outlines = true.")
    else:
        page.facts(
            {
                "slip |v_droplet − v_flow|, mean (v_f∞)": f"{trust.slip:.3g}",
                "95 % slip less than": f"{trust.slip_95:.3g}",
                "held droplets, share": f"{trust.held:.3g}",
                "blocked gaps, share": f"{trust.blocked:.3g}",
                "largest island of touching droplets": trust.largest_island,
                "frames looked at": trust.frames,
                "droplets taken out by guards": run.balance["retired"],
            }
        )
        page.paragraph(trust.verdict())
    page.paragraph(
        "Droplets do not disturb the flow. Few break in an open "
        "lattice, because they thread the gaps. Droplets below smallest_breaking do not break, "
        "which cuts off the lower tail of the distribution."
    )
