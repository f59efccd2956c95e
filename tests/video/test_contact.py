"""First contact from the history of the gap, on motions whose contact is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po
from pinchoff.video.clips import measure_clip
from pinchoff.video.contact import (
    Approach,
    Place,
    contact_velocity,
    first_contact,
    rest_begins,
    touching_velocity,
)
from pinchoff.video.encounters import Laboratory, encounter_table
from pinchoff.video.microscope import (
    Microscope,
    film,
    lane_scene,
    passage_of,
    scene_encounters,
)
from pinchoff.video.settings import VideoSettings


def closing(speed, rest, phase=0.0, frames=30, noise=0.0, seed=0):
    """Return a gap that closes evenly to its rest, and the frame from which on it rests."""
    gaps = np.maximum(rest, 12.0 + phase * speed - speed * np.arange(frames))
    touched = int(np.argmax(gaps <= rest))
    return gaps + noise * np.random.default_rng(seed).standard_normal(frames), touched


@pytest.mark.parametrize("rest", [0.0, 1.2, 2.5])
@pytest.mark.parametrize("speed", [1.0, 2.3, 7.0])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.8])
def test_contact_is_within_a_pixel_of_the_rest(rest, speed, phase):
    gaps, touched = closing(speed, rest, phase)
    found = first_contact(gaps, 3.0, 1.0)
    assert touched - 1 <= found <= touched
    assert rest <= gaps[found] <= rest + 1.0
    assert gaps[found - 1] > rest + 1.0


@pytest.mark.parametrize("speed", [0.3, 1.0, 3.0])
def test_noise_does_not_stop_it_early(speed):
    for seed in range(50):
        gaps, touched = closing(speed, 0.5, 0.2, frames=80, noise=0.05, seed=seed)
        found = first_contact(gaps, 3.0, 1.0)
        assert abs(found - (touched - 1.0 / speed)) <= 1.0 + 0.5 / speed


def test_gap_that_still_closes_has_no_rest():
    assert rest_begins(12.0 - 2.0 * np.arange(6), 3.0) is None
    assert rest_begins([5.0, 5.0, 5.0, 5.0], 3.0) is None  # it rests, but far away
    assert rest_begins([5.0, 2.0, 2.0, 2.0, 2.0], 3.0) is not None


def test_droplet_that_passes_by_is_nearest_at_its_contact():
    gaps = np.hypot(20.0 - 2.0 * np.arange(21), 18.0) - 16.0  # 2 pixels at the nearest
    found = first_contact(gaps, 3.0, 1.0)
    assert gaps[found] <= 3.0 < gaps[found - 1]


def soft(times, touch, before=(200.0, -30.0), pushed=(-2000.0, 300.0)):
    """Return places of what is slowed down from a touch on, and the velocity at any time."""
    since = np.maximum(times - touch, 0.0)
    places = [
        Place(t, 10.0 + before[0] * t + pushed[0] * s**2, 5.0 + before[1] * t + pushed[1] * s**2)
        for t, s in zip(times, since, strict=True)
    ]
    return places, lambda t: tuple(
        b + 2.0 * p * max(t - touch, 0.0) for b, p in zip(before, pushed, strict=True)
    )


@pytest.mark.parametrize("late", [0.0, 0.4, 0.9])
def test_velocity_of_what_is_slowed_down_by_the_touch(late):
    times = np.arange(12) / 60.0
    touch = times[7] - late / 60.0
    places, velocity = soft(times, touch)
    assert touching_velocity(places, 7, touch) == pytest.approx(velocity(times[7]), rel=1e-6)


def test_velocity_of_what_is_hard_is_that_before():
    times = np.arange(12) / 60.0
    touch = times[7] - 0.5 / 60.0
    places = [Place(t, 200.0 * min(t, touch), 200.0 * max(t - touch, 0.0)) for t in times]
    assert touching_velocity(places, 7, touch) == pytest.approx((200.0, 0.0), abs=1e-6)


def test_few_frames_give_what_they_can():
    places = [Place(k / 60.0, 2.0 * k, 0.0) for k in range(6)]
    assert touching_velocity(places, 1, places[1].time_s)[0] == pytest.approx(120.0)
    assert math.isnan(touching_velocity(places, 0, 0.0)[0])


def test_noise_does_not_turn_the_velocity_but_a_bend_does():
    """Places a twentieth of a pixel off, as those of a film: the direction is that of a line."""
    times, turned = np.arange(8) / 60.0, []
    for seed in range(50):
        noise = 0.05 * np.random.default_rng(seed).standard_normal((8, 2))
        places = [Place(t, 180.0 * t + dx, dy) for t, (dx, dy) in zip(times, noise, strict=True)]
        vx, vy = contact_velocity(places)
        turned.append(math.degrees(math.atan2(vy, vx)))
    # A line's slope is 0.0077 pixels a frame off, of 3 pixels a frame; a parabola's end 0.036.
    assert np.sqrt(np.mean(np.square(turned))) < 0.3
    bent = [Place(t, 180.0 * t, 400.0 * t**2) for t in times]
    assert contact_velocity(bent) == pytest.approx((180.0, 800.0 * times[-1]), rel=1e-6)


def test_approach_is_known_some_frames_after_the_touch():
    approach = Approach([], 8, 3.0, fixed=False)
    gaps, touched = closing(2.0, 1.0)
    known = None
    for frame, gap in enumerate(gaps):
        approach.add(frame, Place(frame / 60.0, 2.0 * frame, 0.0), np.full((3, 2), frame), gap)
        known = frame if approach.known and known is None else known
    contact = approach.contact()
    assert touched - 1 <= contact.frame <= touched
    assert contact.outline[0, 0] == contact.frame
    assert known is not None
    assert known <= touched + 6
    fixed = Approach([], 8, 3.0, fixed=True)
    for frame, gap in enumerate(gaps):
        fixed.add(frame, Place(frame / 60.0, 2.0 * frame, 0.0), np.full((3, 2), frame), gap)
    assert fixed.contact().frame == int(np.argmax(gaps <= 3.0))


def test_long_approach_keeps_its_end_only():
    approach = Approach([], 8, 3.0, fixed=False)
    gaps, touched = closing(0.02, 1.0, frames=900)
    for frame, gap in enumerate(gaps):
        approach.add(frame, Place(frame / 60.0, 0.02 * frame, 0.0), np.zeros((3, 2)), gap)
    assert abs(approach.contact().frame - (touched - 50)) <= 1


def test_contact_and_speed_on_drawn_films(tmp_path):
    """No frame is missed, and the speed has no bias beyond 2 %: slow droplets and fast ones."""
    laboratory = Laboratory(
        obstacle_radius_um=85, thickness_um=85, viscosity_mPa_s=48, surface_tension_mN_m=20
    )
    look = Microscope(width=480, height=360, noise=3.0)
    runs = [
        passage_of(
            po.Parameters(size_ratio=d, simulation_capillary_number=ca, offset=y), look, laboratory
        )
        for d, ca, y in (
            (3.3, 25, 0.05),
            (3.6, 45, 0.04),
            (4.7, 35, 0.1),
            (4.4, 50, 0.02),
            (3.8, 21, 0.15),
            (3.0, 30, -0.12),
        )
    ]
    scene, count = lane_scene(runs, look)
    made = film(scene, tmp_path / "clip.mp4", count, microscope=look, laboratory=laboratory)
    settings = VideoSettings(pixel_size_um=5.28, laboratory=laboratory, method="rings")
    result = measure_clip(made.clip, settings)
    table = encounter_table(result.encounters, laboratory, "video", "")
    truth = encounter_table(scene_encounters(scene, look, count), laboratory, "film", "")
    assert len(table) == len(truth) == 6
    late = table["contact_frame"].to_numpy() - truth["contact_frame"].to_numpy()
    assert np.abs(late).max() <= 1
    assert abs(late.mean()) <= 0.2
    bias = table["speed_mm_s"].to_numpy() / truth["speed_mm_s"].to_numpy() - 1.0
    assert abs(bias.mean()) < 0.02
    fixed = measure_clip(made.clip, settings.replace(contact_distance_um=16.0))
    early = encounter_table(fixed.encounters, laboratory, "video", "")
    assert early["contact_frame"].mean() < table["contact_frame"].mean()
