"""The logarithm of the flow, against one of 30 digits."""

from __future__ import annotations

import decimal

import numpy as np
import pytest

from pinchoff import _core


def exact_logs(values):
    """Natural logarithms to 40 digits."""
    with decimal.localcontext(prec=40):
        return [decimal.Decimal(float(x)).ln() for x in values]


def errors_in_ulp(values):
    """|computed - exact| in units of the last place of the exact logarithm."""
    got = _core.natural_log(values)
    errors = []
    for g, e in zip(got, exact_logs(values), strict=True):
        unit = decimal.Decimal(float(np.spacing(abs(float(e)))))
        with decimal.localcontext(prec=40):
            errors.append(float(abs(decimal.Decimal(float(g)) - e) / unit))
    return np.array(errors)


@pytest.mark.parametrize(
    ("low", "high"),
    [(np.finfo(float).tiny, np.finfo(float).max), (0.5, 2.0), (0.99, 1.01), (1 / 1.42, 1.42)],
)
def test_logarithm_is_right_to_two_ulp(low, high):
    """Over the whole normal range, and over the range where the logarithm goes through zero."""
    rng = np.random.default_rng(1)
    values = np.exp(rng.uniform(np.log(low), np.log(high), 4000))
    values = np.clip(values, low, high)
    assert errors_in_ulp(values).max() < 2


def test_logarithm_keeps_its_digits_next_to_one():
    """1 ± k ulp: the result is tiny, and still right to two of its own last places."""
    steps = np.concatenate((np.arange(-200, 0), np.arange(1, 200), 2 ** np.arange(8, 50)))
    values = 1.0 + steps * np.spacing(0.5)
    values = values[values != 1.0]
    assert errors_in_ulp(values).max() < 2
    np.testing.assert_array_equal(_core.natural_log(np.array([1.0])), [0.0])


def test_logarithm_at_the_ends_of_its_pieces():
    """Powers of two, the neighbours of √2 times powers of two, and the ends of the normal range."""
    powers = 2.0 ** np.arange(-1022, 1024, 31)
    root = np.sqrt(2.0) * powers[:-1]
    ends = [np.finfo(float).tiny, np.finfo(float).max]
    values = np.concatenate((powers, root, np.nextafter(root, 0), np.nextafter(root, np.inf), ends))
    values = values[values != 1.0]
    assert errors_in_ulp(values).max() < 2
