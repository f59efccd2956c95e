"""A device that is small enough to be computed in a test, and the exact flow past a cylinder."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import kv

pytest.importorskip("gdstk", reason="the extra 'chamber' is not installed")

from pinchoff.chamber import Chamber

SMALL: dict[str, Any] = {
    "inlets": {
        "port_diameter_um": 600,
        "trap_length_um": 300,
        "wall_um": 200,
        "post_gap_um": 80,
    },
    "oil_inputs": {"port_diameter_um": 400},
    "expansion": {"length_um": 700, "straight_um": 500, "divider_um": 150},
    "supports": {"radius_um": 120, "flank_um": 600, "pitch_um": 700},
    "imaging": {"pitch_um": 800, "rows": 3, "columns": 3},
    "exit": {"length_um": 1800, "width_um": 700, "port_diameter_um": 900},
    "mask": {"margin_um": 1000},
    "operation": {"elements_across_gap": 7},
}


@pytest.fixture(scope="session")
def paper() -> Chamber:
    """The device of the paper."""
    return Chamber()


@pytest.fixture(scope="session")
def small() -> Chamber:
    return Chamber(**SMALL)


class Cylinder:
    """Brinkman's flow past a cylinder in an unbounded slit, exact.

    With κ = √12/z the stream function is f(r) sin θ, f = r + B/r + C K₁(κ r), and f = f' = 0 on the
    cylinder; the far speed is 1.
    """

    def __init__(self, radius: float, thickness: float) -> None:
        self.radius, self.kappa = radius, math.sqrt(12.0) / thickness
        x = self.kappa * radius
        self.c = 2.0 / (self.kappa * kv(0, x))
        self.b = -(radius**2) - self.c * radius * kv(1, x)

    def _f(self, r: Any, derivative: int) -> Any:
        x = self.kappa * r
        k0, k1 = kv(0, x), kv(1, x)
        first = -k0 - k1 / x
        if derivative == 0:
            return r + self.b / r + self.c * k1
        if derivative == 1:
            return 1.0 - self.b / r**2 + self.c * self.kappa * first
        second = (1.0 + 1.0 / x**2) * k1 - first / x
        return 2.0 * self.b / r**3 + self.c * self.kappa**2 * second

    def velocity(self, points: np.ndarray) -> np.ndarray:
        r = np.hypot(*points.T)
        cosine, sine = points.T / r
        radial, around = self._f(r, 0) / r * cosine, -self._f(r, 1) * sine
        return np.column_stack([radial * cosine - around * sine, radial * sine + around * cosine])

    @property
    def drag(self) -> float:
        """Force over viscosity and thickness: pressure κ²(R - B/R) and shear f'' on the surface."""
        pressure = self.kappa**2 * (self.radius - self.b / self.radius)
        return float(math.pi * self.radius * (pressure + self._f(self.radius, 2)))


@pytest.fixture
def cylinder() -> Callable[[float, float], Cylinder]:
    return Cylinder
