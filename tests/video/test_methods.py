"""Segmentations on pictures whose every droplet is known, and the choice among them."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from pinchoff.support.errors import InputError
from pinchoff.video.background import Sample, sample
from pinchoff.video.choice import choose
from pinchoff.video.clips import measure_clip, reason_for_doubt
from pinchoff.video.droplets import Droplet
from pinchoff.video.methods.alike import more_alike, without_what_others_show
from pinchoff.video.methods.enclosed import EnclosedSegmenter
from pinchoff.video.methods.function import FunctionSegmenter
from pinchoff.video.methods.spots import SpotSegmenter
from pinchoff.video.obstacles import is_obstacle
from pinchoff.video.quality import Picture, across, covered_twice, persistence, quality
from pinchoff.video.reading import Frame
from pinchoff.video.settings import METHOD_NAMES, VideoSettings
from pinchoff.video.signal import Signal, best_channel
from pinchoff.video.tracking import Tracker
from pinchoff.video.variants import METHODS

SIZE = (420, 200)  # width and height, pixels
TOP, BOTTOM, WALL = 60, 140, 12  # of the channel, inside
LENGTH, RIM = 130.0, 6.0
LIGHT, DARK = 170.0, 45.0
SETTINGS = VideoSettings(pixel_size_um=1.0)


def distance_to_stadium(x, y, length, height):
    """Signed distance from the outline of a plug of some length, positive outside."""
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
    half = 0.5 * (length - height)
    off = np.maximum(np.abs(columns - x) - half, 0.0)
    return np.hypot(off, rows - y) - 0.5 * height


def picture(plugs, *, specks=(), seed=0, noise=2.0):
    """A channel whose walls are as dark as the rims of the plugs (x, length) that fill it."""
    luma = np.full(SIZE[::-1], LIGHT)
    luma[TOP - WALL : TOP] = luma[BOTTOM : BOTTOM + WALL] = DARK
    middle, height = 0.5 * (TOP + BOTTOM), BOTTOM - TOP + 2.0 * RIM
    for x, length in plugs:
        away = distance_to_stadium(x, middle, length, height)
        rim = np.clip(0.5 - away, 0.0, 1.0) - np.clip(0.5 - away - RIM, 0.0, 1.0)
        luma += rim * (DARK - luma)
    for x, y in specks:
        cv2.circle(luma, (int(x), int(y)), 4, 60.0, cv2.FILLED)
    luma = cv2.GaussianBlur(luma, (0, 0), 1.0)
    luma += noise * np.random.default_rng(seed).standard_normal(luma.shape)
    return np.clip(luma, 0, 255).astype(np.uint8)


def plug_film(count=12, step=11.0, **drawn):
    lumas = [
        picture([(90 + step * k, LENGTH), (265 + step * k, LENGTH)], seed=k, **drawn)
        for k in range(count)
    ]
    return [Frame(k, k / 30.0, luma, None) for k, luma in enumerate(lumas)]


def chosen(frames, settings=SETTINGS):
    return choose(sample(iter(frames)), settings)


def whole(droplets):
    return sorted((each for each in droplets if not each.cut), key=lambda each: each.x)


def test_plugs_that_share_the_walls_darkness_are_found_by_default():
    frames = plug_film(8, 6.0)
    choice = chosen(frames)
    assert choice.method == "enclosed"
    assert choice.scores()["enclosed"] == 1.0
    for k, frame in enumerate(frames[:3]):
        first, second = whole(choice.segmenter.droplets(frame))  # the oil between them is none
        for x, plug in ((90 + 6.0 * k, first), (265 + 6.0 * k, second)):
            assert plug.x == pytest.approx(x, abs=0.5)
            low, high = plug.outline.min(axis=0), plug.outline.max(axis=0)
            assert (low[0], high[0]) == pytest.approx((x - LENGTH / 2, x + LENGTH / 2), abs=0.3)
            height = BOTTOM - TOP + 2.0 * RIM
            true = (LENGTH - height) * height + 0.25 * math.pi * height**2
            assert plug.area == pytest.approx(true, rel=0.01)
            assert plug.group == -1


@pytest.fixture(scope="module")
def plain_areas():
    """Areas of the whole plugs of a film's first frame, as the camera sees it."""
    droplets = chosen(plug_film(6, 6.0)).segmenter.droplets(plug_film(1)[0])
    return sorted(each.area for each in whole(droplets))


@pytest.mark.parametrize(
    "change",
    [
        lambda luma: 255 - luma,
        lambda luma: luma[:, ::-1],
        lambda luma: luma.T,
        lambda luma: (0.4 * luma + 60).astype(np.uint8),
        lambda luma: cv2.resize(luma, None, fx=2.0, fy=2.0, interpolation=cv2.INTER_CUBIC),
    ],
    ids=["negative", "mirrored", "turned", "pale", "twice as large"],
)
def test_what_is_found_does_not_depend_on_how_the_camera_sees_it(plain_areas, change):
    frames = [
        frame._replace(luma=np.ascontiguousarray(change(frame.luma))) for frame in plug_film(6, 6.0)
    ]
    scale = max(frames[0].luma.shape) / max(SIZE)
    choice = chosen(frames)
    assert choice.method == "enclosed"
    found = whole(choice.segmenter.droplets(frames[0]))
    seen = sorted(each.area / scale**2 for each in found)
    assert seen == pytest.approx(plain_areas, rel=0.02)


def test_specks_in_a_plug_and_on_its_rim_are_no_droplets_and_leave_no_dents():
    clean = [frame.luma for frame in plug_film(1)]
    specks = [(70, 90), (100, 110), (90, TOP + 5)]
    luma = picture([(90, LENGTH), (265, LENGTH)], specks=specks)
    frames = [Frame(0, 0.0, clean[0], None), Frame(1, 0.0, luma, None)]
    segmenter = EnclosedSegmenter.learned(frames, Signal(), 25, 200.0)
    before, after = (whole(segmenter.droplets(frame)) for frame in frames)
    assert len(after) == len(before) == 2
    assert after[0].area == pytest.approx(before[0].area, rel=0.01)


def test_what_stands_still_while_others_move_is_no_droplet():
    frames = plug_film(8, 6.0)
    for frame in frames:  # a still ring above the channel, and a clock below it
        cv2.circle(frame.luma, (210, 25), 14, 50, 3)
        cv2.putText(frame.luma, "00:0", (20, 190), cv2.FONT_HERSHEY_SIMPLEX, 1.0, 20, 2)
    segmenter = chosen(frames).segmenter
    found = [whole(segmenter.droplets(frame)) for frame in frames[:3]]
    assert [len(here) for here in found] == [2, 2, 2]
    assert all(each.area > 5000.0 for here in found for each in here)


def test_the_dark_edge_of_the_view_cuts():
    frames = plug_film(8, 6.0)
    for frame in frames:
        frame.luma[:, :60] = 0  # the first plug begins beyond it
    segmenter = chosen(frames).segmenter
    for frame in frames[:2]:
        droplets = segmenter.droplets(frame)
        assert [round(each.x) for each in whole(droplets)] == [265 + 6 * frame.number]


def discs(places, radius, *, size=SIZE, dark=70.0, light=190.0):
    rows, columns = np.mgrid[: size[1], : size[0]].astype(float)
    luma = np.full(size[::-1], light)
    for x, y in places:
        luma += np.clip(radius + 0.5 - np.hypot(columns - x, rows - y), 0.0, 1.0) * (dark - luma)
    return cv2.GaussianBlur(luma, (0, 0), 1.2)


def test_dark_discs_are_spots_of_their_true_size():
    luma = np.clip(discs([(80, 90), (200, 60), (300, 130)], 24.0), 0, 255).astype(np.uint8)
    frame = Frame(0, 0.0, luma, None)
    found = whole(SpotSegmenter.learned([frame], Signal(), 101, 95.0).droplets(frame))
    assert [(round(d.x), round(d.y)) for d in found] == [(80, 90), (200, 60), (300, 130)]
    assert [d.area for d in found] == pytest.approx([math.pi * 24**2] * 3, rel=0.02)
    bright = frame._replace(luma=255 - luma)
    negative = SpotSegmenter.learned([bright], Signal(inverted=True), 101, 95.0)
    assert [d.area for d in whole(negative.droplets(bright))] == pytest.approx(
        [d.area for d in found], rel=1e-3
    )


def test_discs_that_touch_come_apart_round_a_gap():
    places = [(100, 80), (146, 80), (100, 126), (146, 126)]  # the gap among them is no droplet
    luma = np.clip(discs(places, 23.5), 0, 255).astype(np.uint8)
    frame = Frame(0, 0.0, luma, None)
    found = SpotSegmenter.learned([frame], Signal(), 101, 95.0).droplets(frame)
    assert sorted((round(d.x), round(d.y)) for d in found) == sorted(places)
    assert [d.area for d in found] == pytest.approx([math.pi * 23.5**2] * 4, rel=0.05)
    assert {d.group for d in found} == {0}


def test_shaded_droplets_are_found_by_their_likeness_to_the_sure_ones():
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
    image = np.full(SIZE[::-1], 150.0)
    places = [(50 + 45 * k, 50 + 60 * (k % 2)) for k in range(8)]
    for x, y in places:
        inside = np.hypot(columns - x, rows - y) <= 14.0
        image = np.where(inside, 150.0 + 4.0 * (rows - y), image)  # dark above, bright below
    image = cv2.GaussianBlur(image, (0, 0), 1.0).astype(np.float32)
    angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    circle = 14.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    sure = [
        Droplet(circle + place, math.pi * 14**2, *map(float, place), False, -1)
        for place in places[:3]
    ]
    more = more_alike(image, sure)
    found = sorted((round(each.x), round(each.y)) for each in more)
    assert found == sorted(places[3:])
    assert more_alike(image, sure[:2]) == []  # two are too few to know what droplets look like
    # A place below one, nothing in it, has of a droplet only what that one shows.
    x, y = places[5]
    empty = sure[0]._replace(outline=circle + np.array([x, y + 20.0]), x=float(x), y=y + 20.0)
    assert without_what_others_show(image, sure, sure, [*more, empty], 14.0) == more


def test_strong_light_of_one_colour_leaves_the_signal_in_another():
    frame = plug_film(1)[0]
    grey = cv2.cvtColor(frame.luma, cv2.COLOR_GRAY2RGB)
    blue_only = grey.copy()
    blue_only[..., :2] = 200  # red and green show nothing
    yuv = cv2.cvtColor(blue_only, cv2.COLOR_RGB2YUV)
    chroma = np.moveaxis(cv2.resize(yuv[..., 1:], (210, 100)), 2, 0).copy()
    assert best_channel([Frame(0, 0.0, yuv[..., 0].copy(), chroma)]) == "blue"
    assert best_channel([frame]) == "brightness"


def ringed(x, y, radius, count=96):
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    outline = np.array([x, y]) + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return Droplet(outline, math.pi * radius**2, x, y, False, -1)


def ring_image(x=200.0, y=100.0, radius=40.0):
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]].astype(float)
    away = np.hypot(columns - x, rows - y)
    luma = np.where((away <= radius) & (away >= radius - 6), 50.0, 170.0)
    return cv2.GaussianBlur(luma, (0, 0), 1.0).astype(np.float32)


def test_an_outline_is_worth_less_where_nothing_happens_across_it():
    image = ring_image()
    right, shifted, inner = (
        ringed(200, 100, 40),
        ringed(215, 100, 40),
        ringed(200, 100, 33.5),
    )
    worth = [quality([[Picture(image, 1.0)]], [[each]]).score for each in (right, shifted, inner)]
    assert worth[0] == pytest.approx((math.pi * 40**2) ** 0.75, rel=0.05)
    assert worth[1] < 0.5 * worth[0]
    assert worth[2] < 0.5 * worth[0]  # the inner edge of a rim
    assert across(image, right.outline, 1.0).closed == 1.0
    assert across(image, inner.outline, 1.0).inner > 0.9


def test_an_outline_beside_the_edge_is_worth_less_than_one_on_it():
    picture = Picture(ring_image(), 1.0)
    worth = [quality([[picture]], [[ringed(200, 100, radius)]]).score for radius in (40, 42.5)]
    assert worth[1] < 0.95 * worth[0]


def test_droplets_that_vanish_inside_the_frame_do_not_persist():
    here, near = ringed(200, 100, 20), ringed(215, 100, 20)
    at_edge = ringed(24, 100, 20)
    assert persistence([([here], [near])], SIZE) == 1.0
    assert persistence([([here], [])], SIZE) == 0.0
    assert persistence([([], [here])], SIZE) == 0.0  # nothing appears there either
    assert math.isnan(persistence([([at_edge], [])], SIZE))  # it may have left
    assert persistence([([here, at_edge], [near])], SIZE) == 1.0
    assert persistence([([here], [ringed(215, 100, 25)])], SIZE) == 0.0  # another size
    unsteady = persistence([([here], [ringed(215, 100, 21)])], SIZE)
    assert unsteady == pytest.approx(1.0 - 2 * 20 * (1 - (20 / 21) ** 2) / 41)
    assert math.isnan(persistence([([], [])], SIZE))


def test_droplets_that_the_frame_cuts_before_or_after_are_not_lost():
    inside = ringed(50, 100, 20)
    part = ringed(18, 100, 14)._replace(cut=True)  # of what was inside, or will be
    beyond = ringed(18, 100, 24)._replace(cut=True)  # larger: another one
    assert math.isnan(persistence([([inside], [part])], SIZE))
    assert math.isnan(persistence([([part], [inside])], SIZE))
    assert persistence([([inside], [beyond])], SIZE) == 0.0
    # What is found again counts wherever it is: a plug that nearly fills the frame.
    at_edge, speck = ringed(24, 100, 20), ringed(300, 100, 5)
    assert persistence([([at_edge], [at_edge])], SIZE) == 1.0
    assert persistence([([at_edge], [at_edge, speck])], SIZE) == pytest.approx(1 - 5 / 45)


def test_what_outlines_cover_twice():
    one, other, apart = ringed(100, 100, 30), ringed(130, 100, 30), ringed(300, 100, 30)
    lens = 2 * math.acos(0.5) - 0.5 * math.sqrt(3.0)  # that two discs share, radii squared
    assert covered_twice([[one, apart]], SIZE) == 0.0
    assert covered_twice([[one, other]], SIZE) == pytest.approx(lens / (2 * math.pi), rel=0.03)
    assert covered_twice([[one], [other]], SIZE) == 0.0  # in different frames
    assert covered_twice([[one, other._replace(cut=True)]], SIZE) == 0.0
    assert covered_twice([[]], SIZE) == 0.0


def test_outlines_that_overlap_make_a_choice_a_guess():
    choice = chosen(plug_film())
    assert (choice.method, reason_for_doubt(choice)) == ("enclosed", "")
    twice = [[each for each in here for _ in range(2)] for here in choice.trial.found]
    doubtful = choice._replace(trial=choice.trial._replace(found=twice))
    assert "its outlines overlap, by 50 % of what they cover" in reason_for_doubt(doubtful)


def test_method_names_are_those_that_settings_know():
    assert tuple(METHODS) == METHOD_NAMES
    assert VideoSettings(pixel_size_um=1.0, packed=True).method == "packed"
    with pytest.raises(InputError, match="method must be one of rings, enclosed"):
        VideoSettings(pixel_size_um=1.0, method="magic")


def test_a_method_that_is_named_is_used():
    frames = plug_film(5, 6.0)
    choice = chosen(frames, SETTINGS.replace(method="spots"))
    assert choice.method == "spots"
    assert list(choice.scores()) == ["spots"]


def squares(luma):
    return [[(10, 10), (50, 10), (50, 60), (10, 60)], [(0, 80), (0, 120), (40, 120), (40, 80)]]


def test_a_function_of_ones_own():
    frame = plug_film(1)[0]
    inside, at_edge = FunctionSegmenter(squares, 95.0).droplets(frame)
    assert (inside.area, inside.x, inside.y, inside.cut) == (2000.0, 30.0, 35.0, False)
    assert at_edge.cut
    for wrong in ([[1, 2, 3]], [[(0, 0), (1, math.nan), (2, 2)]], [["a", "b"]]):
        with pytest.raises(InputError, match="segment must be"):
            FunctionSegmenter(lambda luma, wrong=wrong: wrong, 0.0).droplets(frame)
    assert choose(Sample([frame]), SETTINGS, squares).method == "own"


def test_an_obstacle_is_no_droplet():
    pillars = np.array([[200.0, 100.0, 20.0]])
    assert is_obstacle(ringed(202, 101, 21), pillars)
    assert not is_obstacle(ringed(202, 101, 45), pillars)  # a droplet that lies over it
    assert not is_obstacle(ringed(240, 100, 20), pillars)
    assert not is_obstacle(ringed(200, 100, 20), np.empty((0, 3)))


def test_films_whose_frames_repeat_are_followed():
    """Nothing moves for three frames, then by more than half a diameter at once."""
    tracker = Tracker(SETTINGS)
    for frame in range(40):
        steps = np.minimum(18.0 + 4.0 * np.arange(frame // 4), 36.0)
        x = 30.0 + steps.sum()
        numbers, _ = tracker.step(frame, [ringed(x, 100.0, 30.0)])
        assert numbers == [0]


def test_an_empty_film_says_what_was_tried(tmp_path):
    folder = tmp_path / "empty"
    folder.mkdir()
    for k in range(6):
        noise = np.random.default_rng(k).normal(128, 3, (120, 160))
        cv2.imwrite(str(folder / f"{k}.png"), noise.astype(np.uint8))
    result = measure_clip(folder, SETTINGS)
    assert result.track_count == 0
    assert "no droplets were found; none of the methods rings, enclosed" in result.warning


def test_a_scale_at_which_nothing_shows_is_refused(tmp_path):
    folder = tmp_path / "clip"
    folder.mkdir()
    for frame in plug_film(2):
        cv2.imwrite(str(folder / f"{frame.number}.png"), frame.luma)
    settings = VideoSettings(pixel_size_um=5280.0, laboratory={"obstacle_radius_um": 85.0})
    with pytest.raises(InputError, match=r"0\.0161 px"):
        measure_clip(folder, settings)
