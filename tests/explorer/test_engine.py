"""The engine as WebAssembly against the native one, without a browser."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from pinchoff import InputError, Parameters, _core
from pinchoff.explorer.facts import facts

wasmtime = pytest.importorskip("wasmtime", reason="wasmtime is not installed")


class Engine:
    """One instance of the compiled module; the names are those of its C interface."""

    def __init__(self, code: bytes) -> None:
        engine = wasmtime.Engine()
        self._store = wasmtime.Store(engine)
        linker = wasmtime.Linker(engine)
        linker.define_wasi()
        self._store.set_wasi(wasmtime.WasiConfig())
        module = wasmtime.Module(engine, code)
        self._exports = linker.instantiate(self._store, module).exports(self._store)
        self.call("_initialize")
        self.fields, self.results, self.guards = (
            self._text(self.call(f"{kind}_names")).split() for kind in ("field", "result", "guard")
        )

    def call(self, name: str, *arguments: float) -> int:
        return self._exports[name](self._store, *arguments)

    def read(self, place: int, count: int) -> np.ndarray:
        memory = self._exports["memory"].read(self._store, place, place + 8 * count)
        return np.frombuffer(memory, dtype="<f8")

    def write_row(self, row: Sequence[float]) -> None:
        data = np.asarray(row, dtype="<f8").tobytes()
        self._exports["memory"].write(self._store, data, self.call("row"))

    def row(self) -> np.ndarray:
        return self.read(self.call("row"), len(self.fields))

    def refused(self, row: Sequence[float]) -> str:
        """Return the field for which a row is refused, or nothing."""
        self.write_row(row)
        field = self.call("start")
        return self.fields[field - 1] if field else ""

    def run(self, row: Sequence[float]) -> dict[str, float]:
        assert not self.refused(row)
        while self.call("advance", math.inf):
            pass
        return dict(
            zip(self.results, self.read(self.call("result"), len(self.results)), strict=True)
        )

    def numbers(self, what: str, *arguments: float) -> np.ndarray:
        count = self.call(what, *arguments)
        return self.read(self.call("numbers"), count)

    def _text(self, place: int) -> str:
        data = self._exports["memory"].read(self._store, place, place + 4096)
        return data[: data.index(b"\0")].decode()


@pytest.fixture(scope="module")
def engine(code: bytes) -> Engine:
    return Engine(code)


def native(rows: list[Any]) -> list[dict[str, float]]:
    table = _core.run_many(np.array(rows), None, 2, None)
    return [dict(zip(_core.RESULT_FIELDS, row, strict=True)) for row in table.tolist()]


def assert_same(here: dict[str, float], there: dict[str, float], tolerance: float = 1e-12) -> None:
    assert here["outcome"] == there["outcome"]
    assert here["guard"] == there["guard"]
    assert here["symmetry"] == pytest.approx(there["symmetry"], abs=tolerance, rel=0, nan_ok=True)
    assert here["breakup_count"] == there["breakup_count"]
    assert here["steps"] == there["steps"]
    for name in ("impact_parameter", "breakup_time", "small_daughter_area", "end_time"):
        assert here[name] == pytest.approx(there[name], rel=1e3 * tolerance, nan_ok=True)


def test_the_rows_are_those_of_the_python_binding(engine: Engine) -> None:
    assert tuple(engine.fields) == tuple(_core.MODEL_FIELDS)
    assert tuple(engine.results) == tuple(_core.RESULT_FIELDS)
    assert ("", *engine.guards) == tuple(_core.GUARDS)


def test_a_hundred_random_collisions_are_the_same(engine: Engine) -> None:
    random = np.random.default_rng(18)
    rows = [
        Parameters(
            offset=random.uniform(-0.4, 0.4),
            simulation_capillary_number=10 ** random.uniform(0.8, 2.0),
            size_ratio=random.uniform(2.0, 9.0),
            vertex_count=int(random.integers(24, 80)),
            follow_daughters=bool(random.integers(2)),
            model=str(random.choice(["deformable-particle", "front-tracking"])),
        ).model_row()
        for _ in range(100)
    ]
    there = native(rows)
    assert {r["outcome"] for r in there} >= {0.0, 1.0}
    for row, result in zip(rows, there, strict=True):
        assert_same(engine.run(row), result)


MOST_STEPS = 20_000

# Without edge springs vertices gather, and rounding grows: the native instruction sets differ from
# each other by 1e-7 there.
ILL_CONDITIONED = {("edge_stiffness", 1e-6): 1e-5}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        (p["name"], value)
        for p in facts()["parameters"]
        for value in (
            [p[end] for end in ("low", "high") if p[end] is not None]
            + (p["choices"] or [])
            + ([True, False] if isinstance(p["default"], bool) else [])
        )
    ],
)
def test_the_limits_of_every_parameter_are_the_same(engine: Engine, name: str, value: Any) -> None:
    try:
        parameters = Parameters(**{name: value})
        parameters.model_row()
    except InputError:
        pytest.skip("possible, but not beside the other defaults")
    # A whole collision where that is quick, its first steps where it is not.
    limit = min(parameters.time_limit, MOST_STEPS * parameters.effective_time_step)
    row = parameters.replace(time_limit=max(0.01, limit)).model_row()
    tolerance = ILL_CONDITIONED.get((name, value), 1e-12)
    assert_same(engine.run(row), native([row])[0], tolerance)


def test_the_automatic_time_step_is_pythons(engine: Engine) -> None:
    place = engine.fields.index("time_step")
    for values in ({}, {"line_tension": 5.0}, {"vertex_count": 200, "size_ratio": 2.0}):
        row = Parameters(**values).model_row()
        unknown = row.copy()
        unknown[place] = math.nan
        engine.write_row(unknown)
        assert engine.call("set_automatic_step") == 0
        np.testing.assert_allclose(engine.row(), row, rtol=1e-15)


ANY_NUMBER = (
    "offset",
    "neck_separation_in_diameters",
    "neck_thickness_is_fixed",
    "stop_at_breakup",
    "front_tracking",
)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, -1.0])
@pytest.mark.parametrize("name", _core.MODEL_FIELDS)
def test_a_row_with_a_bad_number_is_refused(engine: Engine, name: str, bad: float) -> None:
    if bad == -1.0 and name in ANY_NUMBER:
        pytest.skip("any finite number is possible here")
    row = Parameters().model_row()
    row[_core.MODEL_FIELDS.index(name)] = bad
    assert engine.refused(row) == name
    assert engine.call("advance", math.inf) == 0, "nothing runs after a refusal"


def refused_argument(values: dict[str, Any]) -> str:
    try:
        Parameters(**values)
    except InputError as error:
        return error.argument
    return ""


def test_rows_are_refused_just_where_the_parameters_are(engine: Engine) -> None:
    random = np.random.default_rng(3)
    default = Parameters()
    place = {name: k for k, name in enumerate(_core.MODEL_FIELDS)}
    refused = 0
    for _ in range(300):
        values = {
            "size_ratio": 10 ** random.uniform(-0.3, 1.0),
            "start_distance": random.uniform(0.76, 3.0),
            "vertex_count": int(random.integers(16, 80)),
            "neck_thickness": random.uniform(0.0, 1.0),
            "neck_separation": random.uniform(0.02, 0.6),
            "neck_separation_unit": random.choice(["perimeter", "diameter"]),
        }
        row = default.model_row()
        row[place["obstacle_radius"]] = 1.0 / values["size_ratio"]
        for name in ("start_distance", "vertex_count", "neck_thickness", "neck_separation"):
            row[place[name]] = values[name]
        row[place["neck_separation_in_diameters"]] = values["neck_separation_unit"] == "diameter"
        row[place["time_step"]] = 1e-5
        expected = refused_argument(values)
        refused += expected != ""
        assert engine.refused(row) == expected
    assert 50 < refused < 290


def test_an_unstable_time_step_is_refused(engine: Engine) -> None:
    row = Parameters().model_row()
    row[_core.MODEL_FIELDS.index("time_step")] = 1.01 * _core.stable_time_step(row)
    assert engine.refused(row) == "time_step"


def test_the_fluid_moves_as_in_python(engine: Engine) -> None:
    engine.write_row(Parameters().model_row())
    flow = _core.StokesFlow(Parameters().obstacle_radius)
    for x, y in ((-1.0, 0.2), (0.3, -0.4), (0.0, 0.1)):
        expected = flow.velocity(np.array([[x, y]]))[0]
        np.testing.assert_allclose(engine.numbers("fluid_velocity", x, y), expected, rtol=1e-14)


def test_outlines_are_those_of_python(engine: Engine) -> None:
    parameters = Parameters(offset=0.08)
    row = parameters.model_row()
    assert engine.refused(row) == ""
    engine.call("advance", 2.5)
    numbers = engine.numbers("outlines")
    flow = _core.StokesFlow(parameters.obstacle_radius)
    circles = np.array([[0.0, 0.0, parameters.obstacle_radius]])
    starts = np.array([[-parameters.start_distance, parameters.offset, 1.0]])
    system = _core.System(row, flow, circles, starts)
    system.advance(2.5)
    [(_, _, vertices, _)] = system.outlines()
    assert numbers[2] == len(vertices)
    np.testing.assert_allclose(numbers[11:].reshape(-1, 2), vertices, atol=1e-12)
    assert numbers[3] == pytest.approx(_core.area(vertices))
    assert numbers[5] == pytest.approx(_core.shape_parameter(vertices))
    thickness, i, j = _core.neck(vertices, parameters.neck_separation, False, 1.0)
    assert numbers[6] == pytest.approx(thickness)
    np.testing.assert_allclose(numbers[7:11], vertices[[i, j]].ravel(), atol=1e-12)
