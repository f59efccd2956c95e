"""Models, droplets and runs that the physics tests share."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import pinchoff as po
from pinchoff import _core


def model_row(*, core=None, **constants):
    """One row for the core from `Parameters`, then with some of the core's own numbers replaced."""
    base = {"size_ratio": 5.66, "simulation_capillary_number": 20.0, "offset": 0.05}
    row = po.Parameters(**{**base, **constants}).model_row()
    for name, value in (core or {}).items():
        row[_core.MODEL_FIELDS.index(name)] = value
    return row


REFERENCE = Path(__file__).parents[3] / "benchmarks" / "reference"


@pytest.fixture(scope="session")
def reference(tmp_path_factory):
    """Function (name, *arguments) -> what an independent program says of a collision."""
    programs = {}

    def compiled(name):
        compiler = shutil.which("g++") or shutil.which("c++")
        if compiler is None:
            pytest.skip("no C++ compiler")
        source = REFERENCE / f"{name}.cpp"
        if not source.exists():
            pytest.skip("the reference program is not here")
        program = tmp_path_factory.mktemp("reference") / name
        subprocess.run([compiler, "-O2", "-o", program, source], check=True)
        return program

    def call(name, *arguments):
        if name not in programs:
            programs[name] = compiled(name)
        command = [programs[name], *map(str, arguments)]
        ended = subprocess.run(command, check=True, capture_output=True, text=True)
        return json.loads(ended.stdout)

    return call


@pytest.fixture
def model():
    """Function (core={...}, **parameters) -> model row."""
    return model_row


@pytest.fixture
def any_collisions(model):
    """Function (rng, count) -> rows over the usual range of offsets, Ca_sim and sizes."""

    def draw(rng, count):
        rows = [
            model(
                offset=rng.uniform(-0.3, 0.3),
                simulation_capillary_number=rng.uniform(8, 90),
                size_ratio=rng.uniform(2, 8),
            )
            for _ in range(count)
        ]
        return np.array(rows)

    return draw


@pytest.fixture
def run():
    """Function (rows or one row, threads=1) -> list of dicts, one a run, keyed by RESULT_FIELDS."""

    def call(rows, threads=1, flow=None):
        results = _core.run_many(np.atleast_2d(rows), flow, threads, None)
        return [dict(zip(_core.RESULT_FIELDS, r.tolist(), strict=True)) for r in results]

    return call


@pytest.fixture
def system():
    """Function (row, flow, obstacles, droplets) -> System; by default the single collision."""

    def build(row, flow=None, obstacles=None, droplets=None):
        value = dict(zip(_core.MODEL_FIELDS, row, strict=True))
        if obstacles is None:
            obstacles = [[0.0, 0.0, value["obstacle_radius"]]]
        if droplets is None:
            droplets = [[-value["start_distance"], value["offset"], 1.0]]
        if flow is None:
            flow = _core.StokesFlow(value["obstacle_radius"])
        obstacles = np.array(obstacles, dtype=float).reshape(-1, 3)
        return _core.System(row, flow, obstacles, np.array(droplets, dtype=float).reshape(-1, 3))

    return build


@pytest.fixture
def result():
    """Function (System) -> dict of its results."""

    def read(of):
        return dict(zip(_core.RESULT_FIELDS, of.result().tolist(), strict=True))

    return read


@pytest.fixture
def droplet():
    """Function (rng, count, center) -> a rough, non-convex, counter-clockwise outline, about D0."""

    def build(rng, count=64, center=(0.0, 0.0)):
        angle = (np.arange(count) + 0.5 * rng.random(count)) * 2 * np.pi / count
        modes = np.arange(2, 6)
        size, phase = rng.normal(0.0, 0.2, modes.size), rng.uniform(0, 2 * np.pi, modes.size)
        radius = 0.5 * np.exp((size * np.cos(np.outer(angle, modes) + phase)).sum(axis=1))
        radius *= 1 + 0.02 * rng.normal(size=count)
        return np.column_stack((radius * np.cos(angle), radius * np.sin(angle))) + center

    return build
