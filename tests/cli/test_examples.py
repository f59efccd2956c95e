"""``pinchoff examples``: its files are what the other commands take, from an empty folder."""

from __future__ import annotations

import json

import pytest

import pinchoff as po
from pinchoff.chamber.device import Device
from pinchoff.cli import main
from pinchoff.studies.sweep import SweepDesign
from pinchoff.support.files import read_toml


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("user") / "examples"
    assert main(["examples", str(folder)]) == 0
    return folder


def test_configurations_are_read(folder):
    for name in ("phase-diagram", "speed-and-offset"):
        assert len(SweepDesign.from_toml(folder / f"{name}.toml")) > 20
    po.Parameters.from_toml(folder / "separating_line.toml")
    Device(**read_toml(folder / "chamber.toml"))


def test_the_table_is_fitted(folder, tmp_path, capsys):
    columns = {
        "symmetry=S_meas": "",
        "broke=result": "",
        "area=A (mm^2)": "area=mm^2",
        "speed=v (um/s)": "speed=um/s",
        "obstacle_radius=R (um)": "obstacle_radius=um",
        "thickness=z (um)": "thickness=um",
        "viscosity=mu (mPa s)": "viscosity=mPa s",
    }
    maps = [text for pair in columns for text in ("--map", pair)]
    units = [text for unit in columns.values() if unit for text in ("--unit", unit)]
    law = tmp_path / "law"
    constant = ["--constant", "surface_tension=20 mN/m", "--samples", "20"]
    command = ["fit", str(folder / "mine.csv"), *maps, *units, *constant, "--out", str(law)]
    assert main(command) == 0
    assert json.loads((law / "law.json").read_text())["synthetic"] is True


def test_the_clip_has_its_truth(folder):
    pytest.importorskip("cv2", reason="the extra 'video' is not installed")
    truth = po.read_collisions(folder / "clip.truth.parquet")
    assert set(truth["broke"]) == {True, False}
    assert (folder / "clip.mp4").stat().st_size > 10_000


def test_what_is_there_is_not_replaced_unasked(folder, capsys):
    assert main(["examples", str(folder)]) == 2
    assert "--overwrite" in capsys.readouterr().err
