"""Obstacles in a regular array, against counting them one by one."""

from __future__ import annotations

import numpy as np
import pytest

from pinchoff.video.obstacles import lattice_obstacles
from pinchoff.video.settings import Lattice, VideoSettings

SIZE = (640, 512)


def brute_force(lattice, pixel):
    """Try every obstacle within a hundred steps of the given one."""
    pitch, radius = lattice.pitch_um / pixel, lattice.radius_um / pixel
    turn = np.exp(1j * np.radians(lattice.angle_deg))
    second = turn * (np.exp(1j * np.pi / 3) if lattice.hexagonal else 1j)
    found = []
    for i in range(-100, 101):
        for j in range(-100, 101):
            place = complex(lattice.x_px, lattice.y_px) + pitch * (i * turn + j * second)
            inside = -radius < place.real < SIZE[0] - 1 + radius
            if inside and -radius < place.imag < SIZE[1] - 1 + radius:
                found.append((place.real, place.imag))
    return in_order(found)


def in_order(places):
    return sorted(map(tuple, np.round(places, 6).tolist()))


@pytest.mark.parametrize("hexagonal", [False, True])
@pytest.mark.parametrize("angle", [0.0, 17.0, -90.0])
def test_every_obstacle_in_view(angle, hexagonal):
    lattice = Lattice(
        pitch_um=700.0, radius_um=85.0, x_px=333.0, y_px=-20.0, angle_deg=angle, hexagonal=hexagonal
    )
    found = lattice_obstacles(lattice, 5.28, SIZE)
    expected = brute_force(lattice, 5.28)
    assert len(found) == len(expected) > 10
    np.testing.assert_allclose(in_order(found[:, :2]), expected, atol=2e-6)
    assert found[:, 2] == pytest.approx(85 / 5.28)


def test_a_far_obstacle_names_the_same_array():
    near = Lattice(pitch_um=528.0, radius_um=85.0, x_px=50.0, y_px=60.0)
    far = Lattice(pitch_um=528.0, radius_um=85.0, x_px=50.0 + 9e4, y_px=60.0 - 9e4)
    found = [np.sort(lattice_obstacles(each, 5.28, SIZE), axis=0) for each in (near, far)]
    np.testing.assert_allclose(*found, atol=1e-6)


def test_wrong_arrays_are_refused(refused):
    flat = {"x_px": 0.0, "y_px": 0.0}
    touching = Lattice(pitch_um=170.0, radius_um=85.0, **flat)
    refused("lattice.pitch_um", lattice_obstacles, touching, 5.28, SIZE)
    tiny = Lattice(pitch_um=5.0, radius_um=1.0, **flat)
    refused("lattice.radius_um", lattice_obstacles, tiny, 5.28, SIZE)
    both = {"obstacles": ((1.0, 2.0, 3.0),), "lattice": touching}
    refused("lattice", VideoSettings, pixel_size_um=5.28, **both)
    refused(
        "lattice.pitch_um", VideoSettings, pixel_size_um=5.28, lattice={"radius_um": 85.0, **flat}
    )
