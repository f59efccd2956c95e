"""Pillar positions agree between the design, a frame, and what engine and film use."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff.chamber import in_frame


def test_the_middle_of_the_frame_is_the_point_that_was_asked_for(paper):
    pillar = next(p for p in paper.layout.pillars if p.region == "imaging")
    table = in_frame(paper, centre_um=(pillar.x_um, pillar.y_um), pixel_size_um=5.0)
    # 640 by 512 pixels: the middle lies between pixels 319 and 320, 255 and 256.
    assert nearest(table, 319.5 * 5.0, 255.5 * 5.0) == pytest.approx(0.0, abs=1e-9)


def test_what_is_downstream_and_at_greater_y_is_to_the_right_and_above(paper):
    pillar = next(p for p in paper.layout.pillars if p.region == "imaging")
    table = in_frame(paper, centre_um=(pillar.x_um - 300, pillar.y_um - 100), pixel_size_um=5.0)
    assert nearest(table, 319.5 * 5.0 + 300, 255.5 * 5.0 - 100) == pytest.approx(0.0, abs=1e-9)


def nearest(table, x_um, y_um):
    """Distance of the nearest pillar to a point of the frame."""
    return np.hypot(table["obstacle_x_um"] - x_um, table["obstacle_y_um"] - y_um).min()


def test_y_points_down_in_the_frame_and_distances_stay(paper):
    at = paper.layout.stations
    middle = ((at.imaging + at.exit) / 2, 0.0)
    frame, design = in_frame(paper), paper.obstacles
    x = frame["obstacle_x_um"] - 319.5 * 5.28 + middle[0]
    y = 255.5 * 5.28 - frame["obstacle_y_um"]
    here = set(zip(x.round(3), y.round(3), frame["obstacle_radius_um"], strict=True))
    columns = ["obstacle_x_um", "obstacle_y_um", "obstacle_radius_um"]
    everywhere = {(round(a, 3), round(b, 3), c) for a, b, c in design[columns].to_numpy()}
    assert here <= everywhere
    assert 8 <= len(here) <= 20  # 3.4 mm by 2.7 mm of a lattice of 0.9 mm
    upper = frame.loc[(y - y.max()).abs().idxmin()]
    assert upper["obstacle_y_um"] == frame["obstacle_y_um"].min()


def test_a_pillar_that_the_edge_cuts_is_shown_and_one_outside_is_not(paper):
    pillar = next(p for p in paper.layout.pillars if p.region == "imaging")
    for beyond, shown in ((80.0, True), (90.0, False)):
        left = pillar.x_um + beyond + 0.5 * 100
        table = in_frame(
            paper, centre_um=(left, pillar.y_um), pixel_size_um=1.0, frame_px=(100, 100)
        )
        assert len(table) == (1 if shown else 0)


@pytest.mark.parametrize(
    ("argument", "options"),
    [
        ("pixel_size_um", {"pixel_size_um": 0}),
        ("frame_px", {"frame_px": (640.5, 512)}),
        ("frame_px", {"frame_px": (640, 0)}),
        ("centre_um", {"centre_um": (float("nan"), 0)}),
    ],
)
def test_bad_frames_are_refused(paper, refused, argument, options):
    refused(argument, in_frame, paper, **options)


def test_pixels_are_those_of_the_micrometres(paper):
    table = in_frame(paper, pixel_size_um=4.0)
    for name in ("obstacle_x", "obstacle_y", "obstacle_radius"):
        np.testing.assert_allclose(table[f"{name}_px"] * 4.0, table[f"{name}_um"])
    assert set(table["obstacle_radius_px"]) >= {85 / 4}


def test_the_tables_units_are_stated(paper):
    assert paper.obstacles.attrs["units"]["obstacle_x_um"] == "µm"
    assert in_frame(paper).attrs["units"]["obstacle_x_um"] == "µm"
