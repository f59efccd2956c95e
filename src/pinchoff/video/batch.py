"""Many clips, one process for each, into one folder; of few clips the frames side by side."""

from __future__ import annotations

import inspect
import itertools
import os
import pickle
import shutil
import uuid
import zlib
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pyarrow.parquet as pq

from pinchoff.collisions.parquet import TableWriter, read_collisions
from pinchoff.model.simulation import thread_count
from pinchoff.support.drawing import Drawable
from pinchoff.support.errors import InputError, PinchoffError, is_full, refused_by_system
from pinchoff.support.locks import held_folder, made_folder
from pinchoff.support.numerals import counted
from pinchoff.support.progress import progress_bar
from pinchoff.video import clip_folder
from pinchoff.video.encounters import Laboratory, encounter_table, write_encounters
from pinchoff.video.settings import VideoSettings
from pinchoff.video.workers import all_done
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


@dataclass(frozen=True, eq=False, repr=False)
class VideoResult(Drawable):
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

    def __repr__(self) -> str:
        clips = counted(len(self.clips), "clip")
        accepted = int(self.collisions["accepted"].sum())
        failed = sum(bool(clip.error) for clip in self.clips)
        errors = f"; {failed} could not be measured" if failed else ""
        rows = f"{accepted} accepted of {counted(len(self.collisions), 'collision')}"
        return f"<VideoResult of {clips}{errors}: {rows}, in {self.path}>"


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
        How many work at the same time, by default one for each core: on clips, or where those
        are fewer, on the frames of each. The results do not depend on it.
    progress : bool, optional
        Whether to show a bar on stderr.
    segment : callable, optional
        A segmentation of your own: from the brightness of a frame, (height, width) of uint8, to
        closed outlines, each (n, 2) of x and y in pixels. With several processes it has to be a
        function at the top level of a module.

    Returns
    -------
    VideoResult
        A clip that cannot be measured has its ``error``; the others are measured all the same.
        If none can be, nothing is written.

    Raises
    ------
    InputError
        There are no clips, or two have the same name.

    Examples
    --------
    >>> import pinchoff as po
    >>> settings = po.VideoSettings(pixel_size_um=5.28)
    >>> found = po.measure_videos(["clip.mp4"], "measured", settings)  # doctest: +SKIP
    """
    require_video_extra("video")
    sources = clip_sources(clips)
    folder = Path(out)
    processes = thread_count(processes)
    for_each = max(1, processes // len(sources))
    jobs = [
        Job(source, folder / CLIPS / name, name, settings, overlay, for_each, segment)
        for name, source in sources.items()
    ]
    total = _frame_count(jobs) if progress else None
    outcomes: dict[str, ClipOutcome] = {}
    with held_folder(folder), made_folder(folder / CLIPS):
        with progress_bar(progress, "frames", total, unit="frames") as show:
            at_once = min(processes, len(jobs))
            with closing(all_done(jobs, measure_to_folder, _ended, at_once, show)) as done:
                for outcome in done:
                    outcomes[outcome.name] = outcome
        ordered = [outcomes[name] for name in sources]
        table = _joined([clip for clip in ordered if not clip.error], folder)
    return VideoResult(folder, ordered, table)


def clip_sources(clips: Iterable[str | os.PathLike[str]]) -> dict[str, Path]:
    """Return the clips by their names; a folder that holds films or stacks stands for these."""
    found: dict[str, Path] = {}
    for given in map(Path, clips):
        for path in _clips_in(given) or [given]:
            name = _name_of(path)
            if name in found and found[name] != path:
                got = f"{found[name]} and {path}"
                raise InputError.of("clips", "of different names", got, "rename one of them")
            found[name] = path
    if not found:
        raise InputError.of("clips", "one or more", "none", "give videos or folders of images")
    return found


def _clips_in(folder: Path) -> list[Path]:
    """Return the films and stacks in a folder; none where it holds single pictures."""
    from pinchoff.video.formats import STACK_SUFFIXES, VIDEO_SUFFIXES
    from pinchoff.video.formats.tiff import page_count

    inside = sorted(folder.iterdir()) if folder.is_dir() else []
    films = [path for path in inside if path.suffix.lower() in VIDEO_SUFFIXES]
    stacks = [path for path in inside if path.suffix.lower() in STACK_SUFFIXES]
    return films or (stacks if stacks and page_count(stacks[0]) > 1 else [])


def _name_of(path: Path) -> str:
    """Return a clip's name in tables and files; one that is a folder's name for sure."""
    stem = path.name if path.is_dir() else path.stem
    name = stem if stem.strip(". ") else f"clip {path.name.strip('. ')}"
    return name.encode("utf-8", "replace").decode()


class Job(NamedTuple):
    """One clip that is to be measured."""

    source: Path
    folder: Path  # where its results go
    name: str
    settings: VideoSettings
    overlay: bool  # whether to write an annotated clip
    processes: int = 1  # that look at its frames at the same time
    segment: SegmentFunction | None = None  # the user's own


def _frame_count(jobs: Sequence[Job]) -> int | None:
    """Return how many frames there are in all; None where a clip does not say."""
    from pinchoff.video.scale import clip_of

    total = 0
    for job in jobs:
        try:
            count = clip_of(job.source, job.settings).frame_count
        except Exception:  # an error in it is reported when it is read
            continue
        if count is None:
            return None
        total += count
    return total


def measure_to_folder(
    job: Job, count: Callable[[int], object] = lambda frames: None
) -> ClipOutcome:
    """Measure one clip into its folder, unless it is there already.

    Nothing is raised for a clip that cannot be measured, whatever is wrong with it. `count` is
    called with the number of frames that are done.
    """
    existed = job.folder.exists()
    try:
        chosen, corrected = _with_obstacles(job.folder, job.settings)
        mark = clip_folder.fingerprint(job.source, chosen) + ("" if job.overlay else " plain")
        mark += "" if job.segment is None else f" {_function_mark(job.segment)}"
        before = clip_folder.finished_result(job.folder, mark)
        if before is not None:
            count(before["frames"])
            return ClipOutcome(job.name, job.folder, before, reused=True)
        result = _fresh(job._replace(settings=chosen), mark, corrected, count)
        return ClipOutcome(job.name, job.folder, result)
    except BaseException as error:  # libraries refuse damaged clips in many ways of their own
        if not existed:
            shutil.rmtree(job.folder, ignore_errors=True)
        if not isinstance(error, Exception):
            raise
        return ClipOutcome(job.name, job.folder, {}, error=failure_of(job.source, error))


def failure_of(source: Path, error: Exception) -> str:
    """Return in a line why a clip cannot be measured, whatever refused it."""
    if isinstance(error, PinchoffError):
        return str(error)
    if isinstance(error, OSError) and is_full(error):
        return str(refused_by_system(error))
    if isinstance(error, FileNotFoundError) and not source.exists():
        rule, advice = "a clip that is there", "check its name"
        return str(InputError.of(str(source), rule, "no such file", advice))
    got = " ".join(f"{type(error).__name__}: {error}".split())
    advice = "see whether a player or Fiji opens it, and save it anew from there"
    return str(InputError.of(str(source), "a clip that can be measured", got, advice))


def _ended(job: Job) -> ClipOutcome:
    """Return the outcome of a clip whose process ended by itself."""
    rule, got = "a clip that can be measured", "a process that ended in the middle of it"
    advice = "it may be damaged, or too large for the memory"
    error = InputError.of(str(job.source), rule, got, advice)
    if not (job.folder / clip_folder.RESULT).exists():
        shutil.rmtree(job.folder, ignore_errors=True)
    return ClipOutcome(job.name, job.folder, {}, error=str(error))


def _function_mark(segment: SegmentFunction) -> str:
    """Return what changes when a user's own segmentation does; it is new where that cannot be told.

    All of its file counts, with constants and functions that it uses, and what it holds itself.
    """
    from pinchoff.video.methods.function import function_name

    try:
        file = Path(inspect.getsourcefile(segment) or "")
        source = file.read_text("utf-8") if file.is_file() else inspect.getsource(segment)
        held = [cell.cell_contents for cell in segment.__closure__ or ()]
        # Not by their repr, which leaves out the middle of a large array.
        known = pickle.dumps((source, segment.__defaults__, segment.__kwdefaults__, held))
    except Exception:  # no plain function, no source, or something held that refuses in its own way
        known = uuid.uuid4().bytes
    return f"{function_name(segment)} {zlib.crc32(known):08x}"


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


def _fresh(job: Job, mark: str, corrected: bool, count: Callable[[int], object]) -> dict[str, Any]:
    import cv2

    from pinchoff.video.choice import Choice
    from pinchoff.video.clips import Measured, measure_clip
    from pinchoff.video.scale import clip_of, overlay_fps, scaled

    cv2.setNumThreads(1)  # clips run side by side
    folder, name = job.folder, job.name
    stamps = clip_folder.file_stamps(job.source)
    clip = clip_of(job.source, job.settings)
    settings, _ = scaled(clip, job.settings)
    fps = overlay_fps(clip) if job.overlay else None
    folder.mkdir(parents=True, exist_ok=True)
    (folder / clip_folder.RESULT).unlink(missing_ok=True)
    with ExitStack() as files:
        recorders: list[clip_folder.ClipRecorder] = []

        def begin(_: Choice, obstacles: Any) -> Callable[[Measured], object]:
            recorder = clip_folder.ClipRecorder(folder, name, settings, obstacles, fps)
            recorders.append(files.enter_context(recorder))
            frames = itertools.count(1)

            def record(seen: Measured) -> None:
                recorder.append(seen)
                count(next(frames))

            return record

        result = measure_clip(
            job.source, settings, begin, processes=job.processes, segment=job.segment
        )
    rate = recorders[0].write_plugs()
    table = encounter_table(result.encounters, settings.laboratory, "video", name)
    write_encounters(table, folder / clip_folder.COLLISIONS)
    if not corrected:
        clip_folder.write_obstacles(folder, result.obstacles)
    summary = {
        "fingerprint": mark,
        "clip": str(job.source.resolve()),
        "files": stamps,
        "frames": result.frame_count,
        "duration_s": result.duration_s,
        "overlay_fps": fps,
        "tracks": result.track_count,
        "plugs_per_s": rate,
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

    if not clips:
        return encounter_table([], Laboratory(), "video", "")
    tables = [read_collisions(clip.folder / clip_folder.COLLISIONS) for clip in clips]
    table = pd.concat(tables, ignore_index=True)
    table["collision_id"] = range(len(table))
    table.attrs["units"] = tables[0].attrs["units"]
    write_encounters(table, out / clip_folder.COLLISIONS)
    for name, columns in clip_folder.STREAMED.items():
        with TableWriter(out / name, columns) as together:
            for clip in clips:
                with pq.ParquetFile(clip.folder / name) as one:
                    for batch in one.iter_batches():
                        together.append_batch(batch)
    return table
