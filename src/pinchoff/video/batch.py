"""Many clips, one process for each, into one folder."""

from __future__ import annotations

import multiprocessing
import os
import zlib
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pyarrow.parquet as pq

from pinchoff.collisions.parquet import read_collisions
from pinchoff.model.simulation import thread_count
from pinchoff.support.errors import InputError
from pinchoff.support.files import written_aside
from pinchoff.support.progress import progress_bar
from pinchoff.video import clip_folder
from pinchoff.video.encounters import encounter_table, write_encounters
from pinchoff.video.settings import VideoSettings
from pinchoff.video.writing import require_video_extra

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.video.methods.function import SegmentFunction

CLIPS = "clips"
"""Name of the folder that holds a folder for every clip."""


class ClipOutcome(NamedTuple):
    """What came of one clip.

    Attributes
    ----------
    name : str
    folder : Path
    result : dict
        What its `clip_folder.RESULT` holds; empty when it failed.
    error : str
        Why it failed; empty when it did not.
    reused : bool
        Whether it had been measured before.
    """

    name: str
    folder: Path
    result: dict[str, Any]
    error: str = ""
    reused: bool = False


@dataclass(frozen=True, eq=False)
class VideoResult:
    """What came of a batch.

    Attributes
    ----------
    path : Path
        The folder.
    clips : list of ClipOutcome
        In the order in which they were given.
    collisions : DataFrame
        Of all clips; the columns of `pinchoff.video.encounters.encounter_table`.
    """

    path: Path
    clips: list[ClipOutcome]
    collisions: pd.DataFrame


def measure_videos(
    clips: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    settings: VideoSettings,
    *,
    overlay: bool = True,
    processes: int | None = None,
    progress: bool = False,
    segment: SegmentFunction | None = None,
) -> VideoResult:
    """Measure the collisions in clips.

    Parameters
    ----------
    clips : sequence of path
        Video files, multi-page TIFFs, folders of images, or folders of videos.
    out : path
        Folder for the results: ``collisions.parquet`` and ``tracks.parquet`` of all clips, and
        in ``clips/NAME`` what belongs to each. Clips that are there, measured whole and with the
        same settings, are not measured again.
    settings : VideoSettings
    overlay : bool, optional
        Whether to write an annotated clip of each.
    processes : int, optional
        How many clips are measured at the same time; by default one for each core.
    progress : bool, optional
        Whether to show a bar on stderr.
    segment : callable, optional
        A segmentation of your own: from the brightness of a frame, (height, width) of uint8, to
        closed outlines, each (n, 2) of x and y in pixels. With several processes it has to be a
        function at the top level of a module.

    Returns
    -------
    VideoResult
        A clip that cannot be read has its ``error``; the others are measured all the same.

    Raises
    ------
    InputError
        There are no clips, or two have the same name.
    """
    require_video_extra("video")
    sources = clip_sources(clips)
    folder = Path(out)
    jobs = [
        (source, folder / CLIPS / name, name, settings, overlay, segment)
        for name, source in sources.items()
    ]
    workers = min(thread_count(processes), len(jobs))
    outcomes: dict[str, ClipOutcome] = {}
    with progress_bar(progress, "clips", len(jobs), unit="clips") as show:
        for outcome in _measured(jobs, workers):
            outcomes[outcome.name] = outcome
            if show is not None:
                show(len(outcomes))
    ordered = [outcomes[name] for name in sources]
    table = _joined([each for each in ordered if not each.error], folder)
    return VideoResult(folder, ordered, table)


def clip_sources(clips: Iterable[str | os.PathLike[str]]) -> dict[str, Path]:
    """Return the clips by their names; a folder that holds videos stands for these.

    Raises
    ------
    InputError
        There are none, or two have the same name.
    """
    from pinchoff.video.reading import VIDEO_SUFFIXES

    found: dict[str, Path] = {}
    for given in map(Path, clips):
        inside = sorted(given.iterdir()) if given.is_dir() else []
        videos = [path for path in inside if path.suffix.lower() in VIDEO_SUFFIXES]
        for path in videos or [given]:
            name = path.name if path.is_dir() or not path.stem else path.stem
            if name in found and found[name] != path:
                got = f"{found[name]} and {path}"
                raise InputError.of("clips", "of different names", got, "rename one of them")
            found[name] = path
    if not found:
        raise InputError.of("clips", "one or more", "none", "give videos or folders of images")
    return found


_Job = tuple[Path, Path, str, VideoSettings, bool, "SegmentFunction | None"]


def _measured(jobs: Sequence[_Job], workers: int) -> Iterable[ClipOutcome]:
    if workers <= 1:
        yield from (measure_to_folder(*job) for job in jobs)
        return
    # Not forked: the libraries of video and pictures have threads of their own.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        futures = [pool.submit(measure_to_folder, *job) for job in jobs]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def measure_to_folder(
    source: Path,
    folder: Path,
    name: str,
    settings: VideoSettings,
    overlay: bool,
    segment: SegmentFunction | None = None,
) -> ClipOutcome:
    """Measure one clip into its folder, unless it is there already.

    The arguments are those of `measure_videos` for one clip. Nothing is raised for a clip that
    cannot be read.
    """
    try:
        chosen, corrected = _with_obstacles(folder, settings)
        mark = clip_folder.fingerprint(source, chosen) + ("" if overlay else " plain")
        mark += "" if segment is None else f" {_function_mark(segment)}"
        before = clip_folder.finished_result(folder, mark)
        if before is not None:
            return ClipOutcome(name, folder, before, reused=True)
        return ClipOutcome(
            name, folder, _fresh(source, folder, name, chosen, mark, overlay, corrected, segment)
        )
    except (InputError, OSError) as error:
        with suppress(OSError):
            folder.rmdir()  # if nothing was written to it
        return ClipOutcome(name, folder, {}, error=str(error))


def _function_mark(segment: SegmentFunction) -> str:
    """Return what changes when a user's own segmentation is changed."""
    from pinchoff.video.methods.function import function_name

    code = getattr(segment, "__code__", None)
    return function_name(segment) + ("" if code is None else f" {zlib.crc32(code.co_code):08x}")


def _with_obstacles(folder: Path, settings: VideoSettings) -> tuple[VideoSettings, bool]:
    """Take the obstacles from the clip's own file where a user has corrected them there."""
    path = folder / clip_folder.OBSTACLES
    given = settings.obstacles is not None or settings.lattice is not None
    if given or not path.exists():
        return settings, False
    written = folder / clip_folder.OBSTACLES_AS_FOUND
    if written.exists() and written.read_bytes() == path.read_bytes():
        return settings, False
    return settings.replace(obstacles=clip_folder.read_obstacles(path)), True


def _fresh(
    source: Path,
    folder: Path,
    name: str,
    settings: VideoSettings,
    mark: str,
    overlay: bool,
    corrected: bool,
    segment: SegmentFunction | None,
) -> dict[str, Any]:
    import cv2

    from pinchoff.video.choice import Choice
    from pinchoff.video.clips import Measured, measure_clip

    cv2.setNumThreads(1)  # clips run side by side
    folder.mkdir(parents=True, exist_ok=True)
    (folder / clip_folder.RESULT).unlink(missing_ok=True)
    recorders: list[clip_folder.ClipRecorder] = []

    def begin(choice: Choice, obstacles: Any) -> Callable[[Measured], object]:
        recorders.append(clip_folder.ClipRecorder(folder, name, settings, obstacles, overlay))
        return recorders[0].append

    problem: BaseException | None = None
    try:
        result = measure_clip(source, settings, begin, segment)
    except BaseException as error:
        problem = error
        raise
    finally:
        for recorder in recorders:
            recorder.close(whole=problem is None)
    table = encounter_table(result.encounters, settings.laboratory, "video", name)
    write_encounters(table, folder / clip_folder.COLLISIONS)
    if not corrected:
        clip_folder.write_obstacles(folder, result.obstacles)
    summary = {
        "fingerprint": mark,
        "clip": str(source),
        "frames": result.frame_count,
        "duration_s": result.duration_s,
        "tracks": result.track_count,
        "obstacles": result.obstacles.tolist(),
        "method": result.choice.method,
        "scores": result.choice.scores(),
        "thresholds": result.choice.thresholds(),
        "settings": settings.model_dump(mode="json"),
        "warning": result.warning,
    }
    clip_folder.write_result(folder, summary)
    return summary


def _joined(clips: Sequence[ClipOutcome], out: Path) -> pd.DataFrame:
    """Write the tables of all clips together, and return that of the collisions."""
    import pandas as pd

    tables = [read_collisions(each.folder / clip_folder.COLLISIONS) for each in clips]
    if tables:
        table = pd.concat(tables, ignore_index=True)
        table["collision_id"] = range(len(table))
        table.attrs["units"] = tables[0].attrs["units"]
    else:
        table = encounter_table([], VideoSettings(pixel_size_um=1.0).laboratory, "video", "")
    out.mkdir(parents=True, exist_ok=True)
    write_encounters(table, out / clip_folder.COLLISIONS)
    for name, fields in (
        (clip_folder.TRACKS, clip_folder.TRACK_FIELDS),
        (clip_folder.EVENTS, clip_folder.EVENT_FIELDS),
    ):
        schema = clip_folder.schema_of(fields)
        with written_aside(out / name) as unfinished, pq.ParquetWriter(unfinished, schema) as all_:
            for each in clips:
                with pq.ParquetFile(each.folder / name) as one:
                    for batch in one.iter_batches():
                        all_.write_batch(batch.cast(schema))
    return table
