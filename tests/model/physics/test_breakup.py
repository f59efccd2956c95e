"""What a break-up keeps, and what becomes of the daughters."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

shapely = pytest.importorskip("shapely")
split = pytest.importorskip("shapely.ops").split

BREAKING = [
    {"offset": 0.02, "simulation_capillary_number": 40.0},
    {"offset": 0.0, "simulation_capillary_number": 30.0},
    {"offset": 0.12, "simulation_capillary_number": 90.0},
    {"offset": 0.05, "simulation_capillary_number": 60.0, "size_ratio": 3.0},
    {"offset": 0.02, "simulation_capillary_number": 40.0, "vertex_count": 97},
]


def before_and_after(model, system, constants):
    """Outlines in the step of the first cut, before it and after it, and the event."""
    row = model(**constants, follow_daughters=False)
    scout = system(row)
    scout.advance(1e9)
    (event,) = scout.breakups()
    step = row[_core.MODEL_FIELDS.index("time_step")]
    row[_core.MODEL_FIELDS.index("sample_interval")] = step
    one = system(row)
    one.advance(event["time"])
    assert not one.finished
    before = one.outlines()
    one.advance(event["time"] + step)
    assert one.finished
    return row, before, one.outlines(), event


@pytest.mark.parametrize("constants", BREAKING)
def test_cut_keeps_area_centre_and_names_the_daughters(model, system, constants):
    """Areas add up to round-off, the centre of all area stays, ids and generations count on."""
    _, ((parent, generation, whole, _),), after, event = before_and_after(model, system, constants)
    areas = [_core.area(outline) for _, _, outline, _ in after]
    assert sum(areas) == pytest.approx(_core.area(whole), rel=1e-12)
    assert sorted(areas) == pytest.approx(sorted(event["areas"]), rel=1e-12)
    centers = [np.array(_core.centroid(outline)) for _, _, outline, _ in after]
    center = sum(a * c for a, c in zip(areas, centers, strict=True)) / sum(areas)
    assert center == pytest.approx(_core.centroid(whole), abs=1e-12)
    assert (parent, generation) == (0, 0) == (event["droplet_id"], event["generation"])
    assert [one[0] for one in after] == list(event["daughter_ids"]) == [1, 2]
    assert [one[1] for one in after] == [1, 1]
    for area, (_, _, outline, _) in zip(areas, after, strict=True):
        # as many vertices as the spacing of the parent gives, at least 16; evenly spaced
        expected = constants.get("vertex_count", 64) * math.sqrt(area / _core.area(whole))
        assert len(outline) == max(16, round(expected))
        edges = np.hypot(*(np.roll(outline, -1, axis=0) - outline).T)
        assert edges.max() < 1.05 * edges.mean()
        assert not _core.self_intersects(outline)
        assert shapely.Polygon(outline).exterior.is_ccw


@pytest.mark.parametrize("constants", BREAKING)
def test_cut_keeps_the_momentum(model, system, constants):
    """Σ M_k ⟨v⟩_k of the daughters is M ⟨v⟩ of the parent, with M_k their share of A_eq."""
    _, ((_, _, whole, velocity),), after, event = before_and_after(model, system, constants)
    share = np.array(event["areas"]) / sum(event["areas"])
    momentum = sum(m * v.mean(axis=0) for m, (_, _, _, v) in zip(share, after, strict=True))
    np.testing.assert_allclose(momentum, velocity.mean(axis=0), atol=1e-10)
    assert _core.area(whole) == pytest.approx(math.pi / 4, rel=0.01)


@pytest.mark.parametrize("constants", BREAKING)
def test_cut_runs_along_the_neck(model, system, constants):
    """It is the thinnest chord, or lies at most half way to the next one along both arcs."""
    _, ((_, _, whole, _),), _, event = before_and_after(model, system, constants)
    thickness, i, j = _core.neck(whole)
    assert event["neck_thickness"] == pytest.approx(thickness, rel=1e-12)
    first, second = np.array(event["neck"])
    count = len(whole)
    beside = [whole[(j - s) % count] - whole[(i + s) % count] for s in (-1, 1)]
    longest = max(thickness, *(0.5 * (thickness + np.hypot(*chord)) for chord in beside))
    assert np.hypot(*(second - first)) <= longest * (1 + 1e-12)
    edges = np.hypot(*(np.roll(whole, -1, axis=0) - whole).T)
    for end, vertex in ((first, i), (second, j)):
        assert np.hypot(*(end - whole[vertex])) <= 0.5 * edges.max() * (1 + 1e-9)
    # what is on the left of the cut is one daughter, up to the re-spacing of its outline
    parts = split(
        shapely.Polygon(whole),
        shapely.LineString([first + 0.1 * (first - second), second + 0.1 * (second - first)]),
    )
    areas = sorted(part.area for part in parts.geoms)
    assert areas[-2:] == pytest.approx(sorted(event["areas"]), abs=1e-3)


@pytest.mark.parametrize("capillary", [25.0, 30.0, 50.0, 90.0])
@pytest.mark.parametrize("count", [48, 64, 128])
def test_head_on_cut_is_symmetric(model, run, capillary, count):
    """Offset zero: S = 1 to 1e-6, and the daughters' areas are equal to 1 %."""
    row = model(
        offset=0.0,
        simulation_capillary_number=capillary,
        vertex_count=count,
        follow_daughters=False,
    )
    (got,) = run(row)
    assert got["outcome"] == 1
    assert got["symmetry"] == pytest.approx(1, abs=1e-6)
    assert got["small_daughter_area"] / got["large_daughter_area"] > 0.99


@pytest.mark.parametrize("offset", [0.05, 0.1, 0.15])
def test_larger_daughter_passes_on_the_side_of_the_offset(model, system, offset):
    """A droplet that starts above the obstacle leaves most of itself above, and mirrored below."""
    for side in (1, -1):
        row = model(offset=side * offset, simulation_capillary_number=90.0, follow_daughters=False)
        one = system(row)
        one.advance(1e9)
        assert one.breakups()
        large = max(one.outlines(), key=lambda d: _core.area(d[2]))
        assert side * _core.centroid(large[2])[1] > 0


@pytest.mark.parametrize("constants", BREAKING)
def test_daughters_keep_apart_and_keep_their_area(model, system, result, constants):
    """After the cut droplets touch but never overlap, and every area stays within 1 % of A_eq.

    The two sides of a cut start in touch, within the range l_eq/2 of their repulsion: they may
    share a sliver no deeper than that range along the cut, and none once they have parted.
    """
    one = system(model(**constants))
    one.advance(1e9)
    total = sum(_core.area(outline) for _, _, outline, _ in one.outlines())
    assert total == pytest.approx(math.pi / 4, rel=0.01)
    assert result(one)["guard"] == 0
    assert result(one)["droplet_count"] == 1 + result(one)["breakup_count"] == len(one.outlines())
    cut = one.breakups()[0]["time"]
    again = system(model(**constants))
    again.advance(cut)
    deepest = 0.0
    while not again.finished:
        again.advance(again.time + 0.005)
        polygons = [shapely.Polygon(outline) for _, _, outline, _ in again.outlines()]
        assert all(p.is_valid for p in polygons)
        for k, p in enumerate(polygons):
            for q in polygons[:k]:
                shared = p.intersection(q)
                if shared.is_empty:
                    continue
                # depth of a sliver: its area over half its outline's length
                depth = 2 * shared.area / shared.length if shared.length else 0.0
                deepest = max(deepest, depth)
    spacing = math.pi / constants.get("vertex_count", 64)
    assert deepest < 0.5 * spacing
    polygons = [shapely.Polygon(outline) for _, _, outline, _ in again.outlines()]
    gaps = [p.distance(q) for k, p in enumerate(polygons) for q in polygons[:k]]
    assert min(gaps) > 0


def test_daughters_survive_their_break_up(any_collisions):
    """Of a seeded sweep over the usual range no run is lost to a guard after its break-up.

    The daughters are smaller and stiffer than the droplet that the time step was chosen for.
    """
    rows = any_collisions(np.random.default_rng(5), 300)
    results = _core.run_many(rows, None, 1, None)
    guard, cuts = (results[:, _core.RESULT_FIELDS.index(n)] for n in ("guard", "breakup_count"))
    assert (cuts > 0).sum() > 80
    lost = (cuts > 0) & (guard > 0)
    assert lost.sum() <= 0.01 * (cuts > 0).sum()


def test_generations_are_counted(model, system, result):
    """Daughters of daughters: each event names a droplet that lived, and its generation.

    With the separation read as a length, tails are cut from daughters too.
    """
    one = system(
        model(offset=0.05, simulation_capillary_number=60.0, neck_separation_unit="diameter")
    )
    one.advance(1e9)
    got, events = result(one), one.breakups()
    assert got["guard"] == 0
    assert len(events) == got["breakup_count"] >= 2
    generation = {0: 0}
    for event in events:
        assert generation[event["droplet_id"]] == event["generation"]
        parent = generation.pop(event["droplet_id"])
        generation.update(dict.fromkeys(event["daughter_ids"], parent + 1))
    assert {d[0]: d[1] for d in one.outlines()} == generation
    assert got["generations"] == max(generation.values()) >= 2
    areas = sum(_core.area(outline) for _, _, outline, _ in one.outlines())
    assert areas == pytest.approx(math.pi / 4, rel=0.01)
