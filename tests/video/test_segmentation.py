"""Droplets of known outline are found where they are, to a small fraction of a pixel."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from pinchoff import _core
from pinchoff.video.contours import trace
from pinchoff.video.levels import calibrate
from pinchoff.video.methods.rings import RingSegmenter
from pinchoff.video.microscope import Scene
from pinchoff.video.settings import VideoSettings

OBSTACLE = (150.0, 60.0, 16.0)


@pytest.fixture
def settings():
    return VideoSettings(pixel_size_um=5.0)


@pytest.fixture
def found(drawn, settings):
    """Function (scene, microscope, count) -> droplets of each frame."""

    def segment(scene, microscope, count=24, *, grey=False, told=settings):
        frames = drawn(scene, microscope, count)
        if grey:
            frames = [frame._replace(chroma=None) for frame in frames]
        segmenter = RingSegmenter(*calibrate(frames, told))
        return [segmenter.droplets(frame) for frame in frames]

    return segment


def crossing(disc, moving, radius=18.0, y=110.0, speed=7.0):
    """A droplet that crosses the whole frame, so that the background is seen everywhere."""
    return moving(disc(radius), (30.3, y + 0.4), (speed, 0.15), OBSTACLE)


def test_area_and_centre_of_a_disc(disc, moving, found, microscope):
    radius = 18.0
    frames = found(Scene((crossing(disc, moving, radius),)), microscope)
    areas, shifts = [], []
    for number, droplets in enumerate(frames):
        (droplet,) = droplets
        assert not droplet.cut
        assert droplet.group == -1
        areas.append(droplet.area / (math.pi * radius**2) - 1)
        shifts.append((droplet.x - 30.3 - 7.0 * number, droplet.y - 110.4 - 0.15 * number))
    assert np.mean(areas) == pytest.approx(0.0, abs=0.004)
    assert np.std(areas) < 0.004
    assert np.mean(shifts, axis=0) == pytest.approx((0.0, 0.0), abs=0.02)
    assert np.std(shifts, axis=0).max() < 0.05


def test_outline_follows_a_droplet_along_an_obstacle(disc, moving, found, microscope):
    """The obstacle's own dark rim does not bend the outline of a droplet that lies against it."""
    scene = Scene((moving(disc(18.0), (60.0, 60.0 + 16.0 + 18.5), (4.0, 0.0), OBSTACLE),))
    frames = found(scene, microscope)
    (droplet,) = frames[22]  # right below the obstacle
    assert droplet.x == pytest.approx(148.0, abs=0.1)
    radii = np.hypot(*(droplet.outline - (148.0, 94.5)).T)
    near = np.abs(droplet.outline[:, 0] - 148.0) < 6
    above = near & (droplet.outline[:, 1] < 94.5)
    assert radii[above].mean() == pytest.approx(18.0, abs=0.12)
    assert radii.mean() == pytest.approx(18.0, abs=0.08)


@pytest.mark.parametrize("grey", [False, True])
def test_touching_droplets_come_apart(disc, moving, found, microscope, grey):
    pair = (
        moving(disc(18.0), (30.0, 110.0), (4.0, 0.0), OBSTACLE),
        moving(disc(14.0), (62.2, 110.0), (4.0, 0.0), OBSTACLE),
    )
    for number, droplets in enumerate(found(Scene(pair), microscope, grey=grey)):
        large, small = sorted(droplets, key=lambda each: -each.area)
        assert large.group == small.group >= 0
        assert large.area == pytest.approx(math.pi * 18.0**2, rel=0.03)
        assert small.area == pytest.approx(math.pi * 14.0**2, rel=0.03)
        assert small.x == pytest.approx(62.2 + 4.0 * number, abs=0.3)


def test_three_touch_in_one_group(disc, moving, found, microscope):
    three = tuple(
        moving(disc(12.0), (20.0 + 24.1 * k, 120.0), (7.0, 0.0), OBSTACLE) for k in range(3)
    )
    for droplets in found(Scene(three), microscope, 20):
        assert len(droplets) == 3
        assert len({droplet.group for droplet in droplets}) == 1


def test_cut_droplets_are_kept_and_marked(disc, moving, found, microscope):
    scene = Scene((moving(disc(18.0), (-10.0, 110.0), (6.0, 0.0), OBSTACLE),))
    frames = found(scene, microscope, 44)
    for number, droplets in enumerate(frames):
        x = -10.0 + 6.0 * number
        if abs(x - 119.5) < 115:  # enough of it is in view
            assert len(droplets) == 1
        for droplet in droplets:
            assert droplet.cut == (x < 18.5 or x > 239 - 18.5)


def test_thin_neck_is_one_droplet(moving, found, microscope):
    """A neck in which both rings meet, so that no inside shows, does not part a droplet."""
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    # Two lobes, joined by a neck that is 7 pixels wide.
    reach = 14.0 + 14.0 * np.cos(2 * angles)
    lobes = np.column_stack([reach * np.cos(angles) * 1.4, reach * np.sin(angles)])
    lobes[:, 1] = np.where(np.abs(lobes[:, 1]) < 3.5, np.sign(np.sin(angles)) * 3.5, lobes[:, 1])
    scene = Scene((moving(lobes, (50.0, 120.0), (4.0, 0.0), OBSTACLE),))
    for droplets in found(scene, microscope, 20):
        assert len({droplet.group for droplet in droplets}) == 1
        if len(droplets) == 2:
            assert droplets[0].whole is not None
            assert droplets[0].whole.area == pytest.approx(sum(d.area for d in droplets), rel=0.01)


@pytest.mark.parametrize("interior", [(226, 142, 172), (120, 170, 210), (190, 200, 120)])
def test_any_colour_of_dye(disc, moving, found, microscope, interior):
    look = microscope.replace(interior=interior)
    frames = found(Scene((crossing(disc, moving),)), look)
    assert all(len(droplets) == 1 for droplets in frames)


@pytest.mark.parametrize("radius", [3.5, 5.0, 7.0, 9.0])
def test_droplets_that_are_all_ring(disc, moving, found, settings, microscope, radius):
    """The ring is 3.6 pixels wide: the smallest droplets show no interior."""
    small = moving(disc(radius), (20.0, 130.4), (6.0, 0.1), OBSTACLE)
    told = settings.replace(minimum_diameter_um=30.0)
    large = moving(disc(18.0), (30.3, 50.0), (5.0, 0.0), OBSTACLE)
    for number, droplets in enumerate(found(Scene((large, small)), microscope, told=told)):
        (droplet,) = (each for each in droplets if each.y > 110.0)
        assert droplet.x == pytest.approx(20.0 + 6.0 * number, abs=0.15)
        assert droplet.area == pytest.approx(math.pi * radius**2, rel=0.5 / radius)


@pytest.mark.parametrize("width_um", [10.0, 60.0, 100.0])
def test_width_of_the_ring(disc, moving, drawn, settings, microscope, width_um):
    """Profiles reach as far inwards as the ring asks for."""
    look = microscope.replace(ring_width_um=width_um)
    frames = drawn(Scene((moving(disc(36.0), (40.3, 110.4), (7.0, 0.1), OBSTACLE),)), look, 24)
    levels = calibrate(frames, settings).levels
    assert levels.ring_width == pytest.approx(width_um / settings.pixel_size_um, abs=0.9)


def test_thresholds_that_are_given_are_taken(disc, moving, drawn, settings, microscope):
    frames = drawn(Scene((crossing(disc, moving),)), microscope, 24)
    told = settings.replace(
        edge_level=0.45,
        pale_edge_level=0.3,
        inner_edge_level=0.7,
        ring_darkness=120.0,
        ring_width_um=15.0,
        interior_level=0.4,
    )
    levels = calibrate(frames, told).levels
    assert (levels.edge, levels.pale_edge, levels.hole) == (0.45, 0.3, 0.7)
    assert (levels.ring, levels.ring_width, levels.interior) == (120.0, 3.0, 0.4)
    assert len(RingSegmenter(*calibrate(frames, told)).droplets(frames[10])) == 1


@pytest.mark.parametrize(("interior", "share"), [(140, 0.42), (230, 0.0)])
def test_pale_rings_are_darker_than_the_interior(
    disc, moving, drawn, settings, microscope, interior, share
):
    look = microscope.replace(interior=(interior,) * 3, fluid=(206,) * 3, ring=(50,) * 3)
    levels = calibrate(drawn(Scene((crossing(disc, moving),)), look, 24), settings).levels
    # The ring's darkness is a tenth less than drawn, because of the blur.
    assert levels.pale_edge == pytest.approx(0.5 * (levels.edge + share), abs=0.04)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.6])
@pytest.mark.parametrize("grey", [False, True])
def test_interior_as_dark_as_the_edge(disc, moving, found, microscope, share, grey):
    """Strongly dyed droplets: at the edge's level they are one dark blob."""
    interior = tuple(round(206 - share * (206 - 50)) for _ in range(3))
    look = microscope.replace(interior=interior, ring=(50, 50, 50))
    for droplets in found(Scene((crossing(disc, moving),)), look, grey=grey):
        (droplet,) = droplets
        assert droplet.area == pytest.approx(math.pi * 18.0**2, rel=0.015)


def test_thin_ring_that_blur_makes_as_pale_as_the_interior(disc, moving, found, microscope):
    look = microscope.replace(ring_width_um=5.0, blur_px=1.6)
    for droplets in found(Scene((crossing(disc, moving),)), look):
        assert len(droplets) == 1


def test_a_pale_ring_that_brushes_past_is_no_part_of_another(disc, moving, found, microscope):
    """A fast, smeared droplet passes a slow one at half a pixel: they touch, or are apart."""
    look = microscope.replace(exposure=0.8, width=320)
    aside = (150.0, 20.0, 12.0)
    slow = moving(disc(24.0), (60.0, 80.0), (4.0, 0.0), aside)
    fast = moving(disc(20.0), (-120.0, 124.5), (11.0, 0.0), aside)
    flagged = 0
    for number, droplets in enumerate(found(Scene((slow, fast)), look, 32)):
        nearest = min(droplets, key=lambda each: abs(each.x - 60.0 - 4.0 * number) + each.y)
        flagged += nearest.group >= 0
        if nearest.group < 0:
            assert nearest.area == pytest.approx(math.pi * 24.0**2, rel=0.03)
    assert flagged > 0


def test_bright_droplets_that_the_frame_cuts(disc, moving, found, microscope):
    look = microscope.replace(fluid=(150, 150, 150), interior=(220, 220, 220), ring=(20, 20, 20))
    frames = found(Scene((moving(disc(24.0), (-30.0, 100.0), (6.0, 0.0), OBSTACLE),)), look, 50)
    for number, droplets in enumerate(frames):
        x = -30.0 + 6.0 * number
        if 2.0 < x < 16.0 or 224.0 < x < 238.0:
            assert [droplet.cut for droplet in droplets] == [True]


def test_thin_droplet_that_is_all_ring(disc, moving, found, microscope):
    """A daughter pressed against its obstacle: two rings thick, three times as long."""
    thin = moving(disc(12.0) * (0.33, 1.0), (20.0, 130.4), (6.0, 0.1), OBSTACLE)
    large = moving(disc(18.0), (30.3, 50.0), (5.0, 0.0), OBSTACLE)
    for droplets in found(Scene((large, thin)), microscope):
        (droplet,) = (each for each in droplets if each.y > 110.0)
        assert droplet.area == pytest.approx(math.pi * 12.0 * 4.0, rel=0.08)


def test_dark_bits_that_are_no_droplets(disc, moving, found, settings, microscope):
    """What is thin, or smaller than the smallest droplet, is none."""
    thread = moving(disc(12.0) * (1.0, 0.15), (20.0, 130.0), (6.0, 0.0), OBSTACLE)
    speck = moving(disc(2.5), (20.0, 150.0), (6.0, 0.0), OBSTACLE)
    large = moving(disc(18.0), (30.3, 50.0), (5.0, 0.0), OBSTACLE)
    told = settings.replace(minimum_diameter_um=30.0)
    for droplets in found(Scene((large, thread, speck)), microscope, told=told):
        assert not [each for each in droplets if each.y > 100.0]


def test_given_colour_and_clicks(disc, moving, found, settings, microscope):
    scene = Scene((crossing(disc, moving),))
    told = settings.replace(interior=microscope.interior)
    assert all(len(each) == 1 for each in found(scene, microscope, told=told))
    other = settings.replace(interior=(90, 200, 120))
    assert not any(found(scene, microscope, told=other))
    clicked = settings.replace(clicks=((0, 30.0, 110.0), (10, 100.0, 112.0)))
    assert all(len(each) == 1 for each in found(scene, microscope, told=clicked))


def test_lamp_flicker_and_uneven_light(disc, moving, found, microscope):
    look = microscope.replace(flicker=0.05, unevenness=0.3)
    areas = [each[0].area for each in found(Scene((crossing(disc, moving),)), look)]
    assert np.mean(areas) == pytest.approx(math.pi * 18.0**2, rel=0.01)
    assert np.std(areas) < 0.01 * np.mean(areas)


def test_focus_drift_does_not_move_the_outline(disc, moving, found, microscope):
    """The steepest place of such a ring lies a third of a pixel too far out: 4 % of the area."""
    look = microscope.replace(focus_drift_px=1.1)
    areas = [each[0].area for each in found(Scene((crossing(disc, moving),)), look)]
    assert np.mean(areas) == pytest.approx(math.pi * 18.0**2, rel=0.012)


@pytest.mark.parametrize("speed", [8.0, 10.0])
def test_fast_droplets_whose_rings_are_smeared(disc, moving, found, microscope, speed):
    """The ring is half as dark at the front and the back as at the sides.

    A single frame is off by up to 0.41 pixels, by its noise; the mean over noises is asked for.
    """
    off = {}
    for seed in range(3):
        look = microscope.replace(exposure=0.9, seed=seed)
        slow = moving(disc(18.0), (20.0, 40.0), (4.5, 0.0), OBSTACLE)
        fast = moving(disc(16.0), (-60.0, 130.0), (speed, 0.0), OBSTACLE)
        for number, droplets in enumerate(found(Scene((slow, fast)), look)):
            x = -60.0 + speed * number
            if 20.0 < x < 219.0:
                (droplet,) = (each for each in droplets if each.y > 90.0)
                assert droplet.group == -1
                off.setdefault(x, []).append(droplet.x - x)
    assert {x: np.mean(found_off) for x, found_off in off.items()} == pytest.approx(
        dict.fromkeys(off, 0.0), abs=0.4
    )


def test_nothing_is_found_in_nothing(found, microscope):
    assert not any(found(Scene(()), microscope, 5))
    assert not any(found(Scene(()), microscope.replace(dust=30), 5))


def test_droplet_that_fills_the_frame(disc, moving, found, microscope):
    scene = Scene((moving(disc(400.0), (120.0, 90.0), (0.0, 0.0)),))
    for droplets in found(scene, microscope, 3):
        assert all(droplet.cut for droplet in droplets)


def test_trace_is_marching_squares():
    """The sub-pixel outline encloses what scikit-image's does, on random smooth regions."""
    from skimage.measure import find_contours

    random = np.random.default_rng(3)
    for _ in range(10):
        field = cv2.GaussianBlur(random.normal(size=(60, 70)), (0, 0), 5.0)
        field[[0, -1]] = field[:, [0, -1]] = -1.0
        excess = np.rint(3e4 * field).clip(-32000, 32000).astype(np.int16)
        mask = (excess > 0).astype(np.uint8)
        walks, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        walks = [walk for walk in walks if len(walk) > 8]
        theirs = find_contours(excess.astype(float), 0.0, fully_connected="high")
        areas = sorted(_core.area(np.ascontiguousarray(c[:-1, ::-1])) for c in theirs if len(c) > 8)
        for outline in trace(walks, excess):
            area = _core.area(outline)
            assert min(abs(area - other) for other in areas) < 0.02 * area + 0.3
            assert not _core.self_intersects(outline)


def test_trace_runs_clockwise_through_the_crossings():
    excess = np.full((9, 9), -10, dtype=np.int16)
    excess[3:6, 2:7] = 30  # crosses zero three quarters of the way out
    mask = (excess > 0).astype(np.uint8)
    walks, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    (outline,) = trace(walks, excess)
    assert outline[:, 0].min() == 1.25
    assert outline[:, 0].max() == 6.75
    assert outline[:, 1].min() == 2.25
    assert outline[:, 1].max() == 5.75
    x, y = outline.T
    turn = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert turn > 0  # clockwise as seen, because y points down
    assert len(outline) == 16
