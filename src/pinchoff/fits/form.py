r"""The form of the law that is fitted: its exponents, and how they follow from coefficients.

With

.. math:: \ln\mathrm{Bk} = \frac{\ln\alpha}{\beta} + \ln\mathrm{Ca} + \varepsilon_1 \ln A
    + \varepsilon_2 \ln R + \varepsilon_3 \ln z - \frac{\ln S}{\beta},
    \qquad 2\varepsilon_1 + \varepsilon_2 + \varepsilon_3 = 0

[paper, eq. bkeqn] and P = x/(1 + x), x = Bk^(1/w), ln x is a sum of coefficients times features

.. math:: \ln x = c_0 + c_1 \ln(\mathrm{Ca}\,\tilde A\,\tilde z) + c_2 \ln S + \sum_j c_j L_j

where the constraint makes A^ε1 R^ε2 z^ε3 = Ã^ε1 z̃^ε3, and an exponent that is left free adds the
feature L_j, such as ln Ã, and is 1 + c_j/c_1. So w = 1/c_1, β = -c_1/c_2 and ln α = -c_0/c_2.

With the radius free there is no such constraint: Bk may depend on a length that is none of the
three, a film's thickness or a neck's. Its feature is ln R, relative to the paper's 85 µm, with
2ε1 + ε2 + ε3 = c_R/c_1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pinchoff.fits.likelihood import Equation, Floats
from pinchoff.support import paper_constants as paper
from pinchoff.support.checked import unknown_name


class Exponent(NamedTuple):
    """An exponent that can be left free.

    Attributes
    ----------
    key, symbol : str
    column : str
        Of the collisions table.
    reference : float
        What the column is divided by, so that α stays dimensionless where the exponent is not 1;
        in the column's unit.
    sign : int
        -1: Bk ∝ (reference/column)^exponent.
    held : float
        Its value in the paper's law.
    """

    key: str
    symbol: str
    column: str
    reference: float = 1.0
    sign: int = 1
    held: float = 1.0


EXPONENTS = {
    "area": Exponent("epsilon_1", "ε1", "normalized_area"),
    "thickness": Exponent("epsilon_3", "ε3", "normalized_thickness"),
    "viscosity": Exponent("epsilon_mu", "ε_μ", "viscosity_mPa_s", paper.VISCOSITY_MPA_S),
    "surface_tension": Exponent(
        "epsilon_gamma", "ε_γ", "surface_tension_mN_m", paper.SURFACE_TENSION_MN_M, -1
    ),
    "speed": Exponent("epsilon_v", "ε_v", "speed_mm_s", 1.0),
    "radius": Exponent(
        "dimension", "2ε1 + ε2 + ε3", "obstacle_radius_um", paper.OBSTACLE_RADIUS_UM, held=0.0
    ),
}
"""The exponents by the quantity that they belong to. All are 1 in the paper's law; the radius has
the one that the others leave it, and what is free is by how much it differs from that. μ, γ, v and
R are relative to the paper's standard experiment."""

SYMBOLS = {
    "alpha": "α",
    "beta": "β",
    "w": "w",
    "epsilon_2": "ε2",
    **{exponent.key: exponent.symbol for exponent in EXPONENTS.values()},
}
"""Symbol of every number of the law, by its key."""

MEANINGS = {
    "alpha": "prefactor of the separating line",
    "beta": "its exponent",
    "w": "width of the transition, in ln Bk",
    "epsilon_1": "exponent of the droplet's area A",
    "epsilon_2": "exponent of the obstacle's radius R",
    "epsilon_3": "exponent of the chamber's thickness z",
    "epsilon_mu": "exponent of the viscosity μ",
    "epsilon_gamma": "exponent of 1/γ, the surface tension",
    "epsilon_v": "exponent of the speed v",
    "dimension": "2ε1 + ε2 + ε3, 0 unless a hidden length acts",
}
"""What every number of the law is, by its key, in the order of reports."""

LOGARITHMIC = ("alpha", "beta", "w")
"""Numbers whose intervals are made in their logarithm (of -β), so that they keep their sign."""

_CONSTANT, _FORCING, _SYMMETRY, _FIRST_FREE = range(4)


@dataclass(frozen=True)
class Form:
    """Which exponents are free.

    Attributes
    ----------
    free : tuple of str
        Quantities in `EXPONENTS`, in the order of their coefficients from the fourth on.

    Raises
    ------
    InputError
        There is no such quantity.
    """

    free: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in self.free:
            if name not in EXPONENTS:
                raise unknown_name("free", "quantities with an exponent", name, EXPONENTS)

    @property
    def size(self) -> int:
        """Number of coefficients, k."""
        return _FIRST_FREE + len(self.free)

    @property
    def names(self) -> tuple[str, ...]:
        """The numbers of the law that the coefficients decide, by their keys."""
        decided = {"alpha", "beta", "w", *(EXPONENTS[name].key for name in self.free)}
        if {"area", "thickness", "radius"} & {*self.free}:
            decided.add("epsilon_2")
        return tuple(key for key in MEANINGS if key in decided)

    def scaled(self, coefficients: Floats) -> dict[str, float]:
        """Return the numbers of the law, those in `LOGARITHMIC` as logarithms, by their keys.

        Where the coefficients, (k,), do not have the signs that the law asks for (c1, c2 > 0), NaN.
        """
        c0, c1, c2 = coefficients[:_FIRST_FREE].tolist()
        if not (c1 > 0 and c2 > 0):
            return dict.fromkeys(self.names, math.nan)
        found = {"alpha": -c0 / c2, "beta": math.log(c1 / c2), "w": -math.log(c1)}
        power = {"area": 1.0, "thickness": 1.0, "radius": 0.0}
        for name, c in zip(self.free, coefficients[_FIRST_FREE:].tolist(), strict=True):
            power[name] = found[EXPONENTS[name].key] = EXPONENTS[name].held + c / c1
        found["epsilon_2"] = power["radius"] - 2.0 * power["area"] - power["thickness"]
        return {name: found[name] for name in self.names}

    def gradients(self, coefficients: Floats) -> dict[str, Floats]:
        """Return the derivatives of `scaled` with respect to the coefficients, shape (k,) each."""
        c0, c1, c2 = coefficients[:_FIRST_FREE].tolist()
        unit = np.eye(self.size)
        found = {
            "alpha": -unit[_CONSTANT] / c2 + c0 / c2**2 * unit[_SYMMETRY],
            "beta": unit[_FORCING] / c1 - unit[_SYMMETRY] / c2,
            "w": -unit[_FORCING] / c1,
        }
        slope = dict.fromkeys(("area", "thickness", "radius"), np.zeros(self.size))
        for k, name in enumerate(self.free, start=_FIRST_FREE):
            slope[name] = unit[k] / c1 - coefficients[k] / c1**2 * unit[_FORCING]
            found[EXPONENTS[name].key] = slope[name]
        found["epsilon_2"] = slope["radius"] - 2.0 * slope["area"] - slope["thickness"]
        return {name: found[name] for name in self.names}

    def equation(self, name: str, scaled: float) -> Equation:
        """Return (a, b) such that a·c = b where one of `names` has a value, on `scaled`'s scale."""
        row = np.zeros(self.size)
        if name == "w":
            row[_FORCING] = 1.0
            return row, math.exp(-scaled)
        if name == "alpha":
            row[_CONSTANT], row[_SYMMETRY] = 1.0, scaled
        elif name == "beta":
            row[_FORCING], row[_SYMMETRY] = 1.0, -math.exp(scaled)
        elif name == "epsilon_2":
            row[_FORCING] = 3.0 + scaled
            for quantity, power in (("area", 2.0), ("thickness", 1.0), ("radius", -1.0)):
                if quantity in self.free:
                    row[_FIRST_FREE + self.free.index(quantity)] = power
        else:
            quantity = next(
                candidate for candidate in self.free if EXPONENTS[candidate].key == name
            )
            row[_FIRST_FREE + self.free.index(quantity)] = 1.0
            row[_FORCING] = EXPONENTS[quantity].held - scaled
        return row, 0.0

    def without_symmetry(self) -> Equation:
        """Return (a, b) such that a·c = b where S does not matter."""
        return np.eye(self.size)[_SYMMETRY], 0.0


def unscaled(name: str, scaled: float) -> float:
    """Return a number of the law from its value in `Form.scaled`."""
    if name not in LOGARITHMIC:
        return scaled
    try:
        value = math.exp(scaled)
    except OverflowError:
        value = math.inf
    return 0.0 - value if name == "beta" else value


def free_names(free: str | Sequence[str]) -> tuple[str, ...]:
    """Return the quantities with free exponents, in the order of `EXPONENTS`, each once."""
    given = (free,) if isinstance(free, str) else tuple(free)
    Form(given)
    return tuple(name for name in EXPONENTS if name in given)
