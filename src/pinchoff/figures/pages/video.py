"""The page about a batch of measured clips."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.figures.contact_sheet import Picture, write_contact_sheet
from pinchoff.figures.page import Page
from pinchoff.figures.video import histograms, timeline
from pinchoff.video import clip_folder

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.video.batch import ClipOutcome, VideoResult

PAGE = "index.html"
SHEET = "contact_sheet.png"

MOST_SHOWN = 300
"""Collisions that the page shows; the sheet has more of them."""


def write_report(result: VideoResult) -> list[Path]:
    """Write the contact sheet and the page about a batch into its folder.

    Returns
    -------
    list of Path
        What was written.
    """
    pictures = _pictures(result)
    sheet = result.path / SHEET
    shown = write_contact_sheet(sheet, pictures)
    table = result.collisions
    accepted = table["accepted"].to_numpy(bool)
    broke = table["broke"].fillna(False).to_numpy(bool)
    page = Page(
        "Droplets that meet obstacles",
        f"{len(table)} collisions in {len(result.clips)} clips: {int(accepted.sum())} accepted, "
        f"of which {int((accepted & broke).sum())} broke.",
    )
    for clip in result.clips:
        if clip.result.get("warning"):
            page.paragraph(f"{clip.name}: {clip.result['warning']}.")
    _clips(page, result.clips, table)
    _rejected(page, table)
    if len(table):
        page.section("What was measured")
        if accepted.any():
            page.figure(histograms(table)[0], "Accepted collisions, broken on unbroken.")
        page.figure(timeline(table), "Contacts in the course of each clip.")
    _ranges(page, table[accepted])
    there = [picture for picture in pictures if picture.path.exists()]
    if there:
        page.section("Every collision")
        page.paragraph(
            "At first contact, and where the collision ends: in the frame with two droplets, or "
            f"one obstacle radius away. {shown} of {len(table)} are on {SHEET}"
            + (f"; the first {MOST_SHOWN} are here." if len(there) > MOST_SHOWN else ".")
        )
        page.gallery((each.path, each.label) for each in there[:MOST_SHOWN])
    page.write(result.path / PAGE)
    return [sheet, result.path / PAGE]


def _pictures(result: VideoResult) -> list[Picture]:
    folders = {each.name: each.folder for each in result.clips}
    return [
        Picture(
            folders[row.clip]
            / clip_folder.THUMBNAILS
            / clip_folder.thumbnail_name(row.contact_frame, row.track_id, row.obstacle_id),
            _label(row.collision_id, row.symmetry, row.speed_mm_s, row.outcome, row.reject_reason),
        )
        for row in _rows(result.collisions)
    ]


def _rows(table: pd.DataFrame) -> Iterator[Any]:
    return table.itertuples()


def _label(number: int, symmetry: float, speed: float, outcome: str, reason: str) -> str:
    end = f"rejected: {reason}" if reason else outcome
    return f"{number}  S = {symmetry:.2f}  v = {speed:.2f} mm/s  {end}"


def _clips(page: Page, clips: list[ClipOutcome], table: pd.DataFrame) -> None:
    page.section("Clips")
    counts = Counter(table["clip"])
    fit = Counter(table["clip"][table["accepted"].to_numpy(bool)])
    rows = []
    for each in clips:
        found = each.result
        numbers: tuple[object, ...] = ("–",) * 7
        if found:
            numbers = (
                _method(found),
                found["frames"],
                f"{found['duration_s']:.1f}",
                len(found["obstacles"]),
                found["tracks"],
                counts[each.name],
                fit[each.name],
            )
        rows.append((each.name, *numbers, each.error or (found.get("warning") or "")))
    heads = (
        "clip",
        "method and scores",
        "frames",
        "time [s]",
        "obstacles",
        "droplets",
        "collisions",
        "accepted",
        "",
    )
    page.table(heads, rows)


def _method(found: dict[str, Any]) -> str:
    scores = ", ".join(f"{name} {score:.2f}" for name, score in found["scores"].items())
    return f"{found['method']} ({scores})"


def _rejected(page: Page, table: pd.DataFrame) -> None:
    reasons = Counter(
        reason for text in table["reject_reason"] if text for reason in text.split("; ")
    )
    if reasons:
        page.section("Rejected collisions")
        page.table(("reason", "collisions"), reasons.most_common())


def _ranges(page: Page, table: pd.DataFrame) -> None:
    names = (
        ("area_um2", "area [µm²]"),
        ("speed_mm_s", "speed at contact [mm/s]"),
        ("symmetry", "S"),
        ("impact_parameter", "b/D0"),
        ("capillary_number", "Ca"),
        ("breakup_number", "Bk"),
        ("neck_um", "thinnest neck [µm]"),
        ("breakup_neck_um", "neck before break-up [µm]"),
        ("daughter_area_ratio", "A1/A2"),
    )
    rows = []
    for name, label in names:
        values = table[name].to_numpy(np.float64)
        values = values[np.isfinite(values)]
        if values.size:
            numbers = np.quantile(values, [0.0, 0.5, 1.0])
            rows.append((label, len(values), *(f"{value:.4g}" for value in numbers)))
    if rows:
        page.table(("", "measured", "least", "median", "greatest"), rows)
