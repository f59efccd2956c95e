"""Obstacles and droplets of one's own: what is refused, and what the groups then stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.collisions.law import breakup_number

SHORT = po.Parameters(time_limit=0.05)
RADIUS = SHORT.obstacle_radius


@pytest.mark.parametrize("gap", [-0.1, 0.0, 1e-4, 0.049])
def test_droplets_start_clear_of_obstacles_and_each_other(refused, gap):
    start = -(0.5 + RADIUS + gap)
    error = refused("droplets[0]", po.simulate, SHORT, droplets=[[start, 0, 1]])
    assert "0.05 D0" in error.rule
    beside = [[-5, 0, 1], [-5, 0.8 + gap, 0.6]]
    refused("droplets[1]", po.simulate, SHORT, droplets=beside)


def test_droplets_may_start_at_the_clearance():
    po.simulate(SHORT, droplets=[[-(0.5 + RADIUS + 0.051), 0, 1], [-5, 0, 1], [-5, 0.851, 0.6]])


def test_coarse_outlines_need_a_vertex_spacing(refused):
    coarse = SHORT.replace(vertex_count=16)
    droplets = [[-(0.5 + RADIUS + 0.19), 0, 1]]
    refused("droplets[0]", po.simulate, coarse, droplets=droplets)
    po.simulate(coarse, droplets=[[-(0.5 + RADIUS + 0.2), 0, 1]])


@pytest.mark.parametrize(
    ("argument", "keywords"),
    [
        ("droplets[0]", {"droplets": [[-100, 0, 64.1]]}),
        ("droplets[0]", {"droplets": [[-5, 0, 1e9]]}),
        ("droplets[1]", {"droplets": [[-5, 0, 1], [-9, 0, 0.019]]}),
        ("obstacles[0]", {"obstacles": [[0, 0, 9e-4]]}),
        ("obstacles[1]", {"obstacles": [[0, 0, 1], [5, 5, 1e-300]]}),
    ],
)
def test_what_cannot_be_built_is_refused(refused, argument, keywords):
    refused(argument, po.simulate, SHORT, **keywords)


def test_the_smallest_things_are_built():
    obstacles, droplets = [[0, 0, 1e-3]], [[-1, 0, 0.02]]
    assert po.simulate(SHORT, obstacles=obstacles, droplets=droplets).outcome == "captured"


GROUPS = ("size_ratio", "offset", "normalized_area")


def test_groups_are_those_of_the_first_contact():
    """The second droplet is the one that meets an obstacle, and it meets the second one."""
    p = po.Parameters(time_limit=4)
    c = po.simulate(
        p,
        flow=po.flow.uniform(),
        obstacles=[[0, 50, 0.2], [0, -2, 0.4]],
        droplets=[[-5, 3, 1], [-2, -1.9, 1.2]],
    )
    assert (c.contacts[0]["droplet_id"], c.contacts[0]["obstacle"]) == (1, 1)
    row = c.to_row()
    assert row["size_ratio"] == pytest.approx(1.2 / 0.4)
    assert row["offset"] == pytest.approx(0.1)
    assert row["normalized_area"] == pytest.approx(math.pi / 4 * 1.2**2 / 0.4**2)
    assert row["breakup_number"] == pytest.approx(
        float(
            breakup_number(
                p.capillary_number, normalized_area=row["normalized_area"], symmetry=row["symmetry"]
            )
        )
    )
    assert row["capillary_number"] == p.capillary_number


def test_groups_without_contact_are_missing():
    c = po.simulate(SHORT, droplets=[[-5, 0, 1]])
    assert all(math.isnan(c.to_row()[name]) for name in (*GROUPS, "breakup_number"))
    plain = po.simulate(SHORT).to_row()
    assert plain["normalized_area"] == SHORT.normalized_area
    assert plain["size_ratio"] == SHORT.size_ratio


def test_obstacle_radius_in_micrometres_is_that_of_the_first_contact(experiment):
    p = po.Parameters.from_physical(**experiment, time_limit=2)
    near = {"obstacles": [[0, 0, 0.3]], "droplets": [[-1, 0, 1]]}
    assert po.simulate(p, **near).to_row()["obstacle_radius_um"] == pytest.approx(0.3 * 481)
    far = po.simulate(p.replace(time_limit=0.05), droplets=[[-5, 0, 1]]).to_row()
    assert math.isnan(far["obstacle_radius_um"])
    assert far["thickness_um"] == pytest.approx(85)


def test_default_flow_past_several_obstacles_is_warned_of():
    obstacles = [[0, 0, RADIUS], [3, 0, RADIUS]]
    with pytest.warns(UserWarning, match="flow=") as caught:
        po.simulate(SHORT, obstacles=obstacles)
    assert caught[0].filename == __file__
    po.simulate(SHORT, obstacles=obstacles, flow=po.flow.uniform())


@pytest.mark.parametrize("interval", [1e308, np.float32(0.25), np.int64(2)])
def test_any_positive_interval_is_taken(interval):
    outlines = po.simulate(SHORT, outlines=interval).outlines
    assert outlines is not None
    assert len(outlines) == 2


def test_none_records_nothing():
    assert po.simulate(SHORT, outlines=None).outlines is None


def test_what_cannot_be_called_is_refused(refused):
    refused("on_frame", po.simulate, SHORT, on_frame=3)
    refused("outlines", po.simulate, SHORT, outlines=10**400)
