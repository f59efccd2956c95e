"""``pinchoff fit`` and ``pinchoff virtual``: files, numbers, words, refusals."""

from __future__ import annotations

import json
import re

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.cli import main
from pinchoff.collisions.parquet import write_collisions
from pinchoff.explorer.page import is_built

ALWAYS = ["breakup_probability.png", "constant_height.png", "law.json", "report.html"]
ALWAYS += ["separated_outcomes.png", "collisions.parquet"]
ALWAYS += ["explore.html"] if is_built() else []
QUICK = ["--samples", "10"]


@pytest.fixture(scope="module")
def virtual(tmp_path_factory):
    path = tmp_path_factory.mktemp("virtual") / "virtual.parquet"
    write_collisions(po.virtual_experiment(1, 1500, symmetry_noise=0), path)
    return path


def fit(*arguments):
    return main(["fit", *map(str, arguments)])


@pytest.fixture(scope="module")
def fitted(virtual, tmp_path_factory):
    """A folder with a finished fit."""
    out = tmp_path_factory.mktemp("fit") / "law"
    assert fit(virtual, *QUICK, "--out", out) == 0
    return out


def files_in(folder):
    return sorted(path.name for path in folder.iterdir())


def law_in(folder):
    return json.loads((folder / "law.json").read_text(encoding="utf-8"))


def test_numbers_figures_and_page(virtual, tmp_path, capsys):
    out = tmp_path / "new" / "law"
    assert fit(virtual, "--free", "area", "--free", "thickness", *QUICK, "--out", out) == 0
    assert files_in(out) == sorted([*ALWAYS, "laws.csv"])
    law = law_in(out)
    for name in ("alpha", "beta", "w", "epsilon_1", "epsilon_2", "epsilon_3"):
        assert set(law[name]) == {"value", "low", "high", "method"}
        assert law[name]["low"] < law[name]["value"] < law[name]["high"]
        assert law[name]["method"] == "profile likelihood"
    assert set(law["intervals"]) == {"profile likelihood", "delta method", "bootstrap"}
    assert law["synthetic"] is True
    direct = po.fit_law(virtual, free=("area", "thickness"))
    assert law["beta"]["value"] == direct.beta.value
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "95% intervals" in printed.out
    assert all(f"wrote {out / name}" in printed.out for name in ALWAYS)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "synthetic" in page
    assert page.count("data:image/png;base64,") == 3
    assert not re.search(r'(?:src|href)="(?!data:|#|explore\.html)', page)


@pytest.mark.usefixtures("unrendered")
def test_a_table_of_ones_own(tmp_path, capsys):
    table = po.virtual_experiment(2, 600, symmetry_noise=0)
    mine = pd.DataFrame(
        {
            "S_meas": table["symmetry"],
            "outcome": np.where(table["broke"], "broke", "slipped"),
            "A": table["area_um2"] / 1e6,
            "v": table["speed_mm_s"] * 1e3,
            "R": table["obstacle_radius_um"],
            "z": table["thickness_um"],
            "mu": table["viscosity_mPa_s"],
        }
    )
    mine.loc[5, "S_meas"] = 3.0
    mine.loc[6, "outcome"] = None
    mine.to_csv(tmp_path / "mine.csv", index=False)
    names = {"symmetry": "S_meas", "broke": "outcome", "area": "A", "speed": "v"}
    names |= {"obstacle_radius": "R", "thickness": "z", "viscosity": "mu"}
    units = {"area": "mm^2", "speed": "um/s", "obstacle_radius": "um", "thickness": "um"}
    units["viscosity"] = "mPa.s"
    options = [f"--map={name}={column}" for name, column in names.items()]
    options += [f"--unit={name}={unit}" for name, unit in units.items()]
    options += ["--constant=surface_tension=20mN/m", *QUICK]
    assert fit(tmp_path / "mine.csv", *options, "--out", tmp_path / "law") == 0
    law = law_in(tmp_path / "law")
    assert law["synthetic"] is False  # it does not say so any more
    assert law["set_aside"] == {"outcome not known": 1, "symmetry is not from 0 to 2": 1}
    expected = po.fit_law(table.drop(index=[5, 6]))
    assert law["alpha"]["value"] == pytest.approx(expected.alpha.value)
    aside = pd.read_csv(tmp_path / "law" / "set_aside.csv")
    assert aside["row"].tolist() == [6, 7]
    assert "2 of 600 rows are set aside" in capsys.readouterr().err
    assert "symmetry is not from 0 to 2" in (tmp_path / "law" / "report.html").read_text("utf-8")


@pytest.mark.usefixtures("unrendered")
def test_daughters_and_necks_where_there_are_some(tmp_path):
    runs = po.virtual_experiment(3, 60, outcomes="engine", symmetry_noise=0, progress=False)
    write_collisions(runs, tmp_path / "runs.csv")
    assert fit(tmp_path / "runs.csv", *QUICK, "--out", tmp_path / "law") == 0
    assert {"daughter_areas.png", "neck_histograms.png"} <= {*files_in(tmp_path / "law")}


@pytest.mark.usefixtures("unrendered")
def test_separated_outcomes_say_why_there_is_no_width(tmp_path, capsys):
    table = po.virtual_experiment(4, 600, width=0.0, symmetry_noise=0)
    write_collisions(table, tmp_path / "step.parquet")
    assert fit(tmp_path / "step.parquet", "--out", tmp_path / "law") == 0
    law = law_in(tmp_path / "law")
    assert law["w"]["value"] == law["w"]["low"] == 0
    assert "upper bound" in law["w"]["method"]
    assert set(law["missing"]) == {"delta method", "bootstrap", "comparison"}
    assert "w = 0: a line separates" in capsys.readouterr().out
    assert not (tmp_path / "law" / "laws.csv").exists()


@pytest.mark.usefixtures("unrendered")
def test_json_alone(virtual, tmp_path, capsys):
    assert fit(virtual, *QUICK, "--json", "--out", tmp_path / "law") == 0
    assert json.loads(capsys.readouterr().out) == law_in(tmp_path / "law")


@pytest.mark.usefixtures("unrendered")
def test_an_end_that_is_not_there_is_null(tmp_path):
    """Some collisions bound β on one side only; JSON has no infinity."""
    table = po.virtual_experiment(1, 3000, symmetry_noise=0)
    broke = table[table["broke"].astype(bool)].head(2)
    few = pd.concat([broke, table[~table["broke"].astype(bool)].head(14)])
    write_collisions(few, tmp_path / "few.parquet")
    assert fit(tmp_path / "few.parquet", *QUICK, "--out", tmp_path / "law") == 0
    law = law_in(tmp_path / "law")
    ends = [law[name][end] for name in ("alpha", "beta", "w") for end in ("low", "high")]
    assert None in ends


@pytest.mark.usefixtures("unrendered")
def test_results_are_not_overwritten_unasked(virtual, fitted, capsys, refusal):
    arguments = [virtual, *QUICK, "--out", fitted]
    before = (fitted / "law.json").read_bytes()
    capsys.readouterr()
    assert refusal("fit", *arguments)["argument"] == "--out"
    assert fit(*arguments, "--overwrite", "--confidence", "2") == 2
    assert (fitted / "law.json").read_bytes() == before
    assert fit(*arguments, "--overwrite") == 0
    assert (fitted / "law.json").read_bytes() == before


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        (["--map", "symmetry"], "--map"),
        (["--map", "symmetry=nothing"], "--map symmetry"),
        (["--map", "size=symmetry"], "--map size"),
        (["--map", "symmetry=symmetry", "--map", "symmetry=broke"], "--map symmetry"),
        (["--unit", "area=litre"], "--unit area"),
        (["--constant", "viscosity=48"], "--constant viscosity"),
        (["--free", "colour"], "--free"),
        (["--free", "surface_tension"], "TABLE"),
        (["--confidence", "95"], "--confidence"),
        (["--symmetry-noise", "-1"], "--symmetry-noise"),
        (["--samples", "1"], "--samples"),
        (["--fraction", "1"], "--fraction"),
    ],
)
def test_wrong_options_are_refused_by_name(virtual, tmp_path, refusal, options, argument):
    assert refusal("fit", virtual, *options, "--out", tmp_path / "law")["argument"] == argument
    assert not list(tmp_path.glob("law/*.*"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["fit"], "TABLE must be given; got nothing"),
        (["fit", "x", "--samples", "many"], "--samples must be a whole number; got many"),
        (["fit", "x", "--fraction=half"], "--fraction must be a number; got half"),
        (["fit", "x", "--seed"], "--seed must be followed by a value; got nothing"),
        (["virtual", "--engine=3"], "--engine must be given without a value; got 3"),
        (["sweep"], "CONFIG must be given; got nothing"),
    ],
)
def test_what_the_parser_does_not_understand(capsys, arguments, message):
    assert main(arguments) == 2
    see = f"see pinchoff {arguments[0]} --help"
    assert capsys.readouterr().err == f"error: {message}; {see}\n"


def test_files_that_are_none_are_refused(tmp_path, capsys):
    assert fit(tmp_path / "no.csv") == 2
    assert "no.csv must be a readable table" in capsys.readouterr().err


def test_virtual_writes_a_table_that_fit_reads(tmp_path, capsys):
    path = tmp_path / "virtual.csv"
    arguments = ["virtual", "--rows", "300", "--seed", "7", "--out", str(path)]
    assert main(arguments) == 0
    assert "300 synthetic collisions" in capsys.readouterr().out
    table = pd.read_csv(path)
    assert table["source"].str.startswith("synthetic").all()
    assert table["symmetry"].to_numpy() == pytest.approx(po.virtual_experiment(7, 300)["symmetry"])
    assert main(arguments) == 2
    assert "--out must be a new file" in capsys.readouterr().err
    arguments[arguments.index("300")] = "10"
    assert main([*arguments, "--overwrite", "--engine"]) == 0
    assert pd.read_csv(path)["neck_um"].notna().any()


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        (["--rows", "0"], "--rows"),
        (["--seed", "-1"], "--seed"),
        (["--symmetry-noise", "3"], "--symmetry-noise"),
        (["--out", "table.txt"], "--out"),
        (["--out", "no/table.csv"], "--out"),
    ],
)
def test_virtual_refuses_by_name(tmp_path, monkeypatch, refusal, options, argument):
    monkeypatch.chdir(tmp_path)
    assert refusal("virtual", *options)["argument"] == argument
    assert not list(tmp_path.iterdir())


def test_virtual_simulates_in_another_reading_of_ca(tmp_path, capsys):
    """As the library does with such parameters; without the engine they mean nothing."""
    out = tmp_path / "film.parquet"
    reading = {"ca_conversion": "fixed-film", "ca_speed": "contact"}
    given = [text for name, value in reading.items() for text in ("--set", f"{name}={value}")]
    words = ["virtual", "--engine", "--rows", "12", "--symmetry-noise", "0", "--out", str(out)]
    assert main([*words, *given]) == 0
    base = po.Parameters(**reading)
    options = {"outcomes": "engine", "symmetry_noise": 0, "progress": False}
    expected = po.virtual_experiment(1, 12, base=base, **options)
    table = po.read_collisions(out)
    np.testing.assert_array_equal(table["capillary_number"], expected["capillary_number"])
    plain = po.virtual_experiment(1, 12, **options)
    assert (plain["capillary_number"] != expected["capillary_number"]).any()
    capsys.readouterr()
    assert main(["virtual", *given, "--out", str(tmp_path / "none.parquet")]) == 2
    assert "left out without --engine" in capsys.readouterr().err
