"""A scene that several tests of many droplets run."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po


def _through_pillars(time, *, model="front-tracking", threads=1, seed=3, **changes):
    """Droplets come in before an array of pillars and leave behind it; some break."""
    pillars = po.arrays.staggered(rows=3, columns=4, radius=0.18, gap=0.9)
    array = pillars.with_margins(before=4.0, behind=3.0)
    x = np.linspace(-2, array.length + 3, 320)
    y = np.arange(96) * array.width / 96
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    still = np.ones(grid.shape[:2])  # 0 in pillars, 1 far from them
    for px, py, radius in array.circles:
        for image in (-array.width, 0.0, array.width):
            away = np.hypot(grid[..., 0] - px, grid[..., 1] - py - image) - radius
            still *= 1 - np.exp(-((np.maximum(away, 0) / 0.15) ** 2))
    sideways = 0.1 * np.sin(2 * np.pi * grid[..., 1] / array.width)
    flow = po.flow.sampled(x, y, still, still * sideways, periodic="y")
    arguments = {
        "obstacles": array,
        "periodic": "y",
        "flow": flow,
        "inlet": po.Inlet(0.0, 0.0, array.width, area_fraction=0.12, diameters=[0.8, 1.0]),
        "outlet": array.length,
        "threads": threads,
        "seed": seed,
        **changes,
    }
    constants = po.Parameters(model=model, simulation_capillary_number=40, vertex_count=48)
    return po.simulate_emulsion(constants, time=time, **arguments)


@pytest.fixture
def through_pillars():
    """Return what runs droplets through pillars for a time, t0."""
    return _through_pillars
