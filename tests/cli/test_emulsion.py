"""``pinchoff emulsion``: the page it writes, going on after a stop, and what it refuses."""

from __future__ import annotations

import json

import pytest

from pinchoff.cli import main

pytest.importorskip("skfem", reason="its extra is not installed")

CONFIG = """
time = 12
smallest_breaking = 0.3
[parameters]
simulation_capillary_number = 60
vertex_count = 32
[array]
kind = "staggered"
rows = 2
columns = 2
radius = 0.3
gap = 1.0
before = 3
behind = 2
[flow]
thickness = 0.5
[inlet]
area_fraction = 0.3
"""


def run(folder, text):
    (folder / "config.toml").write_text(text)
    return main(["emulsion", str(folder / "config.toml"), "--out", str(folder / "out")])


@pytest.mark.usefixtures("unrendered")
def test_the_page_has_every_figure_and_a_second_run_goes_on(tmp_path):
    assert run(tmp_path, CONFIG) == 0
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.count("<figure>") == 7
    report = json.loads((tmp_path / "out" / "emulsion.json").read_text())
    assert report["balance"]["entered"] > 5
    assert report["trust"]["slip"] > 0
    assert run(tmp_path, CONFIG.replace("time = 12", "time = 14")) == 0
    assert json.loads((tmp_path / "out" / "emulsion.json").read_text())["time"] == 14


@pytest.mark.slow
def test_a_run_that_a_guard_ends_has_its_page_which_says_so(tmp_path, capsys):
    """Pillars thinner than the spacing of the vertices: they pass between two of them."""
    coarse = CONFIG.replace("vertex_count = 32", 'vertex_count = 16\nmodel = "deformable-particle"')
    coarse = coarse.replace("thickness = 0.5", "thickness = inf")  # no line of a pillar alone
    coarse = coarse.replace("radius = 0.3", "radius = 0.03").replace("time = 12", "time = 6")
    assert run(tmp_path, 'on_guard = "stop"\n' + coarse) == 0
    said = capsys.readouterr().err
    assert "warning: a guard ended the run at t = " in said
    assert "warning: Errors were not measured, because" in said
    page = (tmp_path / "out" / "index.html").read_text()
    assert "A guard ended the run at t = " in page
    assert "It was to take 6 t0" in page
    assert "Guards took out 1 droplet" in page
    report = json.loads((tmp_path / "out" / "emulsion.json").read_text())
    assert report["stopped"]
    assert report["time"] < 6
    # The same file without that line goes on from there.
    assert run(tmp_path, coarse) == 0
    report = json.loads((tmp_path / "out" / "emulsion.json").read_text())
    assert not report["stopped"]
    assert report["time"] == 6


def test_a_run_too_short_for_sizes_has_its_page_which_says_so(tmp_path, capsys):
    assert run(tmp_path, CONFIG.replace("time = 12", "time = 0.05")) == 0
    assert "not measured, because" in capsys.readouterr().err
    assert "not measured, because" in (tmp_path / "out" / "index.html").read_text()


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('kind = "staggered"', 'kind = "stagered"', "array.kind must be"),
        ("rows = 2", "rows = 0", "array.rows must be"),
        ("radius = 0.3", 'radius = "85 um"', "array.radius must be"),
        ("thickness = 0.5", "thickness = -1", "flow.thickness must be"),
        ("area_fraction = 0.3", "area_fraction = 2", "inlet.area_fraction must be"),
        ("before = 3", "before = 0", "array.before must be"),
        ("time = 12", "times = 12", "times must be"),
        ("time = 12", 'time = 12\non_guard = "go"', "on_guard must be"),
        ("vertex_count = 32", "vertex_cout = 32", "parameters.vertex_cout must be"),
    ],
)
def test_a_wrong_key_is_named(tmp_path, capsys, old, new, named):
    assert run(tmp_path, CONFIG.replace(old, new)) == 2
    assert f"error: {named}" in capsys.readouterr().err


def test_physical_units_give_the_same_run(tmp_path):
    from pinchoff.chamber.emulsion_design import EmulsionDesign
    from pinchoff.support.files import read_toml

    (tmp_path / "c.toml").write_text(CONFIG)
    table = read_toml(tmp_path / "c.toml")
    plain = EmulsionDesign.from_config(table)
    del table["parameters"]["simulation_capillary_number"]
    table["array"] |= {"radius": "150 um", "gap": "0.5 mm"}
    table["physical"] = {
        "diameter": "500 um",
        "speed": "1 mm/s",
        "viscosity": "117.6 mPa s",
        "surface_tension": "20 mN/m",
    }
    physical = EmulsionDesign.from_config(table)
    assert physical.array.circles == pytest.approx(plain.array.circles)
    number = physical.parameters.simulation_capillary_number
    assert number == pytest.approx(plain.parameters.simulation_capillary_number)


SHORT = CONFIG.replace("time = 12", "time = 9")


@pytest.mark.usefixtures("unrendered")
def test_a_sweep_writes_a_folder_a_run_and_a_table(tmp_path):
    import pandas as pd

    text = SHORT + "\n[sweep]\nseed = [1, 2]\n"
    assert run(tmp_path, text) == 0
    table = pd.read_csv(tmp_path / "out" / "sweep.csv")
    assert table["seed"].tolist() == [1, 2]
    assert table["mean_diameter"].between(0.3, 1.01).all()
    page = (tmp_path / "out" / "index.html").read_text()
    for folder in table["folder"]:
        assert (tmp_path / "out" / folder / "index.html").is_file()
        assert f"{folder}/index.html" in page
    before = (tmp_path / "out" / "run-0001" / "checkpoint.npz").read_bytes()
    assert run(tmp_path, text) == 0
    assert (tmp_path / "out" / "run-0001" / "checkpoint.npz").read_bytes() == before


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """Return the folder of a run with its film."""
    pytest.importorskip("av", reason="its extra is not installed")
    folder = tmp_path_factory.mktemp("filmed")
    (folder / "config.toml").write_text(SHORT)
    arguments = ["emulsion", str(folder / "config.toml"), "--out", str(folder / "out")]
    assert main([*arguments, "--movie"]) == 0
    return folder / "out"


def test_the_film_shows_every_frame_of_the_whole_cell(filmed):
    import av
    import numpy as np

    with av.open(str(filmed / "movie.mp4")) as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(pictures) == 19
    assert pictures[0].shape[1] == 1280
    # What moves is seen, and the pillars stay.
    moved = np.abs(pictures[-1].astype(int) - pictures[4].astype(int)).max(axis=2) > 60
    assert 0.02 < moved.mean() < 0.6


def test_a_film_without_outlines_is_refused_before_anything_runs(tmp_path, capsys):
    (tmp_path / "config.toml").write_text("outlines = false\n" + SHORT)
    arguments = ["emulsion", str(tmp_path / "config.toml"), "--out", str(tmp_path / "out")]
    assert main([*arguments, "--movie"]) == 2
    assert "error: --movie must be" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_events_and_sizes_are_one_table_each(filmed):
    import pandas as pd

    for name in ("events", "sizes"):
        whole = pd.read_parquet(filmed / f"{name}.parquet")
        pieces = [pd.read_parquet(path) for path in sorted(filmed.glob(f"{name}-*.parquet"))]
        assert len(pieces) > 0
        assert len(whole) > 5
        pd.testing.assert_frame_equal(whole, pd.concat(pieces, ignore_index=True))


def test_contacts_can_be_fitted_and_explored(filmed):
    import pinchoff as po
    from pinchoff.explorer.page import is_built

    table = po.read_collisions(filmed / "collisions.parquet")
    assert len(table) > 5
    assert (filmed / "explore.html").is_file() == is_built()
    assert ('href="explore.html"' in (filmed / "index.html").read_text()) == is_built()
