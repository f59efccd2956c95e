"""The page of a reproduction: verdicts on every number, and every figure."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from pinchoff.figures.html_page import Detailed, Mark, Page
from pinchoff.paper.verdicts import KINDS, TONES, how_many

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pinchoff.paper.make import Reproduction
    from pinchoff.paper.verdicts import Number, Verdict

COLUMNS = ("", "paper", "ours, with 95 % interval or range", "verdict", "where and how")
FRONT_COLUMNS = ("front tracking", "verdict")
"""Columns between verdict and source where front tracking stands beside."""


def verdicts(made: Reproduction) -> list[str]:
    """Say how many numbers there are of each kind, and what came of them, a line for each kind."""
    lines = []
    for kind in KINDS:
        of_kind = [number for number in made.numbers if number.kind == kind]
        if of_kind:
            parts = [_counted(number.verdict for number in of_kind)]
            fronts = _counted(number.front_verdict for number in of_kind)
            if fronts:
                parts.append(f"with front tracking {fronts}")
            lines.append(": ".join(filter(None, (how_many(len(of_kind), kind), "; ".join(parts)))))
    return lines


def _counted(said: Iterable[Verdict]) -> str:
    counts = Counter(verdict for verdict in said if verdict)
    return ", ".join(how_many(count, verdict) for verdict, count in counts.items())


def _mark(verdict: Verdict) -> Mark | str:
    tone = TONES.get(verdict)
    return Mark(verdict, tone) if tone else verdict


def _row(number: Number, beside: bool) -> tuple[Mark | Detailed | str, ...]:
    ours = (Detailed(number.ours, number.interval), _mark(number.verdict))
    front = (Detailed(number.front, number.front_interval), _mark(number.front_verdict))
    return (number.name, number.paper, *ours, *(front if beside else ()), _sources(number))


def _sources(number: Number) -> str:
    return "; ".join(filter(None, (number.place, number.how, number.note)))


def reproduction_page(made: Reproduction) -> Page:
    """Return the page."""
    synthetic = made.settings["experiment"] is None
    notice = (
        "There are no real collisions in this reproduction: what the paper measured is replaced by "
        "synthetic collisions, drawn from the paper's own law under its conditions. Where they are "
        "used, it is said; that a number is recovered there shows that the analysis works, not "
        "that the experiment was repeated."
        if synthetic
        else ""
    )
    summary = (
        "Figures and numbers of “Droplet Breakup Against an Isolated Obstacle” (Meer, Sista, "
        "Shattuck, O'Hern and Weeks, Soft Matter 2026, doi 10.1039/D5SM01266J), remade."
    )
    page = Page("The paper, remade", summary, notice)
    if made.numbers:
        page.section("Numbers")
        page.paragraph(f"{'. '.join(verdicts(made))}.")
    for kind, meaning in KINDS.items():
        of_kind = [number for number in made.numbers if number.kind == kind]
        if of_kind:
            page.section(f"Numbers: {kind}")
            page.paragraph(f"{meaning[0].upper()}{meaning[1:]}.")
            beside = any(number.front for number in of_kind)
            columns = (*COLUMNS[:-1], *(FRONT_COLUMNS if beside else ()), COLUMNS[-1])
            page.table(columns, [_row(number, beside) for number in of_kind])
    for figure in made.figures:
        page.section(f"Figure {figure.figure.name}: {figure.figure.title}")
        page.figure(figure.png, figure.figure.caption)
        page.paragraph(f"From: {figure.how}. For papers: {figure.pdf.name}.")
    if made.left_out:
        page.section("Figures that were left out")
        page.facts({f"Figure {name}": reason for name, reason in made.left_out.items()})
    page.section("Provenance")
    settings = made.settings
    page.facts(
        {
            "version": settings["pinchoff_version"],
            "seed": settings["seed"],
            "simulations": "quick: fewer and coarser, front tracking with half of its vertices"
            if settings["quick"]
            else "full",
            "experiment": "synthetic" if synthetic else f"sha256 {settings['experiment'][:16]}…",
            "time": f"{made.seconds:.0f} s",
            "constants": "preset default, unless a caption says otherwise; for front tracking the "
            "preset of that name",
        }
    )
    return page
