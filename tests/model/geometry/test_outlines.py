"""Outlines: what is stored comes back, and what is measured is the shape's."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff import InputError, Outlines
from pinchoff.model.outlines import Outline, OutlineWriter
from pinchoff.support.files import written_aside

ARRAYS = (
    "times",
    "frame",
    "droplet_id",
    "generation",
    "offsets",
    "vertices",
    "velocities",
    "obstacles",
)
PARAMETERS = {"size_ratio": 5.66, "neck_separation": 0.28, "neck_separation_unit": "perimeter"}
OBSTACLES = [[0.0, 0.0, 0.1767], [3.0, -1.0, 0.25]]


def ellipse(a, b, count, center=(0.0, 0.0), angle=0.0):
    """Vertices of an ellipse with half axes a and b, equally spaced in its parameter."""
    t = 2 * np.pi * np.arange(count) / count
    x, y = a * np.cos(t), b * np.sin(t)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return np.column_stack((x, y)) @ turn.T + center


def ragged_outlines():
    """Three frames with one, two and no droplets, of different vertex counts."""
    rng = np.random.default_rng(20261122)
    frames = [
        [(0, 0, ellipse(0.5, 0.5, 64, (-5.0, 0.05)), rng.normal(size=(64, 2)))],
        [
            (1, 1, ellipse(0.3, 0.4, 33, (1.0, 0.5)), rng.normal(size=(33, 2))),
            (2, 1, ellipse(0.2, 0.3, 24, (1.0, -1 / 3)), rng.normal(size=(24, 2))),
        ],
        [],
    ]
    return Outlines.from_frames([0.0, 0.1, 0.3], frames, OBSTACLES, PARAMETERS)


def assert_same(got, expected):
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(got, name), getattr(expected, name), err_msg=name)
    assert got.parameters == expected.parameters
    assert got.units == expected.units


@pytest.mark.parametrize("suffix", [".gsd", ".npz"])
def test_saved_outlines_come_back_to_the_last_bit(tmp_path, suffix):
    outlines = ragged_outlines()
    path = tmp_path / f"outlines{suffix}"
    outlines.save(path)
    assert_same(Outlines.load(path), outlines)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_every_kind_of_file_can_be_read_by_the_same_people(tmp_path):
    for suffix in (".gsd", ".npz", ".csv"):
        ragged_outlines().save(tmp_path / f"outlines{suffix}")
    (tmp_path / "usual").write_text("")
    assert len({path.stat().st_mode for path in tmp_path.iterdir()}) == 1


def test_csv_holds_every_vertex_with_units_in_the_names(tmp_path):
    outlines = ragged_outlines()
    outlines.save(tmp_path / "outlines.csv")
    table = pd.read_csv(tmp_path / "outlines.csv")
    np.testing.assert_array_equal(table[["x_D0", "y_D0"]], outlines.vertices)
    np.testing.assert_array_equal(table[["vx_D0_per_t0", "vy_D0_per_t0"]], outlines.velocities)
    assert table["vertex"].tolist() == [*range(64), *range(33), *range(24)]
    assert table["time_t0"].tolist() == [0.0] * 64 + [0.1] * 57
    assert table["droplet_id"].tolist() == [0] * 64 + [1] * 33 + [2] * 24
    assert table["generation"].tolist() == [0] * 64 + [1] * 57


def test_gsd_file_is_what_other_programs_expect(tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd")
    outlines = ragged_outlines()
    outlines.save(tmp_path / "outlines.gsd")
    with hoomd.open(tmp_path / "outlines.gsd") as file:
        frame = file[1]
        empty = file[2]
    assert frame.particles.types == ["vertex", "obstacle"]
    assert frame.particles.typeid.tolist() == [1, 1] + [0] * 57
    assert frame.particles.diameter[:2] == pytest.approx([0.3534, 0.5])
    assert frame.particles.body.tolist() == [-1, -1] + [1] * 33 + [2] * 24
    assert frame.log["particles/generation"].tolist() == [-1, -1] + [1] * 57
    assert frame.log["time"] == [0.1]
    assert frame.log["obstacles"].tolist() == OBSTACLES
    assert frame.configuration.dimensions == 2
    half_box = frame.configuration.box[:2] / 2
    assert np.all(np.abs(frame.particles.position[:, :2]) < half_box)
    # Every vertex is on two bonds, and walking along the bonds goes round each outline.
    following = dict(frame.bonds.group.tolist())
    assert sorted(following) == list(range(2, 59))
    ring = [2]
    while following[ring[-1]] != 2:
        ring.append(following[ring[-1]])
    assert ring == list(range(2, 35))
    assert empty.particles.N == 2
    assert empty.bonds.N == 0


def test_frames_are_indexed_like_a_list():
    outlines = ragged_outlines()
    assert len(outlines) == 3
    assert [len(frame) for frame in outlines] == [1, 2, 0]
    assert outlines[-2][1].droplet_id == 2
    assert outlines[1][0].vertices.shape == (33, 2)
    with pytest.raises(IndexError):
        outlines[3]
    assert "3 frames, 3 droplets" in repr(outlines)


def test_circle_measures_as_a_regular_polygon():
    count, radius = 128, 0.5
    circle = ellipse(radius, radius, count, (-2.0, 0.7))
    still = np.zeros_like(circle)
    row = Outlines.from_frames([0.0], [[(0, 0, circle, still)]], OBSTACLES, PARAMETERS).measure()
    area = count / 2 * radius**2 * math.sin(2 * math.pi / count)
    perimeter = 2 * count * radius * math.sin(math.pi / count)
    assert row["area"][0] == pytest.approx(area, rel=1e-13)
    assert row["perimeter"][0] == pytest.approx(perimeter, rel=1e-13)
    assert (row["x"][0], row["y"][0]) == pytest.approx((-2.0, 0.7), rel=1e-13)
    assert row["shape_parameter"][0] == pytest.approx(
        perimeter**2 / (4 * math.pi * area), rel=1e-12
    )
    # The first admissible pair of vertices spans more than 0.28 of the perimeter.
    spanned = math.floor(0.28 * count) + 1
    chord = 2 * radius * math.sin(math.pi * spanned / count)
    assert row["neck_thickness"][0] == pytest.approx(chord, rel=1e-12)


def test_ellipse_measures_converge_to_the_smooth_shape():
    a, b = 0.8, 0.3
    errors = []
    for count in (64, 128, 256):
        shape = ellipse(a, b, count, (1.0, 2.0), angle=0.4)
        frame = [(0, 0, shape, np.zeros_like(shape))]
        row = Outlines.from_frames([0.0], [frame], OBSTACLES, PARAMETERS).measure().iloc[0]
        assert (row["x"], row["y"]) == pytest.approx((1.0, 2.0))
        errors.append(math.pi * a * b - row["area"])
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.01)


def test_direction_of_the_outline_does_not_matter():
    shape = ellipse(0.8, 0.3, 64, (1.0, 2.0), angle=0.4)
    still = np.zeros_like(shape)
    frames = [[(0, 0, shape, still)], [(0, 0, shape[::-1], still)]]
    table = Outlines.from_frames([0.0, 1.0], frames, OBSTACLES, PARAMETERS).measure()
    measured = table.drop(columns=["frame", "time"])
    pd.testing.assert_series_equal(measured.iloc[0], measured.iloc[1], check_names=False)
    assert table["area"].min() > 0


def test_neck_follows_the_unit_of_its_separation():
    """In diameters the arc is 0.28 D0, far shorter than 0.28 of the perimeter."""
    circle = ellipse(0.5, 0.5, 256)
    frame = [(0, 0, circle, np.zeros_like(circle))]
    thickness = {}
    for unit in ("perimeter", "diameter"):
        parameters = {**PARAMETERS, "neck_separation_unit": unit}
        outlines = Outlines.from_frames([0.0], [frame], OBSTACLES, parameters)
        thickness[unit] = outlines.neck(outlines[0][0])[0]
    assert thickness["perimeter"] == pytest.approx(math.sin(0.28 * math.pi), abs=0.02)
    assert thickness["diameter"] == pytest.approx(math.sin(0.28), abs=0.02)


def test_neck_of_a_dumbbell_is_its_waist():
    t = 2 * np.pi * np.arange(200) / 200
    waist = 0.05
    shape = np.column_stack((np.cos(t), np.sin(t) * (waist + 0.5 * np.cos(t) ** 2)))
    outlines = Outlines.from_frames(
        [0.0], [[(0, 0, shape, np.zeros_like(shape))]], OBSTACLES, PARAMETERS
    )
    thickness, i, j = outlines.neck(outlines[0][0])
    assert thickness == pytest.approx(2 * waist)
    assert sorted((i, j)) == [50, 150]


def test_measured_table_says_its_units():
    table = ragged_outlines().measure()
    assert table.attrs["units"]["area"] == "D0²"
    assert table.attrs["units"]["time"] == "t0"
    assert list(table.attrs["units"]) == list(table.columns)
    assert table["frame"].tolist() == [0, 1, 1]
    assert table["droplet_id"].tolist() == [0, 1, 2]


WRITER = """
import os, signal, sys
import numpy as np
from pinchoff.model.outlines import OutlineWriter
ring = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]])
writer = OutlineWriter(sys.argv[1], [[0, 0, 0.2]], {"offset": 0.05})
for frame in range(7):
    writer.append(0.1 * frame, [(0, 0, ring + frame, ring)])
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_file_of_a_killed_writer_holds_every_frame(tmp_path):
    path = tmp_path / "outlines.gsd"
    ended = subprocess.run([sys.executable, "-c", WRITER, str(path)], check=False, timeout=60)
    assert ended.returncode == -signal.SIGKILL
    outlines = Outlines.load(path)
    assert len(outlines) == 7
    assert outlines.parameters == {"offset": 0.05}
    np.testing.assert_array_equal(outlines[-1][0].vertices[0], [6.0, 6.0])


def test_file_is_readable_while_it_is_written(tmp_path):
    outlines = ragged_outlines()
    with OutlineWriter(tmp_path / "outlines.gsd", OBSTACLES, PARAMETERS) as writer:
        for count, (time, frame) in enumerate(zip(outlines.times, outlines, strict=True), 1):
            writer.append(time, frame)
            assert len(Outlines.load(tmp_path / "outlines.gsd")) == count


@pytest.mark.parametrize("every", [1, 3, None])
def test_frames_reach_the_disk_after_a_number_of_them_and_are_numbered(tmp_path, every):
    hoomd = pytest.importorskip("gsd.hoomd")
    ring, path = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]]), tmp_path / "outlines.gsd"
    with OutlineWriter(path, OBSTACLES, PARAMETERS, flush_every=every) as writer:
        for count in range(1, 8):
            writer.append(0.1 * count, [(0, 0, ring, ring)])
            written = count // every * every if every else 0
            assert len(Outlines.load(path)) == max(written, 1)  # the first is written at once
    with hoomd.open(path) as file:
        assert [frame.configuration.step for frame in file] == list(range(7))


def test_failed_save_leaves_the_old_file(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), written_aside(path) as unfinished:
        unfinished.write_text("half of the n")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_unknown_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"^path must be a name ending in \.gsd, \.npz, \.csv; "):
        ragged_outlines().save(tmp_path / "outlines.h5")


@pytest.mark.parametrize("name", ["missing.gsd", "outlines.csv"])
def test_unreadable_name_is_refused(tmp_path, name):
    with pytest.raises(InputError, match=r"^path must be an existing \.gsd or \.npz file; got "):
        Outlines.load(tmp_path / name)


@pytest.mark.parametrize("suffix", [".gsd", ".npz"])
@pytest.mark.parametrize("content", [b"", b"not outlines", bytes(300)])
def test_damaged_file_is_refused(tmp_path, suffix, content):
    path = Path(tmp_path / f"outlines{suffix}")
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"^path must be a file of outlines written by pinchoff"):
        Outlines.load(path)


def test_foreign_npz_is_refused(tmp_path):
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(InputError, match="written by pinchoff"):
        Outlines.load(tmp_path / "other.npz")


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"velocities": np.zeros((3, 2))}, "velocities"),
        ({"obstacles": np.zeros((1, 2))}, "obstacles"),
        ({"offsets": np.array([0, 64, 96, 120])}, "offsets"),
        ({"frame": np.array([1, 0, 1])}, "frame"),
        ({"frame": np.array([0, 1, 3])}, "frame"),
        ({"units": "inch"}, "units"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(change, name):
    outlines = ragged_outlines()
    arrays = {each: getattr(outlines, each) for each in ARRAYS}
    with pytest.raises(InputError, match=f"^{name} must be "):
        Outlines(**{**arrays, **change})


def test_outline_is_a_plain_tuple():
    """The engine's tuples and Outline are interchangeable."""
    outlines = ragged_outlines()
    again = Outlines.from_frames(outlines.times, list(outlines), OBSTACLES, PARAMETERS)
    assert_same(again, outlines)
    assert isinstance(outlines[0][0], Outline)


@pytest.mark.parametrize("suffix", [".gsd", ".npz", ".csv"])
def test_save_into_a_missing_folder_is_refused(refused, tmp_path, suffix):
    refused("path", ragged_outlines().save, tmp_path / "missing" / f"outlines{suffix}")


@pytest.mark.parametrize("suffix", [".gsd", ".npz"])
def test_damage_anywhere_is_refused_or_harmless(tmp_path, suffix):
    """In a process of its own: a reader that follows a damaged index may end it."""
    whole = tmp_path / f"whole{suffix}"
    po.simulate(po.Parameters(time_limit=0.2), outlines=True).outlines.save(whole)
    program = (
        "import random, sys, pinchoff as po\n"
        "from pathlib import Path\n"
        "whole = Path(sys.argv[1])\n"
        "content, copy = whole.read_bytes(), whole.with_stem('copy')\n"
        "draw = random.Random(7)\n"
        "for k in range(150):\n"
        "    damaged = bytearray(content)\n"
        "    end = 600 if k % 3 else len(content)\n"
        "    damaged[draw.randrange(end)] ^= 1 << draw.randrange(8)\n"
        "    cut = draw.randrange(len(content)) if k % 10 == 0 else len(content)\n"
        "    copy.write_bytes(damaged[:cut])\n"
        "    try:\n"
        "        po.Outlines.load(copy)\n"
        "    except po.InputError:\n"
        "        pass\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(whole)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
