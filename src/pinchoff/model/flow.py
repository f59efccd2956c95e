"""Flows of the continuous phase: the fluid's velocity as a function of position.

A flow that another program has computed comes in through `sampled`. All lengths are in D0, all
speeds in v_f∞.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff import _core
from pinchoff.support.arguments import checked_number, checked_positive
from pinchoff.support.errors import InputError

Flow: TypeAlias = _core.Flow
"""What the constructors below return; ``.velocity(points)`` takes and gives (n, 2) arrays."""

_ADVICE = "give it in D0 or v_f∞"
_BRINKMAN_CELLS = 2048  # of R/r
_LEAST_NODES = 4
_SPACING_TOLERANCE = 1e-4  # of the spacing: axes of single precision are regular


def stokes(radius: float, center: tuple[float, float] = (0.0, 0.0)) -> Flow:
    """Creeping flow in +x around a circular obstacle [paper, eqs. v_r fluid, v_theta fluid].

    The velocity vanishes on the obstacle and inside it, and grows like ln(r/R) far away.

    Parameters
    ----------
    radius : float
        R, D0.
    center : (float, float), optional
        The obstacle's centre, D0.

    Raises
    ------
    InputError
        A number is not finite, or the radius not positive.

    Examples
    --------
    >>> flow = stokes(0.2)
    >>> flow.velocity(np.array([[0.2, 0.0], [0.0, 1.0]]))[:, 0].round(3).tolist()
    [0.0, 2.089]
    """
    radius = checked_positive("radius", radius, "give the obstacle's R in D0")
    return _core.StokesFlow(radius, *_pair(center))


def _pair(center: tuple[float, float]) -> tuple[float, float]:
    try:
        x, y = center
    except (TypeError, ValueError):
        advice = "give the obstacle's x and y in D0"
        raise InputError.of("center", "a pair of numbers", center, advice) from None
    return checked_number("center[0]", x, _ADVICE), checked_number("center[1]", y, _ADVICE)


def brinkman(radius: float, thickness: float, center: tuple[float, float] = (0.0, 0.0)) -> Flow:
    r"""Depth-averaged flow in +x past a circular obstacle in a gap, with walls above and below.

    Brinkman's equation, ∇p = μ∇²v - (12μ/z²) v, in closed form. With κ = √12/z the stream function
    is ψ = (r + a/r + b K₁(κr)) sin θ, where b = 2/(κ K₀(κR)) and a = -R² - b R K₁(κR) make the
    velocity vanish on the obstacle. Far away it is 1, unlike `stokes`, which grows like ln(r/R);
    for z ≫ R it is that flow over K₀(κR) near the obstacle.

    Parameters
    ----------
    radius : float
        R, D0.
    thickness : float
        z of the gap, D0; from R/50 to 100 R.
    center : (float, float), optional
        The obstacle's centre, D0.

    Raises
    ------
    InputError
        A number is not finite, not positive, or the gap is out of that range.

    Examples
    --------
    >>> flow = brinkman(0.2, 0.2)
    >>> flow.velocity(np.array([[0.2, 0.0], [0.0, 1.0], [50.0, 0.0]]))[:, 0].round(3).tolist()
    [0.0, 1.066, 1.0]
    """
    radius = checked_positive("radius", radius, "give the obstacle's R in D0")
    thickness = checked_positive("thickness", thickness, "give the gap's z in D0")
    if not radius / 50 <= thickness <= 100 * radius:
        rule = f"from radius/50 to 100 radius, {radius / 50:g} to {100 * radius:g}"
        advice = "use stokes for a thicker gap"
        raise InputError.of("thickness", rule, thickness, advice)
    x, y = _pair(center)
    cells = _brinkman_cells(math.sqrt(12.0) * radius / thickness)
    return _core.BrinkmanFlow(radius, x, y, cells)


def _brinkman_cells(x: float) -> NDArray[np.float64]:
    """Return f - g and g as cubics in s = R/r, shape (n, 8), as the core takes them; x = κR.

    v_r = f cos θ and v_θ = -g sin θ, with f = ψ/(r sin θ) and g = d(r f)/dr. Cubics of Hermite
    have value and slope of the closed form at every node.
    """
    from scipy.special import kve

    s = np.arange(1, _BRINKMAN_CELLS + 1) / _BRINKMAN_CELLS
    # K₀ and K₁ at κr = x/s, over K₀ at the wall; kve is without the factor exp(-κr)
    fall = np.exp(x - x / s) / kve(0, x)
    k0, k1 = kve(0, x / s) * fall, kve(1, x / s) * fall
    a = -1.0 - 2.0 * kve(1, x) / (x * kve(0, x))  # a/R²
    f = 1.0 + a * s**2 + 2.0 * s * k1 / x
    g = 1.0 - a * s**2 - 2.0 * (k0 + s * k1 / x)
    slope_f = (f - g) / s
    # dg/ds = -(x/s²) dg/d(κr), with K₀' = -K₁ and (K₁/κr)' = -K₀/κr - 2 K₁/(κr)²
    slope_g = -2.0 * a * s - 2.0 * (k1 * x / s**2 + k0 / s + 2.0 * k1 / x)
    # at s = 0, infinitely far away: f = g = 1, without slope
    h = 1.0 / _BRINKMAN_CELLS
    cubics = [
        _hermite(np.append(first, value), h * np.append(0.0, slope))
        for first, value, slope in ((0.0, f - g, slope_f - slope_g), (1.0, g, slope_g))
    ]
    return np.ascontiguousarray(np.concatenate(cubics, axis=1))


def _hermite(value: NDArray[np.float64], slope: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return cubics between nodes (n + 1,), shape (n, 4), in the fraction of a cell."""
    rise = np.diff(value)
    second = 3.0 * rise - 2.0 * slope[:-1] - slope[1:]
    third = slope[:-1] + slope[1:] - 2.0 * rise
    return np.stack([value[:-1], slope[:-1], second, third], axis=1)


def uniform(vx: float = 1.0, vy: float = 0.0) -> Flow:
    """Return the same velocity everywhere.

    Parameters
    ----------
    vx, vy : float, optional
        v_f∞.

    Raises
    ------
    InputError
        A component is not finite.

    Examples
    --------
    >>> uniform(0.5).velocity(np.array([[3.0, -2.0]])).tolist()
    [[0.5, 0.0]]
    """
    return _core.UniformFlow(checked_number("vx", vx, _ADVICE), checked_number("vy", vy, _ADVICE))


def sampled(x: ArrayLike, y: ArrayLike, u: ArrayLike, v: ArrayLike, *, periodic: str = "") -> Flow:
    """Flow given at the nodes of a regular grid, bicubic between them.

    What lies between two nodes is not known to the flow: some ten nodes across each obstacle's
    radius and each gap resolve the layer in which the velocity falls to zero.

    Parameters
    ----------
    x : array_like, shape (nx,)
        Ascending, evenly spaced, D0; at least 4 nodes.
    y : array_like, shape (ny,)
        As `x`.
    u, v : array_like, shape (ny, nx)
        The velocity's x and y components at the nodes, v_f∞.
    periodic : {"", "x", "y", "xy"}, optional
        Axes along which the flow repeats itself: the node after the last one is the first.

    Raises
    ------
    InputError
        An axis is not ascending, regular and long enough; an array has the wrong shape; or a
        number is not finite.

    Examples
    --------
    >>> nodes = np.linspace(0.0, 3.0, 4)
    >>> u, v = np.meshgrid(nodes, nodes)
    >>> sampled(nodes, nodes, u, -v).velocity(np.array([[1.5, 0.5]])).round(12).tolist()
    [[1.5, -0.5]]
    """
    x_nodes, y_nodes = _axis("x", x), _axis("y", y)
    if periodic not in ("", "x", "y", "xy"):
        advice = "leave it out where the flow does not repeat itself"
        raise InputError.of("periodic", "'x', 'y', 'xy' or ''", periodic, advice)
    shape = (y_nodes.size, x_nodes.size)
    return _core.SampledFlow(
        x_nodes[0],
        y_nodes[0],
        (x_nodes[-1] - x_nodes[0]) / (x_nodes.size - 1),
        (y_nodes[-1] - y_nodes[0]) / (y_nodes.size - 1),
        _component("u", u, shape),
        _component("v", v, shape),
        periodic_x="x" in periodic,
        periodic_y="y" in periodic,
    )


def _array(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError.of(name, "an array of numbers", str(error), "check its shape") from None
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        got = f"{array[where]} at index {where}"
        raise InputError.of(name, "finite everywhere", got, "fill the gaps, with 0 in obstacles")
    return array


def _axis(name: str, values: ArrayLike) -> NDArray[np.float64]:
    axis = _array(name, values)
    if axis.ndim != 1 or axis.size < _LEAST_NODES:
        rule = f"one-dimensional with at least {_LEAST_NODES} nodes"
        raise InputError.of(name, rule, f"shape {axis.shape}", "give the positions of the nodes")
    steps = np.diff(axis)
    if not (steps > 0).all() or np.ptp(steps) > _SPACING_TOLERANCE * steps.mean():
        got = f"steps from {steps.min():g} to {steps.max():g}"
        raise InputError.of(name, "ascending and evenly spaced", got, "resample the flow first")
    return axis


def _component(name: str, values: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    component = _array(name, values)
    if component.shape != shape:
        rule = f"of shape (len(y), len(x)) = {shape}"
        raise InputError.of(name, rule, f"shape {component.shape}", "transpose it if need be")
    return component
