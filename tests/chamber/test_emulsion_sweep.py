"""Several runs from one file."""

from __future__ import annotations

import copy
import shutil

import pytest

from pinchoff.chamber.emulsion_sweep import run_on_cluster, sweep_runs

BASE = {
    "time": 5,
    "parameters": {"simulation_capillary_number": 60},
    "array": {"kind": "square", "rows": 2, "columns": 2, "radius": 0.3, "gap": 1.0},
    "flow": {"thickness": 0.5},
    "droplets": {"area_fraction": 0.2},
}


def runs(**sweep):
    return sweep_runs({**copy.deepcopy(BASE), "sweep": sweep})


def test_every_combination_is_run_in_a_folder_of_its_own():
    found = runs(**{"array.gap": [0.9, 1.2], "seed": [1, 2, 3]})
    assert [one.folder for one in found] == [f"run-{k:04d}" for k in range(6)]
    assert [tuple(one.values.values()) for one in found[:2]] == [(0.9, 1), (0.9, 2)]
    assert found[3].design.array.least_gap == pytest.approx(1.2)
    assert (found[0].design.droplets != found[1].design.droplets).any()


def test_a_key_may_be_written_with_and_without_quotes():
    quoted = runs(**{"parameters.simulation_capillary_number": [20, 40]})
    plain = runs(parameters={"simulation_capillary_number": [20, 40]})
    for a, b in zip(quoted, plain, strict=True):
        assert a.values == b.values
        assert a.design.parameters == b.design.parameters
    assert quoted[1].design.parameters.simulation_capillary_number == 40


@pytest.mark.parametrize(
    ("sweep", "argument", "word"),
    [
        ({}, "sweep", "a table"),
        ({"seed": 1}, "sweep.seed", "a list"),
        ({"array.gap": []}, "sweep.array.gap", "a list"),
        ({"array.gap": [1.0, -1.0]}, "array.gap", "in run 1 (array.gap = -1.0)"),
        ({"array.gapp": [1.0]}, "array.gapp", "a key of"),
        ({"time.x": [1.0]}, "time", "a table; got 5 in run 0 (time.x = 1.0)"),
        ({"seed": list(range(1001))}, "sweep", "at most 1000"),
    ],
)
def test_a_wrong_sweep_is_refused_before_anything_runs(sweep, argument, word, refused):
    error = refused(argument, runs, **sweep)
    assert word in str(error)


@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_cluster_gives_the_bytes_that_threads_give(tmp_path):
    distributed = pytest.importorskip("distributed")
    pytest.importorskip("skfem", reason="its extra is not installed")
    short = {**copy.deepcopy(BASE), "time": 0.5, "sweep": {"seed": [1, 2, 3]}}
    made = sweep_runs(short)
    flow = made[0].design.flow()
    for one in made:
        one.design.run(flow, tmp_path / "threads" / one.folder)
    shutil.copytree(tmp_path / "threads/run-0001", tmp_path / "cluster/run-0001")
    held = (tmp_path / "cluster/run-0001/checkpoint.npz").stat().st_mtime_ns
    with distributed.Client(
        processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None
    ) as client:
        arrived = list(run_on_cluster(made, tmp_path / "cluster", client))
    assert arrived[0].folder == "run-0001"  # what was begun here is not run again
    assert (tmp_path / "cluster/run-0001/checkpoint.npz").stat().st_mtime_ns == held
    assert {one.folder for one in arrived} == {one.folder for one in made}
    for one in made:
        on_threads, on_cluster = (
            {path.name: path.read_bytes() for path in (tmp_path / how / one.folder).iterdir()}
            for how in ("threads", "cluster")
        )
        assert "checkpoint.npz" in on_threads
        assert on_cluster == on_threads
