"""How well `pinchoff video` measures: drawn clips with known truth, moderate and hard ones.

    python examples/video_accuracy.py [--quick] [--plain] [--out DIR]

Collisions of the engine are filmed by `pinchoff.microscope`, measured, and compared one by one
with the outlines that were drawn. Prints the figures of docs/video.md and writes them, and every
pair, to DIR. A clip that is there is not drawn again.
"""

from __future__ import annotations

import argparse
import json
import math
import operator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from threshold_and_overlap import measure_plainly

import pinchoff as po
from pinchoff.model.simulation import thread_count
from pinchoff.video.clips import measure_clip
from pinchoff.video.encounters import Laboratory, encounter_table
from pinchoff.video.microscope import Microscope, film, lane_scene, passage_of

LABORATORY = Laboratory(
    obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
)
PIXEL_UM = 5.28
RUNS, HARD_RUNS = 35, 12  # of the engine, in a moderate and in a hard clip
PAPER_ERROR_OF_S = 0.088


class Case(NamedTuple):
    """A clip to draw: its name, how it looks, and how its droplets flow."""

    name: str
    look: dict[str, Any]
    angle_deg: float = 0.0
    gap_px: float = 14.0
    still: bool = False  # whether head-on droplets that stick to their pillar take part


MODERATE = (
    Case("noise 3, crf 18", {"noise": 3, "crf": 18}),
    Case("noise 4, crf 20", {"noise": 4, "crf": 20}, 90.0),
    Case("noise 5, crf 22", {"noise": 5, "crf": 22}, 200.0),
    Case("noise 6, crf 26", {"noise": 6, "crf": 26}, 0.0),
    Case("noise 6, crf 18", {"noise": 6, "crf": 18}, 335.0),
    Case("noise 3, crf 26", {"noise": 3, "crf": 26}, 180.0),
)
HARD = (
    Case("lamp flicker 3 %", {"flicker": 0.03}),
    Case("dust, 80 specks", {"dust": 80}),
    Case("focus drift 0.8 to 1.8 px", {"focus_drift_px": 1.0}),
    Case("motion blur, shutter 0.8", {"exposure": 0.8}),
    Case("uneven light 40 %", {"unevenness": 0.4}),
    Case("neighbours brush past", {}, 0.0, 1.5),
    Case("droplets stick to pillars", {}, 0.0, 14.0, True),
    Case("blue dye", {"interior": (120, 160, 214)}),
    Case("pale green dye", {"interior": (186, 206, 160)}),
    Case("all at once", {"flicker": 0.02, "dust": 40, "focus_drift_px": 0.6, "exposure": 0.5}),
)


def draw(case: Case, folder: Path, runs: int, seed: int) -> Path:
    """Film one case, unless that was done; return the clip."""
    clip = folder / f"{case.name.replace(' ', '-').replace(',', '').replace('%', 'percent')}.mp4"
    if clip.exists():
        return clip
    random = np.random.default_rng(seed)
    look = Microscope(pixel_size_um=PIXEL_UM, seed=seed, **case.look)
    passages = []
    for k in range(runs):
        parameters = po.Parameters(
            size_ratio=random.uniform(2.4, 5.6),
            simulation_capillary_number=math.exp(random.uniform(math.log(10), math.log(70))),
            offset=0.0 if case.still and k % 20 == 0 else random.normal(0.0, 0.11),
        )
        passages.append(passage_of(parameters, look, LABORATORY))
    scene, count = lane_scene(
        passages, look, angle=math.radians(case.angle_deg), gap_px=case.gap_px, seed=seed
    )
    film(scene, clip, count, microscope=look, laboratory=LABORATORY)
    return clip


def measure(clip: Path) -> pd.DataFrame:
    settings = po.VideoSettings(pixel_size_um=PIXEL_UM, laboratory=LABORATORY)
    result = measure_clip(clip, settings)
    return encounter_table(result.encounters, LABORATORY, "video", clip.stem)


def measure_by_script(clip: Path) -> pd.DataFrame:
    """Measure as `threshold_and_overlap.py` does, which is told where the obstacles are."""
    truth = po.read_collisions(clip.with_suffix(".truth.parquet"))
    circles = truth[["obstacle_x_um", "obstacle_y_um", "obstacle_radius_um"]].drop_duplicates()
    encounters = measure_plainly(clip, circles.to_numpy() / PIXEL_UM, PIXEL_UM)
    return encounter_table(encounters, LABORATORY, "video", clip.stem)


def paired(truth: pd.DataFrame, found: pd.DataFrame) -> list[tuple[int, int]]:
    """Pair collisions at the same obstacle whose contacts are nearest in time."""
    pairs, used = [], set()
    for k, row in truth.iterrows():
        away = np.hypot(
            found["obstacle_x_um"] - row["obstacle_x_um"],
            found["obstacle_y_um"] - row["obstacle_y_um"],
        )
        late = (found["contact_frame"] - row["contact_frame"]).abs()
        near = [j for j in found.index[(away < 40) & (late <= 12)] if j not in used]
        if near:
            best = min(near, key=lambda j: late[j])
            used.add(best)
            pairs.append((k, best))
    return pairs


def compared(clip: Path, plain: bool = False) -> dict[str, Any]:
    """Measure a clip and compare it with its truth, collision by collision."""
    truth = po.read_collisions(clip.with_suffix(".truth.parquet"))
    found = measure_by_script(clip) if plain else measure(clip)
    pairs = paired(truth, found)
    a = truth.loc[[k for k, _ in pairs]].reset_index(drop=True)
    b = found.loc[[k for _, k in pairs]].reset_index(drop=True)
    fit = (a["accepted"] & b["accepted"]).to_numpy()
    wanted = int(truth["accepted"].sum())
    a_fit, b_fit = a[fit], b[fit]
    errors = {
        "area": b_fit["area_um2"] / a_fit["area_um2"] - 1,
        "speed": b_fit["speed_mm_s"] / a_fit["speed_mm_s"] - 1,
        "S": b_fit["symmetry"] - a_fit["symmetry"],
        "A1/A2": b_fit["daughter_area_ratio"] - a_fit["daughter_area_ratio"],
        "neck_px": (b_fit["neck_um"] - a_fit["neck_um"]) / PIXEL_UM,
        "breakup_neck_px": (b_fit["breakup_neck_um"] - a_fit["breakup_neck_um"]) / PIXEL_UM,
        "breakup_frame": b_fit["breakup_frame"] - a_fit["breakup_frame"],
        "contact_frame": (b_fit["contact_frame"] - a_fit["contact_frame"]).astype(float),
    }
    extra = found.drop(index=[k for _, k in pairs])
    return {
        "clip": clip.stem,
        "truth": wanted,
        "found": int((a["accepted"]).sum()),
        "accepted": int(fit.sum()),
        "false": int(extra["accepted"].sum()),
        # Where neither the truth nor the film knows it, they agree too.
        "outcome_right": sum(map(operator.eq, a_fit["broke"], b_fit["broke"])),
        "broke": int(a_fit["broke"].sum()),
        "errors": {name: values.dropna().tolist() for name, values in errors.items()},
        "truth_rows": a_fit,
        "video_rows": b_fit,
    }


def line_of(results: list[dict[str, Any]]) -> dict[str, float]:
    """Return the figures of one or more clips together."""
    total = {
        name: sum(each[name] for each in results)
        for name in ("truth", "found", "accepted", "false", "outcome_right", "broke")
    }
    errors = {
        name: np.abs(np.concatenate([each["errors"][name] for each in results]))
        for name in results[0]["errors"]
    }

    def middle(name: str) -> float:
        return float(np.median(errors[name])) if len(errors[name]) else math.nan

    return {
        "collisions": total["truth"],
        "found_percent": 100 * total["found"] / total["truth"],
        "false_percent": 100 * total["false"] / max(1, total["found"]),
        "accepted_percent": 100 * total["accepted"] / max(1, total["found"]),
        "outcome_percent": 100 * total["outcome_right"] / max(1, total["accepted"]),
        "broke": total["broke"],
        "area_percent": 100 * middle("area"),
        "speed_percent": 100 * middle("speed"),
        "S": middle("S"),
        "S_within_0.088_percent": 100 * float(np.mean(errors["S"] <= PAPER_ERROR_OF_S)),
        "A1/A2": middle("A1/A2"),
        "neck_px": middle("neck_px"),
        "breakup_neck_px": middle("breakup_neck_px"),
        "breakup_within_1_percent": 100 * float(np.mean(errors["breakup_frame"] <= 1))
        if len(errors["breakup_frame"])
        else math.nan,
    }


def law(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Fit the break-up law to the truth and to what was measured."""
    fits = {}
    for name in ("truth", "video"):
        table = pd.concat([each[f"{name}_rows"] for each in results], ignore_index=True)
        fitted = po.fit_law(table)
        fits[name] = {
            "rows": len(table),
            "alpha": list(fitted.alpha[:3]),
            "beta": list(fitted.beta[:3]),
        }
    return fits


def shown(name: str, line: dict[str, float]) -> str:
    return f"{name:28s}" + "".join(f"{value:10.4g}" for value in line.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two short clips of each kind")
    parser.add_argument("--plain", action="store_true", help="measure by a short script instead")
    parser.add_argument("--out", type=Path, default=Path("video-accuracy"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    lines: dict[str, dict[str, float]] = {}
    fits: dict[str, Any] = {}
    with ProcessPoolExecutor(thread_count(None), mp_context=get_context("spawn")) as pool:
        for name, cases, runs in (("MODERATE", MODERATE, RUNS), ("HARD", HARD, HARD_RUNS)):
            if arguments.quick:
                cases, runs = cases[:2], 12
            seeds = range(100, 100 + len(cases)) if name == "MODERATE" else range(200, 250)
            jobs = [
                pool.submit(draw, case, arguments.out, runs, seed)
                for case, seed in zip(cases, seeds, strict=False)
            ]
            clips = [job.result() for job in jobs]
            results = list(pool.map(partial(compared, plain=arguments.plain), clips))
            of_kind = {case.name: line_of([r]) for case, r in zip(cases, results, strict=True)}
            of_kind[name] = line_of(results)
            print(" " * 28 + "".join(f"{each[:9]:>10s}" for each in of_kind[name]))
            for each, line in of_kind.items():
                print(shown(each, line), flush=True)
            lines |= of_kind
            if name == "MODERATE" and not arguments.quick:
                fits = law(results)
                print(json.dumps(fits, indent=2), flush=True)
    report = arguments.out / ("accuracy-plain.json" if arguments.plain else "accuracy.json")
    report.write_text(json.dumps({"lines": lines, "law": fits}, indent=2) + "\n")
    print(f"wrote {report}")


if __name__ == "__main__":
    main()
