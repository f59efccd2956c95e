"""Numbers with their units: what is read, and what a refusal advises."""

from __future__ import annotations

import pytest

from pinchoff import InputError
from pinchoff.support.units import magnitude_of


@pytest.mark.parametrize("text", ["481 um", "481um", "0.481 mm", "4.81e-4 m"])
def test_lengths_come_in_the_unit_that_is_asked_for(text):
    assert magnitude_of("diameter", text, "um") == pytest.approx(481.0)


@pytest.mark.parametrize(
    ("value", "got", "advice"),
    [
        (None, "nothing", "write it like '85 um'"),
        ("4,81 um", "'4,81 um'", "write a decimal point in place of the comma: '4.81 um'"),
        ("481", "'481'", "write it like '85 um'"),
        ("481 s", "'481 s'", "write it like '85 um'"),
        ("inf um", "'inf um'", "write it like '85 um'"),
    ],
)
def test_a_refusal_shows_what_was_given_and_what_to_write(value, got, advice):
    with pytest.raises(InputError) as raised:
        magnitude_of("diameter", value, "um")
    expected = f"diameter must be a length with its unit; got {got}; {advice}"
    assert str(raised.value) == expected


@pytest.mark.parametrize("value", ["0 um", "-3 um"])
def test_a_length_that_must_be_positive_is(value):
    with pytest.raises(InputError, match=r"^diameter must be a positive length"):
        magnitude_of("diameter", value, "um", positive=True)
