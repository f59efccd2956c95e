"""Designs of sweeps: which points they have, and what is refused before anything is written."""

from __future__ import annotations

import numpy as np
import pytest

import pinchoff as po
from pinchoff.studies.sweep import SweepDesign
from pinchoff.studies.sweep.sampling import unit_points

SAMPLE = {
    "samples": 1500,
    "seed": 4,
    "vary": {
        "offset": {"min": 0, "max": 0.3},
        "simulation_capillary_number": {"min": 8, "max": 90, "scale": "log"},
        "line_tension": [60, 80],
    },
}
EXPERIMENT = {
    "diameter": "481 um",
    "obstacle_radius": "85 um",
    "thickness": "85 um",
    "viscosity": "48 mPa s",
    "surface_tension": "20 mN/m",
}


def varied(**vary):
    return {"vary": vary}


@pytest.fixture
def design_of():
    return SweepDesign.from_config


# Points


def test_grid_holds_all_combinations_and_the_last_parameter_changes_fastest(design_of):
    design = design_of(varied(size_ratio=[4, 5], offset=[0.3, 0.1, 0.2]))
    seen = [(p.size_ratio, p.offset) for p in design.points()]
    assert seen == [(a, b) for a in (4, 5) for b in (0.3, 0.1, 0.2)]
    assert len(design) == 6
    assert [design.point(i) for i in range(6)] == list(design.points())


def test_ranges_are_linear_or_logarithmic_with_both_ends(design_of):
    linear = design_of(varied(offset={"min": -0.1, "max": 0.3, "count": 5}))
    np.testing.assert_allclose(
        [p.offset for p in linear.points()], [-0.1, 0, 0.1, 0.2, 0.3], atol=1e-15
    )
    given = {"min": 5, "max": 80, "count": 5, "scale": "log"}
    logarithmic = [p.line_tension for p in design_of(varied(line_tension=given)).points()]
    np.testing.assert_allclose(logarithmic, [5, 10, 20, 40, 80])
    assert (logarithmic[0], logarithmic[-1]) == (5, 80)
    whole = design_of(varied(vertex_count={"min": 16, "max": 1024, "count": 7, "scale": "log"}))
    assert [p.vertex_count for p in whole.points()] == [16, 32, 64, 128, 256, 512, 1024]


def test_any_parameter_can_be_varied_and_derived_ones_follow(design_of):
    design = design_of(
        {
            "preset": "paper-step",
            "parameters": {"edge_stiffness": 2},
            "vary": {
                "neck_separation_unit": ["perimeter", "diameter"],
                "follow_daughters": [True, False],
                "line_tension": np.array([20.0, 40.0]),
            },
        }
    )
    first, last = design.point(0), design.point(7)
    assert (first.time_step, first.edge_stiffness) == (1e-4, 2)
    assert (last.neck_separation_unit, last.follow_daughters) == ("diameter", False)
    assert last.area_stiffness == 2 * first.area_stiffness


def test_physical_quantities_can_be_varied(design_of):
    offsets = {"min": "0 um", "max": "0.05 mm", "count": 2}
    config = {"physical": EXPERIMENT, **varied(speed=["1 mm/s", "2000 um/s"], offset=offsets)}
    seen = list(design_of(config).points())
    for point, (speed, offset) in zip(
        seen, [(s, y) for s in ("1 mm/s", "2 mm/s") for y in ("0 um", "50 um")], strict=True
    ):
        alone = po.Parameters.from_physical(**EXPERIMENT, speed=speed, offset=offset)
        assert point.size_ratio == pytest.approx(alone.size_ratio, rel=1e-12)
        assert point.simulation_capillary_number == pytest.approx(
            alone.simulation_capillary_number, rel=1e-12
        )
        assert point.offset == pytest.approx(alone.offset, rel=1e-12)
        assert point.scale is not None
        assert point.scale.speed_mm_s == pytest.approx(alone.scale.speed_mm_s)


@pytest.mark.parametrize("kind", ["sobol", "latin-hypercube", "random"])
def test_sample_is_seeded_and_each_point_stands_alone(design_of, kind):
    config = {**SAMPLE, "design": kind}
    design = design_of(config)
    points = list(design.points())
    assert len(points) == 1500
    for i in (0, 1, 777, 1023, 1024, 1499):
        assert design.point(i) == points[i]
    assert list(design.points(1000, 1100)) == points[1000:1100]
    assert list(design_of(config).points(0, 50)) == points[:50]
    assert list(design_of({**config, "seed": 5}).points(0, 50)) != points[:50]
    numbers = [p.simulation_capillary_number for p in points]
    assert 8 <= min(numbers) < 8.2
    assert 88 < max(numbers) <= 90
    assert np.median(numbers) == pytest.approx(np.sqrt(8 * 90), rel=0.1)
    assert np.mean([p.line_tension == 60 for p in points]) == pytest.approx(0.5, abs=0.06)


@pytest.mark.parametrize(("kind", "most"), [("sobol", 1), ("latin-hypercube", 1), ("random", 9)])
def test_low_discrepancy_samples_are_even(design_of, kind, most):
    vary = {"offset": {"min": 0, "max": 1}, "size_ratio": {"min": 4, "max": 5}}
    design = design_of({"design": kind, "samples": 256, "vary": vary})
    for values in (
        [p.offset for p in design.points()],
        [p.size_ratio - 4 for p in design.points()],
    ):
        counts = np.histogram(values, bins=256, range=(0, 1))[0]
        assert counts.max() <= most
        assert (counts.max() == 1) == (kind != "random")


@pytest.mark.parametrize("dimensions", [3, 4, 5, 8, 9, 13])
def test_independent_points_repeat_in_no_part_however_many_parameters(dimensions):
    whole = unit_points("random", dimensions, 48, 3, 0, 48)
    in_parts = [unit_points("random", dimensions, 48, 3, k, k + 8) for k in range(0, 48, 8)]
    np.testing.assert_array_equal(np.concatenate(in_parts), whole)
    assert np.unique(whole).size == 48 * dimensions


def test_whole_numbers_of_a_sample_have_equal_shares(design_of):
    vary = {"vertex_count": {"min": 16, "max": 19}}
    design = design_of({"design": "sobol", "samples": 256, "vary": vary})
    counts = np.bincount([p.vertex_count for p in design.points()], minlength=20)
    assert counts[:16].sum() == 0
    assert counts[16:].tolist() == [64] * 4


# Refusals

SOBOL = {"design": "sobol", "samples": 8}


@pytest.mark.parametrize(
    ("argument", "config"),
    [
        ("vary", {}),
        ("vary", {"vary": {}}),
        ("vary", {"vary": [1]}),
        ("vary.ofset", varied(ofset=[0])),
        ("vary.scale", varied(scale=[0])),
        ("vary.speed", varied(speed=["1 mm/s"])),
        ("vary.offset", varied(offset=[])),
        ("vary.offset", varied(offset=0.1)),
        ("vary.offset", varied(offset="0.1")),
        ("vary.offset", varied(offset=[0.1, 0.2, 0.1])),
        ("vary.offset[1]", varied(offset=[0.1, 6])),
        ("vary.offset[0]", varied(offset=["0.1 um"])),
        ("vary.offset[0]", varied(offset=[float("nan")])),
        ("vary.neck_separation_unit[1]", varied(neck_separation_unit=["diameter", "radius"])),
        ("vary.offset.max", varied(offset={"min": 0.3, "max": 0.1, "count": 3})),
        ("vary.offset.max", varied(offset={"min": 0.3, "max": 0.3, "count": 3})),
        ("vary.offset.max", varied(offset={"min": 0.3, "max": float("inf"), "count": 3})),
        ("vary.offset.min", varied(offset={"max": 0.3, "count": 3})),
        ("vary.offset.min", varied(offset={"min": "0", "max": 0.3, "count": 3})),
        ("vary.offset.min", varied(offset={"min": 0, "max": 0.3, "count": 3, "scale": "log"})),
        ("vary.offset.scale", varied(offset={"min": 0, "max": 1, "count": 3, "scale": "sqrt"})),
        ("vary.offset.count", varied(offset={"min": 0, "max": 1})),
        ("vary.offset.count", varied(offset={"min": 0, "max": 1, "count": 1})),
        ("vary.offset.count", varied(offset={"min": 0, "max": 1, "count": 2.5})),
        ("vary.offset.steps", varied(offset={"min": 0, "max": 1, "steps": 3})),
        ("vary.offset.count", {**SOBOL, **varied(offset={"min": 0, "max": 1, "count": 3})}),
        ("vary.offset.max", {**SOBOL, **varied(offset={"min": 0, "max": 7})}),
        ("vary.offset.max", varied(offset={"min": 0, "max": 7, "count": 3})),
        ("vary.vertex_count", varied(vertex_count={"min": 16, "max": 18, "count": 9})),
        (
            "vary",
            varied(
                offset={"min": 0, "max": 1, "count": 100_000},
                size_ratio={"min": 4, "max": 5, "count": 100_000},
            ),
        ),
        ("design", {"design": "square", **varied(offset=[0])}),
        ("samples", {"samples": 3, **varied(offset=[0])}),
        ("seed", {"seed": 3, **varied(offset=[0])}),
        ("samples", {"design": "sobol", **varied(offset=[0])}),
        ("samples", {**SOBOL, "samples": 0, **varied(offset=[0])}),
        ("seed", {**SOBOL, "seed": -1, **varied(offset=[0])}),
        ("seed", {**SOBOL, "seed": "x", **varied(offset=[0])}),
        ("preset", {"preset": "nice", **varied(offset=[0])}),
        ("line_tnsion", {"line_tnsion": 3, **varied(offset=[0])}),
        ("parameters.line_tnsion", {"parameters": {"line_tnsion": 3}, **varied(offset=[0])}),
        ("parameters", {"parameters": 3, **varied(offset=[0])}),
        ("line_tension", {"parameters": {"line_tension": -3}, **varied(offset=[0])}),
        (
            "line_tension",
            {"line_tension": 3, "parameters": {"line_tension": 4}, **varied(offset=[0])},
        ),
        ("offset", {"offset": 0.1, **varied(offset=[0])}),
        ("physical", {"physical": "um", **varied(offset=[0])}),
        ("physical.speed", {"physical": EXPERIMENT, **varied(offset=["0 um"])}),
        ("physical.sped", {"physical": {"sped": 1}, **varied(offset=["0 um"])}),
        ("physical.diameter", {"physical": EXPERIMENT, **varied(diameter=["4 um"])}),
        ("vary.speed[0]", {"physical": EXPERIMENT, **varied(speed=["1 mm"])}),
        ("vary.speed.min", {"physical": EXPERIMENT, **varied(speed={"min": 1, "max": "2 mm/s"})}),
        (
            "vary.size_ratio",
            {"physical": {**EXPERIMENT, "speed": "1 mm/s"}, **varied(size_ratio=[4])},
        ),
    ],
)
def test_wrong_configuration_is_refused_before_anything_is_written(
    refused, tmp_path, argument, config
):
    refused(argument, po.sweep, config, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_single_impossible_point_is_found_before_the_first_run(refused, tmp_path):
    vary = {"size_ratio": [5, 4, 0.3], "start_distance": [5, 4]}
    error = refused("start_distance", po.sweep, varied(**vary), tmp_path / "out")
    assert "in point 5 (size_ratio = 0.3, start_distance = 4)" in error.got
    unstable = {"time_step": 1e-3, **varied(vertex_count=[16, 1024])}
    error = refused("time_step", po.sweep, unstable, tmp_path / "out")
    assert "in point 1 (vertex_count = 1024)" in error.got
    assert list(tmp_path.iterdir()) == []
