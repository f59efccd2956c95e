"""``pinchoff export``: outlines and tracks for ImageJ, TrackMate and trackpy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pinchoff.cli.folders import Results
from pinchoff.cli.options import argument, grouped
from pinchoff.cli.output import counted_off
from pinchoff.support.numerals import counted


@grouped(out="export")
def export(
    measured: Annotated[Path, argument("DIR", "What pinchoff video wrote, or one clip in it")],
    results: Results,
) -> None:
    """Write outlines and tracks of measured clips for ImageJ, TrackMate and
    trackpy.

    For every clip the folder gets

    - NAME.rois.zip: the outlines for ImageJ's ROI manager, frame and track in
      their names
    - NAME.tracks.csv: tracks as trackpy has them: frame, particle, x, y, area
      in pixels
    - NAME.trackmate.csv: the same as TrackMate's spots, in µm and s

    [bold]Example[/bold]

    pinchoff export measured --out for-imagej
    """
    from pinchoff.video.export import export_clip, exported_names, measured_clips

    clips = measured_clips(measured)
    written = []
    with results.held_for(exported_names(clips)) as folder:
        for clip in counted_off("export", clips, "clips"):
            written += export_clip(clip, folder)
    report = {"clips": [clip.name for clip in clips]}
    results.announce(report, lambda: print(counted(len(clips), "clip")), written)
