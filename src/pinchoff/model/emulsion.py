"""Many droplets among many obstacles: from the arrangement to events, sizes and outlines.

Droplets interact through contact alone. The engine groups those that can meet and advances each
group with a time step of its own, on all threads, so that the cost grows like the number of
droplets; results do not depend on the number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from pinchoff import _core
from pinchoff.model.arrays import PillarArray
from pinchoff.model.emulsion_files import EmulsionFolder
from pinchoff.model.emulsion_result import Emulsion, Recorder
from pinchoff.model.emulsion_scene import (
    WINDOW,
    Coalescence,
    Inlet,
    OnGuard,
    checked_on_guard,
    checked_scene,
)
from pinchoff.model.flow import Flow
from pinchoff.model.gsd import Frame
from pinchoff.model.parameters import FRONT, PARAMETERS, SPRINGS, Parameters, require_parameters
from pinchoff.model.simulation import require_on_frame, thread_count
from pinchoff.support.arguments import checked_number, checked_positive, checked_whole
from pinchoff.support.errors import InputError
from pinchoff.support.locks import held_folder
from pinchoff.support.progress import Bar, progress_bar

if TYPE_CHECKING:
    import os


def simulate_emulsion(
    parameters: Parameters,
    *,
    time: float,
    droplets: ArrayLike | None = None,
    obstacles: ArrayLike | PillarArray | None = None,
    flow: Flow | None = None,
    cell: Sequence[float] | None = None,
    periodic: str = "",
    inlet: Inlet | None = None,
    outlet: float | None = None,
    coalescence: Coalescence | None = None,
    on_guard: OnGuard = "retire",
    smallest_breaking: float = 0.0,
    interval: float = 0.5,
    on_frame: Callable[[float, Frame], object] | None = None,
    out: str | os.PathLike[str] | None = None,
    outlines: bool = True,
    checkpoint: float = 10.0,
    resume: bool = False,
    seed: int = 0,
    threads: int | None = None,
    progress: bool = False,
) -> Emulsion:
    """Run many droplets among many obstacles.

    Parameters
    ----------
    parameters : Parameters
        The model. Where neither ``model`` nor a constant of the springs is given it is front
        tracking, in which a small droplet shortens no other's step; `Emulsion.parameters` tells.
        Offset, start distance and time limit are those of a single collision and play no part;
        daughters are always followed.
    time : float
        How long, t0; rounded up to windows of 0.05 t0.
    droplets : array_like, shape (K, 3), optional
        Start x, y and diameter of each, D0, clear of each other and of the obstacles; by default
        none, if there is an inlet.
    obstacles : array_like, shape (M, 3), or PillarArray, optional
        Centre x, y and radius of each, D0; by default none.
    flow : Flow, optional
        What `pinchoff.flow` builds, or an array's; by default uniform, if there is no obstacle.
    cell : (left, right, bottom, top), optional
        D0; needed where space is periodic. By default that of the PillarArray.
    periodic : {"", "x", "y", "xy"}, optional
        Along which axes the cell repeats itself. Outlines are stored whole.
    inlet : Inlet, optional
        Where droplets come in. One that finds no room waits.
    outlet : float, optional
        Droplets wholly beyond this x leave the run, D0.
    coalescence : Coalescence, optional
        How droplets merge; by default they do not, and their contacts are not recorded.
    on_guard : {"retire", "stop"}, optional
        What follows where a guard refuses a droplet whose shape cannot be trusted. "retire": it is
        taken out, with an event, and the others go on. "stop": the first one ends the run, and
        what there is up to then is returned.
    smallest_breaking : float, optional
        Droplets of a smaller diameter do not break, D0.
    interval : float, optional
        Time between two frames, t0; rounded up to windows.
    on_frame : callable, optional
        Called as ``on_frame(time, droplets)`` for every frame. Velocities are half a time step
        behind the positions.
    out : path, optional
        A folder for events, sizes, outlines and checkpoints, written piece by piece. Without it
        events and sizes are kept in memory, and no outlines.
    outlines : bool, optional
        Whether the folder gets the outlines of every frame.
    checkpoint : float, optional
        Time between two checkpoints, t0; rounded up to frames.
    resume : bool, optional
        Whether to go on from the folder's checkpoint, if it has one. The result is the same to
        the last bit as that of a run that was not interrupted.
    seed : int, optional
        Of the places and diameters at the inlet, and of stochastic merging.
    threads : int, optional
        By default as many as there are cores for this process.
    progress : bool, optional
        Whether to show a bar on stderr.

    Returns
    -------
    Emulsion

    Raises
    ------
    InputError
        An argument is wrong.
    KeyboardInterrupt
        Ctrl-C; the folder holds the run up to its last checkpoint.

    Warns
    -----
    RuntimeWarning
        A guard ended the run, or guards took out droplets with more than 1 % of all area.

    Examples
    --------
    >>> import pinchoff as po
    >>> run = po.simulate_emulsion(
    ...     po.Parameters(simulation_capillary_number=20),
    ...     time=1, droplets=[[0, 0, 1], [0, 1.5, 0.8]],
    ... )
    >>> run.balance["present"], len(run.sizes)
    (2, 6)
    """
    parameters = emulsion_parameters(parameters)
    scene = checked_scene(
        parameters, droplets, obstacles, flow, cell, periodic, inlet, outlet, coalescence
    )
    settings = {
        "smallest_breaking": checked_number(
            "smallest_breaking", smallest_breaking, "give a diameter in D0", low=0.0
        ),
        "seed": checked_whole("seed", seed, "use 0", low=0, high=2**63 - 1),
    }
    windows = _windows("time", time)
    per_frame = _windows("interval", interval)
    frames_per_piece = max(1, math.ceil(_windows("checkpoint", checkpoint) / per_frame))
    require_on_frame(on_frame)
    if resume and out is None:
        raise InputError.of("out", "given to resume", None, "name the folder of the earlier run")
    stops = checked_on_guard(on_guard) == "stop"
    run = scene.start(settings, thread_count(threads), stops)
    record = scene.record() | settings | {"interval": per_frame * WINDOW}
    folder = None if out is None else EmulsionFolder(Path(out), record, scene.circles, outlines)
    result = Emulsion(parameters=parameters, _folder=folder)
    with (
        ExitStack() as held,
        progress_bar(progress, "emulsion", windows * WINDOW, unit="t0") as show,
    ):
        if folder is not None:
            held.enter_context(held_folder(folder.path))
            held.enter_context(folder)
        recorder = Recorder(run, result, on_frame)
        recorder.begin(resume)
        _run(run, windows, per_frame, frames_per_piece, recorder, show)
    result.warn_of_guards(stacklevel=3)
    return result


def emulsion_parameters(parameters: Parameters) -> Parameters:
    """Return the parameters with the model that a run of many droplets takes by default.

    Raises
    ------
    InputError
        They are none.

    Examples
    --------
    >>> emulsion_parameters(Parameters(simulation_capillary_number=20)).model
    'front-tracking'
    >>> emulsion_parameters(Parameters(edge_stiffness=0.1)).model
    'deformable-particle'
    """
    require_parameters("parameters", parameters)
    springs = {name for name, entry in PARAMETERS.items() if entry.model == SPRINGS}
    if ({"model"} | springs) & parameters.model_fields_set:
        return parameters
    return parameters.replace(model=FRONT)


def _windows(name: str, value: object) -> int:
    length = checked_positive(name, value, "give it in t0")
    if length > 1e7:
        raise InputError.of(name, "at most 1e7 t0", value, "run in pieces, with resume")
    return max(1, math.ceil(length / WINDOW - 1e-9))


def _run(
    run: _core.Emulsion,
    windows: int,
    per_frame: int,
    frames_per_piece: int,
    recorder: Recorder,
    show: Bar | None,
) -> None:
    """Advance from frame to frame; write a piece whenever one is full, and at the end."""
    done = round(run.time / WINDOW)
    frames = 0
    while done < windows and not run.stopped:
        step = min(per_frame - done % per_frame, windows - done)
        run.advance(step)
        done += step
        recorder.take_frame()
        frames += 1
        if frames % frames_per_piece == 0:
            recorder.write_piece()
        if show is not None:
            show(run.time, label=f"{recorder.result.balance['present']} droplets, t0")
    recorder.write_piece()
