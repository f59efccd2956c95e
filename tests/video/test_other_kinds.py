"""Kinds of film that none of the real ones shows, drawn small: found by default."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from pinchoff.video.background import sample
from pinchoff.video.choice import choose
from pinchoff.video.clips import measure_clip, reason_for_doubt
from pinchoff.video.droplets import Droplet
from pinchoff.video.reading import Frame
from pinchoff.video.regions import outside_view, seen_part
from pinchoff.video.scale import clip_of
from pinchoff.video.settings import VideoSettings
from pinchoff.video.standing import Travels, standing_rows

CLIP = Path(__file__).parents[2] / "examples" / "clip.mp4"
HEIGHT, WIDTH = 120, 160
SETTINGS = VideoSettings(pixel_size_um=1.0, fps=100.0)
ROWS, COLUMNS = np.mgrid[:HEIGHT, :WIDTH].astype(float)


def away(x, y, radius):
    """Distance from a circle, positive outside."""
    return np.hypot(COLUMNS - x, ROWS - y) - radius


def bump(distance, width):
    return np.exp(-(distance**2) / (2.0 * width**2))


def film(draw, count=6, noise=2.0):
    """Frames that `draw` gives by their numbers, with noise."""
    generator = np.random.default_rng(1)
    lumas = [draw(k) + noise * generator.standard_normal((HEIGHT, WIDTH)) for k in range(count)]
    return [
        Frame(k, k / 100.0, np.clip(luma, 0, 255).astype(np.uint8), None)
        for k, luma in enumerate(lumas)
    ]


def chosen(frames):
    return choose(sample(iter(frames)), SETTINGS)


def whole(droplets):
    return sorted((each for each in droplets if not each.cut), key=lambda each: each.x)


def places(k):
    """Centres of three droplets in the k-th frame."""
    return [(30 + 5 * k, 35), (65 + 5 * k, 82), (100 + 5 * k, 40)]


def found_at(frames, radius, tolerance=0.1):
    """Return the choice, once every droplet of `places` was found with its radius."""
    choice = chosen(frames)
    for frame in frames:
        found = whole(choice.segmenter.droplets(frame))
        assert [round(each.x) for each in found] == [x for x, _ in sorted(places(frame.number))]
        radii = [math.sqrt(each.area / math.pi) for each in found]
        assert radii == pytest.approx([radius] * 3, rel=tolerance)
    return choice


def ringed(k, radius=12.0, light=150.0, dark=70.0):
    image = np.full((HEIGHT, WIDTH), light)
    for x, y in places(k):
        image -= dark * bump(away(x, y, radius) + 1.5, 1.2)
    return image


def test_the_light_about_droplets_in_phase_contrast_is_not_their_edge():
    def draw(k):
        image = np.full((HEIGHT, WIDTH), 120.0)
        for x, y in places(k):
            edge = away(x, y, 14.0)
            image += 50.0 * bump(edge - 2.2, 2.0) - 45.0 * bump(edge + 2.0, 1.4)
        return image

    found_at(film(draw), 14.0)


def test_droplets_that_glow_and_bright_rims_on_dark():
    def glowing(k):
        image = np.full((HEIGHT, WIDTH), 15.0)
        for x, y in places(k):
            image += 120.0 / (1.0 + np.exp(np.clip(2.0 * away(x, y, 11.0), -40, 40)))
        return image

    found_at(film(glowing), 11.0)
    found_at(film(lambda k: 175.0 - ringed(k)), 12.0)


def test_droplets_smaller_than_is_looked_for_are_found_if_they_move():
    def draw(k):
        image = np.full((HEIGHT, WIDTH), 160.0)
        for x, y in places(k):
            image -= 80.0 / (1.0 + np.exp(np.clip(2.5 * away(x, y, 3.6), -40, 40)))
        return image

    found_at(film(draw), 3.6, 0.2)
    still = chosen(film(lambda k: draw(0)))  # dust
    assert still.trial.quality.droplets == 0.0


def test_a_black_frame_all_round_cuts_nothing_within():
    def draw(k):
        image = ringed(k)
        image[:8] = image[-8:] = 0.0
        image[:, :8] = image[:, -8:] = 0.0
        return image

    frames = film(draw)
    view = outside_view([frame.luma.astype(np.float32) for frame in frames])
    assert np.count_nonzero(view) / view.size == pytest.approx(
        1 - 104 * 144 / (120 * 160), abs=0.03
    )
    part = seen_part(view, (WIDTH, HEIGHT))
    assert abs(part.left - 8) <= 1
    assert abs(part.width - 144) <= 2
    found_at(frames, 12.0)


@pytest.mark.parametrize("method", ["enclosed", "packed"])
def test_dirt_is_no_droplet_where_droplets_pass(method):
    def draw(k):
        image = ringed(k)
        for x, y in ((20, 100), (140, 100), (140, 15)):
            image -= 60.0 * bump(away(x, y, 7.0) + 1.5, 1.2)
        return image

    frames = film(draw, 8)
    choice = choose(sample(iter(frames)), SETTINGS.replace(method=method))
    counts = [len(whole(choice.segmenter.droplets(frame))) for frame in frames[:6]]
    assert counts == [3] * 6


def test_tracks_that_never_move_are_counted_where_others_do():
    def disc(x, y):
        return Droplet(np.empty((0, 2)), 300.0, x, y, False, -1)

    passing, resting = Travels(), Travels()
    for k in range(12):
        dirt, droplet = disc(20.0 + 0.5 * math.sin(k), 30.0), disc(10.0 + 5.0 * k, 60.0)
        passing.append([dirt, droplet], [0, 1])
        resting.append([dirt, disc(50.0 + 0.5 * k, 60.0)], [0, 1])
    assert passing.standing() == 1
    assert resting.standing() == 0  # nothing goes far: they are droplets at rest
    assert Travels().standing() == 0


def test_what_stands_and_what_moves_about_its_place():
    generator = np.random.default_rng(2)
    dirt = np.array([[50.0, 60.0, 200.0], [90.0, 20.0, 150.0]])
    frames = 8

    def trembling(size):
        return [
            np.column_stack([dirt[:, :2] + size * generator.standard_normal((2, 2)), dirt[:, 2]])
            for _ in range(frames)
        ]

    moving = [np.array([[10.0 + 12.0 * k, 40.0, 300.0]]) for k in range(frames)]
    still = trembling(0.1)
    assert len(standing_rows(still)) == 0  # nothing moves: they are the droplets
    assert len(standing_rows(still, always=True)) == 2 * frames
    assert len(standing_rows([])) == 0
    both = [np.concatenate(pair) for pair in zip(still, moving, strict=True)]
    assert sorted(set(standing_rows(both)[:, 2])) == [150.0, 200.0]
    # Droplets that tremble about their places stand no more than one that travels.
    both = [np.concatenate(pair) for pair in zip(trembling(1.2), moving, strict=True)]
    assert len(standing_rows(both)) == 0


def test_a_picture_that_moves_is_said_to(tmp_path):
    def draw(k):
        image = ringed(k)
        for x, y in np.random.default_rng(5).uniform(0, (WIDTH, HEIGHT), (40, 2)):
            image -= 60.0 * bump(away(x, y, 3.0), 1.2)
        return image

    steady = film(draw)
    assert chosen(steady).moved is None
    drifting = film(lambda k: np.roll(draw(k), 2 * k, axis=0))
    moved = chosen(drifting).moved
    assert moved.pixels == pytest.approx(2.0, abs=0.3)
    assert moved.last == moved.first + 1
    for frame in drifting:
        cv2.imwrite(str(tmp_path / f"{frame.number}.png"), frame.luma)
    warning = measure_clip(tmp_path, SETTINGS).warning
    assert "the picture itself moves" in warning
    assert "align the frames" in warning


def test_droplets_that_all_move_alike_are_no_moving_picture():
    assert chosen(film(ringed)).moved is None
    flicker = film(lambda k: (1.0 + 0.1 * math.sin(k)) * (140.0 + 0.1 * COLUMNS))
    assert chosen(flicker).moved is None


def test_shades_much_fainter_than_droplets_are_no_spots():
    def draw(k):
        image = np.full((HEIGHT, WIDTH), 160.0)
        for x, y in places(k):
            image -= 80.0 / (1.0 + np.exp(np.clip(2.5 * away(x, y, 11.0), -40, 40)))
        image[90:112, 10:32] -= 5.0  # a block of a codec, that comes and goes
        return image if k % 2 else draw(k + 1)

    frames = film(draw, 6, noise=0.5)
    choice = choose(sample(iter(frames)), SETTINGS.replace(method="spots"))
    assert [len(whole(choice.segmenter.droplets(frame))) for frame in frames] == [3] * 6


def test_rims_in_a_pale_picture_are_found_as_in_a_full_one():
    full = film(ringed)
    pale = [
        frame._replace(luma=(0.6 * frame.luma + 90.0).astype(np.uint8)) for frame in film(ringed)
    ]
    for frames in (full, pale):
        choice = choose(sample(iter(frames)), SETTINGS.replace(method="packed"))
        assert len(whole(choice.segmenter.droplets(frames[0]))) == 3


def test_an_empty_packed_scene_has_no_droplets():
    empty = film(lambda k: np.full((HEIGHT, WIDTH), 150.0))
    choice = choose(sample(iter(empty)), SETTINGS.replace(method="packed"))
    assert choice.trial.quality.droplets == 0.0


def test_what_lies_beyond_a_wall_is_no_cut_droplet():
    def draw(k):
        image = ringed(k)
        image -= 90.0 * bump(COLUMNS - ROWS - 100.0, 2.0)  # a wall across a corner of the frame
        image -= 90.0 * bump(COLUMNS + ROWS - 50.0, 2.0) * (ROWS > 0)
        return image

    frames = film(lambda k: draw(k + 2), 4)
    found = chosen(frames).segmenter.droplets(frames[0])
    assert max(each.area for each in found) < 1000.0


def test_a_choice_that_is_a_guess_is_said_to_be_one(tmp_path):
    generator = np.random.default_rng(3)
    for k in range(6):  # droplets that are somewhere else in every frame
        image = np.full((HEIGHT, WIDTH), 150.0)
        for x, y in zip(generator.integers(20, 140, 3), (25, 60, 95), strict=True):
            image -= 70.0 * bump(away(x, y, 12.0) + 1.5, 1.2)
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.clip(image, 0, 255).astype(np.uint8))
    warning = measure_clip(tmp_path, SETTINGS).warning
    assert "is a guess" in warning
    assert "look at a preview" in warning


def test_methods_tried_on_other_frames_make_no_choice_a_guess():
    """Spots are tried on one frame, where there are more droplets than there are on average."""
    settings = VideoSettings(pixel_size_um=5.28, laboratory={"obstacle_radius_um": 85.0})
    choice = choose(sample(clip_of(CLIP, settings).frames(sparse=True)), settings)
    (spots,) = (trial for trial in choice.trials if trial.method == "spots")
    assert len(spots.found) < len(choice.trial.found)
    assert spots.quality.droplets > 1.5 * choice.trial.quality.droplets
    assert reason_for_doubt(choice) == ""
