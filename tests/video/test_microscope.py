"""What the microscope draws is what it was given, and its truth is the engine's."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff import _core
from pinchoff.video.encounters import Laboratory
from pinchoff.video.microscope import (
    Microscope,
    Passage,
    Scene,
    film,
    frames,
    lane_scene,
    passage_of,
    scene_encounters,
)
from pinchoff.video.microscope.drawing import coverage

LABORATORY = Laboratory(
    obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
)


@pytest.mark.parametrize("diameter", [12.0, 40.0, 91.3])
def test_drawn_area_and_edge_are_unbiased(diameter, disc):
    """The edge lies within a hundredth of a pixel of the outline, wherever its centre falls."""
    random = np.random.default_rng(1)
    offsets = []
    for _ in range(20):
        outline = disc(diameter / 2, 256) + 60 + random.uniform(-0.5, 0.5, 2)
        _, inside, _ = coverage(outline, (120, 120), 3.0)
        offsets.append((inside.sum() - _core.area(outline)) / (math.pi * diameter))
    assert abs(np.mean(offsets)) < 0.01
    assert np.std(offsets) < 0.03


def test_drawn_centre_is_unbiased(disc):
    outline = disc(15.0) + np.array([40.3, 30.8])
    (rows, columns), inside, core = coverage(outline, (100, 80), 3.0)
    y, x = np.mgrid[rows, columns]
    for share in (inside, core):
        assert (share * x).sum() / share.sum() == pytest.approx(40.3, abs=0.02)
        assert (share * y).sum() / share.sum() == pytest.approx(30.8, abs=0.02)


def test_outline_over_the_edge_is_cut(disc):
    (rows, columns), inside, _ = coverage(disc(10.0) + np.array([0.0, 40.0]), (100, 80), 3.0)
    assert columns.start == 0
    assert inside.shape == (rows.stop - rows.start, columns.stop)
    assert inside.sum() == pytest.approx(
        math.pi * 50 + 0.5 * 20, rel=0.02
    )  # half, and half a pixel
    _, nothing, _ = coverage(disc(5.0) - 50.0, (100, 80), 3.0)
    assert nothing.size == 0


def test_frames_show_the_colours(microscope, disc, moving):
    look = microscope.replace(noise=0.0, unevenness=0.0, blur_px=0.5)
    scene = Scene((moving(disc(20.0), (60.0, 90.0), (0.0, 0.0), (150.0, 90.0, 16.0)),))
    (image,) = frames(scene, look, 1)
    assert image.shape == (180, 240, 3)
    assert tuple(image[90, 60]) == pytest.approx(look.interior, abs=1)
    assert tuple(image[20, 20]) == pytest.approx(look.fluid, abs=1)
    assert tuple(image[90, 150]) == pytest.approx(look.pillar, abs=1)
    ring = image[90, 60 + 18].astype(int)
    assert ring.sum() < sum(look.ring) + 60


def test_same_seed_same_frames(microscope, disc, moving):
    look = microscope.replace(flicker=0.02, dust=5, exposure=0.5, focus_drift_px=1.0)
    scene = Scene((moving(disc(20.0), (60.0, 90.0), (3.0, 0.0)),))
    first, second = (list(frames(scene, look, 3)) for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    other = list(frames(scene, look.replace(seed=1), 3))
    assert not np.array_equal(first[0], other[0])


@pytest.mark.parametrize(("distance_um", "gap_px"), [(16.0, 16.0 / 5.0), (None, 1.0)])
def test_truth_of_a_disc(microscope, disc, moving, symmetry_of_disc, distance_um, gap_px):
    """A disc that passes below an obstacle: contact, S and b from plane geometry."""
    radius, below, speed = 20.0, 8.0, 2.5
    obstacle = (150.0, 80.0, 16.0)
    scene = Scene((moving(disc(radius), (40.0, 88.0), (speed, 0.0), obstacle),))
    (found,) = scene_encounters(scene, microscope, 40, distance_um)
    reach = radius + 16.0 + gap_px
    x_contact = 150.0 - math.sqrt(reach**2 - below**2)
    assert found.contact_frame == math.ceil((x_contact - 40.0) / speed)
    row = found.row(LABORATORY)
    assert row["symmetry"] == pytest.approx(symmetry_of_disc(radius, below), abs=0.002)
    assert row["impact_parameter"] == pytest.approx(below / (2 * radius), rel=0.002)
    assert row["speed_mm_s"] == pytest.approx(speed * 60 * 5e-3, rel=1e-6)
    assert row["flow_direction_deg"] == pytest.approx(0.0, abs=1e-6)
    assert row["capillary_number"] == pytest.approx(48e-3 * speed * 0.3e-3 / 20e-3, rel=1e-6)


def test_truth_agrees_with_the_engine():
    look = Microscope()
    parameters = po.Parameters(simulation_capillary_number=25, offset=0.02)
    scene, count = lane_scene([passage_of(parameters, look, LABORATORY)], look)
    (found,) = scene_encounters(scene, look, count)
    run = po.simulate(parameters)
    assert found.outcome == run.outcome == "broke"
    row = found.row(LABORATORY)
    # The engine's contact is a little later: a film of oil counts as contact here.
    assert row["symmetry"] == pytest.approx(run.symmetry, abs=0.05)
    assert row["daughter_area_ratio"] == pytest.approx(run.daughter_area_ratio, abs=0.02)
    unit_s = scene.passages[0].unit_s
    since_contact = (found.breakup_frame - found.contact_frame) / look.fps
    assert since_contact == pytest.approx((run.breakup_time - run.contact_time) * unit_s, abs=0.1)


@pytest.mark.parametrize("angle", [0.0, 0.7, math.pi / 2, 2.5])
def test_lanes_keep_droplets_apart(angle):
    look = Microscope(width=480, height=400)
    runs = [
        passage_of(po.Parameters(size_ratio=3.0, offset=y), look, LABORATORY)
        for y in (0.05, 0.1, 0.2, -0.1)
    ]
    scene, count = lane_scene(runs, look, angle=angle, lanes=2)
    assert len(scene.obstacles) == 2
    for frame in range(0, count, 10):
        droplets = scene.droplets_at(frame / look.fps, look.size)
        for k, one in enumerate(droplets):
            for other in droplets[:k]:
                if one.passage != other.passage:
                    gaps = np.hypot(
                        *(one.vertices[:, None] - other.vertices[None]).transpose(2, 0, 1)
                    )
                    assert gaps.min() > 10.0
    met = scene_encounters(scene, look, count)
    direction = math.degrees(math.atan2(math.sin(angle), math.cos(angle)))
    assert len(met) == 4
    for each in met:
        assert each.row(LABORATORY)["flow_direction_deg"] == pytest.approx(direction, abs=25)


def test_between_two_records_an_outline_of_as_many_vertices_is_the_mean():
    """One that has other vertices in the next record goes on as it moved."""
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    speed = np.tile([2.0, 0.5], (4, 1))
    still, later = square, square + np.array([4.0, 0.0])

    def halfway(after):
        frames = [
            [(0, 0, still, speed)],
            [(0, 0, still, speed)],
            [(0, 0, after, np.zeros(after.shape))],
        ]
        outlines = po.Outlines.from_frames([0.0, 1.0, 2.0], frames, [[9.0, 0.0, 1.0]], {})
        ((_, vertices),) = Passage(outlines, 10.0, 0.1).in_run(0.15)
        return vertices

    np.testing.assert_allclose(halfway(later), square + np.array([2.0, 0.0]))
    np.testing.assert_allclose(halfway(later[:3]), square + np.array([1.0, 0.25]))


def test_droplet_that_stays_comes_last():
    """A droplet caught head-on closes its lane, and nothing runs into it."""
    look = Microscope(width=480, height=400)
    runs = [
        passage_of(po.Parameters(size_ratio=3.0, offset=y), look, LABORATORY) for y in (0.0, 0.1)
    ]
    scene, count = lane_scene(runs, look, lanes=1)
    assert len(scene.passages) == 2
    assert scene.passages[1].start_s > scene.passages[0].start_s
    caught = scene_encounters(scene, look, count)[-1]
    assert caught.outcome == "captured"
    assert caught.reject_reason == "the clip ends during the collision"
    only, _ = lane_scene([runs[0], runs[0]], look, lanes=1)
    assert len(only.passages) == 1


def test_film_writes_clip_and_truth(tmp_path, microscope, disc, moving):
    scene = Scene((moving(disc(20.0), (40.0, 88.0), (2.5, 0.0), (150.0, 80.0, 16.0)),))
    made = film(scene, tmp_path / "clip.mp4", 12, microscope=microscope, laboratory=LABORATORY)
    assert made.clip.exists()
    table = po.read_collisions(made.truth)
    assert list(table["source"]) == ["film"] * len(table)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["clip.mp4", "clip.truth.parquet"]


def test_refuses(refused, tmp_path, microscope, disc, moving):
    refused("passages", lane_scene, [], microscope)
    refused("width", Microscope, width=641)
    refused("interior", Microscope, interior=(1, 2, 300))
    scene = Scene((moving(disc(20.0), (60.0, 90.0), (0.0, 0.0)),))
    refused("path", film, scene, tmp_path / "clip.avi", 1)
    assert not list(tmp_path.iterdir())
