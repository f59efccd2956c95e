"""The computed flow of the device, and a collision in that flow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from numpy.typing import NDArray

from pinchoff.figures import style
from pinchoff.figures.chamber_design import REGION_LOOK, shape_patch
from pinchoff.figures.plane import CONTROL_PARAMETER, CRITICAL_SYMMETRY, logarithmic_axes
from pinchoff.figures.scene import Window, draw_chamber, draw_droplets
from pinchoff.model.flow import Flow, stokes
from pinchoff.support import palette

if TYPE_CHECKING:
    from matplotlib.collections import QuadMesh

    from pinchoff.chamber.flow_check import FlowCheck
    from pinchoff.chamber.obstacle_flow import FlowComparison
    from pinchoff.model.simulation import Collision
    from pinchoff.studies.boundary import Boundary

CHAMBER = palette.VERMILION
STOKES = palette.BLUE

_NODES = 1100  # along the longer side of a map of speeds
_CLOSE_PITCHES = 2.1  # width of the close-up
_FASTEST = 2.0  # times the mean speed of the imaging area: faster fluid has the last colour
_MOMENTS = 5
_LEAST_POINTS = 3  # of a line that is fitted

Floats: TypeAlias = NDArray[np.float64]


def chamber_flow(check: FlowCheck) -> list[Axes]:
    """Draw the speed in the whole device, streamlines round an obstacle, and two profiles.

    Returns
    -------
    list of 3 Axes
        The device, the close-up and the profiles; of one new figure across two columns.
    """
    with style.journal_style():
        figure = style.new_figure(style.TWO_COLUMNS, 5.0)
        panels = figure.subplot_mosaic(
            [["device", "device"], ["close", "profile"]],
            height_ratios=[1.0, 1.15],
            width_ratios=[1.0, 1.25],
        )
        device, close, profile = panels["device"], panels["close"], panels["profile"]
        speeds = _draw_device(device, check)
        bar = figure.colorbar(speeds, ax=device, pad=0.01, extend="max")
        bar.set_label("speed (mm/s)")
        _draw_close(close, check)
        _draw_profiles(profile, check)
        for panel, letter in ((device, "a"), (close, "b"), (profile, "c")):
            panel.set_title(f"({letter})", loc="left")
        return [device, close, profile]


def flow_comparison(compared: FlowComparison) -> list[Axes]:
    """Draw a collision in the chamber's flow beside one in the Stokes flow, and both lines.

    Returns
    -------
    list of 4 Axes
        The two collisions, the speed beside the obstacle and the separating lines.
    """
    with style.journal_style():
        figure = style.new_figure(style.TWO_COLUMNS, 4.9)
        panels = figure.subplot_mosaic(
            [["chamber", "stokes"], ["profile", "line"]], height_ratios=[1.0, 1.45]
        )
        axes = [panels[name] for name in ("chamber", "stokes", "profile", "line")]
        _draw_collision(axes[0], compared.in_chamber, "(a) the chamber's flow")
        _draw_collision(axes[1], compared.in_stokes, "(b) Stokes flow")
        _draw_beside(axes[2], compared)
        _draw_lines(axes[3], compared)
        return axes


def _velocity(check: FlowCheck, x: Floats, y: Floats) -> Floats:
    """Return the velocity on a grid, mm/s; NaN outside the fluid. Shape (len(y), len(x), 2)."""
    grid = np.stack(np.meshgrid(x, y), axis=-1)
    velocity: Floats = check.velocity(grid.reshape(-1, 2)).reshape(grid.shape)
    fluid = check.chamber.layout.fluid
    shapely.prepare(fluid)
    velocity[~shapely.contains_xy(fluid, grid[..., 0], grid[..., 1])] = np.nan
    return velocity


def _draw_speed(axes: Axes, check: FlowCheck, x: Floats, y: Floats, velocity: Floats) -> QuadMesh:
    """Draw the speed on a grid, places in µm."""
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    fastest = _FASTEST * check.imaging_speed_mm_s
    axes.set(xlabel="$x$ (mm)", ylabel="$y$ (mm)", aspect="equal")
    return axes.pcolormesh(
        x / 1e3, y / 1e3, speed, cmap=palette.ORDERED_MAP, vmin=0, vmax=fastest, rasterized=True
    )


def _draw_device(axes: Axes, check: FlowCheck) -> QuadMesh:
    left, low, right, high = check.chamber.layout.fluid.bounds
    step = (right - left) / _NODES
    x, y = np.arange(left, right, step), np.arange(low, high, step)
    mesh = _draw_speed(axes, check, x, y, _velocity(check, x, y))
    axes.add_patch(
        shape_patch(check.chamber.layout.fluid, fill=False, edgecolor=palette.INK, lw=0.3)
    )
    rim = 0.02 * (right - left)
    axes.set(xlim=((left - rim) / 1e3, (right + rim) / 1e3))
    axes.set(ylim=((low - rim) / 1e3, (high + rim) / 1e3))
    return mesh


def _draw_close(axes: Axes, check: FlowCheck) -> None:
    """Draw speed and streamlines round the obstacle in the middle."""
    obstacle, pitch = check.central_obstacle(), check.chamber.imaging.pitch_um
    half = _CLOSE_PITCHES * pitch / 2
    x = obstacle.x_um + np.linspace(-half, half, 400)
    y = obstacle.y_um + np.linspace(-half, half, 400)
    velocity = _velocity(check, x, y)
    _draw_speed(axes, check, x, y, velocity)
    seeds = np.column_stack([np.full(15, x[1]), np.linspace(y[5], y[-6], 15)])
    axes.streamplot(
        *(x / 1e3, y / 1e3, velocity[..., 0], velocity[..., 1]),
        start_points=seeds / 1e3,
        color="white",
        linewidth=0.5,
        arrowsize=0.5,
        density=3,
        broken_streamlines=False,
    )
    for pillar in check.chamber.layout.pillars:
        place = (pillar.x_um / 1e3, pillar.y_um / 1e3)
        axes.add_patch(Circle(place, pillar.radius_um / 1e3, fc=palette.OBSTACLE, lw=0, zorder=3))
    axes.set(xlim=(x[0] / 1e3, x[-1] / 1e3), ylim=(y[0] / 1e3, y[-1] / 1e3))


def _draw_profiles(axes: Axes, check: FlowCheck) -> None:
    """Draw the speed along the middle of the channel, and half a pitch beside it."""
    at, pitch = check.chamber.layout.stations, check.chamber.imaging.pitch_um
    x = np.linspace(at.channel - 600.0, at.outlet, 3000)
    for y, color, label in (
        (0.0, palette.BLACK, "$y$ = 0"),
        (pitch / 2, CHAMBER, f"$y$ = {pitch / 2:g} µm"),
    ):
        along = _velocity(check, x, np.array([y]))[0, :, 0]
        axes.plot(x / 1e3, along, color=color, lw=0.9, label=label)
    mean = check.imaging_speed_mm_s
    axes.axhline(mean, color="0.5", lw=0.8, ls=(0, (4, 2)), label="mean of the imaging area")
    axes.axvspan(at.imaging / 1e3, at.exit / 1e3, color=REGION_LOOK["imaging"][0], alpha=0.2, lw=0)
    axes.text(*((at.imaging + at.exit) / 2e3, 2.85 * mean, "imaging area"), ha="center", va="top")
    before = (at.channel + at.imaging) / 2e3
    axes.text(before, 2.85 * mean, "droplets'\nchannel", ha="center", va="top")
    axes.set(xlim=(x[0] / 1e3, x[-1] / 1e3), ylim=(0, 3.0 * mean))
    axes.set(xlabel="$x$ (mm)", ylabel="velocity along $x$ (mm/s)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, columnspacing=1.0)


def _draw_collision(axes: Axes, collision: Collision, title: str) -> None:
    """Draw the droplet at some moments, from the start to shortly after its break-up."""
    outlines = collision.outlines
    assert outlines is not None
    window = Window(-1.6, 2.2, -1.0, 1.0)
    draw_chamber(axes, outlines, window)
    times = np.asarray(outlines.times)
    begin = collision.contact_time if np.isfinite(collision.contact_time) else times[-1] / 2
    wanted = np.linspace(begin - 0.8, begin + 1.6, _MOMENTS)
    for moment in dict.fromkeys(int(np.argmin(np.abs(times - t))) for t in wanted):
        draw_droplets(axes, outlines[moment], rim=0.7).set_alpha(0.55)
    heading = f"{title}: $S$ = {collision.symmetry:.2f}, {collision.outcome}"
    axes.set_title(heading, loc="left", fontsize=7.5)


def _draw_beside(axes: Axes, compared: FlowComparison) -> None:
    """Draw the velocity along x on the line through the obstacle's centre, across the flow."""
    radius = 1.0 / compared.in_chamber.parameters.size_ratio
    y = np.linspace(0.0, 1.4, 400)
    beside = np.column_stack([np.zeros_like(y), y])
    before = np.column_stack([-y, np.zeros_like(y)])
    flows: Sequence[tuple[Flow, str, str]] = (
        (compared.flow, CHAMBER, "chamber"),
        (stokes(radius), STOKES, "Stokes"),
    )
    for flow, color, name in flows:
        for points, dashes, where in (
            (beside, "-", "beside ($x=0$)"),
            (before, (0, (3, 1.5)), "before ($y=0$)"),
        ):
            along = np.asarray(flow.velocity(points))[:, 0]
            axes.plot(along, y / radius, color=color, ls=dashes, label=f"{name}, {where}")
    axes.axhspan(0, 1, color=palette.OBSTACLE, alpha=0.25, lw=0)
    axes.set(xlabel="velocity along $x$ ($v_{f\\infty}$)", ylabel="distance from the centre ($R$)")
    axes.set(ylim=(0, 1.4 / radius))
    axes.text(0.98, 0.5, "obstacle", transform=axes.get_yaxis_transform(), ha="right", va="center")
    axes.set_title("(c) beside and before the obstacle", loc="left", fontsize=7.5)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, columnspacing=1.0)


def _draw_lines(axes: Axes, compared: FlowComparison) -> None:
    control: list[float] = []
    lines: Sequence[tuple[Boundary, str, str]] = (
        (compared.line_in_chamber, CHAMBER, "chamber"),
        (compared.line_in_stokes, STOKES, "Stokes"),
    )
    for line, color, name in lines:
        found = line.found
        control += found["control_parameter"].tolist()
        label = name
        if len(found) >= _LEAST_POINTS:
            fit = line.fit()
            wide = np.geomspace(*fit.control_range, 50)
            axes.plot(wide, fit.symmetry(wide)[0], color=color, lw=0.8)  # named by its points
            label = rf"{name}; line: {fit.alpha.value:.3f} $x^{{{fit.beta.value:.2f}}}$"
        points = found["control_parameter"], found["critical_symmetry"]
        axes.plot(*points, "o", ms=3.5, color=color, label=label)
    if control:
        logarithmic_axes(axes, np.array([0.85 * min(control), 1.15 * max(control)]))
    axes.set(xlabel=rf"$x$ = {CONTROL_PARAMETER}", ylabel=CRITICAL_SYMMETRY)
    axes.set_title("(d) separating lines", loc="left", fontsize=7.5)
    axes.legend(loc="lower left")
