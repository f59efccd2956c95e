"""Random parameters and arrangements over all that is accepted: what each result must satisfy.

`--attacks N` sets how many collisions of each model are drawn: ten for each; and N arrangements.
"""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from matplotlib.path import Path as Polygon

import pinchoff as po
from pinchoff import _core

pytestmark = pytest.mark.slow

MODELS = ("deformable-particle", "front-tracking")
LONGEST_S = 60.0  # of CPU time, for a run


def drawn(rng: np.random.Generator, model: str) -> po.Parameters | None:
    """Draw parameters far beyond the paper's; None where they are refused."""

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    unit = str(rng.choice(["perimeter", "diameter"]))
    tension = log(5.0, 300.0)
    try:
        return po.Parameters(
            model=model,
            size_ratio=log(0.5, 20.0),
            simulation_capillary_number=log(1.0, 1500.0),
            offset=float(rng.choice([0.0, rng.uniform(-1.5, 1.5), rng.normal(0.0, 0.1)])),
            vertex_count=int(rng.choice([16, 32, 64, 96])),
            line_tension=tension if model == "deformable-particle" else None,
            start_distance=float(rng.uniform(1.2, 5.0)),
            neck_thickness=log(0.02, 0.7),
            neck_separation=float(rng.uniform(0.05, 0.9 if unit == "diameter" else 0.45)),
            neck_separation_unit=unit,
            follow_daughters=bool(rng.random() < 0.5),
            time_limit=float(rng.uniform(1.0, 12.0)),
        )
    except po.InputError:
        return None


def faults(parameters: po.Parameters, row: dict[str, object]) -> list[str]:
    """Return what an accepted row has that cannot be."""
    found = []

    def require(name: str, holds: bool) -> None:
        if not holds:
            found.append(name)

    number = {name: value for name, value in row.items() if isinstance(value, float)}
    require("S from 0 to 1", 0.0 <= number["symmetry"] <= 1.0)
    require("contact after the start", 0.0 <= number["contact_time"] <= number["end_time"])
    area = number["contact_area"]
    require("area near that of the start", abs(area / (math.pi / 4) - 1.0) < 0.05)
    require("shape parameter at least 1", number["contact_shape_parameter"] >= 1.0 - 1e-9)
    small, large = number["small_daughter_area"], number["large_daughter_area"]
    if row["broke"]:
        require("broke after contact", number["breakup_time"] >= number["contact_time"])
        require("daughters positive", 0.0 < small <= large)
        require("daughters make up the mother", abs((small + large) / area - 1.0) < 0.05)
        require("ratio of the daughters", number["daughter_area_ratio"] == small / large)
        require("neck below its limit", number["breakup_neck"] < parameters.neck_thickness)
        needed = {"breakup_time", "breakup_neck", "daughter_area_ratio"}
    else:
        require("no daughters", math.isnan(small) and math.isnan(large))
        needed = set()
    needed |= {"symmetry", "contact_time", "contact_speed", "impact_parameter", "end_time"}
    needed |= {"breakup_number"} if number["symmetry"] > 0 else set()
    require("no NaN", not any(math.isnan(number[name]) for name in needed))
    require("finite", not any(math.isinf(value) for value in number.values()))
    return found


def crossing(outline: np.ndarray) -> bool:
    """Return whether two edges of an outline cross, by all pairs of them."""
    a, b = outline, np.roll(outline, -1, axis=0)

    def side(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        u, v = q[:, None] - p[:, None], r[None] - p[:, None]
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]

    first = side(a, b, a) * side(a, b, b) < 0
    hits = first & first.T
    n = len(outline)
    i, j = np.nonzero(hits)
    return bool(np.any((np.abs(i - j) > 1) & (np.abs(i - j) < n - 1)))


def faults_of_outlines(collision: po.Collision, obstacles: np.ndarray) -> list[str]:
    """Return what the outlines of an accepted run have that cannot be."""
    found = []
    for frame in collision.outlines:
        shapes = [outline.vertices for outline in frame]
        centres = [*obstacles[:, :2], *(shape.mean(axis=0) for shape in shapes)]
        for k, shape in enumerate(shapes):
            if not np.isfinite(shape).all():
                found.append("outlines finite")
            elif _core.area(shape) <= 0:
                found.append("outlines counter-clockwise")
            if crossing(shape):
                found.append("outlines without crossings")
            others = np.delete(np.array(centres), len(obstacles) + k, axis=0)
            if Polygon(shape).contains_points(others).any():
                found.append("nothing inside of a droplet")
    return found


@pytest.mark.parametrize("model", MODELS)
def test_every_accepted_row_of_a_random_search_can_be(attacks, model):
    rng = np.random.default_rng(19)
    count, wrong, slow = 0, [], []
    rejected: dict[str, int] = {}
    while count < 10 * attacks:
        parameters = drawn(rng, model)
        if parameters is None:
            continue
        count += 1
        start = time.process_time()
        try:
            collision = po.simulate(parameters, outlines=0.5)
        except po.SimulationError as error:
            rejected[error.guard] = rejected.get(error.guard, 0) + 1
            continue
        finally:
            if time.process_time() - start > LONGEST_S:
                slow.append(parameters)
        row = collision.to_row()
        if not row["accepted"]:
            continue
        found = faults(parameters, row)
        found += faults_of_outlines(collision, collision.outlines.obstacles)
        if found:
            given = parameters.model_dump(exclude_defaults=True)
            wrong.append(f"{sorted(set(found))}: {given}")
    summary = f"{len(wrong)} wrong of {count}, stopped by guards: {rejected}"
    print(summary)
    assert not wrong, "\n".join([summary, *wrong[:20]])
    assert not slow, slow


def arranged(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Draw up to five droplets upstream of up to six obstacles, which may touch one another."""
    count = int(rng.integers(1, 6))
    places = np.column_stack([rng.uniform(-6.0, -2.0, count), rng.uniform(-2.0, 2.0, count)])
    obstacles = np.column_stack(
        [
            rng.uniform(-1.0, 3.0, k := int(rng.integers(1, 7))),
            rng.uniform(-1.5, 1.5, k),
            rng.uniform(0.05, 0.6, k),
        ]
    )
    return {
        "droplets": np.column_stack([places, rng.uniform(0.3, 1.5, count)]),
        "obstacles": obstacles,
    }


@pytest.mark.filterwarnings("ignore:the default flow:UserWarning")
@pytest.mark.parametrize("model", MODELS)
def test_every_random_arrangement_can_be(attacks, model):
    rng = np.random.default_rng(20)
    count, wrong, slow = 0, [], []
    rejected: dict[str, int] = {}
    while count < attacks:
        parameters, places = drawn(rng, model), arranged(rng)
        if parameters is None:
            continue
        flow = po.flow.uniform() if rng.random() < 0.3 else None
        start = time.process_time()
        try:
            collision = po.simulate(parameters, flow=flow, outlines=0.5, **places)
        except po.InputError:  # too near to one another
            continue
        except po.SimulationError as error:
            count += 1
            rejected[error.guard] = rejected.get(error.guard, 0) + 1
            continue
        finally:
            if time.process_time() - start > LONGEST_S:
                slow.append((parameters, places))
        count += 1
        if collision.to_row()["accepted"] and (
            found := faults_of_outlines(collision, places["obstacles"])
        ):
            given = parameters.model_dump(exclude_defaults=True)
            wrong.append(f"{sorted(set(found))}: {given}, {places}")
    summary = f"{len(wrong)} wrong of {count}, stopped by guards: {rejected}"
    print(summary)
    assert not wrong, "\n".join([summary, *wrong[:20]])
    assert not slow, slow
