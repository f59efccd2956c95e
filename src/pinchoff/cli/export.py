"""``pinchoff export``: outlines and tracks for ImageJ, TrackMate and trackpy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pinchoff.cli.folders import results_folder, results_in
from pinchoff.cli.options import AsJson, OutFolder, Overwrite, argument
from pinchoff.cli.output import announce, counted_off
from pinchoff.support.numerals import counted


def export(
    measured: Annotated[Path, argument("DIR", "What pinchoff video wrote, or one clip in it")],
    out: OutFolder = "export",
    as_json: AsJson = False,
    overwrite: Overwrite = False,
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

    folder = results_folder(out)
    clips = measured_clips(measured)
    written = []
    with results_in(folder, exported_names(clips), overwrite=overwrite):
        for clip in counted_off("export", clips, "clips"):
            written += export_clip(clip, folder)
    report = {"clips": [clip.name for clip in clips]}
    announce(report, lambda: print(counted(len(clips), "clip")), written, as_json=as_json)
