"""Jobs in processes: one that ends its process costs no other job.

Every process imports this file, so it imports little.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from pinchoff.video import workers
from pinchoff.video.workers import all_done, segmented


def _ends(job, count):
    """Do what a job says: "end" ends the process, as a damaged file may."""
    count(1)
    if job == "end":
        time.sleep(0.5)
        os._exit(7)
    time.sleep(0.05)
    return f"{job} done"


def _broken(job):
    return f"{job} broken"


def test_a_process_that_ends_costs_its_own_job_only():
    jobs = ["a", "end", "b", "end", "c"]
    found = sorted(all_done(jobs, _ends, _broken, 2))
    assert found == ["a done", "b done", "c done", "end broken", "end broken"]


def test_progress_is_summed_over_jobs():
    shown = []
    assert sorted(all_done("abc", _ends, _broken, 1, shown.append)) == [
        "a done",
        "b done",
        "c done",
    ]
    assert shown == [1.0, 2.0, 3.0]


class _Unpicklable:
    def __init__(self):
        self.found = lambda frame: [frame]

    def droplets(self, frame):
        return self.found(frame)


def test_a_users_function_that_cannot_be_copied_works_here():
    assert list(segmented([1, 2], _Unpicklable(), 4)) == [(1, [1]), (2, [2])]


class _Starting:
    """Stands for a pool: what it is handed it starts as a program."""

    def submit(self, code):
        return subprocess.run([sys.executable, "-c", code], check=False, capture_output=True)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signals of this kind")
def test_a_process_that_starts_leaves_ctrl_c_to_its_parent():
    """Until it has imported what it works with it would end with a traceback."""
    code = "import os, signal; os.kill(os.getpid(), signal.SIGINT); print('lives')"
    ended = workers._submitted(_Starting(), code)
    assert ended.stdout.split() == [b"lives"]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
