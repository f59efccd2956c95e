"""The page about droplets that were sent through an array."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np

from pinchoff.figures import emulsion_figures as figures
from pinchoff.figures.html_page import Page
from pinchoff.model.emulsion_result import RETIRED_WARNING
from pinchoff.studies.block_errors import Measured
from pinchoff.studies.lineage import lineage
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.chamber.emulsion_trust import Trust
    from pinchoff.model.emulsion_result import Emulsion
    from pinchoff.model.emulsion_scene import Coalescence
    from pinchoff.studies.emulsion_sizes import SizeStudy

_COLORS: dict[Literal["generation", "size"], str] = {
    "generation": "the break-ups in a droplet's ancestry",
    "size": "size",
}
_RETIRED = 20  # droplets in the table of those that guards took out
EXPLORE = "Explore these contacts: filter them, and simulate each on a pillar alone"
"""What leads to the page of the live model."""

_STEADY = {
    True: "Steady: gains and losses balance within 2σ, and the mean area has no trend.",
    False: "Not steady: droplets are gained or lost, or the mean area has a trend.",
    None: "Whether sizes are steady cannot be told from this run.",
}


def emulsion_page(
    design: EmulsionDesign,
    run: Emulsion,
    study: SizeStudy,
    trust: Trust | None,
    contacts: pd.DataFrame,
    isolated: pd.DataFrame | None,
    links: Mapping[str, str],
) -> Page:
    """Return the page.

    There is no `trust` where outlines were not kept, and no `isolated`, of `isolated_pillar`,
    where this run has no such line. `contacts` are those of `contact_outcomes`; `links` has names
    of files beside the page, by what is said of each.
    """
    counts = run.balance
    merges = f"{counts['merges']:.0f} merges, " if design.coalescence else ""
    page = Page(
        "Droplets through an array of pillars",
        f"{counts['start'] + counts['entered']:.0f} droplets in {run.time:.4g} t0: "
        f"{counts['breakups']:.0f} break-ups, {merges}"
        f"{counts['present']:.0f} droplets present. "
        f"{_STEADY[study.steady]}",
        _ending(design, run, study),
    )
    for label, name in links.items():
        page.link(label, name)
    events, array = run.events, design.array
    page.section("The array")
    for last in deque(run.outline_pieces(), maxlen=1):
        droplets, time = last[-1], float(last.times[-1])
        for color, label in _COLORS.items():
            axes = figures.droplets_in_array(droplets, array, time, color, design.periodic)
            page.figure(axes, f"The last frame, coloured by {label}.")
    page.facts(_settings(design, run))
    page.section("Sizes")
    _tell_sizes(page, design, run, study)
    page.section("Rates")
    _tell_rates(page, events, study, merging=design.coalescence is not None)
    if design.coalescence is not None:
        _tell_merging(page, events, design.coalescence, counts)
    page.section("Contacts and the break-up law")
    _tell_contacts(page, contacts, isolated)
    page.section("Lineage")
    _tell_lineage(page, events, run.time)
    page.section("How far this can be trusted")
    _tell_trust(page, trust, run, study.start)
    return page


def _ending(design: EmulsionDesign, run: Emulsion, study: SizeStudy) -> str:
    """Say what a reader has to know first: what guards did, and what was not measured, and why."""
    told = []
    if run.stopped or run.retired_share > RETIRED_WARNING:
        report = run.guard_report
        told.append(f"{report[0].upper()}{report[1:]}.")
    if run.stopped:
        told.append(f"It was to take {design.time:.4g} t0; what follows was measured up to there.")
    return " ".join(told + study.remarks)


def _tell_sizes(page: Page, design: EmulsionDesign, run: Emulsion, study: SizeStudy) -> None:
    if len(study.series) > 1:
        page.figure(
            figures.sizes_over_time(run.sizes, study),
            "Shares of the area by diameter against time. Means are taken from the dots on.",
        )
    else:
        page.paragraph("Not drawn against time, because fewer than two frames have droplets.")
    if not math.isnan(study.mean_diameter.value):
        errors = "" if math.isnan(study.mean_diameter.error) else ", standard errors"
        page.figure(figures.size_distribution(study), f"Distribution of diameters{errors}.")
    page.facts(_sizes(design, study))


def _tell_rates(page: Page, events: pd.DataFrame, study: SizeStudy, *, merging: bool) -> None:
    if figures.rated_events(events).any():
        page.figure(figures.rates_over_time(events, study), "What happens per t0.")
    else:
        page.paragraph("Not drawn, because no droplet came in, broke, merged or left.")
    rates = {f"{k} (1/t0)": v for k, v in study.rates.items() if v.value > 0 or k == "breakup"}
    balance = {"growth (1/t0)": study.growth}
    if merging:
        balance["merges per break-up"] = study.exchange
    page.facts({**rates, **balance})


def _tell_lineage(page: Page, events: pd.DataFrame, end: float) -> None:
    family = lineage(events)
    if not len(family):
        page.paragraph("Not drawn, because no droplet came in, broke, merged or left.")
        return
    page.figure(
        figures.lineage_tree(family, end),
        "The largest family, up to its first 60 droplets. A merged droplet goes on in the line of "
        "the larger of the two; dotted: the smaller one joins it. Arrows: it left.",
    )


def _tell_merging(
    page: Page, events: pd.DataFrame, how: Coalescence, counts: dict[str, float]
) -> None:
    page.section("Contacts of droplets, and merging")
    page.paragraph(
        f"Films drain with K = {how.drainage:g}, which is fitted and not predicted; pairs that "
        f"part merge at C ≥ {1 - how.separation:g}"
        + (" times a random number of mean 1." if how.stochastic else ".")
    )
    page.figure(
        figures.pair_contacts(events),
        "How long droplets were in contact, and the clock C of their film at the end, for those "
        "that merged and those that parted.",
    )
    ended = events[events["kind"].isin(("parted", "merge"))]
    lasted, otherwise = ended["time"] - ended["since"], "no contact ended"
    median = ended.assign(lasted=lasted)[["lasted", "facing_length"]].median()
    refused = events["reason"][events["kind"] == "unmerged"].astype(str)
    closing = int(refused.str.startswith("the obstacle").sum())
    page.facts(
        {
            "contacts of two droplets": f"{counts['touches']:.0f}",
            "of these merged": int((ended["kind"] == "merge").sum()),
            "merges refused, as the droplet would close round a pillar": closing,
            "merges refused, as it would cross itself": len(refused) - closing,
            "duration of a contact, median (t0)": _found(median["lasted"], otherwise),
            "facing length L at most, median (D0)": _found(median["facing_length"], otherwise),
        }
    )


def sweep_page(table: pd.DataFrame, varied: Sequence[str], page_name: str) -> Page:
    """Return the page of several runs.

    The table has a row a run, of `summary_row`; `varied` are those of its columns that were
    varied, and `page_name` is that of the page in each run's folder.
    """
    page = Page(
        "Droplets through arrays of pillars",
        f"{counted(len(table), 'run')}, varied: {', '.join(varied)}.",
    )
    page.figure(
        figures.sizes_over_sweep(table, varied),
        "Mean diameters against what was varied, standard errors where a run is long enough.",
    )
    measured = ("mean_diameter", "weighted_diameter", "breakup_rate", "steady", "retired_share")
    shown = ["folder", *varied, *measured]
    rows = table[shown].map(lambda v: f"{v:.4g}" if isinstance(v, float) else str(v))
    page.table(shown, rows.to_numpy().tolist(), "Lengths in D0, rates in 1/t0, shares of the area")
    for folder in table["folder"]:
        page.link(f"The page of {folder}", f"{folder}/{page_name}")
    return page


def _settings(design: EmulsionDesign, run: Emulsion) -> dict[str, object]:
    """Return what was run, for a reader who sees the page alone."""
    array, p = design.array, run.parameters
    facts: dict[str, object] = {
        "pillars": len(array.circles),
        "share of fluid in the cell": f"{array.porosity:.3f}",
        "narrowest gap (D0)": f"{array.least_gap:.3g}",
        "R (D0)": f"{float(np.median(array.circles[:, 2])):.3g}",
        "z (D0)": f"{design.thickness:.3g}",
        "Ca_sim": f"{p.simulation_capillary_number:.4g}",
        "vertices of a droplet of 1 D0": p.vertex_count,
        "space repeats itself along": " and ".join(design.periodic),
    }
    if design.inlet is not None:
        facts["area fraction at the inlet"] = design.inlet.area_fraction
    if p.scale is not None:
        milliseconds = 1e3 * p.scale.time_unit_s
        facts |= {
            "D0 (µm)": f"{p.scale.diameter_um:.4g}",
            "v_f∞ (mm/s)": f"{p.scale.speed_mm_s:.4g}",
            "t0 (ms)": f"{milliseconds:.4g}",
        }
    return facts


def _sizes(design: EmulsionDesign, study: SizeStudy) -> dict[str, object]:
    facts: dict[str, object] = {
        "mean diameter (D0)": study.mean_diameter,
        "the same, weighted by area": study.weighted_diameter,
        "mean area (D0²)": study.mean_area,
        "<A²>/<A>²": study.dispersity,
        "correlation time (t0)": _found(study.correlation_time, "not measured"),
        "blocks that errors come from": (
            "too few" if math.isnan(study.mean_area.error) else study.blocks
        ),
        "residence time (t0)": _found(study.residence_time, "not measured"),
        "trend of the mean area, share": study.trend,
    }
    scale = design.parameters.scale
    if scale is not None:
        value, error = (scale.diameter_um * number for number in study.mean_diameter)
        facts["mean diameter (µm)"] = Measured(value, error)
    return facts


def _found(value: float, otherwise: str = "none found") -> str:
    return otherwise if math.isnan(value) else f"{value:.3g}"


def _tell_contacts(page: Page, contacts: pd.DataFrame, isolated: pd.DataFrame | None) -> None:
    law = (
        "Share of the first contacts of a droplet with a pillar that broke it, against Bk of the "
        "droplet's area and speed at contact. The line is the law of isolated collisions, with the "
        "separating line of the paper's simulations and w of its experiments"
    )
    if not len(contacts):
        page.paragraph("Not drawn, because no droplet met a pillar.")
        return
    if not contacts["settled"].any():
        seen = counted(len(contacts), "contact")
        page.paragraph(
            f"Not drawn, because none of {seen} with a pillar was settled when the run ended."
        )
        return
    if isolated is None:
        page.figure(figures.contact_breakups(contacts), f"{law}.")
    else:
        law += (
            "; on the right Bk is divided by that at which a droplet of the same diameter breaks "
            "on a pillar that stands alone in the same flow."
        )
        page.figure(figures.contact_breakups(contacts, isolated), law)
        page.table(
            ("diameter (D0)", "S_c alone", "speed at contact (v_f∞)", "Bk there"),
            isolated.map(_found).to_numpy().tolist(),
            "A pillar alone in this flow",
        )
        page.paragraph(
            "The paper's line holds for plane Stokes flow and D0/R near 5.66. Where the left panel "
            "differs from it and the right one does not, the flow and the size are the cause, not "
            "the neighbours."
        )
    page.paragraph(
        f"{counted(int((~contacts['settled']).sum()), 'contact')} not settled when the run ended."
    )


def _tell_trust(page: Page, trust: Trust | None, run: Emulsion, begin: float) -> None:
    if trust is None:
        page.paragraph("Slip and blocked gaps were not measured, because outlines = false.")
    elif not trust.frames:
        page.paragraph(
            f"Slip and blocked gaps were not measured, because no frame from t = {begin:.4g} t0 on "
            "has a droplet."
        )
    else:
        page.facts(
            {
                "slip |v_droplet − v_flow|, mean (v_f∞)": f"{trust.slip:.3g}",
                "95 % slip less than": f"{trust.slip_95:.3g}",
                "held droplets, share": f"{trust.held:.3g}",
                "blocked gaps, share": f"{trust.blocked:.3g}",
                "largest island of touching droplets": trust.largest_island,
                "frames looked at": trust.frames,
            }
        )
        page.paragraph(trust.verdict())
    _tell_retired(page, run)
    page.paragraph(
        "Droplets do not disturb the flow. Few break in an open "
        "lattice, because they thread the gaps. Droplets below smallest_breaking do not break, "
        "which cuts off the lower tail of the distribution."
    )


def _tell_retired(page: Page, run: Emulsion) -> None:
    gone = run.retired
    if not len(gone):
        page.paragraph("Guards took out no droplet.")
        return
    shown = gone.head(_RETIRED)
    more = f"; the first {_RETIRED}" if len(gone) > _RETIRED else ""
    rows = [
        [
            row["droplet_id"],
            f"{row['time']:.4g}",
            f"{row['x']:.3g}, {row['y']:.3g}",
            f"{row['diameter']:.3g}",
            f"{100 * row['share']:.2g} %",
            row["reason"],
        ]
        for row in shown.to_dict("records")
    ]
    page.table(
        ("droplet", "time (t0)", "x, y (D0)", "diameter (D0)", "share of all area", "why"),
        rows,
        f"Guards took out {counted(len(gone), 'droplet')} with {100 * run.retired_share:.2g} % of "
        f"all area{more}",
    )
