"""Runs of many droplets: what is refused, what guards take out, and what Ctrl-C ends."""

from __future__ import annotations

import math
import signal

import numpy as np
import pytest

import pinchoff as po

FEW = po.Parameters(model="deformable-particle", simulation_capillary_number=30, vertex_count=32)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": -1}, "time must be"),
        ({"time": 1e9}, "time must be at most"),
        ({"droplets": None}, "droplets must be given"),
        ({"droplets": [[0, 0, 1], [0.5, 0, 1]]}, r"droplets\[1\] must be"),
        ({"obstacles": [[3, 0, 0.2]]}, "flow must be given"),
        ({"periodic": "z"}, "periodic must be"),
        ({"periodic": "x"}, "cell must be given"),
        ({"periodic": "x", "cell": (0, 1, 0, 1)}, "cell must be at least 2 D0"),
        ({"periodic": "x", "cell": (0, 3, 0)}, "cell must be four"),
        ({"periodic": "x", "cell": (0, 3, 0, 9), "droplets": [[0, 0, 1], [2.5, 0, 1]]}, "images"),
        ({"inlet": 3}, "inlet must be an Inlet"),
        ({"inlet": po.Inlet(0, 0, 1, 0.1)}, "inlet.top must be"),
        ({"inlet": po.Inlet(0, 0, 3, 2.0)}, "inlet.area_fraction must be"),
        ({"inlet": po.Inlet(0, 0, 3, 0.1, [])}, "inlet.diameters must be"),
        ({"inlet": po.Inlet(0, 0, 3, 0.1, [1, -1])}, r"inlet.diameters\[1\] must be"),
        ({"outlet": "far"}, "outlet must be"),
        ({"smallest_breaking": -1}, "smallest_breaking must be"),
        ({"seed": 0.5}, "seed must be"),
        ({"interval": 0}, "interval must be"),
        ({"on_frame": 3}, "on_frame must be callable"),
        ({"resume": True}, "out must be given"),
        ({"coalescence": 0.5}, "coalescence must be a Coalescence"),
        ({"coalescence": po.Coalescence(-1.0)}, "coalescence.drainage must be"),
        ({"coalescence": po.Coalescence(math.nan)}, "coalescence.drainage must be"),
        ({"coalescence": po.Coalescence(1.0, 1.5)}, "coalescence.separation must be"),
        (
            {"coalescence": po.Coalescence(1.0, 0.5, 1)},
            "coalescence.stochastic must be True or False",
        ),
        ({"flow": 3}, "flow must be"),
        ({"threads": 0}, "threads must be"),
    ],
)
def test_bad_input_is_named(changes, message):
    arguments = {"time": 1, "droplets": [[0, 0, 1]], **changes}
    with pytest.raises(po.InputError, match=message):
        po.simulate_emulsion(FEW, **arguments)


def test_interrupt_acts_between_windows():
    import threading

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            po.simulate_emulsion(FEW, time=1e6, interval=1e5, droplets=[[0, 0, 1]])
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)


def test_a_droplet_that_fails_is_retired_and_said_so(tmp_path):
    """One droplet leaves the sampled flow: it goes with a reason, and the run says so."""
    x = np.linspace(-2, 3, 60)
    gx, _ = np.meshgrid(x, x)
    flow = po.flow.sampled(x, x, 1 + 0 * gx, 0 * gx)
    scene = {"time": 4, "droplets": [[0, 0, 1], [-1.5, 1.4, 0.4]], "flow": flow}
    with pytest.warns(RuntimeWarning, match=r"86.2 % of all area.*droplet 0 .*sampled flow"):
        run = po.simulate_emulsion(FEW, out=tmp_path / "run", **scene)
    assert (run.time, run.stopped) == (4, False)
    assert (run.balance["retired"], run.balance["present"]) == (1, 1)
    assert run.retired_share == pytest.approx(1 / (1 + 0.4**2))
    first = run.retired.iloc[0]
    assert (first["droplet_id"], first["share"]) == (0, run.retired_share)
    with pytest.warns(RuntimeWarning, match=r"ended the run.*droplet 0 .*sampled flow"):
        stopped = po.simulate_emulsion(FEW, on_guard="stop", out=tmp_path / "stop", **scene)
    assert stopped.stopped
    assert first["time"] <= stopped.time < first["time"] + 0.051
    # What was stopped goes on where that is asked for, to the same end.
    with pytest.warns(RuntimeWarning, match="took out"):
        on = po.simulate_emulsion(FEW, resume=True, out=tmp_path / "stop", **scene)
    assert on.balance == run.balance
    with pytest.raises(po.InputError, match="on_guard must be"):
        po.simulate_emulsion(FEW, on_guard="ignore", **scene)


def test_a_daughter_too_small_to_be_followed_goes_alone():
    """A droplet of 0.025 D0 breaks: the smaller daughter is taken out, the other one goes on."""
    size, radius = 0.025, 0.025 / 5.66
    with pytest.warns(RuntimeWarning, match=r"droplet 1 .*at least 0.02 D0"):
        run = po.simulate_emulsion(
            po.Parameters(simulation_capillary_number=60 / size, vertex_count=64),
            time=0.2,
            droplets=[[-0.09, 0.02 * size, size]],
            obstacles=[[0, 0, radius]],
            flow=po.flow.stokes(radius),
            interval=0.05,
        )
    kinds = run.events.set_index("kind")
    broke, gone = kinds.loc["breakup"], kinds.loc["retired"]
    assert (broke["daughter_1"], broke["daughter_2"], gone["droplet_id"]) == (1, 2, 1)
    assert gone["area"] == pytest.approx(broke["area_1"])
    assert gone["area"] < broke["area_2"]
    assert run.balance["present"] == 1
    assert run.sizes["diameter"].iloc[-1] == pytest.approx(math.sqrt(4 / math.pi * broke["area_2"]))
