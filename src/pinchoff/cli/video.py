"""``pinchoff video``: clips of a microscope to a table of collisions."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from pinchoff.cli.assignments import read_value, read_values
from pinchoff.cli.folders import ResultsFolder
from pinchoff.cli.laboratory import EXPERIMENT, LaboratoryOptions, quantity
from pinchoff.cli.options import (
    OUTPUT,
    Workers,
    argument,
    flag_of,
    grouped,
    named_as_options,
    option,
    switch,
)
from pinchoff.cli.output import warn
from pinchoff.explorer.page import FOLDER_PAGE
from pinchoff.support.errors import InputError
from pinchoff.support.numerals import counted
from pinchoff.support.records import jsonable

if TYPE_CHECKING:
    from pinchoff.video.batch import VideoResult
    from pinchoff.video.settings import VideoSettings

_IMAGE = "Image"
_CLIP = "Part of a clip"
_TABLE = "collisions.parquet"
_FILES = (_TABLE, "events.parquet", "index.html", FOLDER_PAGE)


@dataclass(frozen=True)
class VideoOptions:
    """How clips are read and measured."""

    config: Annotated[Path | None, option("FILE.toml", "Settings from a TOML file")] = None
    pixel_size: Annotated[
        str | None, quantity("Side of a pixel", "5.28 um", default="what the file says")
    ] = None
    fps: Annotated[
        str | None,
        option("NUMBER", "Frames a second", default="the times in the file", panel=EXPERIMENT),
    ] = None
    frames: Annotated[
        str | None,
        option("RANGE", "Frames that are measured, as 0:200:2", default="all", panel=_CLIP),
    ] = None
    crop: Annotated[
        str | None,
        option(
            "LIST",
            "Part of the picture: left,top,width,height in pixels",
            default="all of it",
            panel=_CLIP,
        ),
    ] = None
    channel: Annotated[
        str | None,
        option(
            "NAME", "One of several channels, by name or number; or red, green or blue", panel=_CLIP
        ),
    ] = None
    minimum_diameter: Annotated[
        str | None, quantity("Smallest droplet", "60 um", _IMAGE, default="by the method")
    ] = None
    contact_distance: Annotated[
        str | None,
        quantity(
            "Distance that counts as contact",
            "16 um",
            _IMAGE,
            default="where the gap stops closing",
        ),
    ] = None
    method: Annotated[
        str | None,
        option(
            "NAME",
            "How droplets are told: rings, enclosed, spots or packed",
            default="what suits the clip",
            panel=_IMAGE,
        ),
    ] = None
    find_obstacles: Annotated[
        bool,
        switch(
            "--find-obstacles",
            "Look for pillars of any radius; with --obstacle-radius they are looked for",
            panel=_IMAGE,
        ),
    ] = False
    packed: Annotated[
        bool,
        switch("--packed", "The same as --method packed: droplets fill the view", panel=_IMAGE),
    ] = False
    assignments: Annotated[
        list[str] | None,
        option(
            "NAME=VALUE",
            "Any other setting, as edge_level=0.5; may be repeated",
            "--set",
            panel=_IMAGE,
        ),
    ] = None

    def settings(self, laboratory: LaboratoryOptions) -> VideoSettings:
        """Return what a file and the command line say together; the command line overrides."""
        from pinchoff.support.files import read_toml
        from pinchoff.support.units import magnitude_of
        from pinchoff.video.settings import VideoSettings

        table: dict[str, Any] = {} if self.config is None else read_toml(self.config)
        known = table.pop("laboratory", {})
        if not isinstance(known, dict):
            place, advice = f"{self.config}: laboratory", "write it as [laboratory]"
            raise InputError.of(place, "a table", known, advice)
        for name in ("pixel_size", "minimum_diameter", "contact_distance"):
            if (text := getattr(self, name)) is not None:
                table[f"{name}_um"] = magnitude_of(flag_of(name), text, "um", positive=True)
        if self.fps is not None:
            table["fps"] = read_value("--fps", self.fps)
        if self.crop is not None:
            table["crop"] = read_value("--crop", f"[{self.crop}]")
        words = {"frames": self.frames, "channel": self.channel}
        table |= {name: text for name, text in words.items() if text is not None}
        assignments = [
            *(self.assignments or []),
            *(["method=packed"] if self.packed else []),
            *([f"method={self.method}"] if self.method is not None else []),
            *(["find_obstacles=true"] if self.find_obstacles else []),
        ]
        table |= read_values("--set", assignments, "edge_level=0.5")
        flags = ("fps", "frames", "crop", "channel", "method")
        with named_as_options(*(name for name in flags if getattr(self, name) is not None)):
            return VideoSettings(**table, laboratory={**known, **laboratory.values()})


@grouped(out="video")
def video(
    clips: Annotated[
        list[Path], argument("FILES", "Videos, TIFF stacks, folders of either or images")
    ],
    measuring: VideoOptions,
    experiment: LaboratoryOptions,
    *,
    preview: Annotated[
        bool,
        switch("--preview", "Draw what each method finds in a few frames, and measure nothing"),
    ] = False,
    overlay: Annotated[
        bool, switch("--overlay/--no-overlay", "Write annotated clips", panel=OUTPUT)
    ] = True,
    workers: Workers = None,
    results: ResultsFolder,
) -> None:
    r"""Measure droplets that meet obstacles in microscope videos.

    DIR gets

    - collisions.parquet: the collisions of all clips, the rejected ones with
      their reasons
    - tracks.parquet, events.parquet: every droplet in every frame, break-ups,
      coalescences
    - index.html, contact_sheet.png: counts, histograms, every collision
      before and after
    - clips/NAME/: outlines.gsd, overlay.mp4, obstacles.toml and the tables of
      each clip

    Look first: --preview measures nothing and draws into preview-NAME.png what
    each method finds. Pillars are looked for if --obstacle-radius or
    --find-obstacles is given.

    A second run measures only new clips, and those with other settings. To
    correct a circle, edit the clip's obstacles.toml and give the command again.

    [bold]Example[/bold]

    pinchoff video clips/*.mp4 --pixel-size 5.28um --fps 60 \
    --obstacle-radius 85um --thickness 85um --viscosity 48mPa.s \
    --surface-tension 20mN/m --out measured
    """
    settings = measuring.settings(experiment)
    if preview:
        with results.held() as folder:
            _preview(clips, folder, settings)
        return
    from pinchoff.figures.pages.video import write_report
    from pinchoff.video.batch import clip_sources, measure_videos

    _describe(clip_sources(clips), settings, sys.stderr if results.as_json else sys.stdout)
    with results.resumed(_FILES, ("clips",)) as folder:
        result = measure_videos(
            clips,
            folder,
            settings,
            overlay=overlay,
            processes=workers,
            progress=sys.stderr.isatty(),
        )
        _tell_problems(result)
        written = [result.path / _TABLE, *write_report(result)]
        results.announce(_report(result), lambda: _tell_counts(result), written)


def _preview(clips: list[Path], folder: Path, settings: VideoSettings) -> None:
    """Draw what each method finds in each clip, and print the scores."""
    from pinchoff.video.batch import clip_sources, failure_of
    from pinchoff.video.clips import reason_for_doubt
    from pinchoff.video.preview import write_preview

    sources, failed = clip_sources(clips), 0
    for name, source in sources.items():
        path = folder / f"preview-{name}.png"
        try:
            choice = write_preview(source, path, settings)
        except Exception as error:  # libraries refuse damaged clips in many ways of their own
            print(f"error: {failure_of(source, error)}", file=sys.stderr)
            failed += 1
            continue
        scores = ", ".join(f"{method} {score:.2f}" for method, score in choice.scores().items())
        print(f"{name}: {choice.method} is used ({scores}); --method NAME takes another")
        if doubt := reason_for_doubt(choice):
            print(f"warning: {name}: {doubt}", file=sys.stderr)
        print(f"wrote {path}")
    if failed == len(sources):
        raise _none_measurable(failed)


def _describe(sources: Mapping[str, Path], settings: VideoSettings, stream: TextIO) -> None:
    """Print scale and rate of every clip before the work starts.

    Refused where neither the user nor any of the clips says how large a pixel is.
    """
    from pinchoff.video.scale import described

    lines = described(sources, settings)
    if settings.pixel_size_um is None and not lines and all(p.exists() for p in sources.values()):
        rule, advice = "given where the files do not say it", "write it like '5.28 um'"
        raise InputError.of("--pixel-size", rule, "nothing", advice)
    for line in lines:
        print(line, file=stream)


def _tell_problems(result: VideoResult) -> None:
    """Print errors and warnings of the clips; fail where none could be measured."""
    for clip in result.clips:
        if clip.error:
            print(f"error: {clip.error}", file=sys.stderr)
        elif clip.result.get("warning"):
            warn(f"{clip.name}: {clip.result['warning']}")
    if all(clip.error for clip in result.clips):
        raise _none_measurable(len(result.clips))


def _none_measurable(clips: int) -> InputError:
    got = f"{counted(clips, 'clip')} with errors"
    return InputError.of("FILES", "measurable", got, "see the errors above")


def _report(result: VideoResult) -> dict[str, Any]:
    """Return what --json prints: counts, and what came of each clip."""
    accepted = result.collisions["accepted"].to_numpy(bool)
    reasons = result.collisions.loc[~accepted, "reject_reason"].value_counts()
    return {
        "collisions": len(accepted),
        "accepted": int(accepted.sum()),
        "rejected": {str(reason): int(count) for reason, count in reasons.items()},
        "clips": {
            clip.name: {"error": clip.error or None, **jsonable(clip.result)}
            for clip in result.clips
        },
    }


def _tell_counts(result: VideoResult) -> None:
    measured = [clip for clip in result.clips if not clip.error]
    reused = sum(clip.reused for clip in measured)
    before = f", {reused} of them measured before" if reused else ""
    accepted = int(result.collisions["accepted"].sum())
    count = len(result.collisions)
    for clip in measured:
        print(_seen(clip.name, clip.result))
    print(
        f"{counted(count, 'collision')}, {accepted} accepted, "
        f"in {counted(len(measured), 'clip')}{before}"
    )
    if rejected := _report(result)["rejected"]:
        reason, rows = next(iter(rejected.items()))
        print(f"{rows} of {count - accepted} rejected ones: {reason}; index.html has all reasons")


def _seen(name: str, clip: Mapping[str, Any]) -> str:
    """Return what was found in a clip, and what was not looked for."""
    from pinchoff.video.clip_folder import OBSTACLES

    settings = clip["settings"]
    sought = (
        settings["find_obstacles"],
        settings["obstacles"],
        settings["laboratory"]["obstacle_radius_um"],
    )
    pillars = (
        counted(len(clip["obstacles"]), "pillar")
        if any(sought)
        else "no pillars were looked for, which --obstacle-radius or --find-obstacles does"
    )
    if any(sought) and not clip["obstacles"]:
        pillars += f": if there are some, write their circles into clips/{name}/{OBSTACLES}"
    tracks = counted(clip["tracks"], "track")
    return f"{name}: {tracks} of droplets by the method {clip['method']}; {pillars}"
