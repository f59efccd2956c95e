"""How far a run can be trusted: droplets whose slip, blocking and contacts are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.chamber.emulsion_trust import Trust, measure_trust, neighbour_gaps
from pinchoff.model import arrays, flow
from pinchoff.model.outlines import Outlines

ARRAY = arrays.square(rows=3, columns=3, radius=0.3, gap=1.4)  # pitch 2: gaps' middles are known
SPACING = 0.06


def ring(x, y, diameter=0.8, count=60):
    angle = 2 * math.pi * np.arange(count) / count
    return 0.5 * diameter * np.column_stack([np.cos(angle), np.sin(angle)]) + [x, y]


def outlines(droplets, times=(0.0,)):
    """Return frames of (vertices, velocity) that are the same at every time."""
    frame = [
        (number, 0, vertices, np.broadcast_to(velocity, vertices.shape))
        for number, (vertices, velocity) in enumerate(droplets)
    ]
    frames = [frame] * len(times)
    parameters = po.Parameters().model_dump(mode="json")
    return Outlines.from_frames(times, frames, ARRAY.circles, parameters)


def trust(droplets, fluid=None, **more):
    stream = flow.uniform(0.7, 0.1) if fluid is None else fluid
    return measure_trust([outlines(droplets)], ARRAY, stream, 0.0, SPACING, **more)


def test_droplets_that_move_with_the_flow_have_no_slip():
    found = trust([(ring(0.0, 0.0), (0.7, 0.1)), (ring(3.0, 3.0), (0.7, 0.1))])
    assert found.slip == pytest.approx(0.0, abs=1e-12)
    assert found.held == found.blocked == 0.0


def test_slip_is_the_length_of_the_difference():
    found = trust([(ring(1.0, 1.5), (0.7 + 0.3, 0.1 - 0.4)), (ring(3.0, 3.0), (0.7, 0.1))])
    assert found.slip == pytest.approx(0.25)
    assert found.slip_95 == pytest.approx(np.quantile([0.0, 0.5], 0.95))


def test_the_flow_is_averaged_over_a_droplets_vertices():
    shear = flow.sampled(
        np.linspace(0, 6, 7),
        np.linspace(0, 6, 7),
        np.tile(np.linspace(0, 6, 7)[:, None], (1, 7)),
        np.zeros((7, 7)),
    )
    found = trust([(ring(3.0, 2.5), (2.5, 0.0))], fluid=shear)  # u = y: the mean is at the centre
    assert found.slip == pytest.approx(0.0, abs=1e-9)


def test_a_held_droplet_blocks_the_gap_that_it_covers():
    gaps = neighbour_gaps(ARRAY)
    middle = gaps[np.argmin(np.hypot(*(gaps - [2.0, 2.5]).T))]
    assert middle == pytest.approx([2.0, 2.5])  # between (1, 2.5) and (3, 2.5)
    found = trust([(ring(*middle), (0.0, 0.0)), (ring(4.0, 0.5), (0.7, 0.1))])
    assert found.held == 0.5
    assert found.blocked == pytest.approx(1 / len(gaps))
    moving = trust([(ring(*middle), (0.7, 0.1))])
    assert moving.blocked == 0.0


def test_a_gap_across_the_edge_of_the_cell_is_blocked_from_either_side():
    gaps = neighbour_gaps(ARRAY)
    edge = gaps[np.argmin(np.hypot(*(gaps - [1.0, 5.5]).T))]
    assert edge == pytest.approx([1.0, 5.5])  # between (1, 4.5) and (1, 6.5), which is (1, 0.5)
    for y in (5.5, -0.5):
        assert trust([(ring(1.0, y), (0.0, 0.0))]).blocked == pytest.approx(1 / len(gaps))


def test_the_largest_island_is_of_droplets_that_touch():
    apart = 0.8 + 0.5 * SPACING
    row = [(ring(1.0 + apart * k, 5.9), (0.7, 0.1)) for k in range(3)]
    across = (ring(1.0, 5.9 + apart - 6.0), (0.7, 0.1))  # touches the first across the edge
    alone = (ring(4.5, 2.5), (0.7, 0.1))
    assert trust([*row, alone]).largest_island == 3
    assert trust([*row, across, alone]).largest_island == 4


def test_frames_before_the_start_are_left_out_and_none_gives_no_numbers():
    pieces = [outlines([(ring(0.0, 0.0), (0.0, 0.0))], times=np.arange(8.0))]
    found = measure_trust(pieces, ARRAY, flow.uniform(), 4.0, SPACING)
    assert found.frames == 4
    assert found.held == 1.0
    none = measure_trust(pieces, ARRAY, flow.uniform(), 9.0, SPACING)
    assert none.frames == 0
    assert math.isnan(none.slip)


@pytest.mark.parametrize(
    ("slip", "blocked", "word"),
    [(0.05, 0.0, "fair"), (0.3, 0.0, "estimates"), (0.05, 0.2, "artefacts")],
)
def test_the_verdict_follows_from_slip_and_blocking(slip, blocked, word):
    assert word in Trust(1, slip, slip, 0.0, blocked, 1).verdict()
