"""Real films and pictures, by default, with no option but the scale.

They lie beside the project and belong to others; where they are not there, nothing is tested.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "films"
BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "films.py"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FOLDER.exists(), reason="the real films are not beside the project"),
]

# Counted by eye, once, on enlarged pictures: whole droplets, without those that the frame cuts.
# Beside each the least share that must be found.
SEEN = {
    "packed/droplets.png": (119, 0.9),
    "packed/snapshot_45.jpg": (284, 0.9),
    "packed/snapshot_22.jpg": (34, 0.85),
    "packed/snapshot_1991.png": (35, 0.7),
}
MOST_FALSE = 1.1
FEWEST_CELLS = 0.8 * 476  # of the foam; their number is an estimate, not a count
DROPLETS_IN_CHANNEL = 36  # that pass, told apart by eye in the annotated film, from first to last


@pytest.fixture(scope="module")
def films():
    spec = importlib.util.spec_from_file_location("benchmark_films", BENCHMARK)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("name", "least", "false"), [("plugs", 0.98, 0.01), ("junction", 0.95, 0.02)]
)
def test_boxed_plugs(films, name, least, false):
    seen = films.measured(FOLDER / name)
    boxes, found, wrong = films.against_boxes(seen, FOLDER / name)
    assert found >= least * boxes
    assert wrong <= false * boxes
    assert (seen.obstacles, seen.collisions) == (0, 0)


def test_a_channel_of_plugs(films):
    seen = films.measured(FOLDER / "channel" / "plugs.mp4", 2.0)
    assert sum(seen.whole) >= 2300
    long = [length for length in seen.lengths if length >= 10]
    assert len(long) == DROPLETS_IN_CHANNEL
    assert sum(long) >= 0.99 * sum(seen.lengths)
    assert seen.collisions == 0
    assert not set(seen.events) - {"entry", "exit"}


def test_beads_and_a_grainy_droplet(films):
    beads = films.measured(FOLDER / "beads", 4.0)
    assert beads.whole == [5] * 20
    assert beads.lengths == [20] * 5
    assert beads.obstacles == 0
    grain = films.measured(FOLDER / "grain")
    assert (grain.whole, grain.cut) == ([1] * 6, [0] * 6)


@pytest.mark.parametrize("name", list(SEEN))
def test_packed_scenes(films, name, tmp_path):
    clip = tmp_path / "clip"
    clip.mkdir()
    (clip / Path(name).name).symlink_to(FOLDER / name)
    (whole,) = films.measured(clip).whole
    there, least = SEEN[name]
    assert least * there <= whole <= MOST_FALSE * there


def test_foam(films):
    seen = films.measured(FOLDER / "foam")
    assert min(seen.whole) >= FEWEST_CELLS
    assert not {"break-up", "coalescence"} & set(seen.events)
