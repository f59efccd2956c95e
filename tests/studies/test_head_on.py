"""K of a coalescence from what head-on pairs were seen to do."""

from __future__ import annotations

import pytest

import pinchoff as po
from pinchoff.studies.head_on import calibrate_drainage, head_on_pair

PAIR = po.Parameters(model="front-tracking", simulation_capillary_number=25, vertex_count=48)


def test_calibrated_pairs_merge_below_the_number_and_not_above():
    found = calibrate_drainage(0.005, PAIR)
    for share, merges in ((0.5, 1), (0.97, 1), (1.03, 0), (1.5, 0)):
        number = share * 0.005 / 9.8e-5
        run = head_on_pair(PAIR.replace(simulation_capillary_number=number), found.coalescence)
        assert run.balance["merges"] == merges
    late = calibrate_drainage(0.005, PAIR, separation=0.5)
    assert late.drainage == pytest.approx(2 * found.drainage, rel=1e-9)
    assert late.coalescence == po.Coalescence(late.drainage, 0.5)


def test_a_pair_that_does_not_meet_calibrates_nothing():
    with pytest.raises(po.InputError, match="widening must be such that the pair touches"):
        calibrate_drainage(0.005, PAIR, widening=1.05)
