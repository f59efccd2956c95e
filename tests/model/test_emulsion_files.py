"""The folder of a run of many droplets: killed, resumed, and refused where it is another run's."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pinchoff as po

CROWDED = {
    "coalescence": po.Coalescence(0.1, 0.3, stochastic=True),
    "inlet": po.Inlet(0.0, 0.0, 3.78, area_fraction=0.3, diameters=[0.8, 1.0]),
    "checkpoint": 2.0,
}


def test_a_killed_run_resumes_to_the_same_bits(tmp_path, through_pillars):
    """SIGKILL with films between droplets, then resume on two threads."""
    whole = through_pillars(8.0, out=tmp_path / "whole", **CROWDED)
    late = whole.events[whole.events["time"] > 6.0]["kind"].value_counts()
    assert (late[["entered", "contact", "breakup", "touched", "parted", "merge"]] > 0).all()
    script = f"""
        import os, signal, sys
        sys.path.insert(0, {str(Path(__file__).parent)!r})
        import conftest, test_emulsion_files
        def die(time, droplets):
            if time > 6.6:
                os.kill(os.getpid(), signal.SIGKILL)
        crowded = test_emulsion_files.CROWDED
        conftest._through_pillars(8.0, out={str(tmp_path / "killed")!r}, on_frame=die, **crowded)
    """
    killed = subprocess.run([sys.executable, "-c", textwrap.dedent(script)], check=False)
    assert killed.returncode == -signal.SIGKILL
    resumed = through_pillars(8.0, out=tmp_path / "killed", resume=True, threads=2, **CROWDED)
    pd.testing.assert_frame_equal(whole.events, resumed.events, check_exact=True)
    pd.testing.assert_frame_equal(whole.sizes, resumed.sizes, check_exact=True)
    np.testing.assert_array_equal(whole.outlines.vertices, resumed.outlines.vertices)
    np.testing.assert_array_equal(whole.outlines.velocities, resumed.outlines.velocities)
    assert whole.balance == resumed.balance
    assert not list((tmp_path / "killed").glob(".*"))


def test_a_run_in_memory_has_the_tables_of_one_in_a_folder(tmp_path, through_pillars):
    kept, written = through_pillars(6.0), through_pillars(6.0, out=tmp_path, checkpoint=2.0)
    pd.testing.assert_frame_equal(kept.events, written.events, check_exact=True)
    pd.testing.assert_frame_equal(kept.sizes, written.sizes, check_exact=True)
    assert kept.outlines is None
    assert len(written.outlines) == 13


def test_resume_refuses_another_run(tmp_path, through_pillars):
    run = {"out": tmp_path, "coalescence": po.Coalescence(0.1)}
    through_pillars(0.5, **run)
    with pytest.raises(po.InputError, match="other seed"):
        through_pillars(0.5, resume=True, **run, seed=4)
    for other in (po.Coalescence(0.2), po.Coalescence(math.inf)):
        with pytest.raises(po.InputError, match="other coalescence"):
            through_pillars(0.5, resume=True, **{**run, "coalescence": other})
    with pytest.raises(po.InputError, match="without a run"):
        through_pillars(0.5, **run)
    (tmp_path / "checkpoint.npz").write_bytes(b"nonsense")
    with pytest.raises(po.InputError, match="a checkpoint"):
        through_pillars(0.5, resume=True, **run)
