"""Sizes of an emulsion: against a solvable process, and against data whose errors are known."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

import pinchoff as po
from pinchoff.collisions.law import breakup_number
from pinchoff.studies.block_errors import correlation_time, jackknife
from pinchoff.studies.emulsion_contacts import contact_outcomes
from pinchoff.studies.emulsion_sizes import study_sizes
from pinchoff.studies.lineage import ancestors, lineage, origins

NO_EVENTS = pd.DataFrame({"time": [], "kind": []})


def merging_and_breaking(seed, *, kernel, rate, volume, fraction, events):
    """Draw a population that merges (K for each pair) and breaks (S v, uniform daughters)."""
    rng = np.random.default_rng(seed)
    start = math.sqrt(kernel * fraction / (2 * rate))
    count = round(fraction * volume / start)
    v = np.zeros(8 * count)
    v[:count] = fraction * volume / count
    time, frames, happened = 0.0, [], []
    breaking = rate * fraction * volume  # the sum of S v over all droplets, which is conserved
    for step in range(events):
        merging = kernel * count * (count - 1) / (2 * volume)
        time += rng.exponential(1 / (merging + breaking))
        if rng.random() * (merging + breaking) < merging:
            i, j = rng.choice(count, 2, replace=False) if count < 3 else _pair(rng, count)
            v[i] += v[j]
            v[j] = v[count - 1]
            count -= 1
            happened.append((time, "merge"))
        else:
            i = np.searchsorted(np.cumsum(v[:count]), rng.random() * v[:count].sum())
            part = rng.random() * v[i]
            v[count], v[i] = part, v[i] - part
            count += 1
            happened.append((time, "breakup"))
        if step % (count // 4) == 0:
            frames.append((time, v[:count].copy()))
    sizes = pd.DataFrame(
        {
            "time": np.concatenate([np.full(len(areas), t) for t, areas in frames]),
            "diameter": np.sqrt(4 / math.pi * np.concatenate([areas for _, areas in frames])),
        }
    )
    return sizes, pd.DataFrame(happened, columns=["time", "kind"])


def _pair(rng, count):
    i, j = rng.integers(count), rng.integers(count - 1)
    return i, j + (j >= i)


def test_constant_kernel_and_uniform_daughters_give_an_exponential_distribution():
    kernel, rate, fraction = 2.0, 0.5, 0.3
    sizes, events = merging_and_breaking(
        3, kernel=kernel, rate=rate, volume=2000.0, fraction=fraction, events=120_000
    )
    residence = 1.0 / math.sqrt(kernel * fraction * rate / 2)
    study = study_sizes(
        sizes, events, start=0.1 * sizes["time"].max(), residence_time=residence, bins=16
    )
    mean = math.sqrt(kernel * fraction / (2 * rate))
    assert study.mean_area.value == pytest.approx(mean, rel=0.02)
    assert study.dispersity.value == pytest.approx(2.0, rel=0.02)
    assert abs(study.mean_area.value - mean) < 4 * study.mean_area.error
    # The whole distribution: P(d) d(d) = exp(-v/<v>) dv/<v> with v = pi d^2 / 4.
    volumes = math.pi / 4 * study.edges**2
    expected = -np.diff(np.exp(-volumes / mean)) / np.diff(study.edges)
    heavy = expected > 0.1
    assert np.allclose(study.by_number[heavy, 0], expected[heavy], rtol=0.05)
    pulls = (study.by_number[heavy, 0] - expected[heavy]) / study.by_number[heavy, 1]
    assert np.sqrt(np.mean(pulls**2)) < 2.5
    # The rates are the process's own, and balance.
    total = rate * fraction * 2000.0
    assert study.rates["breakup"].value == pytest.approx(total, rel=0.02)
    assert study.rates["merge"].value == pytest.approx(total, rel=0.02)
    assert abs(study.growth.value) < 3 * study.growth.error
    assert study.exchange.value == pytest.approx(1.0, abs=3 * study.exchange.error)


def test_correlation_time_is_that_of_an_autoregressive_series():
    rng, keep = np.random.default_rng(1), 0.9
    values = np.zeros(200_000)
    for k in range(1, len(values)):
        values[k] = keep * values[k - 1] + rng.normal()
    expected = 0.1 * (0.5 + keep / (1 - keep))
    found = correlation_time(0.1 * np.arange(len(values)), values)
    assert found == pytest.approx(expected, rel=0.05)


def test_errors_from_blocks_are_those_of_repeated_runs():
    found = []
    for seed in range(60):
        blocks = np.random.default_rng(seed).normal(3.0, 1.0, (20, 1))
        ones = np.concatenate([blocks, np.ones((20, 1))], axis=1)
        found.append(jackknife(ones, lambda s: s[0] / s[1]))
    values, errors = np.array(found).T
    assert np.mean(errors) == pytest.approx(1 / math.sqrt(20), rel=0.1)
    assert np.std(values) == pytest.approx(np.mean(errors), rel=0.3)


def test_rates_are_events_over_the_time_in_which_they_were_counted():
    """The first frame that is kept is later than half the run."""
    sizes = pd.DataFrame({"time": np.arange(22.0), "diameter": 1.0})
    moments = np.arange(0.05, 21.0, 0.1)
    study = study_sizes(sizes, pd.DataFrame({"time": moments, "kind": "entered"}))
    assert (study.start, study.end) == (10.5, 21.0)
    assert study.rates["entered"].value == pytest.approx(10.0)
    assert study.growth.value == pytest.approx(10.0)


def test_too_few_blocks_give_no_error():
    assert math.isnan(jackknife(np.ones((4, 1)), lambda s: s[0]).error)


def noisy_sizes(drift, seed=0):
    """Return a through-flow of 100 droplets, each present for 10 t0, whose size may drift."""
    rng = np.random.default_rng(seed)
    times = np.repeat(np.arange(0.0, 200.0), 100)
    sizes = pd.DataFrame(
        {"time": times, "diameter": rng.uniform(0.5, 1.0, len(times)) * (1 + drift * times)}
    )
    moments = np.arange(0.0, 200.0, 0.1)
    kinds = np.tile(["entered", "left"], len(moments))
    return sizes, pd.DataFrame({"time": np.repeat(moments, 2), "kind": kinds})


def test_steady_sizes_are_called_steady_and_drifting_ones_are_not():
    calm = study_sizes(*noisy_sizes(0.0))
    assert calm.residence_time == pytest.approx(10.0, rel=0.02)
    assert calm.rates["left"].value == pytest.approx(10.0, rel=0.02)
    assert calm.steady is True
    drifting = study_sizes(*noisy_sizes(-0.002))
    assert drifting.steady is False
    assert drifting.trend.value < 0


def test_a_run_that_gains_droplets_is_not_steady():
    sizes, events = noisy_sizes(0.0)
    extra = events[events["kind"] == "entered"].assign(kind="breakup").iloc[::5]
    assert study_sizes(sizes, pd.concat([events, extra])).steady is False


def test_a_short_run_says_that_it_is_too_short():
    sizes, events = noisy_sizes(0.0)
    short = study_sizes(sizes[sizes["time"] < 20], events[events["time"] < 20])
    assert short.steady is None
    assert any("steady was not measured" in remark for remark in short.remarks)


def test_what_few_frames_cannot_tell_is_not_a_number_and_said():
    sizes = pd.DataFrame({"time": [0.0, 1.0, 1.0], "diameter": [1.0, 1.0, 2.0]})
    study = study_sizes(sizes, NO_EVENTS, start=0.0)
    assert study.mean_diameter.value == pytest.approx(4 / 3)
    assert study.rates["breakup"].value == 0.0
    assert str(study.mean_diameter) == "1.333, error not measured"
    assert any(remark.startswith("Errors were not measured") for remark in study.remarks)
    one = study_sizes(sizes, NO_EVENTS)
    assert (one.mean_diameter.value, str(one.rates["left"])) == (1.5, "not measured")
    none = study_sizes(sizes[:0], NO_EVENTS)
    assert str(none.mean_diameter) == "not measured"
    assert none.steady is None
    assert none.remarks[0].startswith("Sizes were not measured, because no frame")


def breakup(time, droplet, daughters):
    row = {"kind": "breakup", "time": time, "droplet_id": droplet, "area": 0.7}
    return (
        row
        | {f"daughter_{k}": d for k, d in enumerate(daughters, 1)}
        | {"area_1": 0.3, "area_2": 0.4}
    )


def test_lineage_tells_mothers_and_fates():
    entered = {"kind": "entered", "time": 0.5, "droplet_id": 0, "area": 0.7}
    left = {"kind": "left", "time": 9.0, "droplet_id": 4, "area": 0.4}
    events = pd.DataFrame([entered, breakup(2.0, 0, (1, 2)), breakup(3.0, 2, (3, 4)), left])
    family = lineage(events)
    assert family["parent"].to_dict() == {0: -1, 1: 0, 2: 0, 3: 2, 4: 2}
    assert list(ancestors(family, 4)) == [2, 0]
    assert family.loc[4, ["born", "ended", "fate"]].tolist() == [3.0, 9.0, "left"]
    assert math.isnan(family.loc[3, "ended"])


def merging(time, droplet, partner, into, areas):
    return {
        "kind": "merge",
        "time": time,
        "droplet_id": droplet,
        "partner": partner,
        "into": into,
        "area_1": areas[0],
        "area_2": areas[1],
    }


def test_lineage_tells_what_merged_droplets_come_from():
    """0 breaks into 1 and 2; 2 and 3 merge into 4, then 4 and 1 into 5."""
    events = pd.DataFrame(
        [
            breakup(1.0, 0, (1, 2)) | {"area_1": 0.3, "area_2": 0.1},
            merging(2.0, 2, 3, 4, (0.1, 0.4)),
            merging(3.0, 1, 4, 5, (0.3, 0.5)),
        ]
    )
    family = lineage(events)
    assert family["parent"].to_dict() == {0: -1, 1: 0, 2: 0, 3: -1, 4: 3, 5: 4}
    assert family["other_parent"].to_dict() == {0: -1, 1: -1, 2: -1, 3: -1, 4: 2, 5: 1}
    assert family["fate"].tolist() == ["breakup", "merge", "merge", "merge", "merge", ""]
    assert list(ancestors(family, 5)) == [4, 3]
    assert origins(family, 5) == pytest.approx({0: 0.5, 3: 0.5})
    assert origins(family, 4) == pytest.approx({0: 0.2, 3: 0.8})
    assert origins(family, 3) == {3: 1.0}


def test_a_contact_of_a_droplet_that_soon_merged_is_not_settled():
    circles = np.array([[0.0, 0.0, 0.3]])
    events = pd.DataFrame(
        [
            contact(1.0, 0, 0),
            contact(1.0, 1, 0),
            contact(1.0, 2, 0),
            merging(2.0, 0, 1, 7, (0.5, 0.5)),
            merging(8.0, 2, 7, 8, (0.5, 1.0)),
        ]
    )
    parameters = po.Parameters(simulation_capillary_number=40)
    events[["x", "y"]] = math.nan
    table = contact_outcomes(events, circles, parameters, end=20.0)
    assert table["settled"].tolist() == [False, False, True]


def contact(time, droplet, obstacle):
    numbers = {"symmetry": 0.5, "speed": 0.5, "area": 0.8}
    return {"kind": "contact", "time": time, "droplet_id": droplet, "obstacle": obstacle, **numbers}


def test_a_breakup_is_put_down_to_the_pillar_at_its_neck():
    circles = np.array([[0.0, 0.0, 0.3], [2.0, 0.0, 0.3]])
    at_second = breakup(3.0, 0, (1, 2)) | {"x": 2.0, "y": 5.9}  # across the edge of the cell
    events = pd.DataFrame([contact(1.0, 0, 0), contact(2.0, 0, 1), at_second, contact(9.5, 5, 0)])
    parameters = po.Parameters(simulation_capillary_number=40)
    table = contact_outcomes(events, circles, parameters, end=10.0, width=6.0)
    assert table["broke"].tolist() == [False, True, False]
    assert table["settled"].tolist() == [True, True, False]
    expected = breakup_number(9.8e-5 * 40 * 0.5, normalized_area=0.8 / 0.09, symmetry=0.5)
    assert table["breakup_number"].tolist() == pytest.approx([float(expected)] * 3)


def correlated_sizes(seed, keep=0.9, frames=1200):
    """Return droplets whose size is an autoregressive series in time: correlated by 9.5 frames."""
    rng = np.random.default_rng(seed)
    size = np.zeros(frames)
    for k in range(1, frames):
        size[k] = keep * size[k - 1] + rng.normal()
    times = np.repeat(np.arange(float(frames)), 5)
    return pd.DataFrame({"time": times, "diameter": 1.0 + 0.02 * np.repeat(size, 5)})


def test_errors_hold_for_a_series_that_is_correlated_in_time():
    """Droplets of one frame are alike, and so are neighbouring frames: neither is independent."""
    studies = [
        study_sizes(correlated_sizes(seed), NO_EVENTS, start=0.0, residence_time=50.0)
        for seed in range(60)
    ]
    values, errors = np.array([study.mean_diameter for study in studies]).T
    exact = 0.02 / (1 - 0.9) / math.sqrt(1200)  # of a mean of such a series
    assert np.std(values) == pytest.approx(exact, rel=0.25)
    assert np.mean(errors) == pytest.approx(exact, rel=0.2)
    naive = 0.02 / math.sqrt(1 - 0.81) / math.sqrt(6000)
    assert np.mean(errors) > 5 * naive
    pulls = (values - 1.0) / errors
    assert 0.75 < np.sqrt(np.mean(pulls**2)) < 1.4
