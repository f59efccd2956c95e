"""Energy and forces of one droplet of any shape, term by term."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff import _core
from pinchoff.model.arrangement import obstacle_circles
from pinchoff.model.parameters import Parameters
from pinchoff.support.errors import InputError

TERMS: tuple[str, ...] = _core.TERMS
"""The terms of the energy [paper, eqs. shape, U_γ and U_w]."""

LEAST_VERTICES = 16


def total_energy(parameters: Parameters, outline: ArrayLike) -> dict[str, float]:
    """Energy of a droplet against its obstacle, U = U_s + U_w [paper, section 3.1].

    Parameters
    ----------
    parameters : Parameters
        The model; A_eq is that of its undeformed droplet.
    outline : array_like, shape (n, 2)
        Vertices in D0, counter-clockwise, the obstacle's centre at the origin; n at least 16.

    Returns
    -------
    dict of str to float
        Each of `TERMS` and their sum ``total``, in M v_f∞².

    Raises
    ------
    InputError
        The outline is not such an array.

    Examples
    --------
    >>> import numpy as np
    >>> t = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    >>> circle = np.column_stack([np.cos(t) - 4, np.sin(t)]) / 2
    >>> round(total_energy(Parameters(), circle)["line_tension"] / (80 * np.pi), 3)
    1.0
    """
    energies = _core.term_energies(parameters.model_row(), *_scene(parameters, outline))
    return {name: energies[name] for name in (*TERMS, "total")}


def term_forces(parameters: Parameters, outline: ArrayLike) -> dict[str, NDArray[np.float64]]:
    """Force of every term of the energy on every vertex.

    Parameters
    ----------
    parameters : Parameters
    outline : array_like, shape (n, 2)
        As for `total_energy`.

    Returns
    -------
    dict of str to ndarray, shape (n, 2)
        Each of `TERMS`, in M v_f∞²/D0.

    Raises
    ------
    InputError
        The outline is not such an array.

    Examples
    --------
    >>> t = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    >>> circle = np.column_stack([np.cos(t) - 4, np.sin(t)]) / 2
    >>> forces = term_forces(Parameters(), circle)
    >>> [(name, bool(force.any())) for name, force in forces.items()]
    [('area', True), ('edges', True), ('line_tension', True), ('wall', False), ('adhesion', False)]
    """
    forces: dict[str, NDArray[np.float64]] = _core.term_forces(
        parameters.model_row(), *_scene(parameters, outline)
    )
    return forces


def _scene(
    parameters: Parameters, outline: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rule = f"a finite array of shape (n, 2) with n at least {LEAST_VERTICES}"
    advice = "give the vertices in D0, counter-clockwise"
    try:
        vertices = np.ascontiguousarray(outline, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError.of("outline", rule, type(outline).__name__, advice) from None
    if vertices.ndim != 2 or vertices.shape[1] != 2 or len(vertices) < LEAST_VERTICES:
        raise InputError.of("outline", rule, f"shape {vertices.shape}", advice)
    if not np.isfinite(vertices).all():
        raise InputError.of("outline", rule, "a number that is not finite", advice)
    x, y = vertices.T
    if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) <= 0:
        raise InputError.of("outline", "counter-clockwise", "clockwise", "reverse its order")
    return vertices, obstacle_circles(parameters, None)
