"""Sweeps on a Dask cluster: the same rows as on threads, also when a worker dies on the way."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

import pinchoff as po
from pinchoff.cli import main
from pinchoff.studies.sweep import cluster

distributed = pytest.importorskip("distributed")

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # of the workers' pipes

CONFIG = {
    "design": "sobol",
    "samples": 192,
    "seed": 2,
    "follow_daughters": False,
    "vary": {
        "offset": {"min": 0, "max": 0.3},
        "simulation_capillary_number": {"min": 8, "max": 90, "scale": "log"},
    },
}


NO_PORT = "127.0.0.1:0"  # any that is free, and none that others reach


def parts(folder):
    return {path.name: path.read_bytes() for path in folder.glob("part-*.parquet")}


@pytest.fixture(scope="module")
def workers():
    """Return a cluster of two worker processes on this machine."""
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=NO_PORT,
        memory_limit=None,
    ) as local:
        yield local


@pytest.fixture
def client(workers):
    with distributed.Client(workers, set_as_default=False) as client:
        yield client


@pytest.fixture(scope="module")
def on_threads(tmp_path_factory):
    folder = tmp_path_factory.mktemp("threads") / "out"
    po.sweep(CONFIG, folder)
    return parts(folder)


def kill_when(condition, pid, killed):
    deadline = time.monotonic() + 60
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.005)
    os.kill(pid, signal.SIGKILL)
    killed.append(pid)


def test_worker_killed_during_the_sweep_loses_nothing(client, on_threads, tmp_path):
    client.wait_for_workers(2)
    pids = client.run(os.getpid)
    assert len(set(pids.values())) == 2
    assert os.getpid() not in pids.values()
    victim, killed, seen = min(pids.values()), [], []

    def some_parts_are_there():
        seen[:] = tmp_path.glob("part-*.parquet")
        return len(seen) >= 4

    killer = threading.Thread(target=kill_when, args=(some_parts_are_there, victim, killed))
    killer.start()
    result = po.sweep(CONFIG, tmp_path, client=client, progress=True)
    killer.join()
    assert killed == [victim]
    assert 4 <= len(seen) < len(on_threads)
    assert result.computed == 192
    assert parts(tmp_path) == on_threads
    assert victim not in client.run(os.getpid).values()


def test_command_finishes_on_a_cluster_what_threads_began(workers, on_threads, tmp_path):
    po.sweep(CONFIG, tmp_path)
    for name in sorted(on_threads)[5:9]:
        (tmp_path / name).unlink()
    config = tmp_path.parent / "config.toml"
    config.write_text(
        'design = "sobol"\nsamples = 192\nseed = 2\nfollow_daughters = false\n'
        "[vary]\noffset = { min = 0, max = 0.3 }\n"
        'simulation_capillary_number = { min = 8, max = 90, scale = "log" }\n'
    )
    address = workers.scheduler_address
    assert main(["sweep", str(config), "--out", str(tmp_path), "--scheduler", address]) == 0
    assert parts(tmp_path) == on_threads


def test_bad_points_and_failures_are_reported_from_workers(client, tmp_path):
    with pytest.warns(RuntimeWarning, match="stopped 1 of 2 runs"):
        po.sweep({"vary": {"area_stiffness": [1, 200_000]}}, tmp_path, client=client)


def test_workers_of_another_version_are_refused(refused, client, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_version", lambda: "9.9.9")
    error = refused("client", po.sweep, CONFIG, tmp_path, client=client)
    assert error.rule == "of workers with pinchoff 9.9.9"


def test_cluster_without_workers_is_refused(refused, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_SECONDS_TO_CONNECT", 0.2)
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=NO_PORT) as empty,
        distributed.Client(empty, set_as_default=False) as client,
    ):
        refused("client", po.sweep, CONFIG, tmp_path, client=client)


def test_unreachable_scheduler_is_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cluster, "_SECONDS_TO_CONNECT", 0.5)
    config = tmp_path / "config.toml"
    config.write_text("vary.offset = [0, 0.1]\n")
    for address in ("tcp://127.0.0.1:1", "nonsense://x", ""):
        arguments = ["sweep", str(config), "--out", str(tmp_path / "out")]
        assert main([*arguments, "--scheduler", address]) == 2
        said = capsys.readouterr().err
        assert said.startswith("error: --scheduler must be the address of a Dask scheduler")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_lost_scheduler_keeps_what_is_there_and_says_what_to_do(on_threads, tmp_path):
    local = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=NO_PORT
    )
    with distributed.Client(local, set_as_default=False) as client:

        def close_soon():
            while len(list(tmp_path.glob("part-*.parquet"))) < 2:
                time.sleep(0.005)
            local.close()

        closer = threading.Thread(target=close_soon)
        closer.start()
        with pytest.raises(po.PinchoffError, match="start it again"):
            po.sweep(CONFIG, tmp_path, client=client)
        closer.join()
    there = parts(tmp_path)
    assert 2 <= len(there) < len(on_threads)
    assert there.items() <= on_threads.items()
