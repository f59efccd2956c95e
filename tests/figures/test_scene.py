"""What is written into pictures of a run: lengths and times in the units of its scale."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff.figures.scene import Scale
from pinchoff.model.outlines import Outlines


def outlines_of(parameters, units="D0"):
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    return Outlines.from_frames(
        [0.0], [[(0, 0, triangle, np.zeros((3, 2)))]], [[5.0, 0.0, 1.0]], parameters, units=units
    )


@pytest.mark.parametrize(
    ("diameter_um", "speed_mm_s", "time", "label"),
    [
        (481.0, 1.0, 0.5, "$t$ = 240 ms"),  # one t0 is 481 ms: two digits of it are 5 ms
        (481.0, 2.0, 1.0, "$t$ = 240 ms"),
        (30.0, 2.0, 1.5, "$t$ = 22.5 ms"),
        (5.0, 2.0, 2.25, "$t$ = 5.62 ms"),
        (2.0, 8.0, 3.0, "$t$ = 0.750 ms"),
    ],
)
def test_times_of_a_known_experiment_are_in_milliseconds(diameter_um, speed_mm_s, time, label):
    """t0 = D0/v_f∞, with as many decimals as two of t0 are worth."""
    scale = Scale.of(outlines_of({"scale": {"diameter_um": diameter_um, "speed_mm_s": speed_mm_s}}))
    assert (scale.length, scale.length_unit) == (diameter_um, "µm")
    assert scale.time_label(time) == label


def test_times_without_an_experiment_are_in_t0():
    assert Scale.of(outlines_of({})) == (1.0, "$D_0$", 1.0, "$t_0$")
    assert Scale.of(outlines_of({})).time_label(1.2345) == "$t$ = 1.23 $t_0$"


def test_times_of_a_filmed_run_are_in_milliseconds():
    scale = Scale.of(outlines_of({}, "um"))
    assert scale[:2] == (1.0, "µm")
    assert scale.time_label(1.2345) == "$t$ = 1234 ms"
