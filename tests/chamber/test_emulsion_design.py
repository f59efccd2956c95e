"""Runs of many droplets read from a file: where droplets are put, kinds of arrays, the end."""

from __future__ import annotations

import copy

import numpy as np
import pandas as pd
import pytest

from pinchoff.chamber.emulsion_design import STRETCHES, EmulsionDesign

pytest.importorskip("skfem", reason="its extra is not installed")

CELL = {
    "time": 2,
    "parameters": {"simulation_capillary_number": 60, "vertex_count": 32},
    "array": {"kind": "square", "rows": 2, "columns": 2, "radius": 0.3, "gap": 1.0},
    "flow": {"thickness": 0.5},
    "droplets": {"area_fraction": 0.3, "diameters": [0.8, 1.0]},
    "outlines": False,
}


def design(**changes):
    return EmulsionDesign.from_config({**copy.deepcopy(CELL), **changes})


def test_droplets_of_the_start_are_clear_of_all_as_the_engine_wants_it(tmp_path):
    made = design(time=0.1)
    assert len(made.droplets) >= 4
    run = made.run(made.flow(), tmp_path / "run")  # the engine refuses droplets that are too near
    assert run.balance["present"] == len(made.droplets)


def test_a_device_is_an_array_in_the_droplets_diameters():
    array = {"kind": "chamber", "before": 3, "behind": 2}
    inlet = {"area_fraction": 0.2}
    config = {**copy.deepcopy(CELL), "array": array, "inlet": inlet}
    del config["droplets"]
    own = EmulsionDesign.from_config(config)
    assert len(own.array.circles) == 30
    del config["parameters"]["simulation_capillary_number"]
    config["physical"] = {
        "diameter": "240.5 um",
        "speed": "1 mm/s",
        "viscosity": "48 mPa s",
        "surface_tension": "20 mN/m",
    }
    physical = EmulsionDesign.from_config(config)
    assert physical.array.circles[:, 2] * 240.5 == pytest.approx(85.0)


def test_a_device_of_a_file_is_looked_for_beside_the_design(tmp_path, refused):
    (tmp_path / "device.toml").write_text("[imaging]\nrows = 6\ncolumns = 4\n")
    config = {**copy.deepcopy(CELL), "array": {"kind": "chamber", "path": "device.toml"}}
    assert len(EmulsionDesign.from_config(config, beside=tmp_path).array.circles) == 24
    config["array"]["path"] = 3
    refused("array.path", EmulsionDesign.from_config, config, beside=tmp_path)


@pytest.mark.parametrize("name", ["outlines", "stop_when_steady"])
def test_a_switch_is_true_or_false(name, refused):
    refused(name, EmulsionDesign.from_config, {**copy.deepcopy(CELL), name: "yes"})


@pytest.mark.parametrize("length", [-1, 1e4, 9223372036854775808])
def test_margins_have_bounds(length, refused):
    array = {**CELL["array"], "behind": length}
    refused("array.behind", EmulsionDesign.from_config, {**copy.deepcopy(CELL), "array": array})


class Watched(EmulsionDesign):
    """A design that notes until when it was run, and calls the sizes steady from a time on."""

    steady_from = 1.0

    def _run_until(self, time, flow, out, options):
        self.__dict__.setdefault("ends", []).append(time)
        return super()._run_until(time, flow, out, options)

    def _is_steady(self, run, flow):
        return run.time >= self.steady_from


def watched(**changes):
    made = design(stop_when_steady=True, **changes)
    return Watched(**vars(made))


def test_a_run_ends_at_the_first_look_that_finds_it_steady(tmp_path):
    made = watched()
    flow = made.flow()
    run = made.run(flow, tmp_path / "run")
    assert run.time == pytest.approx(1.0)
    assert STRETCHES == 20  # looks every 0.1 t0 here
    again = watched()
    assert again.run(flow, tmp_path / "run").time == pytest.approx(1.0)


def test_a_run_that_goes_on_ends_where_it_would_have_ended(tmp_path):
    made = watched()
    flow = made.flow()
    whole = made.run(flow, tmp_path / "whole")
    design(time=0.55).run(flow, tmp_path / "stopped")  # between two looks
    resumed = watched().run(flow, tmp_path / "stopped")
    assert resumed.time == whole.time
    pd.testing.assert_frame_equal(
        resumed.sizes[resumed.sizes["time"] == resumed.time].reset_index(drop=True),
        whole.sizes[whole.sizes["time"] == whole.time].reset_index(drop=True),
    )


def test_a_run_that_is_never_steady_runs_to_its_time(tmp_path):
    made = watched(time=0.5)
    assert made.run(made.flow(), tmp_path / "run").time == pytest.approx(0.5)


def test_steadiness_itself_ends_a_cell_in_which_nothing_breaks(tmp_path):
    calm = {"simulation_capillary_number": 2, "vertex_count": 32}
    made = design(
        time=60, parameters=calm, stop_when_steady=True, interval=0.25, smallest_breaking=2.0
    )
    run = made.run(made.flow(), tmp_path / "run")
    residence = made.array.length  # the fluid goes at 1
    assert 5 * residence <= run.time < 60
    assert np.isclose(run.time % 3.0, 0.0)


def test_a_finished_run_is_left_as_it_is(tmp_path):
    made = design(time=0.5)
    flow = made.flow()
    first = made.run(flow, tmp_path / "run")
    held = {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()}
    second = made.run(flow, tmp_path / "run")
    assert (second.time, second.balance) == (first.time, first.balance)
    assert {path.name: path.read_bytes() for path in (tmp_path / "run").iterdir()} == held
