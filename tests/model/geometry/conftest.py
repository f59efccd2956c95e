"""Outlines of many shapes for the tests of the geometry."""

from __future__ import annotations

import numpy as np
import pytest


def _random_outline(rng, count):
    """A simple, non-convex, counter-clockwise outline: a star of random lobes, then twisted.

    Sorted angles make the star simple; the twist, a turn that grows with the radius, is one-to-one
    and takes away that every vertex sees the centre.
    """
    angle = (np.arange(count) + 0.8 * rng.random(count)) * 2 * np.pi / count
    modes = np.arange(2, 7)
    size, phase = rng.normal(0.0, 0.25, modes.size), rng.uniform(0, 2 * np.pi, modes.size)
    radius = np.exp((size * np.cos(np.outer(angle, modes) + phase)).sum(axis=1))
    radius *= 0.5 * (1 + 0.02 * rng.normal(size=count))
    angle = angle + rng.uniform(-1.5, 1.5) * radius
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))


@pytest.fixture
def random_outline():
    """Function (rng, count) -> (count, 2) simple, non-convex, counter-clockwise outline."""
    return _random_outline


@pytest.fixture
def regular_polygon():
    """Function (count, radius, center) -> vertices of a regular polygon, counter-clockwise."""

    def build(count, radius=1.0, center=(0.0, 0.0)):
        angle = 2 * np.pi * np.arange(count) / count
        return np.column_stack((np.cos(angle), np.sin(angle))) * radius + np.asarray(center)

    return build
