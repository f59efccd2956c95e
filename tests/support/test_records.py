"""Every JSON of ours, damaged in its shape: refused in one line that names it, or made again."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.chamber import Chamber
from pinchoff.chamber.record import design_record, read_design
from pinchoff.cli import main
from pinchoff.paper import make
from pinchoff.paper.make import reproduce
from pinchoff.studies.calibration import fitting
from pinchoff.studies.sweep.dataset import MANIFEST, read_manifest
from pinchoff.support.records import Shape, read_record

SHAPES = ("3", "null", "[]", "{}", '"text"', "[[[", "", "\0", "[" * 100_000, '{"a": NaN}')
"""What no record of ours is."""


def changed(content, name, value):
    """Return a record with one entry, named with dots, set to something else."""
    copy = json.loads(json.dumps(content))
    inside = copy
    *way, last = name.split(".")
    for key in way:
        inside = inside[int(key) if key.isdigit() else key]
    inside[last] = value
    return json.dumps(copy)


def damaged(content, *names):
    """Yield texts: none of them a record, and the record with each entry of another kind."""
    yield from SHAPES
    for name in names:
        value = content
        for key in name.split("."):
            value = value[key]
        for other in ("x", 1, [[]], {"x": 1}):
            kinds = (int, float) if isinstance(value, (int, float)) else type(value)
            if value is not None and not isinstance(other, kinds):
                yield changed(content, name, other)


class Named(Shape):
    name: str
    size: float


def test_a_record_is_what_it_should_be_or_refused(tmp_path, refused):
    path = tmp_path / "a.json"
    path.write_text('{"name": "a", "size": 1, "later": [1]}')
    assert read_record(path, Named, "it", "mend it") == {"name": "a", "size": 1, "later": [1]}
    for text in damaged({"name": "a", "size": 1.0}, "name"):
        path.write_text(text)
        refused(str(path), read_record, path, Named, "it", "mend it")
    path.write_text('{"name": "a", "size": "1"}')
    error = refused(str(path), read_record, path, Named, "it", "mend it")
    assert error.got.startswith("size: ")
    refused(str(tmp_path / "no"), read_record, tmp_path / "no", Named, "it", "mend it")


SWEEP = {
    "design": "sobol",
    "samples": 2,
    "start_distance": 1.0,
    "time_limit": 0.05,
    "vertex_count": 16,
    "vary": {"offset": {"min": 0, "max": 0.3}},
}


def test_sweeps_manifest(tmp_path, refused):
    po.sweep(SWEEP, tmp_path)
    path = tmp_path / MANIFEST
    whole = json.loads(path.read_text())
    for text in damaged(whole, *whole):
        path.write_text(text)
        refused(str(path), read_manifest, tmp_path)
        refused(str(path), po.sweep, SWEEP, tmp_path)
    path.write_text(changed(whole, "count", 10**15))
    refused("out", po.sweep, SWEEP, tmp_path)
    assert main(["film", str(tmp_path), "--out", str(tmp_path / "a.mp4")]) == 2


def test_report_of_a_run(tmp_path, refused, capsys):
    out = tmp_path / "run"
    assert main(["run", "--set", "time_limit=0.1", "--out", str(out)]) == 0
    path = out / "collision.json"
    whole = json.loads(path.read_text())
    for text in damaged(whole, "parameters", "row", "results", "results.contacts"):
        path.write_text(text)
        refused(str(path), po.Collision.load, path)
        assert main(["run", "--out", str(out)]) == 2
    capsys.readouterr()


def test_design_of_a_chamber(tmp_path, refused):
    path = tmp_path / "design.json"
    whole = design_record(Chamber())
    for text in damaged(whole, "parameters"):
        path.write_text(text)
        with pytest.raises(po.InputError):
            read_design(path)


def test_settings_figures_and_numbers_of_a_reproduction(tmp_path, refused, monkeypatch):
    monkeypatch.setattr(make.style, "save", lambda path, axes: path.touch())  # pictures take long
    made = reproduce(tmp_path, only=["2"], quick=True)
    record, settings = tmp_path / "figure_2.json", tmp_path / "settings.json"
    whole, kept = record.read_text(), settings.read_text()
    for text in damaged(json.loads(whole), "how", "seconds"):
        record.write_text(text)
        again = reproduce(tmp_path, only=["2"], quick=True)
        assert again.figures[0].how == made.figures[0].how
        assert json.loads(record.read_text())["how"] == json.loads(whole)["how"]
    for text in damaged(json.loads(kept), *json.loads(kept)):
        settings.write_text(text)
        refused(str(settings), reproduce, tmp_path, only=["2"], quick=True)


@pytest.mark.slow
def test_numbers_of_a_reproduction_are_made_again(tmp_path):
    (tmp_path / "numbers.json").write_text('{"numbers": [{"name": 3}], "seconds": 1}')
    assert len(reproduce(tmp_path, only=["numbers"], quick=True).numbers) > 10


def test_evaluations_of_a_calibration(tmp_path, refused, monkeypatch):
    # What follows the search is in no record of its own.
    monkeypatch.setattr(fitting, "sensitivity_table", lambda *_: pd.DataFrame())
    monkeypatch.setattr(fitting, "match_onset", lambda *_, **__: None)

    def calibrate():
        options = {"points": 3, "width": 0.1, "scan": 6, "evaluations": 1, "grid": 0}
        return po.calibrate("paper-simulation", ["edge_stiffness"], out=tmp_path, **options)

    calibrate()
    path = tmp_path / "evaluations.jsonl"
    head, first, *_ = path.read_text().splitlines()
    whole = json.loads(first)
    for text in [t for t in damaged(whole, *whole) if t.strip()]:
        path.write_text(f"{head}\n{text}\n")
        refused(f"{path}, line 2", calibrate)
    path.write_text(f"{head}\n{changed(whole, 'status', ['bracketed'])}\n")
    refused(f"{path}, line 2", calibrate)
    for text in SHAPES:
        path.write_text(f"{text}\n")
        refused(str(path), calibrate)


def emulsion(folder, **options):
    return po.simulate_emulsion(
        po.Parameters(simulation_capillary_number=20, vertex_count=16),
        time=0.5,
        droplets=[[0, 0, 1]],
        out=folder,
        resume=True,
        **options,
    )


def test_checkpoint_of_an_emulsion(tmp_path, refused):
    emulsion(tmp_path)
    path = tmp_path / "checkpoint.npz"
    with np.load(path) as data:
        header, state = json.loads(str(data["header"])), data["state"]
    for text in damaged(header, "format", "piece", "record"):
        np.savez(path, header=np.array(text), state=state)
        refused(str(path), emulsion, tmp_path)
    huge = np.where(np.arange(len(state)) > 10, 1e18, state)
    for wrong in (state[:-1], state[:12], state[:0], np.full(len(state), np.nan), huge):
        np.savez(path, header=np.array(json.dumps(header)), state=wrong)
        refused(str(path), emulsion, tmp_path)
    for content in (b"", b"PK\3\4", path.read_bytes()[:100]):
        path.write_bytes(content)
        refused(str(path), emulsion, tmp_path)


@pytest.mark.parametrize("text", ["laboratory = 3", "laboratory = []", "laboratory = 'a'"])
def test_settings_of_a_film(tmp_path, capsys, text):
    pytest.importorskip("cv2", reason="the extra 'video' is not installed")
    config = tmp_path / "film.toml"
    config.write_text(f"{text}\n")
    assert main(["video", "a.mp4", "--config", str(config), "--out", str(tmp_path / "out")]) == 2
    assert "laboratory must be a table; got" in capsys.readouterr().err


def test_result_of_a_clip(tmp_path, refused):
    folder = tmp_path / "clip"
    clip_folder = pytest.importorskip(
        "pinchoff.video.clip_folder", reason="the extra 'video' is not installed"
    )
    folder.mkdir()
    whole = {
        "fingerprint": "a",
        "clip": "/a.mp4",
        "files": [["a.mp4", 1, 2]],
        "frames": 3,
        "duration_s": 0.1,
        "overlay_fps": None,
        "tracks": 1,
        "plugs_per_s": None,
        "obstacles": [[1.0, 2.0, 3.0]],
        "method": "rings",
        "scores": {"rings": 1.0},
        "thresholds": {},
        "settings": {"pixel_size_um": 1.0},
        "warning": "",
    }
    path = folder / clip_folder.RESULT
    path.write_text(json.dumps(whole))
    assert clip_folder.read_result(folder) == whole
    for text in damaged(whole, *whole):
        path.write_text(text)
        refused(str(path), clip_folder.read_result, folder)
        assert clip_folder.finished_result(folder, "a") is None
    shutil.rmtree(folder)
