"""What a camera sees of a neck that thins."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po
from pinchoff.studies.necks import (
    ThinningHistory,
    last_frame_necks,
    median_history,
    thinning_history,
)

LINEAR = ThinningHistory(np.array([0.0, 1.0]), np.array([100.0, 0.0]), 1.0)  # 100 µm/s


def test_the_last_frame_is_up_to_an_interval_before_the_break_up():
    seen = last_frame_necks(LINEAR, 10.0, phases=[1e-9, 0.5, 1.0])
    assert seen == pytest.approx([0, 5, 10], abs=1e-6)


def test_a_faster_camera_sees_thinner_necks_in_proportion():
    slow, fast = last_frame_necks(LINEAR, 10.0), last_frame_necks(LINEAR, 40.0)
    assert slow.max() == pytest.approx(4 * fast.max())
    assert slow.mean() == pytest.approx(5)
    assert slow.std() == pytest.approx(10 / np.sqrt(12), rel=1e-3)


def test_frames_before_the_history_are_not_known():
    assert np.isnan(last_frame_necks(LINEAR, 0.5, phases=[1.0])[0])


def test_a_simulated_neck_thins_to_its_threshold(experiment):
    parameters = po.Parameters.from_physical(**experiment)
    history = thinning_history(po.simulate(parameters, outlines=0.02))
    threshold = 0.167 * 481
    assert history.necks_um[-1] == pytest.approx(threshold, rel=0.01)
    assert history.necks_um[:-1].min() > threshold
    assert history.breakup_time_s == history.times_s[-1]


def test_the_paper_s_frames_see_70_micrometres_at_most_of_its_median_droplet():
    """By construction: 4.2 mm/s is 70 µm in 1/60 s."""
    seen = last_frame_necks(median_history(), 60.0)
    assert seen.max() == pytest.approx(70, rel=0.01)


def test_pinching_off_ends_at_nothing():
    history = ThinningHistory(np.array([0.0, 1.0]), np.array([90.0, 42.0]), 1.0).pinched_off(4.2)
    assert history.necks_um[-1] == 0
    assert history.breakup_time_s == pytest.approx(1.01)


def test_wrong_input_is_refused(refused, experiment):
    refused("times_s", ThinningHistory, [0.0, 1.0], [1.0], 1.0)
    refused("times_s", ThinningHistory, [1.0, 0.0], [1.0, 1.0], 1.0)
    refused("times_s", ThinningHistory, [0.0, 2.0], [1.0, 1.0], 1.0)
    refused("frame_rate", last_frame_necks, LINEAR, 0.0)
    refused("speed_mm_s", LINEAR.pinched_off, -1.0)
    dimensionless = po.simulate(po.Parameters(), outlines=True)
    refused("collision", thinning_history, dimensionless)
