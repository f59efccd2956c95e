"""Sweeps: which rows, and what is left after any kind of interruption."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import pinchoff as po
from pinchoff.collisions import schema as collisions
from pinchoff.collisions.checksums import CHECKSUMS
from pinchoff.studies.sweep import SweepDesign, dataset, execution
from pinchoff.studies.sweep.dataset import MANIFEST

SHORT = {"vertex_count": 16, "start_distance": 1.0, "time_limit": 0.02}
QUICK = {"follow_daughters": False, "start_distance": 1.5}
SAMPLE = {
    **QUICK,
    "design": "sobol",
    "samples": 300,
    "seed": 4,
    "vary": {
        "offset": {"min": 0, "max": 0.3},
        "simulation_capillary_number": {"min": 8, "max": 90, "scale": "log"},
        "line_tension": [60, 80],
    },
}


def changed(config, **changes):
    return {**config, **changes}


def varied(**vary):
    return {"vary": vary}


def parts(folder):
    return sorted(folder.glob("part-*.parquet"))


def contents(folder):
    return {path.name: path.read_bytes() for path in parts(folder)}


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Return a finished sweep, for tests that only read it."""
    folder = tmp_path_factory.mktemp("sweep") / "done"
    result = po.sweep(SAMPLE, folder, threads=2)
    assert (result.path, result.rows, result.computed) == (folder, 300, 300)
    return folder


# Rows


def test_rows_are_those_of_simulate_many(done):
    read = po.read_collisions(done)
    direct = po.simulate_many(SweepDesign.from_config(SAMPLE).points(), all_columns=True)
    assert read.attrs["units"] == {**collisions.units(), "line_tension": "M v_f∞²/D0"}
    tension = read.pop("line_tension")
    assert set(tension) == {60, 80}
    pd.testing.assert_series_equal(direct.pop("line_tension"), tension)
    pd.testing.assert_frame_equal(read, direct, check_exact=True)


@pytest.mark.parametrize("threads", [1, 3])
def test_parts_are_the_same_whatever_the_threads(done, tmp_path, threads):
    po.sweep(SAMPLE, tmp_path, threads=threads, progress=threads == 3)
    assert contents(tmp_path) == contents(done)


def test_folder_opens_as_it_is(done):
    frame = pd.read_parquet(done)
    assert frame["collision_id"].tolist() == list(range(300))
    assert frame["outcome"].dtype == "category"
    assert frame.attrs["units"]["contact_time"] == "t0"
    schema = pq.read_schema(parts(done)[0])
    for column in collisions.COLUMNS:
        assert schema.field(column.name).metadata[b"unit"].decode() == column.unit


def test_varied_parameters_have_columns(tmp_path):
    vary = {
        "time_step": ["auto", 5e-5],
        "neck_thickness": [0.16, 0.17],
        "neck_separation_unit": ["perimeter"],
        "follow_daughters": [False],
        "vertex_count": [16],
    }
    config = {"start_distance": 1.0, "time_limit": 0.02, "vary": vary}
    po.sweep(config, tmp_path)
    frame = po.read_collisions(tmp_path)
    auto = SweepDesign.from_config(config).point(0).effective_time_step
    assert frame["time_step"].tolist() == [auto, auto, 5e-5, 5e-5]
    assert frame["neck_thickness_limit"].tolist() == [0.16, 0.17] * 2
    assert set(frame["neck_separation_unit"]) == {"perimeter"}
    assert not frame["follow_daughters"].any()
    assert set(frame["vertex_count"]) == {16}
    assert frame["neck_thickness"].isna().all()  # what is measured, and never was


def test_stopped_runs_are_counted_rows(tmp_path):
    config = {**QUICK, **varied(area_stiffness=[1, 200_000])}
    with pytest.warns(RuntimeWarning, match="stopped 1 of 2 runs") as caught:
        result = po.sweep(config, tmp_path)
    assert caught[0].filename == __file__
    assert result.failed == 1
    assert po.read_collisions(tmp_path)["accepted"].tolist() == [False, True]


def test_reading_what_is_no_table_is_refused(refused, tmp_path):
    refused(str(tmp_path), po.read_collisions, tmp_path)
    refused(str(tmp_path / "no"), po.read_collisions, tmp_path / "no")
    text = tmp_path / "text.parquet"
    text.write_text("text")
    refused(str(text), po.read_collisions, text)
    pd.DataFrame({"a": [1]}).to_parquet(tmp_path / "a.parquet")
    error = refused(str(tmp_path / "a.parquet"), po.read_collisions, tmp_path / "a.parquet")
    assert "without the columns" in error.got


# Interruptions

SLOW = changed(SAMPLE, samples=320, follow_daughters=True)
"""Some seconds of work in parts of 16."""

PROGRAM = f"import pinchoff as po, sys; po.sweep({SLOW!r}, sys.argv[1], threads=2, progress=False)"


def wait_for_parts(folder, count, process):
    deadline = time.monotonic() + 60
    while len(parts(folder)) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.005)


def test_killed_sweep_goes_on_and_gives_the_same_rows(tmp_path):
    out = tmp_path / "out"
    for more in (2, 6):
        process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(out)])
        wait_for_parts(out, len(parts(out)) + more, process)
        process.kill()
        process.wait()
    before = {path.name: path.stat().st_mtime_ns for path in parts(out)}
    assert 8 <= len(before) < 20
    (out / ".pinchoff-0123456789abcdef.unfinished").write_bytes(b"half a part")
    killed = po.read_collisions(out)
    assert len(killed) == 16 * len(before)

    result = po.sweep(SLOW, out)
    assert result.computed == 320 - len(killed)
    after = {path.name: path.stat().st_mtime_ns for path in parts(out)}
    assert {name: after[name] for name in before} == before
    assert sorted(path.name for path in out.iterdir()) == sorted([MANIFEST, CHECKSUMS, *after])
    po.sweep(SLOW, tmp_path / "whole")
    assert contents(out) == contents(tmp_path / "whole")
    ids = po.read_collisions(out)["collision_id"]
    assert ids.tolist() == list(range(320))


@pytest.mark.slow
def test_ctrl_c_stops_soon_and_leaves_a_sweep_that_goes_on(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(tmp_path)], stderr=subprocess.PIPE
    )
    wait_for_parts(tmp_path, 3, process)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    _, said = process.communicate(timeout=20)
    assert time.monotonic() - start < 3
    assert b"KeyboardInterrupt" in said
    there = len(parts(tmp_path))
    assert [path for path in tmp_path.iterdir() if path.name.startswith(".")] == []
    assert po.sweep(SLOW, tmp_path).computed == 320 - 16 * there


def test_nothing_tells_how_often_a_sweep_was_stopped(done, tmp_path):
    po.sweep(SAMPLE, tmp_path)
    checksums = tmp_path / CHECKSUMS
    whole = checksums.read_bytes()
    # Killed between the second part's line and the part, and again within that line.
    first, second = whole.splitlines(keepends=True)[:2]
    checksums.write_bytes(first + second + second[:9])
    for path in parts(tmp_path)[1:]:
        path.unlink()
    po.sweep(SAMPLE, tmp_path)
    assert checksums.read_bytes() == whole
    assert contents(tmp_path) == contents(done)


def test_damaged_part_is_computed_again(done, tmp_path):
    po.sweep(SAMPLE, tmp_path)
    parts(tmp_path)[2].write_bytes(b"")
    parts(tmp_path)[3].write_bytes(parts(tmp_path)[3].read_bytes()[:1000])
    parts(tmp_path)[5].unlink()
    with pytest.warns(UserWarning, match=r"part-00000[23]\.parquet is damaged: it is set aside"):
        assert po.sweep(SAMPLE, tmp_path).computed == 48
    assert contents(tmp_path) == contents(done)
    assert (tmp_path / "_damaged-part-000003.parquet").stat().st_size == 1000
    assert len(po.read_collisions(tmp_path)) == 300


def test_no_flipped_bit_is_read_back_as_other_numbers(done, attacks, tmp_path, refused):
    po.sweep(SAMPLE, tmp_path)
    draw = np.random.default_rng(2)
    for path in draw.choice(parts(tmp_path), attacks):
        whole = path.read_bytes()
        damaged = bytearray(whole)
        damaged[draw.integers(len(whole))] ^= 1 << draw.integers(8)
        path.write_bytes(damaged)
        refused(str(path), po.read_collisions, tmp_path)
        path.write_bytes(whole)
    assert contents(tmp_path) == contents(done)


def test_finished_sweep_is_left_alone(done):
    before = {path.name: path.stat().st_mtime_ns for path in done.iterdir()}
    assert po.sweep(SAMPLE, done).computed == 0
    assert {path.name: path.stat().st_mtime_ns for path in done.iterdir()} == before


def test_a_sweep_that_is_removed_makes_room_for_another(tmp_path):
    first, second = ({**SHORT, **varied(offset=[0, y])} for y in (0.1, 0.2))
    po.sweep(first, tmp_path)
    parts(tmp_path)[0].write_bytes(b"")
    with pytest.warns(UserWarning, match="set aside"):
        po.sweep(first, tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    dataset.remove_sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]
    (tmp_path / "notes.txt").unlink()
    assert po.sweep(second, tmp_path).computed == 2


# Refusals


@pytest.mark.parametrize(
    ("changes", "shown"),
    [
        ({"samples": 301}, "samples = 301, there 300"),
        ({"seed": 5}, "seed = 5, there 4"),
        ({"edge_stiffness": 4}, "parameters.edge_stiffness = 4.0, there nothing"),
        ({"design": "random"}, "design = 'random', there 'sobol'"),
        (
            {"vary": {**SAMPLE["vary"], "offset": [0, 0.1]}},
            "vary.offset.min = nothing, there 0.0 (and ",
        ),
        ({"vary": dict(reversed(SAMPLE["vary"].items()))}, "the order of the varied parameters"),
    ],
)
def test_changed_configuration_is_refused(refused, done, changes, shown):
    before = contents(done)
    error = refused("out", po.sweep, changed(SAMPLE, **changes), done)
    assert shown in error.got
    assert contents(done) == before


def test_same_configuration_in_other_words_goes_on(done):
    vary = {**SAMPLE["vary"], "line_tension": [60.0, 80.0]}
    fixed = {**QUICK, "start_distance": 1.50, "edge_stiffness": 3}
    rest = {key: SAMPLE[key] for key in ("design", "samples", "seed")}
    assert po.sweep({**rest, "parameters": fixed, "vary": vary}, done).computed == 0


def test_other_version_and_other_drawing_are_refused(refused, tmp_path):
    config = {**SHORT, **varied(offset=[0, 0.1])}
    po.sweep(config, tmp_path)
    manifest = json.loads((tmp_path / MANIFEST).read_text(encoding="utf-8"))
    for key, value, advice in (
        ("pinchoff_version", "0.0.1", "finish it with pinchoff 0.0.1"),
        ("last_point", {"offset": 0.2}, "the version of scipy"),
    ):
        (tmp_path / MANIFEST).write_text(json.dumps({**manifest, key: value}), encoding="utf-8")
        assert advice in refused("out", po.sweep, config, tmp_path).advice
    for damaged in ("", "[1]", '{"format": 99}', '{"format": 1}', '{"format": 1, "count": "2"}'):
        (tmp_path / MANIFEST).write_text(damaged, encoding="utf-8")
        refused(str(tmp_path / MANIFEST), po.sweep, config, tmp_path)


def test_unfit_folder_is_refused(refused, tmp_path):
    config = {**SHORT, **varied(offset=[0, 0.1])}
    (tmp_path / "thesis.tex").write_text("do not touch")
    assert "thesis.tex" in refused("out", po.sweep, config, tmp_path).got
    refused("out", po.sweep, config, tmp_path / "thesis.tex")
    refused("out", po.sweep, config, tmp_path / "thesis.tex" / "below")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_second_sweep_in_the_same_folder_is_refused(refused, tmp_path):
    design = SweepDesign.from_config({**SHORT, **varied(offset=[0, 0.1])})
    with dataset.opened(tmp_path, design), ThreadPoolExecutor(1) as other:
        error = other.submit(refused, "out", po.sweep, design, tmp_path).result()
    assert "in use" in error.got
    assert po.sweep(design, tmp_path).computed == 2


def test_full_disk_ends_with_advice_and_keeps_what_is_there(done, tmp_path):
    limit = max(path.stat().st_size for path in parts(done)[:3])
    later = [i for i, path in enumerate(parts(done)) if path.stat().st_size > limit]
    program = (
        "import resource, sys, pinchoff as po\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"
        "try:\n"
        f"    po.sweep({SAMPLE!r}, sys.argv[1], threads=1)\n"
        "except po.PinchoffError as error:\n"
        "    sys.exit(f'{type(error).__name__} {error.exit_code}: {error}')\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert later, "no part is larger than the limit"
    assert ended.stderr.startswith("PinchoffError 1: ")
    assert "make room and start again" in ended.stderr
    assert len(parts(tmp_path)) >= 2
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    po.sweep(SAMPLE, tmp_path)
    assert contents(tmp_path) == contents(done)


def test_wrong_arguments_are_refused_by_name(refused, tmp_path):
    config = {**SHORT, **varied(offset=[0])}
    refused("config", po.sweep, 3, tmp_path / "out")
    refused(str(tmp_path / "no.toml"), po.sweep, tmp_path / "no.toml", tmp_path / "out")
    refused("threads", po.sweep, config, tmp_path / "out", threads=0)
    refused("client", po.sweep, config, tmp_path / "out", client="tcp://127.0.0.1:8786")
    refused("threads", po.sweep, config, tmp_path / "out", threads=2, client=object())
    assert list(tmp_path.iterdir()) == []


# Memory


def test_points_are_never_held(tmp_path, monkeypatch):
    alive: weakref.WeakSet[po.Parameters] = weakref.WeakSet()
    most = 0
    made = SweepDesign._parameters

    def watched(self, values):
        nonlocal most
        point = made(self, values)
        alive.add(point)
        most = max(most, len(alive))
        return point

    monkeypatch.setattr(SweepDesign, "_parameters", watched)
    config = {**SHORT, **varied(offset={"min": 0, "max": 1, "count": 4096})}
    po.sweep(config, tmp_path / "out", threads=1)
    assert most <= 2 * 64 + 2


@pytest.mark.skipif(sys.platform != "linux", reason="units of ru_maxrss")
def test_memory_does_not_grow_with_the_rows(tmp_path):
    program = (
        "import resource, sys, pinchoff as po\n"
        "for rows in (2_000, 20_000):\n"
        "    vary = {'offset': {'min': 0, 'max': 1, 'count': rows}}\n"
        f"    po.sweep({SHORT!r} | {{'vary': vary}}, f'{{sys.argv[1]}}/{{rows}}')\n"
        "    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)\n"
    )
    printed = subprocess.check_output([sys.executable, "-c", program, str(tmp_path)])
    few, many = map(float, printed.split())  # MiB, the most that the process has had until then
    # 18 000 rows more are 7 MiB as a table, and 40 MiB or more as Python objects.
    assert many - few < 6


def test_parts_of_a_batch_share_the_threads(monkeypatch, tmp_path):
    sizes = []
    compute = execution.compute_parts

    def watched(design, ranges, threads, show=None):
        sizes.append(sum(map(len, ranges.values())))
        return compute(design, ranges, threads, show)

    monkeypatch.setattr(execution, "compute_parts", watched)
    po.sweep({**SHORT, **varied(offset={"min": 0, "max": 1, "count": 200})}, tmp_path, threads=2)
    assert sizes == [64, 64, 64, 8]
