"""A filmed collision with its simulation in red, and the two in numbers [paper, appendix B]."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pinchoff.figures import style
from pinchoff.support import palette
from pinchoff.support.numerals import numeral
from pinchoff.video.overlay import rgb_of
from pinchoff.video.scale import clip_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pinchoff.video.comparison import Comparison

_PANELS = 6
_DIAMETERS = 1.5  # of the droplet, shown on either side of the obstacle


def compared(comparison: Comparison) -> list[Axes]:
    """Draw six frames with the simulated outline in red, y(x) and 𝒜(x) of both, and their lag.

    Parameters
    ----------
    comparison : Comparison

    Returns
    -------
    list of Axes
        Of a new figure across two columns: the frames, then y(x), 𝒜(x) and how far the simulated
        droplet is ahead of the filmed one at equal times.
    """
    with style.journal_style():
        figure = style.new_figure(style.TWO_COLUMNS, 6.2)
        grid = figure.add_gridspec(4, _PANELS, height_ratios=(0.8, 1.0, 1.0, 0.7))
        shown = _shown(comparison)
        chosen = shown[np.unique(np.linspace(0, len(shown) - 1, _PANELS).round().astype(int))]
        images = _images(comparison, {int(comparison.frames[k]) for k in chosen})
        frames = [figure.add_subplot(grid[0, column]) for column in range(len(chosen))]
        for panel, k in zip(frames, chosen.tolist(), strict=True):
            _draw_frame(panel, comparison, k, images)
        path = figure.add_subplot(grid[1, :])
        shape, lag = (figure.add_subplot(grid[row, :], sharex=path) for row in (2, 3))
        _draw_path(path, comparison)
        _draw_shape(shape, comparison)
        _draw_lag(lag, comparison)
        return [*frames, path, shape, lag]


def _shown(comparison: Comparison) -> NDArray[np.intp]:
    """Return which of the frames have the droplet's centre well within the pictures."""
    inside = np.flatnonzero(np.abs(comparison.filmed).max(axis=1) < 0.75 * _reach_um(comparison))
    return inside if len(inside) else np.arange(len(comparison.frames))


def _reach_um(comparison: Comparison) -> float:
    """Return how far a picture reaches from the obstacle's centre: small droplets are enlarged."""
    row = comparison.row
    return float(row["obstacle_radius_um"] * (1.0 + _DIAMETERS * row["size_ratio"]))


def _images(comparison: Comparison, wanted: set[int]) -> dict[int, tuple[float, NDArray[np.uint8]]]:
    found = {}
    for frame in clip_of(comparison.source, comparison.settings).frames():
        if frame.number in wanted:
            found[frame.number] = (frame.time_s, rgb_of(frame))
        if len(found) == len(wanted):
            break
    return found


def _draw_frame(
    axes: Axes,
    comparison: Comparison,
    k: int,
    images: dict[int, tuple[float, NDArray[np.uint8]]],
) -> None:
    time, image = images[int(comparison.frames[k])]
    axes.imshow(image)
    for _, outline in comparison.passage.droplets_at(time):
        closed = np.vstack([outline, outline[:1]])
        axes.plot(*closed.T, color=palette.SIMULATED, lw=0.8)
    x, y, radius = comparison.passage.obstacles[0]
    reach = _reach_um(comparison) / comparison.row["obstacle_radius_um"] * radius
    axes.set(xlim=(x - reach, x + reach), ylim=(y + reach, y - reach), xticks=[], yticks=[])
    since = (time - comparison.row["contact_time_s"]) * 1e3
    axes.set_title(f"{numeral(since, '.0f')} ms")


def _draw_path(axes: Axes, comparison: Comparison) -> None:
    axes.plot(*comparison.simulated.T, color=palette.SIMULATED, label="simulation")
    axes.plot(*comparison.filmed.T, "o", ms=2.5, color=palette.INK, label="film")
    axes.set(ylabel=r"$y_\mathrm{CM}$ (µm)")
    title = f"root mean square distance at equal times {comparison.position_rms_um:.1f} µm"
    axes.set_title(title, loc="right")
    axes.legend()


def _draw_shape(axes: Axes, comparison: Comparison) -> None:
    axes.plot(comparison.simulated[:, 0], comparison.simulated_shape, color=palette.SIMULATED)
    axes.plot(comparison.filmed[:, 0], comparison.filmed_shape, "o", ms=2.5, color=palette.INK)
    axes.set(ylabel=r"shape parameter $\mathcal{A}$")
    axes.set_title(f"root mean square difference {comparison.shape_rms:.3f}", loc="right")


def _draw_lag(axes: Axes, comparison: Comparison) -> None:
    """Draw the lag between film and simulation, which curves against the position do not show."""
    ahead = comparison.simulated[:, 0] - comparison.filmed[:, 0]
    axes.plot(comparison.filmed[:, 0], ahead, color=palette.SIMULATED)
    axes.axhline(0.0, color="0.6", lw=0.6, ls=":", zorder=0)
    axes.set(xlabel=r"$x_\mathrm{CM}$ (µm)", ylabel="simulation\nahead (µm)")
