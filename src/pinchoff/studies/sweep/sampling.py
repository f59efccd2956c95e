"""Points of the unit cube, by their number: the samples behind a sweep."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

KINDS = ("sobol", "latin-hypercube", "random")
"""The samples that there are."""


def unit_points(
    kind: str, dimensions: int, samples: int, seed: int, start: int, stop: int
) -> NDArray[np.float64]:
    """Return some points of a sample of the unit cube, shape (stop - start, dimensions).

    A point depends on its number and on the size and seed of the sample, not on which others are
    asked for. Only the Latin hypercube, whose points know of each other, is drawn and held whole.
    """
    if kind == "sobol":
        return _sobol(dimensions, seed, start, stop)
    if kind == "latin-hypercube":
        return _latin_hypercube(dimensions, samples, seed)[start:stop]
    return _independent(dimensions, seed, start, stop)


def _sobol(dimensions: int, seed: int, start: int, stop: int) -> NDArray[np.float64]:
    from scipy.stats import qmc  # slow to import

    sequence = qmc.Sobol(dimensions, seed=np.random.default_rng(seed))
    if start:
        sequence.fast_forward(start)
        count = stop - start
    else:  # scipy wants to start with a power of two
        count = 1 << (stop - 1).bit_length()
    return np.asarray(sequence.random(count)[: stop - start], dtype=np.float64)


@lru_cache(maxsize=1)
def _latin_hypercube(dimensions: int, samples: int, seed: int) -> NDArray[np.float64]:
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed))
    return np.asarray(sampler.random(samples), dtype=np.float64)


def _independent(dimensions: int, seed: int, start: int, stop: int) -> NDArray[np.float64]:
    # A counter-based generator makes four numbers for each count: whole counts for each point.
    counts = -(-dimensions // 4)
    generator = np.random.Generator(np.random.Philox(key=seed, counter=start * counts))
    return generator.random((stop - start, 4 * counts))[:, :dimensions]
