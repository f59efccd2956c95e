"""What several tests share."""

from __future__ import annotations

import gc
import io
import os
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

# Read when NumPy is first imported. Tests have a worker a core. Further threads of BLAS only wait
# for one another, and the flow through the device takes five times the CPU.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.law import Line, breakup_number, breakup_probability

os.environ.setdefault("MPLBACKEND", "Agg")  # no test opens a window

_FORM = re.compile(r"^(?P<argument>.+?) must be (?P<rule>.+?); got (?P<got>.+?); (?P<advice>.+)$")

_CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")

TRUTH = Line(0.083, -0.74)
WIDTH = 0.098


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let the attacks be as many as one has time for."""
    parser.addoption("--attacks", type=int, help="random inputs that each attack tries")


@pytest.fixture
def attacks(request: pytest.FixtureRequest) -> int:
    """How many random inputs an attack tries."""
    return request.config.getoption("--attacks") or 45


@pytest.fixture(scope="session", autouse=True)
def ctrl_c() -> None:
    """Ctrl-C interrupts tests and the programs that they start, however the tests were started.

    Programs in the background of a script, or behind nohup, begin with it ignored.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium; what needs it is skipped where it is absent."""
    api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    found = next(filter(None, map(shutil.which, _CHROMIUM)), None)
    if found is None:
        pytest.skip("Chromium is not installed; Debian's package is `chromium`")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="session", autouse=True)
def imports_are_kept() -> Iterator[None]:
    """Let the collector of garbage pass over modules and tests, which stay to the end."""
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


@pytest.fixture(scope="session", autouse=True)
def coarse_pictures() -> None:
    """Draw pictures with a fifth of their dots: what they show is the same, in half the time."""
    from pinchoff.figures import style

    style.DOTS_PER_INCH = 60


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


@pytest.fixture
def unrendered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put figures together, and write a pixel in place of each picture.

    For tests that count pictures and do not look at them: rendering takes most of their time.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    pixel = io.BytesIO()
    FigureCanvasAgg(Figure(figsize=(0.01, 0.01), dpi=100)).print_png(pixel)

    def save(figure: Figure, target: io.BytesIO | str | os.PathLike[str], **how: object) -> None:
        if isinstance(target, io.BytesIO):
            target.write(pixel.getvalue())
        else:
            Path(target).write_bytes(pixel.getvalue())

    monkeypatch.setattr(Figure, "savefig", save)


def drawn(n: int, seed: int, width: float = WIDTH, line: Line = TRUTH) -> pd.DataFrame:
    """Draw collisions on both sides of the line; with width 0 their outcome is certain."""
    rng = np.random.default_rng(seed)
    ca = np.exp(rng.normal(-6.0, 0.4, n))
    area = np.exp(rng.uniform(0.0, 3.5, n))
    thickness = rng.choice([0.5, 1.0, 1.4], n)
    symmetry = rng.uniform(0.02, 1.0, n)
    bk = breakup_number(
        ca, normalized_area=area, symmetry=symmetry, normalized_thickness=thickness, line=line
    )
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
