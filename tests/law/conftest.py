"""Collisions drawn from a known law."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from pinchoff.collisions.law import Line, breakup_number, breakup_probability

TRUTH = Line(0.083, -0.74)
WIDTH = 0.098


def drawn(n: int, seed: int, width: float = WIDTH, line: Line = TRUTH) -> pd.DataFrame:
    """Draw collisions on both sides of the line; with width 0 their outcome is certain."""
    rng = np.random.default_rng(seed)
    ca = np.exp(rng.normal(-6.0, 0.4, n))
    area = np.exp(rng.uniform(0.0, 3.5, n))
    thickness = rng.choice([0.5, 1.0, 1.4], n)
    symmetry = rng.uniform(0.02, 1.0, n)
    bk = breakup_number(ca, area, symmetry, thickness, line=line)
    probability = breakup_probability(bk, width) if width else bk > 1
    return pd.DataFrame(
        {
            "capillary_number": ca,
            "normalized_area": area,
            "normalized_thickness": thickness,
            "symmetry": symmetry,
            "broke": rng.random(n) < probability,
        }
    )


@pytest.fixture(scope="session")
def collisions() -> Callable[..., pd.DataFrame]:
    """Return the function that draws them."""
    return drawn


@pytest.fixture(scope="session")
def many() -> pd.DataFrame:
    """As many as in the paper."""
    return drawn(5056, 1)
