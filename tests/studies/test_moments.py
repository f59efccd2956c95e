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
