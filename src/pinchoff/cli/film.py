"""``pinchoff film``: the collisions of a sweep as a microscope would show them."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pinchoff.cli.folders import require_new_file
from pinchoff.cli.laboratory import LaboratoryOptions
from pinchoff.cli.options import OUTPUT, AsJson, Overwrite, Seed, argument, grouped, option
from pinchoff.cli.output import announce, bar, counted_off, warn
from pinchoff.support.errors import InputError, SimulationError
from pinchoff.support.files import read_toml
from pinchoff.support.locks import held_file
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    from pinchoff.video.encounters import Laboratory
    from pinchoff.video.microscope import Microscope, Passage


@grouped()
def film(
    sweep: Annotated[Path, argument("SWEEP", "Folder of a sweep")],
    experiment: LaboratoryOptions,
    out: Annotated[Path, option("FILE.mp4", "The clip", panel=OUTPUT)] = Path("clip.mp4"),
    most: Annotated[int, option("INTEGER", "Collisions to show, from the first")] = 60,
    look: Annotated[
        Path | None,
        option("FILE.toml", "How it looks: settings of the microscope", default="the paper's"),
    ] = None,
    angle: Annotated[
        float, option("NUMBER", "Direction of the flow, from x towards y, in degrees")
    ] = 0.0,
    seed: Seed = 0,
    as_json: AsJson = False,
    overwrite: Overwrite = False,
) -> None:
    """Film the collisions of a sweep, with the truth beside the clip.

    The runs of SWEEP are simulated again, with their daughters. They pass
    obstacles in several lanes, drawn as the paper's microscope shows them, in
    the paper's experiment: R and z 85 µm, μ 48 mPa s, γ 20 mN/m.
    CLIP.truth.parquet has the true numbers of every collision in the clip:
    measure the clip with pinchoff video and compare. Ten collisions take
    about ten seconds.

    [bold]Example[/bold]

    pinchoff film phase-diagram --most 40 --out clip.mp4
    """
    from pinchoff.video.encounters import PAPER_LABORATORY
    from pinchoff.video.microscope import Microscope, lane_scene, truth_of
    from pinchoff.video.microscope import film as write_film

    with held_file(out, "--out"):
        require_new_file("--out", out, truth_of(out), overwrite=overwrite)
        if most < 1:
            raise InputError.of("--most", "1 or more", most, "choose how many collisions to show")
        laboratory = PAPER_LABORATORY.replace(**experiment.values())
        microscope = Microscope(**{"seed": seed, **({} if look is None else read_toml(look))})
        passages = _passages(sweep, most, microscope, laboratory)
        scene, frame_count = lane_scene(passages, microscope, angle=math.radians(angle), seed=seed)
        with bar("film", frame_count, "frames") as show:
            made = write_film(
                scene,
                out,
                frame_count,
                microscope=microscope,
                laboratory=laboratory,
                progress=None if show is None else lambda done, _: show(done),
            )
    counts = {"frames": made.frame_count, "collisions": len(made.collisions)}
    words = f"{counted(made.frame_count, 'frame')}, {counted(len(made.collisions), 'collision')}"
    announce(counts, lambda: print(words), (made.clip, made.truth), as_json=as_json)


def _passages(
    sweep: Path, most: int, microscope: Microscope, laboratory: Laboratory
) -> list[Passage]:
    from pinchoff.studies.sweep import SweepDesign
    from pinchoff.studies.sweep.dataset import read_manifest
    from pinchoff.video.microscope import passage_of

    manifest = read_manifest(sweep)
    if manifest is None:
        got, advice = "something else", "give the folder that pinchoff sweep wrote"
        raise InputError.of(str(sweep), "the folder of a sweep", got, advice)
    design = SweepDesign.from_config(manifest["configuration"])
    chosen = list(design.points(0, min(most, len(design))))
    passages, left_out = [], Counter[str]()
    for parameters in counted_off("simulate", chosen, "runs"):
        try:
            passages.append(passage_of(parameters, microscope, laboratory))
        except SimulationError as error:
            left_out[f"the guard {error.guard} stopped them"] += 1
        except InputError as error:
            left_out[str(error)] += 1
    for reason, count in left_out.most_common():
        warn(f"{count} of {len(chosen)} runs are left out: {reason}")
    if not passages:
        got, advice = "none that can be filmed", "see the reasons above"
        raise InputError.of(str(sweep), "a sweep with runs to film", got, advice)
    return passages
