"""The page about a batch of measured clips."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

import numpy as np

from pinchoff.explorer.page import FOLDER_PAGE, LINK, NO_PAGE, write_folder_page
from pinchoff.figures.contact_sheet import Picture, write_contact_sheet
from pinchoff.figures.html_page import Page
from pinchoff.figures.video_histograms import diameters, histograms, timeline
from pinchoff.support.numerals import counted, numeral
from pinchoff.video import clip_folder
from pinchoff.video.formats.selection import ALL_FRAMES, frame_range

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.video.batch import ClipOutcome, VideoResult

PAGE = "index.html"
SHEET = "contact_sheet.png"

_MOST_TOLD = 5  # clips whose warnings open the page
_MOST_STILLS, _STILL_WIDTH = 12, 720  # clips that are shown; pixels
_BEFORE_S = 0.5  # frames of the film that are shown before a contact

MOST_SHOWN = 300
"""Collisions that the page shows; the sheet has more of them."""


def write_report(result: VideoResult) -> list[Path]:
    """Write a batch's contact sheet, its page and its live page into its folder.

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
    clips = counted(len(result.clips), "clip")
    with_obstacles = any(clip.result.get("obstacles") for clip in result.clips)
    title, lead = "Droplets in films", f"{_droplets(result.clips)} in {clips}; no obstacles."
    if with_obstacles or len(table):
        title = "Droplets that meet obstacles"
        lead = (
            f"{counted(len(table), 'collision')} in {clips}: {int(accepted.sum())} accepted, of "
            f"which {int((accepted & broke).sum())} broke."
        )
    page = Page(title, lead, _notice(result.clips))
    explored = len(table) > 0 and write_folder_page(result.path)
    if explored:
        page.link(LINK, FOLDER_PAGE)
    elif len(table):
        page.paragraph(NO_PAGE)
    _gallery(page, pictures, len(table), shown)
    _stills(page, result)
    if not with_obstacles:
        _sizes(page, result)
    if len(table):
        page.section("What was measured")
        if accepted.any():
            page.figure(histograms(table)[0], "Accepted collisions, broken on unbroken.")
        page.figure(timeline(table), "Contacts in the course of each clip.")
    _clips(page, result.clips, table)
    _rejected(page, table)
    _ranges(page, table[accepted])
    page.write(result.path / PAGE)
    more = [result.path / FOLDER_PAGE] if explored else []
    return [sheet, result.path / PAGE, *more]


def _notice(clips: Sequence[ClipOutcome]) -> str:
    """Return the notice at the top of the page: errors and warnings of the first clips."""
    wrong = [(clip.name, clip.error or clip.result.get("warning", "")) for clip in clips]
    told = [f"{name}: {text}" for name, text in wrong if text]
    more = len(told) - _MOST_TOLD
    return " · ".join(told[:_MOST_TOLD]) + (f" · and {more} more clips" if more > 0 else "")


def _gallery(page: Page, pictures: Sequence[Picture], count: int, on_sheet: int) -> None:
    drawn = [picture for picture in pictures if picture.path.exists()]
    if not drawn:
        return
    page.section("Every collision")
    page.paragraph(
        "At first contact, and where the collision ends: in the frame with two droplets, or one "
        "obstacle radius away. A picture opens the annotated film at that moment. "
        f"{on_sheet} of {count} are on {SHEET}"
        + (f"; the first {MOST_SHOWN} are here." if len(drawn) > MOST_SHOWN else ".")
    )
    page.gallery(drawn[:MOST_SHOWN])


def _droplets(clips: Sequence[ClipOutcome]) -> str:
    return counted(sum(clip.result.get("tracks", 0) for clip in clips), "droplet")


def _stills(page: Page, result: VideoResult) -> None:
    """Add a frame of each annotated film; it opens the film at that moment."""
    stills = []
    for clip in result.clips[:_MOST_STILLS]:
        film = clip.folder / clip_folder.OVERLAY
        still = _still(film) if clip.result else None
        if still is not None:
            picture, second = still
            path = film.relative_to(result.path).as_posix()
            label = f"{clip.name}: {_droplets([clip])}, method {clip.result['method']}"
            stills.append((picture, label, f"{quote(path)}#t={second:.2f}"))
    if not stills:
        return
    page.section("What was found")
    page.paragraph(
        "From the middle of each clip. Are all droplets outlined, once, on their outer edge, and "
        "nothing else?"
        + (" A picture opens the annotated film at that moment." if len(stills) > 1 else "")
        + (f" The first {_MOST_STILLS} clips." if len(result.clips) > _MOST_STILLS else "")
    )
    if len(stills) > 1:
        page.gallery(stills)
        return
    picture, label, _ = stills[0]
    page.figure(picture, label)
    page.link("Open the annotated film", path)


def _still(film: Path) -> tuple[bytes, float] | None:
    """Return the middle frame of a film as a picture, and its time, seconds; None without one."""
    import cv2

    if not film.exists():
        return None
    reader = cv2.VideoCapture(str(film))
    try:
        middle = int(reader.get(cv2.CAP_PROP_FRAME_COUNT)) // 2
        fps = reader.get(cv2.CAP_PROP_FPS)
        reader.set(cv2.CAP_PROP_POS_FRAMES, middle)
        known, frame = reader.read()
    finally:
        reader.release()
    if not known or fps <= 0.0:
        return None
    scale = min(1.0, _STILL_WIDTH / frame.shape[1])
    small = cv2.resize(frame, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".png", small)[1].tobytes(), middle / fps


def _sizes(page: Page, result: VideoResult) -> None:
    """Add a histogram of the droplets' diameters."""
    import pandas as pd

    path = result.path / clip_folder.TRACKS
    if not path.exists():
        return
    tracks = pd.read_parquet(path, columns=["clip", "track_id", "area_um2", "cut"])
    areas = tracks[~tracks["cut"]].groupby(["clip", "track_id"])["area_um2"].median()
    if len(areas):
        page.section("What was measured")
        caption = "Diameter of the circle with a droplet's area, the median over its frames."
        page.figure(diameters(areas.to_numpy()), caption)


def _pictures(result: VideoResult) -> list[Picture]:
    clips = {clip.name: clip for clip in result.clips}
    pictures = []
    rows: Iterable[Any] = result.collisions.itertuples()
    for row in rows:
        clip = clips[row.clip]
        name = clip_folder.thumbnail_name(row.contact_frame, row.track_id, row.obstacle_id)
        symmetry, speed = _shown(row.symmetry, ""), _shown(row.speed_mm_s, " mm/s")
        end = f"rejected: {row.reject_reason}" if row.reject_reason else row.outcome
        label = f"{row.collision_id}: S {symmetry}, v {speed}, {end}"
        opens = _film(clip, result.path, row.contact_frame)
        pictures.append(Picture(clip.folder / clip_folder.THUMBNAILS / name, label, opens))
    return pictures


def _film(clip: ClipOutcome, page: Path, frame: int) -> str:
    """Return an address shortly before a frame of the annotated film; empty where there is none."""
    fps = clip.result.get("overlay_fps")
    if not fps:
        return ""
    told = clip.result["settings"].get("frames")
    part = ALL_FRAMES if told is None else frame_range(told)
    second = max(0.0, (frame - part.start) / part.step / fps - _BEFORE_S)
    path = (clip.folder / clip_folder.OVERLAY).relative_to(page).as_posix()
    return f"{quote(path)}#t={second:.2f}"


def _shown(value: float, unit: str) -> str:
    return f"= {value:.2f}{unit}" if math.isfinite(value) else "not measured"


def _clips(page: Page, clips: list[ClipOutcome], table: pd.DataFrame) -> None:
    page.section("Clips")
    counts = Counter(table["clip"])
    fit = Counter(table["clip"][table["accepted"].to_numpy(bool)])
    rows = []
    for clip in clips:
        found = clip.result
        numbers: tuple[object, ...] = ("–",) * 7
        if found:
            numbers = (
                _method(found),
                found["frames"],
                f"{found['duration_s']:.1f}",
                len(found["obstacles"]),
                found["tracks"],
                counts[clip.name],
                fit[clip.name],
            )
        rows.append((clip.name, *numbers, clip.error or (found.get("warning") or "")))
    counted_there = ("obstacles", "droplets", "collisions", "accepted")
    page.table(("clip", "method and scores", "frames", "time (s)", *counted_there, ""), rows)


def _method(found: dict[str, Any]) -> str:
    scores = ", ".join(f"{name} {score:.2f}" for name, score in found["scores"].items())
    return f"{found['method']} ({scores})"


def _rejected(page: Page, table: pd.DataFrame) -> None:
    """Add a table in which each rejected collision counts once, with all of its reasons."""
    reasons = Counter(text for text in table["reject_reason"] if text)
    if reasons:
        page.section("Rejected collisions")
        page.table(("reasons", "collisions"), reasons.most_common())


def _ranges(page: Page, table: pd.DataFrame) -> None:
    names = (
        ("area_um2", "area (µm²)"),
        ("speed_mm_s", "speed at contact (mm/s)"),
        ("symmetry", "S"),
        ("impact_parameter", "b/D0"),
        ("capillary_number", "Ca"),
        ("breakup_number", "Bk"),
        ("neck_um", "thinnest neck (µm)"),
        ("breakup_neck_um", "neck before break-up (µm)"),
        ("daughter_area_ratio", "A1/A2"),
    )
    rows = []
    for name, label in names:
        values = table[name].to_numpy(np.float64)
        values = values[np.isfinite(values)]
        if values.size:
            numbers = np.quantile(values, [0.0, 0.5, 1.0])
            rows.append((label, len(values), *(numeral(value, ".4g") for value in numbers)))
    if rows:
        page.table(("", "measured", "least", "median", "greatest"), rows)
