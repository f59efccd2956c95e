"""Many droplets: the same physics as a single collision, whatever the grouping and the threads."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff import _core

SPRINGS, FRONT = "deformable-particle", "front-tracking"
MODELS = (SPRINGS, FRONT)
FEW = po.Parameters(model=SPRINGS, simulation_capillary_number=30, vertex_count=32)


def periodic_flow(length, width, nodes=96):
    """A smooth, divergence-free flow that repeats itself, with eddies."""
    x = np.arange(nodes) * length / nodes
    y = np.arange(nodes) * width / nodes
    grid_x, grid_y = np.meshgrid(2 * np.pi * x / length, 2 * np.pi * y / width)
    u = 1 + 0.4 * np.cos(grid_y) * np.cos(grid_x)
    v = 0.4 * width / length * np.sin(grid_y) * np.sin(grid_x)
    return po.flow.sampled(x, y, u, v, periodic="xy")


def lattice(rows, columns, pitch, diameter=0.9, origin=(0.5, 0.5)):
    return [
        [
            (i + origin[0]) * pitch + 0.03 * math.sin(5 * j),
            (j + origin[1]) * pitch + 0.02 * math.cos(3 * i),
            diameter - 0.1 * ((i + j) % 3),
        ]
        for j in range(rows)
        for i in range(columns)
    ]


def in_a_box(row, flow, starts, box, obstacles=(), *, exhaustive=False):
    """Droplets of the core in a periodic box, on one thread; nothing flows in or is recorded."""
    nothing = np.zeros(0)
    return _core.Emulsion(
        row,
        flow,
        np.reshape(obstacles, (-1, 3)).astype(float),
        np.array(starts),
        np.array(box, dtype=float),
        True,
        True,
        0.05,
        0.0,
        np.zeros(4),
        nothing,
        math.inf,
        nothing,
        0,
        1,
        exhaustive=exhaustive,
    )


def crowd(time, *, model=SPRINGS, on_frame=None, threads=1, **changes):
    """Twenty-five droplets pressed against each other and against pillars, all of it periodic."""
    size = 5 * 1.02
    arguments = {
        "droplets": lattice(5, 5, 1.02),
        "flow": periodic_flow(size, size),
        "cell": (0, size, 0, size),
        "periodic": "xy",
        "threads": threads,
        "on_frame": on_frame,
        **changes,
    }
    return po.simulate_emulsion(FEW.replace(model=model), time=time, **arguments)


def last_frame(run, **arguments):
    """Return the droplets of the last frame of a run."""
    kept = []
    run(on_frame=lambda time, droplets: kept.append((time, droplets)), **arguments)
    return kept[-1][1]


def assert_same(one, other, tolerance=0.0):
    assert [(d[0], d[1]) for d in one] == [(d[0], d[1]) for d in other]
    for a, b in zip(one, other, strict=True):
        for k in (2, 3):
            if tolerance:
                np.testing.assert_allclose(a[k], b[k], atol=tolerance)
            else:
                np.testing.assert_array_equal(a[k], b[k])


@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize(("capillary", "offset"), [(20.0, 0.05), (40.0, 0.02)])
def test_a_single_collision_is_the_same_to_the_last_bit(kind, capillary, offset):
    """The same droplet and obstacle through `simulate`, up to when the droplet has left.

    A front is put right between blocks, whose ends differ: there to round-off.
    """
    model = po.Parameters(model=kind, simulation_capillary_number=capillary, offset=offset)
    frames, other = [], []
    alone = po.simulate(model, outlines=0.5, on_frame=lambda t, d: frames.append((t, d)))
    po.simulate_emulsion(
        model,
        time=4,
        droplets=[[-model.start_distance, offset, 1.0]],
        obstacles=[[0, 0, 1 / model.size_ratio]],
        flow=po.flow.stokes(1 / model.size_ratio),
        on_frame=lambda t, d: other.append((t, d)),
    )
    compared = 0
    for (time, one), (also, two) in zip(frames[:-1], other, strict=False):
        assert time == pytest.approx(also, abs=1e-9)
        assert [d[:2] for d in one] == [d[:2] for d in two]
        for a, b in zip(one, two, strict=True):
            if kind == FRONT:
                np.testing.assert_allclose(a[2], b[2], atol=1e-10)
            else:
                np.testing.assert_array_equal(a[2], b[2])
        compared += 1
    assert compared >= 6
    assert alone.broke == (len(other[-1][1]) == 2)


def test_isolated_droplets_go_as_if_they_were_alone():
    """Droplets too far apart to meet: each as in a run of its own, to the last bit."""
    array = po.arrays.staggered(rows=3, columns=4, radius=0.18, gap=0.9)
    x = np.linspace(-6, 12, 200)
    y = np.linspace(-6, 12, 200)
    gx, gy = np.meshgrid(x, y)
    flow = po.flow.sampled(x, y, 1 + 0.2 * np.sin(gy), 0.2 * np.cos(gx))
    starts = [[-3.0, 0.4, 1.0], [-3.0, 2.7, 0.7], [1.4, 5.5, 0.9]]
    frames = {}
    for name, droplets in [("all", starts)] + [(k, [s]) for k, s in enumerate(starts)]:
        kept = []
        po.simulate_emulsion(
            FEW.replace(simulation_capillary_number=8.0),
            time=4,
            droplets=droplets,
            obstacles=array.circles,
            flow=flow,
            on_frame=lambda t, d, kept=kept: kept.append(d),
        )
        frames[name] = kept
    for k in range(3):
        for whole, alone in zip(frames["all"], frames[k], strict=True):
            np.testing.assert_array_equal(whole[k][2], alone[0][2])


@pytest.mark.parametrize("kind", MODELS)
@pytest.mark.parametrize(("crowded", "time"), [(True, 1.5), (False, 8.0)])
def test_threads_do_not_show_in_any_bit(through_pillars, crowded, time, kind):
    scene = crowd if crowded else through_pillars
    frames = [last_frame(scene, time=time, threads=n, model=kind) for n in (1, 2, 8)]
    assert len(frames[0]) > 5
    assert_same(frames[0], frames[1])
    assert_same(frames[0], frames[2])


@pytest.mark.parametrize("kind", MODELS)
def test_numbers_balance_at_every_frame_and_area_is_kept(through_pillars, kind):
    """Start + entered + break-ups - left - retired = present; no area leaks unsaid."""
    seen = []
    run = through_pillars(18.0, model=kind, on_frame=lambda t, d: seen.append((t, d)))
    events = run.events
    for time, droplets in seen:
        counts = events[events["time"] <= time + 1e-9]["kind"].value_counts()
        present = counts["entered"] + counts["breakup"] - counts["left"] - counts["retired"]
        assert len(droplets) == present
        entered = events[(events["time"] <= time + 1e-9) & (events["kind"] == "entered")][
            "area"
        ].sum()
        gone = events[(events["time"] <= time + 1e-9) & events["kind"].isin(["left", "retired"])][
            "area"
        ].sum()
        area = sum(_core.area(d[2]) for d in droplets)
        # Springs: a droplet's area is a little below its rest area, by its Laplace pressure.
        assert area == pytest.approx(entered - gone, rel=1e-3 if kind == FRONT else 0.01)
    assert run.balance["present"] == len(seen[-1][1])
    assert run.balance["left"] > 1
    assert run.balance["breakups"] > 0
    assert run.balance["contacts"] > 5
    ids = [d[0] for d in seen[-1][1]]
    assert ids == sorted(set(ids))


def test_what_flows_in_is_the_fraction_that_was_asked_for():
    """Uniform flow and an empty channel: area in over φ H U t tends to 1, to one droplet."""
    run = po.simulate_emulsion(
        FEW, time=20, outlet=6.0, seed=5, inlet=po.Inlet(0.0, 0.0, 6.0, 0.15, [0.5, 0.9])
    )
    expected = 0.15 * 6.0 * 20
    assert run.balance["area_in"] == pytest.approx(expected, abs=math.pi / 4 * 0.9**2)
    left = run.events[run.events["kind"] == "left"]
    assert len(left) > 10
    assert (left["x"] > 6.0).all()


def test_droplets_wait_at_a_full_inlet_and_never_overlap():
    """Asked for more than fits: some wait, and no two outlines overlap at any frame."""
    shapely = pytest.importorskip("shapely")
    seen = []
    run = po.simulate_emulsion(
        FEW,
        time=4,
        outlet=8.0,
        interval=0.1,
        on_frame=lambda t, d: seen.append(d),
        inlet=po.Inlet(0.0, 0.0, 3.0, 0.85, 0.95),
    )
    assert run.balance["waits"] > 0
    entered = run.events[run.events["kind"] == "entered"]
    assert entered["waited"].max() > 0
    for droplets in seen[::4]:
        polygons = [shapely.Polygon(d[2]) for d in droplets]
        for i, one in enumerate(polygons):
            for other in polygons[:i]:
                assert one.intersection(other).area < 0.01 * one.area


@pytest.mark.parametrize("kind", MODELS)
def test_mirror(kind):
    """The mirrored scene gives the mirrored outlines, as far as round-off lets it."""
    starts = [[0.0, 0.55, 1.0], [-1.1, 0.1, 0.8], [-1.0, 1.2, 0.9], [0.3, -0.6, 0.7]]
    obstacles = [[1.4, 0.2, 0.2], [2.2, -0.6, 0.3]]
    x, y = np.linspace(-4, 8, 121), np.linspace(-4, 4, 81)
    gx, gy = np.meshgrid(x, y)
    u, v = 1 + 0.2 * np.cos(gy), 0.15 * np.sin(gx) + 0.1 * gy
    ends = []
    for sign in (1, -1):
        flip = np.array([1, sign, 1])
        flow = po.flow.sampled(x, y, u[::sign], sign * v[::sign])
        kept = []
        po.simulate_emulsion(
            FEW.replace(model=kind),
            time=1.5,
            droplets=np.array(starts) * flip,
            obstacles=np.array(obstacles) * flip,
            flow=flow,
            on_frame=lambda t, d, kept=kept: kept.append(d),
        )
        ends.append(kept[-1])
    assert len(ends[0]) == len(ends[1])
    for one, two in zip(*ends, strict=True):
        mirrored = (two[2] * [1, -1])[::-1]
        # Vertices are numbered the other way round: compare by the nearest.
        shift = np.argmin(np.hypot(*(mirrored - one[2][0]).T))
        np.testing.assert_allclose(np.roll(mirrored, -shift, axis=0), one[2], atol=1e-6)


@pytest.mark.parametrize("kind", MODELS)
def test_a_shift_by_a_period_changes_nothing(kind):
    """All droplets one cell further on: the same outlines, but for round-off."""
    size = 5 * 1.02
    starts = np.array(lattice(5, 5, 1.02))
    frames = []
    for shift in ([0, 0, 0], [size, -2 * size, 0]):
        frames.append(last_frame(crowd, time=1.0, droplets=starts + shift, model=kind))
    for one, two in zip(*frames, strict=True):
        np.testing.assert_allclose(one[2], two[2], atol=1e-7)


@pytest.mark.parametrize("kind", MODELS)
def test_droplets_in_a_crowd_do_not_overlap(kind):
    """Pressed together in eddies: less than a vertex spacing deep, images included."""
    shapely = pytest.importorskip("shapely")
    size, spacing = 5 * 1.02, math.pi / 32
    droplets = last_frame(crowd, time=3.0, model=kind)
    polygons = [shapely.Polygon(d[2]) for d in droplets]
    touching = 0
    for i, one in enumerate(polygons):
        assert one.is_valid
        for j, other in enumerate(polygons):
            for dx in (-size, 0, size):
                for dy in (-size, 0, size):
                    if (i, dx, dy) == (j, 0, 0):
                        continue
                    image = shapely.affinity.translate(other, dx, dy)
                    if not one.intersects(image):
                        touching += one.distance(image) < spacing
                        continue
                    inside = [p for p in shapely.points(droplets[i][2]) if image.contains(p)]
                    assert all(image.exterior.distance(p) < spacing for p in inside)
    assert touching > 15


def test_momentum_of_touching_droplets_is_kept():
    """Without drag, across a period: the sum of m v stays zero to round-off."""
    row = FEW.replace(line_tension=1.0).model_row()
    for name, value in (("drag", 1e-13), ("neck_thickness", 0.0)):
        row[_core.MODEL_FIELDS.index(name)] = value
    starts = np.array([[0.1, 1.0, 1.0], [2.92, 1.3, 0.9], [0.9, 0.45, 0.6]])
    run = in_a_box(row, po.flow.uniform(0, 0), starts, [0.0, 3.7, 0.0, 3.0])
    run.advance(20)
    _, offsets, _, velocities = run.frame()
    ends = np.asarray(offsets).astype(int)
    mean = [np.asarray(velocities)[a:b].mean(axis=0) for a, b in itertools.pairwise(ends)]
    momentum = sum(d**2 * v for d, v in zip(starts[:, 2], mean, strict=True))
    assert max(np.hypot(*v) for v in mean) > 1e-3
    assert np.abs(momentum).max() < 1e-12


def test_a_small_droplet_does_not_break_where_it_is_said():
    """The break-up of the single collision does not happen below `smallest_breaking`."""
    scene = {
        "time": 2.7,
        "droplets": [[-2.5, 0.02, 1.0]],
        "obstacles": [[0, 0, 1 / 5.66]],
        "flow": po.flow.stokes(1 / 5.66),
    }
    model = FEW.replace(simulation_capillary_number=40)
    assert po.simulate_emulsion(model, **scene).balance["breakups"] >= 1
    assert po.simulate_emulsion(model, smallest_breaking=1.01, **scene).balance["breakups"] == 0


def test_vertices_follow_the_perimeter():
    """Drawn out along one line a droplet keeps its spacing within a factor of 2, and its area."""
    x = np.linspace(-6, 6, 61)
    gx, gy = np.meshgrid(x, x)
    frames = []
    po.simulate_emulsion(
        po.Parameters(simulation_capillary_number=1000, vertex_count=32),
        time=1.6,
        droplets=[[0, 0, 1]],
        flow=po.flow.sampled(x, x, gx, -gy),
        smallest_breaking=2,
        interval=0.1,
        on_frame=lambda _, droplets: frames.append(droplets[0][2]),
    )
    edges = [np.hypot(*(np.roll(r, -1, axis=0) - r).T) for r in frames]
    counts = [len(lengths) for lengths in edges]
    assert edges[-1].sum() > 2.5 * edges[0].sum()
    assert max(lengths.mean() for lengths in edges) < 2.15 * edges[0].mean()  # a window later
    assert counts[0] == 32 < 64 <= counts[-1]
    areas = [
        0.5 * np.sum(np.roll(r[:, 1], -1) * r[:, 0] - np.roll(r[:, 0], -1) * r[:, 1])
        for r in frames
    ]
    np.testing.assert_allclose(areas, areas[0], rtol=1e-6)


@pytest.mark.parametrize("kind", MODELS)
def test_islands_give_what_comparing_everybody_gives(kind):
    """Loose clusters that meet and part, in eddies and among pillars, with nothing that breaks.

    One island of all droplets, every pair and every obstacle looked at, beside islands that come
    and go: the same bits with springs; a front is put right between blocks, there to round-off.
    """
    row = FEW.replace(model=kind).model_row()
    row[_core.MODEL_FIELDS.index("neck_thickness")] = 0.0
    size, rng = 9.0, np.random.default_rng(4)
    obstacles = np.array([[2.0, 2.0, 0.3], [6.5, 4.0, 0.2], [4.0, 7.5, 0.4], [8.9, 0.1, 0.25]])
    starts: list[list[float]] = []
    while len(starts) < 26:
        x, y, d = *rng.uniform(0, size, 2), 1.0  # smaller ones have steps of their own
        discs = [*([a, b, 2 * r] for a, b, r in obstacles), *starts]
        away = [
            math.hypot(*(min(abs(x - a), size - abs(x - a)), min(abs(y - b), size - abs(y - b))))
            - (d + e) / 2
            for a, b, e in discs
        ]
        if min(away) > 0.12:
            starts.append([x, y, d])
    flow = periodic_flow(size, size)
    islands, frames = [], []
    for exhaustive in (False, True):
        run = in_a_box(row, flow, starts, [0, size, 0, size], obstacles, exhaustive=exhaustive)
        run.advance(14)
        counts = dict(zip(_core.BALANCE_FIELDS, np.asarray(run.balance()).tolist(), strict=True))
        islands.append(counts["islands"] / counts["windows"])
        frames.append([np.asarray(part) for part in run.frame()])
    assert islands[1] == 1 < islands[0] < 26
    if kind == FRONT:
        np.testing.assert_allclose(frames[0][2], frames[1][2], atol=1e-7)
    else:
        np.testing.assert_array_equal(frames[0][2], frames[1][2])


@pytest.mark.slow
@pytest.mark.parametrize("kind", MODELS)
def test_no_deep_overlap_in_a_million_droplet_steps(kind):
    """A crowd stirred for long: nobody is retired, which a vertex spacing of overlap would do."""
    run = crowd(60.0 if kind == SPRINGS else 90.0, model=kind, interval=20.0)  # longer steps
    assert run.balance["retired"] == 0
    assert run.balance["steps"] * 25 > 1e6


def test_a_droplet_that_blows_up_is_retired_alone():
    """An area far too stiff for the step: no hang and no crash, but a reason for each."""
    row = FEW.model_row()
    row[_core.MODEL_FIELDS.index("area_stiffness")] *= 1e6
    run = in_a_box(
        row,
        po.flow.uniform(),
        np.array(lattice(3, 3, 1.4)) * [1, 1, 0] + [0, 0, 1],
        [0, 4.4, 0, 4.4],
    )
    run.advance(20)
    events = np.asarray(run.take_events())
    kinds = {_core.EVENT_KINDS[int(k)] for k in events[:, 0]}
    assert "retired" in kinds
    assert len(np.asarray(run.sizes())) < 9


def test_a_droplet_that_a_flow_tears_apart_is_refused_before_its_neighbours_are_sought():
    """Its box would hold a million images of the pillar."""
    nodes = np.arange(12) * 0.5
    x, y = np.meshgrid(2 * np.pi * nodes / 6, 2 * np.pi * nodes / 6)
    tearing = po.flow.sampled(nodes, nodes, 1e9 * np.sin(y), 1e9 * np.sin(x), periodic="xy")
    start = np.array([[0.0, 0.0, 1.0]])
    run = in_a_box(FEW.model_row(), tearing, start, [0, 6, 0, 6], np.array([[2.0, 2.0, 0.1]]))
    run.advance(1)
    assert len(np.asarray(run.sizes())) == 0


def test_a_state_that_is_none_is_refused_and_changes_nothing():
    starts = np.array(lattice(2, 1, 1.4)) * [1, 1, 0] + [0, 0, 1]
    run = in_a_box(FEW.model_row(), po.flow.uniform(), starts, [0, 4.4, 0, 4.4])
    run.advance(1)
    state = np.asarray(run.state())
    for wrong in (state[:-1], state[:3], np.full_like(state, np.nan)):
        with pytest.raises(ValueError, match="a state"):
            run.restore(wrong)
    assert np.array_equal(run.state(), state)
    run.restore(state)
    assert np.array_equal(run.state(), state)


def test_the_engine_refuses_what_it_could_not_run():
    row, nobody, nothing = FEW.model_row(), np.zeros((0, 3)), np.zeros(0)
    flow, four = po.flow.uniform(), np.zeros(4)

    def build(flow=flow, cell=four, window=0.1, coalescence=nothing, threads=1):
        _core.Emulsion(
            row, flow, nobody, nobody, cell, False, False, window, 0.3, four, nothing, 1.0,
            coalescence, 1, threads,
        )  # fmt: skip

    build()
    for wrong in ({"flow": "none"}, {"cell": np.zeros(3)}):
        with pytest.raises(TypeError):
            build(**wrong)
    for wrong in ({"window": np.nan}, {"coalescence": np.zeros(2)}, {"threads": 0}):
        with pytest.raises(ValueError, match="must be"):
            build(**wrong)
    with pytest.raises(TypeError):
        _core.System(row, "none", nobody, nobody)
