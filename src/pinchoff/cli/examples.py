"""``pinchoff examples``: files to try the other commands on."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from pinchoff.cli.folders import Results
from pinchoff.cli.options import argument, grouped
from pinchoff.cli.output import bar, warn
from pinchoff.support.files import write_csv, write_text

TABLE = "mine.csv"
CLIP = "clip.mp4"
_TRUTH = "clip.truth.parquet"

_ROWS = 600
_DROPLETS = ((24, 4.4, 0.02), (36, 5.2, 0.06), (30, 4.8, 0.12), (20, 4.2, 0.18))
"""Ca_sim, D0/R and offset of the droplets in the clip: some break, some do not."""


@dataclass(frozen=True)
class ExamplesFolder(Results):
    """The folder, as an argument."""

    out: Annotated[str, argument("DIR", "Folder for the files")] = "examples"


@grouped()
def examples(results: ExamplesFolder) -> None:
    """Write files to try the other commands on, small ones.

    DIR gets

    - phase-diagram.toml, speed-and-offset.toml: for pinchoff sweep
    - separating_line.toml: for pinchoff run and pinchoff boundary
    - chamber.toml: for pinchoff chamber
    - emulsion.toml: for pinchoff emulsion
    - mine.csv: a synthetic table as a laboratory keeps it, for pinchoff fit
    - clip.mp4, clip.truth.parquet: a drawn film and its truth, for pinchoff
      video; left out where the extra "video" is not installed

    [bold]Examples[/bold]

    pinchoff examples

    pinchoff sweep examples/phase-diagram.toml --out phase-diagram
    """
    texts = _texts()
    names = [*sorted(texts), TABLE, CLIP, _TRUTH]
    with results.held_for(names) as folder:
        write_examples(folder)
    files = [folder / name for name in names]
    report = {"files": [str(path) for path in files if path.exists()]}
    results.announce(report, lambda: None, files)
    if not files[-1].exists():
        advice = "install it with: pip install 'pinchoff[video]'"
        warn(f"no clip: the extra 'video' is not installed; {advice}")


def write_examples(folder: Path) -> None:
    """Write the files into a folder; the clip, if the extra "video" is installed."""
    for name, text in _texts().items():
        write_text(folder / name, text)
    _write_table(folder / TABLE)
    if find_spec("av") is not None and find_spec("cv2") is not None:
        _write_clip(folder / CLIP)


def _texts() -> dict[str, str]:
    """Return the configurations by their names."""
    return {
        file.name: file.read_text(encoding="utf-8")
        for file in resources.files("pinchoff.cli").joinpath("example_files").iterdir()
        if file.name.endswith(".toml")
    }


def _write_table(path: Path) -> None:
    """Write synthetic collisions with other names and units, and what never changes left out."""
    import numpy as np
    import pandas as pd

    from pinchoff.studies.virtual import virtual_experiment

    known = virtual_experiment(3, _ROWS)
    table = pd.DataFrame(
        {
            "S_meas": known["symmetry"],
            "A (mm^2)": known["area_um2"] / 1e6,
            "v (um/s)": known["speed_mm_s"] * 1e3,
            "R (um)": known["obstacle_radius_um"],
            "z (um)": known["thickness_um"],
            "mu (mPa s)": known["viscosity_mPa_s"],
            "result": np.where(known["broke"], "yes", "no"),
            "source": "synthetic",
        }
    )
    write_csv(path, table)


def _write_clip(path: Path) -> None:
    from pinchoff.model.parameters import Parameters
    from pinchoff.video.encounters import PAPER_LABORATORY
    from pinchoff.video.microscope import Microscope, film, lane_scene, passage_of

    microscope = Microscope(seed=0)
    passages = [
        passage_of(
            Parameters(simulation_capillary_number=ca, size_ratio=ratio, offset=offset),
            microscope,
            PAPER_LABORATORY,
        )
        for ca, ratio, offset in _DROPLETS
    ]
    scene, count = lane_scene(passages, microscope, seed=0)
    with bar("clip", count, "frames") as show:
        film(scene, path, count, microscope=microscope, laboratory=PAPER_LABORATORY, progress=show)
