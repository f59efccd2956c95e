"""Droplets that merge: the clock of the film between them, and what joining them keeps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff import _core
from pinchoff.model.emulsion_result import EVENT_COLUMNS
from pinchoff.studies.head_on import head_on_pair

SPRINGS, FRONT = "deformable-particle", "front-tracking"
MODELS = (SPRINGS, FRONT)
COLUMNS = [c.name for c in EVENT_COLUMNS]


def model(kind=FRONT, number=25.0, vertices=32):
    return po.Parameters(model=kind, simulation_capillary_number=number, vertex_count=vertices)


def eddies(size, nodes=64):
    x = np.arange(nodes) * size / nodes
    grid_x, grid_y = np.meshgrid(2 * np.pi * x / size, 2 * np.pi * x / size)
    u = 1 + 0.4 * np.cos(grid_y) * np.cos(grid_x)
    v = 0.4 * np.sin(grid_y) * np.sin(grid_x)
    return po.flow.sampled(x, x, u, v, periodic="xy")


def crowd(time=2.0, coalescence=None, kind=FRONT, shift=(0.0, 0.0), **changes):
    """Sixteen droplets in eddies, in a cell that repeats itself."""
    size = 4 * 1.15
    starts = [
        [(i + 0.5) * 1.15 + shift[0], (j + 0.5) * 1.15 + shift[1], 0.95 - 0.1 * ((i + j) % 3)]
        for j in range(4)
        for i in range(4)
    ]
    arguments = {
        "droplets": starts,
        "flow": eddies(size),
        "cell": (0, size, 0, size),
        "periodic": "xy",
        "coalescence": coalescence,
        "threads": 1,
        **changes,
    }
    return po.simulate_emulsion(model(kind), time=time, **arguments)


def of_kind(run, kind):
    return run.events[run.events["kind"] == kind]


def frames_of(run, **arguments):
    kept = []
    return run(on_frame=lambda time, droplets: kept.append((time, droplets)), **arguments), kept


def assert_same_frames(one, other):
    for (_, a), (_, b) in zip(one, other, strict=True):
        assert [d[:2] for d in a] == [d[:2] for d in b]
        for first, second in zip(a, b, strict=True):
            np.testing.assert_array_equal(first[2], second[2])
            np.testing.assert_array_equal(first[3], second[3])


# ---------------------------------------------------------------- the clock


@pytest.mark.parametrize("kind", MODELS)
def test_films_that_never_drain_change_no_bit(kind):
    """K = inf records contacts, and that is all."""
    without, plain = frames_of(crowd, kind=kind)
    followed, same = frames_of(crowd, kind=kind, coalescence=po.Coalescence(math.inf))
    assert_same_frames(plain, same)
    assert without.balance["touches"] == 0 < 5 < followed.balance["touches"]
    assert followed.balance["merges"] == 0
    changed = {"touches": 0}
    assert without.balance == followed.balance | changed


@pytest.mark.parametrize("kind", MODELS)
def test_without_a_film_droplets_merge_when_they_touch(kind):
    run = head_on_pair(model(kind), po.Coalescence(0.0))
    merge, touched = of_kind(run, "merge").iloc[0], of_kind(run, "touched").iloc[0]
    assert merge["time"] == touched["time"]
    # The look that found them in contact came before they moved by another spacing.
    assert 0.0 < merge["facing_length"] < 0.5
    assert run.balance["present"] + run.balance["left"] == 1


def test_a_head_on_pair_merges_at_one_to_a_step():
    """Just before the step the clock was below 1, at the rate of the length then."""
    parameters = model(number=30.0, vertices=64)
    drainage = 0.2
    run = head_on_pair(parameters, po.Coalescence(drainage))
    merge = of_kind(run, "merge").iloc[0]
    step = 0.05 / round(0.05 / parameters.effective_time_step)
    # No rate was larger than that of a spacing, the shortest length there is.
    fastest = 1.0 / (drainage * 30.0 * merge["facing_length"] ** 2)
    assert 1.0 <= merge["clock"] < 1.0 + 3.0 * fastest * step
    assert merge["since"] < merge["time"]


def test_the_clock_is_that_of_the_outlines():
    """By brute force from frames: the length within a spacing, and its film's rate."""
    shapely = pytest.importorskip("shapely")
    parameters, drainage, spacing = model(number=30.0, vertices=64), 1e3, math.pi / 64
    run, frames = frames_of(
        lambda **o: head_on_pair(parameters, po.Coalescence(drainage), interval=0.05, **o)
    )
    parted = of_kind(run, "parted").iloc[0]
    clock, longest = 0.0, 0.0
    for time, droplets in frames:
        if not parted["since"] < time < parted["time"] or len(droplets) < 2:
            continue
        rings = [shapely.LinearRing(d[2]) for d in droplets]
        lengths = [a.intersection(b.buffer(spacing)).length for a, b in (rings, rings[::-1])]
        length = max(np.mean(lengths), math.sqrt(2 * spacing))
        longest = max(longest, length)
        clock += 0.05 / (drainage * 30.0 * length**2)
    assert parted["facing_length"] == pytest.approx(longest, rel=0.05)
    assert parted["clock"] == pytest.approx(clock, rel=0.05)


def test_small_droplets_drain_by_their_harmonic_mean():
    """Both of half the size, all else scaled: t_d ∝ (L/D_h)² D_h."""
    run = contact_of_still_droplets([1.0, 1.0])
    small = contact_of_still_droplets([1.0, 0.5])
    for found, mean in ((run, 1.0), (small, 2 / 3)):
        rate = mean / (10.0 * found["length"] ** 2)
        assert found["clock"] == pytest.approx(rate * found["time"], rel=1e-9)


def contact_of_still_droplets(diameters, time=0.05):
    """Return the film of two droplets side by side in a fluid that carries both, as its state."""
    reach = sum(diameters) / 2 + 0.02
    run = core_run(
        model(vertices=32), [[0, 0, diameters[0]], [reach, 0, diameters[1]]], (10.0, 0.0, 0.0)
    )
    run.advance(round(time / 0.05))
    state = np.asarray(run.state())
    first = len(_core.BALANCE_FIELDS) + 8  # behind the counts
    # first, second, since, D_h, least length, clock, needed, length
    *_, least, clock, _, length = state[first : first + 8].tolist()
    return {"clock": clock, "length": max(length, least), "time": time}


def core_run(parameters, droplets, how, obstacles=None, seed=0, threads=1, box=None, flow=None):
    """Return a run of the core, of parameters or their row, whose droplets may start in contact."""
    return _core.Emulsion(
        parameters.model_row() if isinstance(parameters, po.Parameters) else parameters,
        po.flow.uniform() if flow is None else flow,
        np.zeros((0, 3)) if obstacles is None else np.array(obstacles, dtype=float),
        np.array(droplets, dtype=float),
        np.zeros(4) if box is None else np.array(box, dtype=float),
        box is not None,
        box is not None,
        0.05,
        0.0,
        np.zeros(4),
        np.zeros(0),
        math.inf,
        np.array(how, dtype=float),
        seed,
        threads,
    )


def events_of(run):
    table = pd.DataFrame(np.asarray(run.take_events()), columns=_core.EVENT_FIELDS)
    table["kind"] = [_core.EVENT_KINDS[int(code)] for code in table["kind"]]
    return table


# ---------------------------------------------------------------- separation, chance


def test_droplets_that_part_merge_late_in_their_clock():
    """S = 1: every separation merges; in between: where C has come to 1 - s."""
    parameters = model(number=30.0)
    whole = of_kind(head_on_pair(parameters, po.Coalescence(1e3)), "parted").iloc[0]["clock"] * 1e3
    drainage = whole / 0.7  # the clock comes to 0.7
    for separation, merges in ((0.2, 0), (0.4, 1), (1.0, 1)):
        run = head_on_pair(parameters, po.Coalescence(drainage, separation))
        assert run.balance["merges"] == merges
        if merges:
            merge = of_kind(run, "merge").iloc[0]
            assert merge["clock"] == pytest.approx(0.7, abs=0.02)
    assert head_on_pair(parameters, po.Coalescence(math.inf, 1.0)).balance["merges"] == 1
    assert head_on_pair(parameters, po.Coalescence(math.inf, 0.99)).balance["merges"] == 0


@pytest.mark.parametrize("kind", MODELS)
def test_every_separation_merges_where_s_is_one(kind):
    run = crowd(3.0, po.Coalescence(math.inf, 1.0), kind)
    assert run.balance["merges"] > 3
    parted = of_kind(run, "parted")
    merged = set(of_kind(run, "merge")[["droplet_id", "partner"]].to_numpy().ravel())
    # What parted was taken over by what came of one of the two at the same instant, or was refused.
    for event in parted.to_dict("records"):
        assert {event["droplet_id"], event["partner"]} & merged


def pairs_at_rest(count, seed, threads=1, how=(0.05, 0.0, 1.0), time=3.0):
    """Return the merges of pairs that touch, each alone, while the fluid carries all along."""
    starts = [[2.5 * k, 4.0 * (k % 7) + 1.02 * j, 1.0] for k in range(count) for j in range(2)]
    run = core_run(model(vertices=16), starts, how, seed=seed, threads=threads)
    run.advance(round(time / 0.05))
    table = events_of(run)
    return table[table["kind"] == "merge"].reset_index(drop=True)


def test_stochastic_merging_has_a_rate():
    """The clock at which pairs merge: an exponential distribution of mean 1, by the seed."""
    from scipy.stats import kstest

    merges = pairs_at_rest(300, seed=1)
    assert len(merges) > 0.95 * 300
    late = merges["clock"].to_numpy()
    # Seen step by step: each is at most a step's share late.
    assert kstest(late, "expon").pvalue > 1e-3
    assert late.mean() == pytest.approx(1.0, abs=0.2)
    pd.testing.assert_frame_equal(merges, pairs_at_rest(300, seed=1, threads=2))
    assert not pairs_at_rest(300, seed=2)["clock"].equals(merges["clock"])


# ---------------------------------------------------------------- joining


@pytest.mark.parametrize("kind", MODELS)
def test_merging_keeps_area(kind):
    _, frames = frames_of(lambda **o: crowd(2.0, po.Coalescence(0.01), kind, interval=0.05, **o))
    areas = [sum(_core.area(d[2]) for d in droplets) for _, droplets in frames]
    assert len(frames[-1][1]) < 12
    # Springs: their pressure squeezes small droplets by up to a percent.
    assert np.ptp(areas) < (1e-6 if kind == FRONT else 0.01) * areas[0]


@pytest.mark.parametrize("kind", MODELS)
def test_at_the_instant_of_a_merge_areas_add_up(kind):
    """One window, in which two droplets merge at once: outlines and events."""
    spacing = math.pi / 32
    starts = [[0, 0, 1.0], [0.85 + 0.5 * spacing, 0.1, 0.7]]
    run = core_run(model(kind, number=20.0), starts, (0.0, 0.0, 0.0))
    run.advance(1)
    merge = events_of(run).iloc[1]
    assert merge["kind"] == "merge"
    assert merge["area"] == pytest.approx(math.pi / 4 * (1 + 0.7**2), rel=1e-12)
    assert [merge["area_1"], merge["area_2"]] == pytest.approx([math.pi / 4, math.pi / 4 * 0.49])
    _, _, vertices, _ = run.frame()
    area = _core.area(np.asarray(vertices))
    assert area == pytest.approx(merge["area"], rel=1e-6 if kind == FRONT else 5e-3)


def test_merging_keeps_momentum():
    """Springs without drag, across a period: the sum of m v stays to round-off."""
    row = model(SPRINGS).replace(line_tension=1.0).model_row()
    for name, value in (("drag", 1e-13), ("neck_thickness", 0.0), ("stop_at_breakup", 0.0)):
        row[_core.MODEL_FIELDS.index(name)] = value
    starts = [[0.1, 1.0, 1.0], [2.92, 1.3, 0.9], [0.9, 0.45, 0.6]]
    still, box = po.flow.uniform(0, 0), [0.0, 3.7, 0.0, 3.0]
    run = core_run(row, starts, (0.5, 0.0, 0.0), flow=still, box=box)
    present, largest = [], 0.0
    for _ in range(60):
        run.advance(1)
        _, offsets, _, velocities = (np.asarray(part) for part in run.frame())
        masses = np.asarray(run.sizes())[:, 2] ** 2
        ends = offsets.astype(int)
        mean = [velocities[a:b].mean(axis=0) for a, b in itertools.pairwise(ends)]
        momentum = sum(m * v for m, v in zip(masses, mean, strict=True))
        present.append(len(masses))
        largest = max(largest, max(np.hypot(*v) for v in mean))
        assert np.abs(momentum).max() < 1e-12
    assert present[-1] < 3
    assert largest > 1e-3


@pytest.mark.parametrize("kind", MODELS)
def test_a_bridge_opens_before_it_counts_as_a_neck(kind):
    """Two droplets that barely touch: the bridge is far thinner than the threshold, and opens."""
    parameters = model(kind, number=25.0, vertices=64)
    run = core_run(parameters, [[0, 0, 1], [1.03, 0, 1]], (0.0, 0.0, 0.0))
    thickness = []
    for _ in range(30):
        run.advance(1)
        table = events_of(run)
        assert not (table["kind"] == "breakup").any()
        _, _, vertices, _ = run.frame()
        r = np.asarray(vertices)
        r = r - r.mean(axis=0)
        thickness.append(np.ptp(r[np.abs(r[:, 0]) < 0.1, 1]))
    threshold = parameters.neck_thickness * math.sqrt(2.0)
    assert thickness[-1] > threshold
    assert np.diff(thickness).min() > -0.02
    assert len(np.asarray(run.sizes())) == 1


def test_a_bridge_that_closes_again_is_a_neck():
    """Drawn apart far faster than the bridge opens: what was joined breaks there again."""
    nodes = np.linspace(-8, 8, 65)
    gx, gy = np.meshgrid(nodes, nodes)
    pulling = po.flow.sampled(nodes, nodes, gx, -gy)
    run = core_run(
        model(number=1e5, vertices=64),
        [[-0.5, 0.03, 1], [0.48, -0.03, 0.9]],
        (math.inf, 1.0, 0.0),
        flow=pulling,
    )
    run.advance(15)
    events = events_of(run)
    assert events["kind"].tolist() == ["touched", "merge", "breakup"]
    broke = events.iloc[2]
    assert broke["time"] > events["time"][1] + 0.1
    assert abs(broke["x"]) < 0.1
    assert broke["neck_thickness"] < 0.1
    areas = sorted([broke["area_1"], broke["area_2"]])
    assert areas == pytest.approx([math.pi / 4 * 0.81, math.pi / 4], rel=0.05)


def test_halves_of_a_break_up_are_not_in_contact_until_they_have_parted():
    """The collision that breaks a droplet: K = 0 does not undo it on the spot."""
    scene = {
        "droplets": [[-2.5, 0.02, 1.0]],
        "obstacles": [[0, 0, 1 / 5.66]],
        "flow": po.flow.stokes(1 / 5.66),
        "coalescence": po.Coalescence(0.0),
    }
    run = po.simulate_emulsion(model(number=40.0), time=3.2, **scene)
    broke = of_kind(run, "breakup").iloc[0]
    sisters = {broke["daughter_1"], broke["daughter_2"]}
    for event in of_kind(run, "touched").to_dict("records"):
        if {event["droplet_id"], event["partner"]} == sisters:
            assert event["time"] > broke["time"] + 0.01
    assert run.balance["breakups"] >= 1


def test_droplets_do_not_close_round_a_pillar():
    """A pillar between two droplets that touch on both sides of it: refused, and said so."""
    run = core_run(
        model(vertices=48), [[0, 0, 1], [1.045, 0, 1]], (0.0, 0.0, 0.0), [[0.5225, 0.0, 0.02]]
    )
    run.advance(1)
    table = events_of(run)
    refused = table[table["kind"] == "unmerged"]
    assert len(refused) == 1
    assert _core.GUARDS[int(refused.iloc[0]["guard"])] == "penetration"
    assert not (table["kind"] == "merge").any()
    counts = dict(zip(_core.BALANCE_FIELDS, np.asarray(run.balance()).tolist(), strict=True))
    assert counts["unmerged"] == 1
    assert len(np.asarray(run.sizes())) == 2


# ---------------------------------------------------------------- the same bits


MANY = po.Coalescence(0.02, 0.3, stochastic=True)


@pytest.mark.parametrize("kind", MODELS)
def test_threads_do_not_show_in_any_bit(kind):
    runs = [frames_of(crowd, coalescence=MANY, kind=kind, threads=n, seed=4) for n in (1, 2, 8)]
    assert runs[0][0].balance["merges"] > 3
    for run, frames in runs[1:]:
        assert_same_frames(runs[0][1], frames)
        pd.testing.assert_frame_equal(runs[0][0].events, run.events)


@pytest.mark.parametrize("how", [po.Coalescence(0.05), po.Coalescence(math.inf, 1.0)])
def test_a_shift_of_everything_changes_nothing(how):
    """Contacts across the edges of the cell are those within it, but for round-off."""
    size = 4 * 1.15
    one = crowd(1.0, how, droplets=[[2.0, 2.0, 1], [3.05, 2.2, 0.8]], flow=narrowing(size))
    two = crowd(1.0, how, droplets=[[2.0, -0.7, 1], [3.05, -0.5, 0.8]], flow=narrowing(size))
    assert one.balance["touches"] == 1
    names = ["time", "x", "area", "facing_length", "clock"]
    np.testing.assert_allclose(one.events[names], two.events[names], atol=1e-6)


def narrowing(size, nodes=64):
    """A flow that depends on x alone, and pushes together what is at its middle."""
    x = np.arange(nodes) * size / nodes
    u = np.broadcast_to(-np.sin(2 * np.pi * (x - 2.5) / size), (nodes, nodes))
    return po.flow.sampled(x, x, u, 0 * u, periodic="xy")


@pytest.mark.parametrize("kind", MODELS)
def test_numbers_balance_and_contacts_end_as_often_as_they_begin(kind):
    run, frames = frames_of(crowd, coalescence=MANY, kind=kind, time=3.0, seed=1)
    events = run.events
    for time, droplets in frames:
        counts = events[events["time"] <= time + 1e-9]["kind"].value_counts()
        assert len(droplets) == 16 + counts["breakup"] - counts["merge"] - counts["retired"]
    counts = events["kind"].value_counts()
    assert counts["merge"] == run.balance["merges"] > 3
    going = counts["touched"] - counts["parted"] - counts["merge"]
    assert 0 <= going <= run.balance["present"] * 4
    area = of_kind(run, "merge")
    assert np.allclose(area["area"], area["area_1"] + area["area_2"])
