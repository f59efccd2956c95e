"""What several tests share."""

from __future__ import annotations

import os
import re
from collections.abc import Callable

import pytest

import pinchoff as po

os.environ.setdefault("MPLBACKEND", "Agg")  # no test opens a window

_FORM = re.compile(r"^(?P<argument>.+?) must be (?P<rule>.+?); got (?P<got>.+?); (?P<advice>.+)$")


@pytest.fixture
def refused() -> Callable[..., po.InputError]:
    """Call something that must refuse its input, and return the error, checked for its form."""

    def call(
        argument: str, function: Callable[..., object], *args: object, **keywords: object
    ) -> po.InputError:
        with pytest.raises(po.InputError) as caught:
            function(*args, **keywords)
        form = _FORM.match(str(caught.value))
        assert form is not None, str(caught.value)
        assert form["argument"] == argument
        return caught.value

    return call


@pytest.fixture(scope="session")
def experiment() -> dict[str, str]:
    """Physical quantities of the paper's median breaking droplet."""
    return {
        "diameter": "481 um",
        "obstacle_radius": "85 um",
        "speed": "1.0 mm/s",
        "viscosity": "48 mPa s",
        "surface_tension": "20 mN/m",
        "thickness": "85 um",
        "offset": "20 um",
    }
