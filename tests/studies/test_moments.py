"""The moments that tell a collision, in whatever unit its outlines are."""

from __future__ import annotations

from dataclasses import replace

import pytest

import pinchoff as po
from pinchoff.studies.moments import collision_moments


@pytest.mark.parametrize("offset", [0.02, 0.3, 2.0])
def test_outlines_in_micrometres_have_the_moments_of_those_in_diameters(offset):
    """A droplet breaks, passes with a touch, and misses."""
    outlines = po.simulate(po.Parameters(offset=offset), outlines=0.1).outlines
    lengths = {name: 481 * getattr(outlines, name) for name in ("vertices", "obstacles")}
    filmed = replace(outlines, **lengths, units="um")
    assert collision_moments(filmed) == collision_moments(outlines)


def test_a_break_up_is_told_in_six_frames_about_the_times_of_its_events():
    every = 0.1
    run = po.simulate(po.Parameters(offset=0.02), outlines=every)
    frame = {moment.name: moment.frame for moment in collision_moments(run.outlines)}
    order = ["approach", "contact", "deformation", "neck", "break-up", "after"]
    assert sorted(frame, key=frame.__getitem__) == order
    assert abs(frame["contact"] * every - run.contact_time) <= 1.5 * every
    assert frame["neck"] * every < run.breakup_time <= frame["break-up"] * every
    droplets = [len(run.outlines[frame[name]]) for name in order[2:]]
    assert droplets[:2] == [1, 1]
    assert min(droplets[2:]) >= 2
