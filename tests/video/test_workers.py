"""Jobs in processes: one that ends its process costs no other job.

Every process imports this file, so it imports little.
"""

from __future__ import annotations

import os
import time

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
