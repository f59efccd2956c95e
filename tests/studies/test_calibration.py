"""Calibration: what its targets measure, that known constants come back, and that it resumes."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.law import Line
from pinchoff.studies.calibration import evaluation, fitting
from pinchoff.studies.calibration.conversions import head_on_onset, match_onset
from pinchoff.studies.calibration.evaluation import Evaluation, critical_symmetry_of
from pinchoff.studies.calibration.sensitivity import sensitivity_table
from pinchoff.studies.calibration.targets import PRESETS, as_target

CONTROL = np.geomspace(0.04, 0.2, 6)
COARSE = po.Parameters(vertex_count=48)
QUICK = {"points": 3, "width": 0.02, "scan": 8, "progress": False}


@pytest.fixture
def search_only(monkeypatch):
    """Leave out what follows the search."""
    monkeypatch.setattr(fitting, "sensitivity_table", lambda *_: pd.DataFrame())
    monkeypatch.setattr(fitting, "match_onset", lambda *_, **__: None)


def collisions(line, width, count=4000, seed=0):
    """Collisions whose outcome is drawn from a logistic transition across a line, in ln S."""
    rng = np.random.default_rng(seed)
    control = np.exp(rng.uniform(math.log(0.02), math.log(0.3), count))
    symmetry = rng.uniform(0.05, 1, count)
    above = np.log(symmetry) - np.log(line.alpha * control**line.beta)
    return pd.DataFrame(
        {
            "symmetry": symmetry,
            "capillary_number": control / 25,
            "normalized_area": 25.0,
            "normalized_thickness": 1.0,
            "broke": rng.uniform(size=count) < 1 / (1 + np.exp(-above / width)),
        }
    )


@pytest.fixture(scope="module")
def soft():
    """The fitted line of softer edges than the default's."""
    ca = CONTROL[[0, 2, 5]] / (9.8e-5 * po.Parameters().normalized_area)
    vary = {"simulation_capillary_number": ca.tolist()}
    base = po.Parameters(edge_stiffness=2.4)
    return po.boundary(base, vary, width=0.005, scan=8, progress=False).fit().line


# Targets


def test_a_line_is_at_no_distance_from_itself():
    target = PRESETS["paper-simulation"]
    assert target.loss(CONTROL, 0.089 * CONTROL**-0.72) == pytest.approx(0, abs=1e-12)
    assert target.loss(CONTROL, 0.089 * CONTROL**-0.72 * math.exp(0.1)) == pytest.approx(0.1)


def test_the_onset_of_a_line_is_where_it_meets_one():
    onset, low, high = PRESETS["paper-experiment"].onset()
    assert 0.083 * onset**-0.74 == pytest.approx(1)
    assert low == onset == high


def test_the_onset_of_collisions_comes_back_within_its_interval():
    truth = 0.089 ** (1 / 0.72)
    hits = 0
    for seed in range(40):
        value, low, high = po.CollisionsTarget(
            collisions(Line(0.089, -0.72), 0.1, seed=seed)
        ).onset()
        assert value == pytest.approx(truth, rel=0.05)
        hits += low <= truth <= high
    assert hits >= 34


def test_collisions_prefer_the_line_that_they_were_drawn_from():
    target = po.CollisionsTarget(collisions(Line(0.089, -0.72), 0.1))
    own = 0.089 * CONTROL**-0.72
    wide = np.geomspace(*target.control_range, 20)
    losses = [target.loss(wide, 0.089 * wide**-0.72 * math.exp(k)) for k in (-0.1, 0, 0.1)]
    assert losses[1] < min(losses[0], losses[2])
    assert target.loss(CONTROL, 0.5 * own) > 2 * losses[1]


def test_the_loss_of_collisions_is_the_cross_entropy_of_the_true_transition():
    table = collisions(Line(0.089, -0.72), 0.1)
    target = po.CollisionsTarget(table)
    wide = np.geomspace(0.02, 0.3, 50)
    control = table["capillary_number"] * table["normalized_area"]
    chance = 1 / (1 + (0.089 * control**-0.72 / table["symmetry"]) ** 10)
    right = np.where(table["broke"], chance, 1 - chance)
    assert target.loss(wide, 0.089 * wide**-0.72) == pytest.approx(-np.log(right).mean(), rel=0.02)


def test_separated_collisions_have_no_onset_of_their_own():
    table = collisions(Line(0.089, -0.72), 0.1)
    control = table["capillary_number"] * table["normalized_area"]
    table["broke"] = table["symmetry"] > 0.089 * control**-0.72
    assert po.CollisionsTarget(table).onset() is None


def test_rows_without_the_numbers_are_left_out():
    table = collisions(Line(0.089, -0.72), 0.1, count=100)
    table.loc[:9, "symmetry"] = math.nan
    table.loc[10:14, "symmetry"] = 0
    table["accepted"] = table.index < 90
    with pytest.warns(UserWarning, match="20 of 100 rows are set aside"):
        assert po.CollisionsTarget(table).count == 75


def test_a_table_is_read_as_a_fit_reads_it(tmp_path):
    """Columns with units, symmetries above 1 and words for the outcome are the same to both."""
    table = collisions(Line(0.089, -0.72), 0.1, count=200)
    plain = po.CollisionsTarget(table)
    other = pd.DataFrame(
        {
            "capillary_number": table["capillary_number"],
            "area_mm2": table["normalized_area"] * 0.085**2,
            "obstacle_radius_um": 85.0,
            "normalized_thickness": table["normalized_thickness"],
            "symmetry": np.where(table.index % 2, table["symmetry"], 2 - table["symmetry"]),
            "broke": np.where(table["broke"], "yes", "slipped"),
        }
    )
    path = tmp_path / "other.csv"
    other.to_csv(path, index=False)
    imported = po.import_collisions(path)
    for target in (as_target(path), po.CollisionsTarget(other), as_target(imported)):
        assert target.count == plain.count == po.fit_law(imported).count
        assert target.size_ratio == pytest.approx(plain.size_ratio)
        assert target.control_range == pytest.approx(plain.control_range)
        assert target.onset() == pytest.approx(plain.onset(), rel=1e-6)


def test_the_size_of_collisions_is_their_median():
    table = collisions(Line(0.089, -0.72), 0.1, count=99)
    table["normalized_area"] = np.pi / 4 * np.linspace(3, 7, 99) ** 2
    assert po.CollisionsTarget(table).size_ratio == pytest.approx(5)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_collisions_from_a_file(tmp_path, suffix):
    table = collisions(Line(0.089, -0.72), 0.1, count=200)
    path = tmp_path / f"collisions.{suffix}"
    table.to_csv(path) if suffix == "csv" else table.to_parquet(path)
    target = as_target(path)
    assert target.settings()["digest"] == po.CollisionsTarget(table).settings()["digest"]
    assert target.name == path.name


def test_wrong_targets_are_refused(refused, tmp_path):
    table = collisions(Line(0.089, -0.72), 0.1, count=100)
    refused("target", as_target, "paper-simulatoin")
    refused("target", as_target, 3)
    refused("target.symmetry", as_target, table.drop(columns="symmetry"))
    refused("target", as_target, table[:10])
    refused("target", as_target, table.assign(broke=True))
    refused("target", as_target, table.assign(capillary_number=0.004))
    refused("target.broke", as_target, table.assign(broke="perhaps"))
    refused(str(tmp_path / "no.csv"), as_target, tmp_path / "no.csv")
    (tmp_path / "no.parquet").write_text("symmetry", encoding="utf-8")
    refused(str(tmp_path / "no.parquet"), as_target, str(tmp_path / "no.parquet"))
    refused("alpha", po.LineTarget, -0.1, -0.7)
    refused("beta", po.LineTarget, 0.1, 0.7)
    for wrong in ((0.2, 0.1), ("a", "b"), 0.1):
        refused("control_range", po.LineTarget, 0.1, -0.7, wrong)
    refused("size_ratio", po.LineTarget, 0.1, -0.7, size_ratio="large")


# Evaluator


def runs(symmetry, broke, necks=0.3):
    offset = np.arange(len(symmetry)) / 10
    columns = {"symmetry": symmetry, "broke": broke, "offset": offset, "minimum_neck": necks}
    return pd.DataFrame(columns).astype({"broke": "boolean"})


@pytest.mark.parametrize(
    ("table", "critical"),
    [
        (runs([1.0, 0.8, 0.6, 0.4], [True, True, False, False]), 0.7),
        (runs([1.0, 0.8, 0.6, 0.4], [False, True, False, False]), 0.7),
        (runs([1.0, 0.8, 0.06], [True, True, True]), 0.03),
        (runs([1.0, 0.8, 1e-6], [True, True, True]), 0.01),
        (runs([1.0, 0.8, 0.6, math.nan], [True, None, False, False]), 0.8),
        (runs([1.0, 0.8], [False, False]), 1.5),
        (runs([1.0, 0.8], [False, False], necks=0.1), 1.0),
        (runs([1.0, 0.8], [None, False]), math.nan),
        (runs([1.0, 0.8], [False, False], necks=1e308), math.nan),
    ],
)
def test_every_outcome_of_a_search_is_a_number(table, critical):
    assert critical_symmetry_of(table, 0.2) == pytest.approx(critical, nan_ok=True)


# The search


def test_known_constants_come_back(soft, search_only):
    found = po.calibrate(soft, {"edge_stiffness": (1.5, 5)}, evaluations=14, **QUICK)
    assert found.best.changes["edge_stiffness"] == pytest.approx(2.4, rel=0.03)
    assert found.best.objective < 0.5 * found.start.objective
    assert found.parameters.edge_stiffness == found.best.changes["edge_stiffness"]
    assert found.at_bound == []


def test_a_known_conversion_comes_back(soft, search_only):
    """Ca is 1.25 times as large at equal Ca_sim: the line moves to larger x by that much."""
    moved = Line(soft.alpha * 1.25**-soft.beta, soft.beta)
    base = po.Parameters(edge_stiffness=2.4)
    target = po.LineTarget(*moved, control_range=(0.05, 0.25))
    found = po.calibrate(target, ["conversion"], base, evaluations=14, **QUICK)
    assert found.best.changes["conversion"] == pytest.approx(1.25 * 9.8e-5, rel=0.03)


def test_simulated_collisions_give_their_constants_back(search_only):
    rng = np.random.default_rng(3)
    base = COARSE.replace(edge_stiffness=2.4, follow_daughters=False)
    drawn = zip(rng.uniform(16, 80, 300), rng.uniform(0, 0.25, 300), strict=True)
    table = po.simulate_many(
        [base.replace(simulation_capillary_number=ca, offset=y) for ca, y in drawn], progress=False
    )
    found = po.calibrate(table, {"edge_stiffness": (1.5, 5)}, COARSE, evaluations=14, **QUICK)
    assert found.best.changes["edge_stiffness"] == pytest.approx(2.4, rel=0.1)


def test_a_search_ends_at_a_bound_and_says_so(soft, search_only):
    """1.1·e^(ln 1.5 - ln 1.1) and the like round to beyond a bound, which the model may refuse."""
    base = po.Parameters(neck_separation_unit="diameter", neck_separation=1.2, edge_stiffness=4)
    found = po.calibrate(soft, {"edge_stiffness": (3.1, 4.5)}, base, evaluations=14, **QUICK)
    assert found.at_bound == ["edge_stiffness"]
    assert 3.1 <= found.evaluations["edge_stiffness"].min() < 3.11
    assert found.evaluations["edge_stiffness"].max() <= 4.5


def test_constants_that_do_not_go_together_are_passed_by(search_only):
    """A neck thickness that breaks a round droplet is refused by the model, not by the search."""
    literal = po.Parameters.preset("literal-separation", neck_thickness=0.26)
    found = po.calibrate(
        "paper-simulation", {"neck_thickness": (0.25, 0.5)}, literal, evaluations=6, **QUICK
    )
    assert (found.evaluations["objective"] == evaluation.UNDECIDED).any()
    assert found.best.objective < evaluation.UNDECIDED
    assert found.parameters.neck_thickness < 0.2764


def test_a_search_that_was_cut_short_says_so(search_only):
    found = po.calibrate("paper-simulation", ["neck_thickness"], evaluations=2, **QUICK)
    assert not found.converged
    assert len(found.evaluations) == 2


def test_a_search_is_taken_up(tmp_path, search_only, monkeypatch):
    def again():
        free = {"edge_stiffness": (2, 5)}
        more = {"evaluations": 6, "out": tmp_path, "grid": 0, **QUICK}
        return po.calibrate("paper-simulation", free, COARSE, **more)

    first = again()
    log = tmp_path / fitting.LOG
    complete = log.read_bytes()
    log.write_bytes(b"".join(complete.splitlines(keepends=True)[:4]))
    assert again().best.changes == first.best.changes
    assert log.read_bytes() == complete
    monkeypatch.setattr(evaluation, "boundary", None)  # nothing is left to simulate
    assert again().best.to_dict() == first.best.to_dict()


def test_evaluations_of_other_settings_are_refused(tmp_path, search_only, refused):
    options = {**QUICK, "evaluations": 1, "out": tmp_path}
    log = tmp_path / fitting.LOG
    po.calibrate("paper-simulation", ["edge_stiffness"], **options)
    before = log.read_bytes()
    for target, free, more in (
        ("paper-experiment", ["edge_stiffness"], {}),
        ("paper-simulation", ["neck_thickness"], {}),
        ("paper-simulation", ["edge_stiffness"], {"scan": 9}),
        ("paper-simulation", ["edge_stiffness"], {"base": po.Parameters(line_tension=60)}),
    ):
        refused(str(log), po.calibrate, target, free, **{**options, **more})
    assert log.read_bytes() == before
    log.write_text("something else", encoding="utf-8")
    refused(str(log), po.calibrate, "paper-simulation", ["edge_stiffness"], **options)


@pytest.mark.parametrize(
    ("argument", "change"),
    [
        ("free", {"free": ["vertex_count"]}),
        ("free", {"free": ["edge_stifness"]}),
        ("free", {"free": "edge_stiffness"}),
        ("free", {"free": []}),
        ("free['edge_stiffness']", {"free": {"edge_stiffness": (4, 2)}}),
        ("free['edge_stiffness']", {"free": {"edge_stiffness": (4, 5)}}),
        ("free.neck_separation", {"free": {"neck_separation": (0.1, 0.6)}}),
        ("base", {"base": "default"}),
        ("points", {"points": 2}),
        ("evaluations", {"evaluations": 0}),
        ("grid", {"grid": 1}),
        ("width", {"width": 0}),
        ("threads", {"threads": 0}),
    ],
)
def test_wrong_input_is_refused(refused, argument, change):
    refused(argument, po.calibrate, "paper-simulation", **{**QUICK, **change})


# The conversion


@pytest.mark.slow
def test_the_onset_parts_head_on_droplets():
    low, high = head_on_onset(po.Parameters())
    assert 1 < high / low < 1.003
    outcomes = [
        po.simulate(po.Parameters(simulation_capillary_number=ca, offset=0, time_limit=100)).broke
        for ca in (low, high)
    ]
    assert outcomes == [False, True]


def test_the_conversion_puts_one_onset_on_the_other(monkeypatch):
    monkeypatch.setattr(
        "pinchoff.studies.calibration.conversions.head_on_onset",
        lambda model, **_: (15.9, 16.1) if model.vertex_count == 64 else (14.9, 15.1),
    )
    model = po.Parameters()
    found = match_onset(PRESETS["paper-simulation"], model)
    onset = 0.089 ** (1 / 0.72)
    scale = model.normalized_area
    assert found.value == pytest.approx(onset / scale / 16, rel=1e-4)
    assert found.low == pytest.approx(onset / scale / 16.1)
    assert found.high == pytest.approx(onset / scale / 14.9)


def test_stiff_edges_have_no_onset_to_match(monkeypatch):
    name = "pinchoff.studies.calibration.conversions.head_on_onset"
    monkeypatch.setattr(name, lambda *_, **__: None)
    assert match_onset(PRESETS["paper-simulation"], po.Parameters()) is None


@pytest.mark.parametrize("critical", [[math.nan, math.nan], [math.nan, 0.4]])
def test_sensitivities_that_no_run_decides_are_not_numbers(critical):
    class Undecided:
        def parameters(self, changes):
            return po.Parameters()

        def __call__(self, changes):
            return Evaluation(changes, 10.0, np.array(critical), ("unresolved",) * 2, 4, 4)

    evaluator = Undecided()
    table = sensitivity_table(evaluator, evaluator({}))
    assert table["mean"].dtype == table["largest"].dtype == np.float64
    assert table["mean"].isna().all()
    assert table["largest"].isna().all()
