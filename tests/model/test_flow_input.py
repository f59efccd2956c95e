"""The flow's constructors refuse what is wrong, and take axes of single precision."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po


@pytest.mark.parametrize(
    ("argument", "function", "arguments"),
    [
        ("vx", po.flow.uniform, ("1",)),
        ("vx", po.flow.uniform, (None,)),
        ("vy", po.flow.uniform, (1, True)),
        ("vy", po.flow.uniform, (1, 10**400)),
        ("radius", po.flow.stokes, ("1",)),
        ("radius", po.flow.stokes, (None,)),
        ("center", po.flow.stokes, (1, (1, 2, 3))),
        ("center", po.flow.stokes, (1, 3)),
        ("center[0]", po.flow.stokes, (1, ("a", 0))),
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
