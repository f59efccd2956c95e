"""Order of the time integration, on smooth motion before anything touches."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pinchoff import _core

NO_OBSTACLES = np.zeros((0, 3))
TIME = 0.4


def state(model, system, time_step, drag_rate):
    """Positions and velocities (2, n, 2) after TIME t0 of approach in the Stokes flow."""
    row = model(
        line_tension=1.0,
        simulation_capillary_number=drag_rate,
        core={"time_step": time_step, "sample_interval": TIME, "neck_thickness": 0.0},
    )
    one = system(row, None, NO_OBSTACLES)
    one.advance(TIME)
    assert one.time == pytest.approx(TIME, rel=1e-12)
    assert not one.finished
    return np.array(one.outlines()[0][2:])


def errors(model, system, steps, drag_rate):
    """Largest error (len(steps), 2) of positions and velocities against 16 times finer steps."""
    exact = state(model, system, min(steps) / 16, drag_rate)
    found = [np.abs(state(model, system, step, drag_rate) - exact) for step in steps]
    return np.array([e.max(axis=(1, 2)) for e in found])


@pytest.mark.parametrize(
    ("drag_rate", "steps"),
    [
        (5.0, (2.5e-4, 1.25e-4, 6.25e-5)),  # breathing: its frequency, 160, must be resolved
        (50.0, (2e-3, 1e-3, 5e-4)),
        (500.0, (2e-3, 1e-3, 5e-4)),  # ζ Δt from 1 to 1/4
    ],
)
def test_second_order_in_the_time_step(model, system, drag_rate, steps):
    """Halving the step divides the error by four: slope 2, up to the next term of its series."""
    error = errors(model, system, steps, drag_rate)
    slopes = np.log2(error[:-1] / error[1:])
    np.testing.assert_allclose(slopes, 2, atol=0.1)


def test_stiff_drag_costs_at_most_one_step_of_drift(model, system):
    """Where drag rules, ζ Δt ≫ 1, the error is a lag of the order of Δt; then slope 2 sets in.

    The velocity half way between two positions relaxes towards the equilibrium of the first. For a
    slowly changing equilibrium w this gives w - c dw/dt with c = (Δt/2) coth(ζΔt/2) where 1/ζ is
    exact: off by ζΔt²/12 if ζΔt is small, by less than Δt/2 always.
    """
    drag_rate, steps = 5000.0, np.array([4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4])
    error = errors(model, system, steps, drag_rate)
    speed = np.abs(_core.StokesFlow(1 / 5.66).velocity(np.array([[-5.5, 0.0]]))).max()
    assert (error[:, 0] < steps / 2 * speed).all()
    assert (np.diff(error[:, 0]) < 0).all()
    last = np.log2(error[-2] / error[-1])  # ζ Δt from 1.25 to 0.6
    np.testing.assert_allclose(last, 2, atol=0.1)


def test_energy_of_a_drop_without_drag_is_kept_to_second_order(model, system):
    """Leapfrog without drag is symplectic: the energy swings by O(Δt²) and does not drift."""

    def swing(time_step):
        row = model(
            line_tension=1.0,
            core={"time_step": time_step, "sample_interval": time_step, "drag": 1e-9},
        )
        one = system(row, _core.UniformFlow(0.0, 0.0), NO_OBSTACLES)
        energies = []
        for time in np.arange(1, 401) * 2e-3:
            one.advance(time)
            velocity = one.outlines()[0][3]
            energies.append(one.energies()["total"] + 0.5 * (velocity**2).sum() / len(velocity))
        energies = np.array(energies)
        half = len(energies) // 2
        drift = energies[half:].mean() - energies[:half].mean()
        return np.ptp(energies), abs(drift)

    coarse, fine = swing(1e-3), swing(5e-4)
    assert coarse[0] / fine[0] == pytest.approx(4, rel=0.1)
    assert fine[1] < 0.05 * fine[0]


@pytest.mark.parametrize(
    "constants",
    [
        {"line_tension": 1.0, "simulation_capillary_number": 1.0},  # hardly damped
        {"line_tension": 1.0, "simulation_capillary_number": 3000.0},  # ruled by drag
        {"edge_stiffness": 100.0},
        {"area_stiffness": 2e6},
    ],
)
def test_stable_step_is_the_limit_of_stability(model, system, constants):
    """A drop in still fluid rests just below the limit; a little above it round-off grows.

    Nothing touches the wall, so its stiffness is taken out. The limit adds the stiffness of line
    tension (across the edges) to that of the springs (along them): at k̃_l = 3 it understates the
    step by up to 1 + 1/3π = 1.11, hence the 15 %.
    """
    row = model(**constants, time_limit=1e4, core={"neck_thickness": 0.0, "wall_stiffness": 1e-3})
    limit = _core.stable_time_step(row)
    stopped = []
    for factor in (0.98, 1.15):
        row[_core.MODEL_FIELDS.index("time_step")] = factor * limit
        one = system(row, _core.UniformFlow(0.0, 0.0), NO_OBSTACLES)
        one.advance(3000 * limit)
        stopped.append(one.finished)
    assert stopped == [False, True]


@pytest.mark.parametrize(
    "constants",
    [
        {},
        {"vertex_count": 128},
        {"line_tension": 5.0},
        {"wall_stiffness": 4e3},
        {"vertex_count": 16},
    ],
)
def test_automatic_step_is_below_the_stable_one(model, constants):
    """At rest there is a margin, and the step is never above the longest that S was checked for."""
    row = model(**constants)
    assert _core.auto_time_step(row) <= min(0.9 * _core.stable_time_step(row), 5e-4)
    # Taken down to a whole number of steps a sample.
    step, interval = (row[_core.MODEL_FIELDS.index(n)] for n in ("time_step", "sample_interval"))
    assert interval / step == pytest.approx(math.ceil(interval / _core.auto_time_step(row)))
