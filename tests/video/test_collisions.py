"""From drawn clips to collisions: discs whose every measure is known from plane geometry."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.video.clips import measure_clip
from pinchoff.video.collisions import CollisionFinder
from pinchoff.video.contact import contact_velocity
from pinchoff.video.droplets import Droplet
from pinchoff.video.encounters import Laboratory, encounter_table, gap_to_circle
from pinchoff.video.microscope import Scene, film, lane_scene, passage_of
from pinchoff.video.settings import VideoSettings
from pinchoff.video.tracking import Event

LABORATORY = Laboratory(
    obstacle_radius_um=80, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
)
OBSTACLE = (150.0, 80.0, 16.0)


@pytest.fixture
def table_of(tmp_path):
    """Function (scene, microscope, count, settings) -> collisions table of the filmed scene."""

    def measure(scene, microscope, count, **told):
        made = film(
            scene, tmp_path / "clip.mp4", count, microscope=microscope, laboratory=LABORATORY
        )
        settings = VideoSettings(pixel_size_um=5.0, laboratory=LABORATORY, **told)
        result = measure_clip(made.clip, settings)
        return encounter_table(result.encounters, LABORATORY, "video", "clip")

    return measure


# To choose the method takes most of the time of so short a clip.
@pytest.fixture(params=["rings", pytest.param(None, marks=pytest.mark.slow)], ids=["rings", "any"])
def measured(table_of, request):
    """Do the same by rings, and by the method that the clip itself chooses."""
    return functools.partial(table_of, method=request.param)


@pytest.mark.parametrize("angle", [0.0, 0.9, math.pi / 2, 3.0, -2.2])
def test_every_direction_of_flow(disc, sliding, symmetry_of_disc, measured, microscope, angle):
    look = microscope.replace(width=300, height=200)
    (row,) = measured(Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE, angle),)), look, 60).to_dict(
        "records"
    )
    assert row["accepted"], row["reject_reason"]
    assert row["outcome"] == "slipped"
    assert row["symmetry"] == pytest.approx(symmetry_of_disc(20.0, 8.0), abs=0.02)
    assert row["impact_parameter"] == pytest.approx(8.0 / 40.0, abs=0.006)
    assert row["speed_mm_s"] == pytest.approx(3.0 * 60 * 5e-3, rel=0.02)
    assert row["area_um2"] == pytest.approx(math.pi * 100**2, rel=0.01)
    assert row["flow_direction_deg"] == pytest.approx(math.degrees(angle), abs=1.0)
    assert row["obstacle_x_um"] == pytest.approx(OBSTACLE[0] * 5.0, abs=1.0)
    assert row["obstacle_y_um"] == pytest.approx(OBSTACLE[1] * 5.0, abs=1.0)
    # A disc's thinnest chord whose shorter arc is 0.28 of the perimeter.
    assert row["neck_um"] == pytest.approx(200 * math.sin(math.pi * 0.28), rel=0.02)


@pytest.mark.parametrize("fps", [15.0, 59.94, 240.0])
def test_every_frame_rate(disc, sliding, table_of, microscope, fps):
    look = microscope.replace(fps=fps)
    scene = Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE, fps=fps),))
    (row,) = table_of(scene, look, 40, method="rings").to_dict("records")
    assert row["speed_mm_s"] == pytest.approx(3.0 * fps * 5e-3, rel=0.01)
    assert row["contact_time_s"] == pytest.approx(row["contact_frame"] / fps, rel=1e-4)
    (row,) = table_of(scene, look, 40, method="rings", fps=60.0).to_dict("records")
    assert row["speed_mm_s"] == pytest.approx(3.0 * 60 * 5e-3, rel=0.01)


def test_groups_follow_from_the_measures(disc, sliding, measured, microscope):
    (row,) = measured(Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE),)), microscope, 60).to_dict(
        "records"
    )
    assert row["capillary_number"] == pytest.approx(48e-3 * row["speed_mm_s"] * 1e-3 / 20e-3)
    assert row["normalized_area"] == pytest.approx(row["area_um2"] / 80**2)
    assert row["normalized_thickness"] == pytest.approx(85 / 80)
    assert row["size_ratio"] == pytest.approx(math.sqrt(4 * row["area_um2"] / math.pi) / 80)
    assert math.isnan(row["speed"])  # in units of v_f∞, which a camera does not see
    assert math.isnan(row["daughter_area_ratio"])


def test_what_is_unknown_is_not_a_number(disc, sliding, microscope, tmp_path):
    made = film(
        Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE),)),
        tmp_path / "c.mp4",
        60,
        microscope=microscope,
    )
    settings = VideoSettings(pixel_size_um=5.0, find_obstacles=True)
    result = measure_clip(made.clip, settings)
    (encounter,) = result.encounters
    row = encounter.row(Laboratory())
    for name in ("capillary_number", "normalized_thickness", "breakup_number", "viscosity_mPa_s"):
        assert math.isnan(row[name])
    assert row["obstacle_radius_um"] == pytest.approx(80.0, rel=0.02)  # as seen


def test_touching_during_the_collision_is_rejected(disc, moving, sliding, measured, microscope):
    one = sliding(disc(20.0), 20.0, 8.0, OBSTACLE)
    behind = sliding(disc(14.0) - np.array([34.2, 0.0]), 20.0, 8.0, OBSTACLE)
    table = measured(Scene((one, behind)), microscope, 60)
    reasons = set(table["reject_reason"])
    assert reasons == {"touching another droplet"}
    assert not table["accepted"].any()


def test_coalescence_during_the_collision_is_rejected(disc, merging, measured, microscope):
    both = merging(
        *(disc(14.0), disc(12.0), disc(math.hypot(14.0, 12.0))),
        *([(60.0, 112.0), (60.0, 142.0)], (3.0, 0.0), 31, OBSTACLE),
    )
    table = measured(Scene((both,)), microscope, 58)
    assert list(table["reject_reason"]) == ["coalescence"]
    assert table["contact_frame"][0] == 28


@pytest.mark.parametrize(("apart", "outcome"), [(1, "slipped"), (3, "slipped"), (4, "broke")])
def test_break_up_that_is_taken_back(disc, apart, outcome):
    """Daughters that are one again within the frames of `memory` had a neck that was not seen."""
    settings = VideoSettings(pixel_size_um=5.0, memory=3)
    finder = CollisionFinder(settings, np.array([[0.0, 0.0, 16.0]]))
    radius, small, parted = 20.0, 20.0 / math.sqrt(2.0), range(12, 12 + apart)

    def droplet(radius, x, y):
        return Droplet(disc(radius) + np.array([x, y]), math.pi * radius**2, x, y, False, -1)

    over = []
    for frame in range(60):
        x = -66.0 + 4.0 * frame
        y = -max(0.0, 40.0 - 0.02 * x * x)  # over the obstacle, at which it arrives in frame 8
        seen, events = {0: droplet(radius, x, y)}, []
        if frame in parted:
            seen = {k: droplet(small, x, y + shift) for k, shift in ((1, -15.0), (2, 15.0))}
        elif frame > parted[-1]:
            seen = {3: seen[0]}
        if frame == parted[0]:
            events = [Event("break-up", frame, (0,), (1, 2))]
        elif frame == parted[-1] + 1:
            events = [Event("coalescence", frame, (1, 2), (3,))]
        over += finder.step(frame, frame / 60.0, list(seen.values()), list(seen), events)
    over += finder.finish()
    first = over[0]
    assert (first.outcome, first.track_id, first.reject_reason) == (outcome, 0, "")
    assert len(over) == 1 or outcome == "broke"


def test_neighbour_that_stays_apart_is_no_reason(disc, moving, sliding, measured, microscope):
    one = sliding(disc(20.0), 20.0, 8.0, OBSTACLE)
    beside = moving(disc(12.0), (60.0, 160.0), (3.0, 0.0), OBSTACLE)
    table = measured(Scene((one, beside)), microscope, 60)
    assert list(table["reject_reason"]) == [""]


def test_cut_by_the_frame_is_rejected(disc, sliding, measured, microscope):
    near_edge = (150.0, 150.0, 16.0)
    scene = Scene((sliding(disc(20.0), 20.0, 5.0, near_edge),))
    table = measured(scene, microscope, 60, obstacles=(near_edge,))
    assert list(table["reject_reason"]) == ["cut by the frame"]


def test_clip_that_ends_too_early(disc, sliding, measured, microscope):
    table = measured(Scene((sliding(disc(20.0), 20.0, 8.0, OBSTACLE),)), microscope, 25)
    assert list(table["outcome"]) == ["captured"]
    assert list(table["reject_reason"]) == ["the clip ends during the collision"]


def test_droplet_that_appears_in_contact_has_no_approach(disc, moving, measured, microscope):
    scene = Scene((moving(disc(20.0), (150.0, 118.0), (3.0, 0.5), OBSTACLE),))
    table = measured(scene, microscope, 30, obstacles=(OBSTACLE,))
    assert list(table["reject_reason"]) == ["no approach: in contact when first seen"]
    assert math.isnan(table["speed_mm_s"][0])
    assert math.isnan(table["symmetry"][0])


def test_no_droplets_and_no_obstacles(disc, moving, measured, microscope):
    assert len(measured(Scene(()), microscope, 5)) == 0
    alone = Scene((moving(disc(20.0), (60.0, 88.0), (3.0, 0.0)),))
    assert len(measured(alone, microscope, 20)) == 0


def test_obstacle_partly_in_view(disc, moving, measured, microscope):
    """Found and fitted from the arc that is in view."""
    edge = (236.0, 90.0, 16.0)
    scene = Scene((moving(disc(20.0), (60.0, 88.0), (3.0, 0.0), edge),))
    made = measured(scene, microscope, 50)
    assert len(made) == 1
    assert made["obstacle_x_um"][0] == pytest.approx(236.0 * 5, abs=2.0)


def test_break_up_of_the_engine(table_of, microscope):
    """A simulated break-up: its frame, its daughters and its neck, against the truth."""
    from pinchoff.video.microscope import Microscope, scene_encounters

    look = Microscope(width=480, height=360, pixel_size_um=5.0, noise=3.0)
    runs = [
        passage_of(po.Parameters(simulation_capillary_number=ca, offset=y), look, LABORATORY)
        for ca, y in ((30, 0.03), (15, 0.15))
    ]
    scene, count = lane_scene(runs, look)
    truth = encounter_table(scene_encounters(scene, look, count), LABORATORY, "film", "")
    table = table_of(scene, look, count, method="rings")
    assert list(table["outcome"]) == list(truth["outcome"])
    assert sorted(table["outcome"]) == ["broke", "slipped"]
    for name, error in (
        ("symmetry", 0.03),
        ("daughter_area_ratio", 0.01),
        ("breakup_frame", 1.0),
        ("breakup_neck_um", 0.7 * 5.0),
        ("neck_um", 0.7 * 5.0),
        ("contact_frame", 1),
    ):
        ours, theirs = table[name].to_numpy(float), truth[name].to_numpy(float)
        assert np.array_equal(np.isnan(ours), np.isnan(theirs)), name
        assert np.nanmax(np.abs(ours - theirs)) <= error, name
    assert table["area_um2"].to_numpy() == pytest.approx(truth["area_um2"].to_numpy(), rel=0.006)
    assert table["speed_mm_s"].to_numpy() == pytest.approx(truth["speed_mm_s"].to_numpy(), rel=0.05)


def test_gap_to_circle_is_to_the_edges(disc):
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    assert gap_to_circle(square, (15.0, 5.0, 2.0)) == pytest.approx(3.0)
    assert gap_to_circle(square, (13.0, 14.0, 1.0)) == pytest.approx(4.0)
    assert gap_to_circle(disc(5.0, 1000), (20.0, 0.0, 4.0)) == pytest.approx(11.0, abs=1e-3)


def test_velocity_of_a_decelerating_droplet():
    times = np.arange(8) / 60.0
    places = [(t, 10.0 + 200.0 * t - 300.0 * t**2, 5.0 - 40.0 * t) for t in times]
    vx, vy = contact_velocity(places)
    assert vx == pytest.approx(200.0 - 600.0 * times[-1])
    assert vy == pytest.approx(-40.0)
    assert contact_velocity(places[:2])[1] == pytest.approx(-40.0)
    assert math.isnan(contact_velocity(places[:1])[0])
