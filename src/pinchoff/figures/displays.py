"""How each result shows itself: its figure, and its page in a notebook (see `support.drawing`)."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable
from html import escape
from typing import TYPE_CHECKING, Any

from pinchoff.figures import style
from pinchoff.figures.breakup_probability import breakup_probability
from pinchoff.figures.calibrated_line import calibrated_line
from pinchoff.figures.movie import animate
from pinchoff.figures.phase_diagram import phase_diagram, separated_outcomes, separating_line
from pinchoff.figures.snapshots import snapshot_strip
from pinchoff.figures.video_histograms import histograms
from pinchoff.fits.form import SYMBOLS
from pinchoff.model.outlines import TIME_UNITS
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pinchoff.collisions.importing import ImportedCollisions
    from pinchoff.fits import LawFit
    from pinchoff.model.outlines import Outlines
    from pinchoff.model.results import Collision
    from pinchoff.studies.boundary import Boundary
    from pinchoff.studies.calibration import Calibration
    from pinchoff.video.batch import VideoResult

__all__ = ["animate", "html", "plot"]

_PAGE_DOTS_PER_INCH = 96
_MOST_LINES = 12  # of a page

Facts = list[tuple[str, str]]


def plot(result: Any, axes: Any = None, **options: Any) -> Any:
    """Draw a result with the figure of its kind."""
    return _SHOWN[type(result).__name__][0](result, axes=axes, **options)


def html(result: Any) -> str:
    """Return what a notebook shows of a result: its name, numbers and a small picture."""
    _, facts = _SHOWN[type(result).__name__]
    rows = "".join(
        f"<tr><td style='text-align:left'>{escape(name)}</td>"
        f"<td style='text-align:left'>{escape(value)}</td></tr>"
        for name, value in facts(result)
    )
    title = escape(type(result).__name__)
    return f"<div><b>{title}</b><table>{rows}</table>{_picture(result)}</div>"


def _picture(result: Any) -> str:
    """Return the result's figure as part of a page, or why it has none."""
    try:
        with style.off_screen():
            drawn = plot(result)
    except InputError as error:
        return f"<p>no picture: {escape(str(error))}</p>"
    first: Axes = drawn[0] if isinstance(drawn, list) else drawn
    encoded = base64.b64encode(style.png(first, _PAGE_DOTS_PER_INCH)).decode()
    return f"<img src='data:image/png;base64,{encoded}'>"


def _plot_collision(collision: Collision, axes: Any, **options: Any) -> list[Axes]:
    return snapshot_strip(collision.recorded(), axes=axes, **options)


def _plot_fit(fit: LawFit, axes: Any, kind: str = "probability") -> Axes | list[Axes]:
    kinds = {"probability": breakup_probability, "outcomes": separated_outcomes}
    if kind not in kinds:
        raise InputError.of("kind", "'probability' or 'outcomes'", kind, "choose one of them")
    draw: Any = kinds[kind]
    drawn: Axes | list[Axes] = draw(fit.used, fit, axes)
    return drawn


def _plot_boundary(boundary: Boundary, axes: Any) -> Axes:
    try:
        fit = boundary.fit()
    except InputError:  # too few points for a line: the runs are shown without one
        fit = None
    return separating_line(boundary, fit, axes)


def _plot_videos(videos: VideoResult, axes: Any) -> list[Axes]:
    if axes is not None:
        rule, advice = "left out: four histograms have a figure of their own", "leave it out"
        raise InputError.of("axes", rule, axes, advice)
    if not videos.collisions["accepted"].any():
        raise InputError.of("videos", "with accepted collisions", "none", "see reject_reason")
    return histograms(videos.collisions)


def _facts_of_collision(collision: Collision) -> Facts:
    found = [("outcome", collision.outcome)]
    if math.isfinite(collision.contact_time):
        found.append(("symmetry S at first contact", f"{collision.symmetry:.3g}"))
    else:
        found.append(("contact", "none"))
    units = collision.parameters.scale is not None
    moments = (
        ("first contact", collision.contact_time, "t0", "contact_time_s", "s"),
        ("speed at first contact", collision.contact_speed, "v_f∞", "contact_speed_mm_s", "mm/s"),
        ("thinnest neck", collision.minimum_neck, "D0", "minimum_neck_um", "µm"),
        ("first break-up", collision.breakup_time, "t0", "breakup_time_s", "s"),
    )
    laboratory = collision.in_units() if units else {}
    for name, value, unit, key, physical in moments:
        if math.isfinite(value):
            also = f" = {laboratory[key]:.4g} {physical}" if units else ""
            found.append((name, f"{value:.4g} {unit}{also}"))
    if collision.broke:
        found.append(("daughters' areas", f"1 : {1 / collision.daughter_area_ratio:.3g}"))
    return [*found, ("droplets at the end", str(collision.droplet_count))]


def _facts_of_outlines(outlines: Outlines) -> Facts:
    if not len(outlines):
        return [("frames", "0")]
    first, last = outlines.times[0], outlines.times[-1]
    return [
        ("frames", f"{len(outlines)}"),
        ("times", f"{first:.4g} to {last:.4g} {TIME_UNITS[outlines.units]}"),
        ("droplets", f"{len(set(outlines.droplet_id.tolist()))}"),
        ("obstacles", f"{len(outlines.obstacles)}"),
    ]


def _facts_of_fit(fit: LawFit) -> Facts:
    return [
        ("law", "P = x/(1 + x), x = Bk^(1/w), Bk = Ca Ã z̃ (S/α)^(-1/β)"),
        *((SYMBOLS[name], f"{estimate}") for name, estimate in fit.estimates.items()),
        ("intervals", f"{fit.confidence:.0%}"),
        ("collisions", f"{fit.count}, of which {fit.broke_count} broke"),
        *(("left out", f"{count}: {reason}") for reason, count in fit.left_out.items()),
        *([("w = 0", fit.step)] if fit.step else []),
    ]


def _facts_of_boundary(boundary: Boundary) -> Facts:
    counts = boundary.table["status"].value_counts()
    found = [(f"points: {status}", str(count)) for status, count in counts.items()]
    return [
        ("varied", ", ".join(boundary.varied) or "nothing"),
        *found,
        ("runs", f"{len(boundary.runs)}"),
    ]


def _facts_of_calibration(calibration: Calibration) -> Facts:
    best = calibration.best
    return [
        ("target", calibration.target.name),
        *((name, f"{value:.4g}") for name, value in best.changes.items()),
        (
            calibration.target.objective_name,
            f"{best.objective:.4g}, from {calibration.start.objective:.4g}",
        ),
        ("search", "ended by itself" if calibration.converged else "stopped: no evaluations left"),
        *(("at a bound", name) for name in calibration.at_bound),
    ]


def _facts_of_imported(collisions: ImportedCollisions) -> Facts:
    table = collisions.table
    return [
        ("collisions", f"{len(table)}, of which {int(table['broke'].sum())} broke"),
        ("rows of the source", f"{collisions.count}"),
        *_counted("set aside", collisions.reasons()),
    ]


def _facts_of_videos(videos: VideoResult) -> Facts:
    table = videos.collisions
    accepted = table["accepted"].to_numpy(dtype=bool)
    reasons = table.loc[~accepted, "reject_reason"].value_counts()
    return [
        ("folder", f"{videos.path}"),
        ("clips", f"{len(videos.clips)}"),
        *((f"clip {clip.name}", clip.error) for clip in videos.clips if clip.error),
        ("collisions", f"{int(accepted.sum())} accepted of {len(table)}"),
        *_counted("rejected", {str(reason): int(count) for reason, count in reasons.items()}),
    ]


def _counted(name: str, reasons: dict[str, int]) -> Iterable[tuple[str, str]]:
    """Return a line for each reason, the most frequent first, and how many more there are."""
    lines = [(name, f"{count}: {reason}") for reason, count in reasons.items()]
    more = len(lines) - _MOST_LINES
    return [*lines[:_MOST_LINES], *([(name, f"and {more} more reasons")] if more > 0 else [])]


_SHOWN: dict[str, tuple[Callable[..., Any], Callable[[Any], Facts]]] = {
    "Collision": (_plot_collision, _facts_of_collision),
    "Outlines": (snapshot_strip, _facts_of_outlines),
    "LawFit": (_plot_fit, _facts_of_fit),
    "Boundary": (_plot_boundary, _facts_of_boundary),
    "Calibration": (calibrated_line, _facts_of_calibration),
    "ImportedCollisions": (phase_diagram, _facts_of_imported),
    "VideoResult": (_plot_videos, _facts_of_videos),
}
"""Figure and facts of each kind of result, by the name of its class."""
