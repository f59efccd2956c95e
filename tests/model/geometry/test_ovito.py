"""Outlines as OVITO reads them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import pinchoff as po

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # of its Qt
    io = pytest.importorskip("ovito.io", reason="OVITO is not installed")

pytestmark = pytest.mark.filterwarnings("ignore")


def test_ovito_reads_closed_outlines_obstacles_and_units(tmp_path):
    run = po.simulate(
        po.Parameters(simulation_capillary_number=40, offset=0.02, follow_daughters=True),
        outlines=0.5,
    )
    run.outlines.save(tmp_path / "outlines.gsd")
    pipeline = io.import_file(tmp_path / "outlines.gsd")
    assert pipeline.num_frames == len(run.outlines)
    last = pipeline.num_frames - 1
    data = pipeline.compute(last)
    assert data.attributes["units"] == "D0"
    assert data.attributes["time"] == run.outlines.times[last]
    droplets = list(run.outlines[last])
    vertices = np.concatenate([droplet.vertices for droplet in droplets])
    positions = np.asarray(data.particles.positions)
    np.testing.assert_allclose(positions[1:, :2], vertices)
    bonds = np.asarray(data.particles.bonds.topology)
    ways = np.linalg.norm(positions[bonds[:, 1]] - positions[bonds[:, 0]], axis=1)
    assert len(bonds) == len(vertices)
    assert len(droplets) >= 2
    for droplet, start in zip(droplets, np.cumsum([1, *map(len_of, droplets)])[:-1], strict=True):
        own = (bonds[:, 0] >= start) & (bonds[:, 0] < start + len_of(droplet))
        rim = droplet.vertices - np.roll(droplet.vertices, -1, axis=0)
        assert ways[own].sum() == pytest.approx(np.linalg.norm(rim, axis=1).sum())
        radii = np.asarray(data.particles["Radius"])[start : start + len_of(droplet)]
        assert radii == pytest.approx(ways[own].mean() / 2)  # beads that touch
    assert data.particles["Radius"][0] == pytest.approx(run.parameters.obstacle_radius)


def len_of(droplet):
    return len(droplet.vertices)
