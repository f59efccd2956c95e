"""Flows: what their constructors take and refuse, and the velocities that they give."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pinchoff as po


@pytest.mark.parametrize(
    ("argument", "function", "arguments"),
    [
        ("vx", po.flow.uniform, ("1",)),
        ("vx", po.flow.uniform, (math.inf,)),
        ("vx", po.flow.uniform, (None,)),
        ("vy", po.flow.uniform, (1, True)),
        ("vy", po.flow.uniform, (1, 10**400)),
        ("radius", po.flow.stokes, ("1",)),
        ("radius", po.flow.stokes, (0,)),
        ("radius", po.flow.stokes, (None,)),
        ("center", po.flow.stokes, (1, (1, 2, 3))),
        ("center", po.flow.stokes, (1, 3)),
        ("center[0]", po.flow.stokes, (1, ("a", 0))),
        ("center[1]", po.flow.stokes, (1, (0, math.nan))),
    ],
)
def test_what_is_no_number_is_refused(refused, argument, function, arguments):
    refused(argument, function, *arguments)


def test_numpy_numbers_are_numbers():
    flow = po.flow.stokes(np.float32(0.5), np.array([1, 2]))
    np.testing.assert_array_equal(flow.velocity(np.array([[1.0, 2.0]])), [[0, 0]])


def test_axes_of_single_precision_are_regular():
    axis = np.linspace(-6.5, 6.5, 1301, dtype=np.float32)
    ones = np.ones((axis.size, axis.size), dtype=np.float32)
    flow = po.flow.sampled(axis[:1301], axis, ones, 0 * ones)
    np.testing.assert_allclose(flow.velocity(np.array([[0.3, 0.1]])), [[1, 0]], atol=1e-12)


AXIS = np.linspace(-1, 1, 5)
ZEROS = np.zeros((5, 5))


@pytest.mark.parametrize(
    ("argument", "arguments"),
    [
        ("x", (AXIS[:3], AXIS, ZEROS[:, :3], ZEROS[:, :3])),
        ("x", (AXIS[::-1], AXIS, ZEROS, ZEROS)),
        ("y", (AXIS, AXIS**3, ZEROS, ZEROS)),
        ("y", (AXIS, 0.01 * AXIS + [0, 0, 1e-5, 0, 0], ZEROS, ZEROS)),
        ("y", (AXIS, [AXIS], ZEROS, ZEROS)),
        ("x", ([0, 1, 2, math.inf, 4], AXIS, ZEROS, ZEROS)),
        ("u", (AXIS, AXIS, ZEROS[:4], ZEROS)),
        ("v", (AXIS, AXIS, ZEROS, ZEROS + math.nan)),
        ("v", (AXIS, AXIS, ZEROS, "fast")),
    ],
)
def test_unfit_samples_of_a_flow_are_refused(refused, argument, arguments):
    refused(argument, po.flow.sampled, *arguments)


def test_flows_give_velocities():
    points = np.array([[0.3, -0.2], [0.5, 0.9]])
    np.testing.assert_array_equal(po.flow.uniform(2, 1).velocity(points), [[2, 1], [2, 1]])
    x, y = np.meshgrid(AXIS, AXIS)
    sheared = po.flow.sampled(AXIS, AXIS, 1 + 2 * x, 3 * y)
    inside = np.array([[0.1, -0.2], [-0.3, 0.25]])
    expected = np.column_stack([1 + 2 * inside[:, 0], 3 * inside[:, 1]])
    np.testing.assert_allclose(sheared.velocity(inside), expected, atol=1e-12)
    np.testing.assert_array_equal(po.flow.stokes(1).velocity(np.array([[0.5, 0.5]])), [[0, 0]])


def test_velocity_has_the_shape_of_the_points():
    flow = po.flow.stokes(0.2)
    assert flow.velocity([0, 0]).tolist() == [0, 0]
    many = np.arange(12.0).reshape(2, 3, 2)
    np.testing.assert_array_equal(flow.velocity(many)[1, 2], flow.velocity(many[1, 2]))
    for wrong in (1.0, [1, 2, 3], [[1], [2]]):
        with pytest.raises(ValueError, match="points must be an array"):
            flow.velocity(wrong)


def test_flow_says_what_it_is():
    assert "radius 0.2" in repr(po.flow.stokes(0.2))
    assert "uniform" in repr(po.flow.uniform())
    nodes = np.linspace(0, 3, 4)
    zeros = np.zeros((4, 4))
    assert "4 by 4 nodes" in repr(po.flow.sampled(nodes, nodes, zeros, zeros, periodic="x"))
