"""A run of many droplets killed at random moments: the same bytes in the end."""

from __future__ import annotations

import hashlib
import pickle
import random
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("skfem", reason="its extra is not installed")

from pinchoff.chamber.emulsion_design import EmulsionDesign

CONFIG = """
time = 25
interval = 0.25
checkpoint = 1
smallest_breaking = 0.3
seed = 3
[parameters]
simulation_capillary_number = 60
vertex_count = 48
[array]
kind = "staggered"
rows = 3
columns = 6
radius = 0.3
gap = 1.0
before = 3
behind = 2
[flow]
thickness = 0.5
[inlet]
area_fraction = 0.3
diameters = [0.8, 1.0]
"""
PROGRAM = """
import pickle, sys
from pathlib import Path
design, flow = pickle.loads(Path(sys.argv[1]).read_bytes())
design.run(flow, Path(sys.argv[2]))
"""


def digests(out):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in out.iterdir()}


def kill_and_go_on(folder, kills, seed, config=CONFIG):
    """Kill a run soon after it has written so many files, whatever time that takes it here."""
    (folder / "c.toml").write_text(config)
    design = EmulsionDesign.from_toml(folder / "c.toml")
    flow = design.flow()
    (folder / "given").write_bytes(pickle.dumps((design, flow)))
    command = [sys.executable, "-c", PROGRAM, str(folder / "given"), str(folder / "killed")]
    design.run(flow, folder / "whole")
    written = len(list((folder / "whole").iterdir()))
    draw = random.Random(seed)
    hits = 0
    for count in sorted(draw.sample(range(1, written - 10), kills)):
        program = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while program.poll() is None and len(list((folder / "killed").glob("*"))) < count:
            time.sleep(1e-3)
        time.sleep(draw.uniform(0.0, 0.02))
        program.send_signal(signal.SIGKILL)
        hits += program.wait() == -signal.SIGKILL
    design.run(flow, folder / "killed")
    assert hits
    whole = digests(folder / "whole")
    assert len(whole) > 70
    assert digests(folder / "killed") == whole


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_killed_twice_it_ends_with_the_same_bytes(tmp_path):
    kill_and_go_on(tmp_path, 2, 0, CONFIG.replace("columns = 6", "columns = 2"))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_killed_twenty_times_it_ends_with_the_same_bytes(tmp_path):
    kill_and_go_on(tmp_path, kills=20, seed=1)
