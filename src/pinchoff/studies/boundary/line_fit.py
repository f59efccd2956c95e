"""The separating line as a power law, fitted in logarithms, with honest intervals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pinchoff.collisions.law import Line
from pinchoff.support.arguments import checked_confidence
from pinchoff.support.errors import InputError
from pinchoff.support.interval import Estimate
from pinchoff.support.numerals import counted

_METHOD = "least squares in logarithms, Student's t"


@dataclass(frozen=True, eq=False)
class LineFit:
    """A fitted line S_c = α (Ca Ã^p z̃)^β; p = 1 unless it was left free.

    Attributes
    ----------
    alpha, beta : Estimate
        Prefactor and exponent, dimensionless.
    area_power : Estimate
        Exponent of Ã itself, βp; the same as beta where p = 1.
    area_exponent : Estimate
        p, dimensionless; exactly 1 unless it was left free.
    speed : str
        "flow": Ca has v_f∞. "contact": Ca has the droplet's speed at first contact.
    confidence : float
        Of the intervals, such as 0.95.
    count : int
        Points that it was fitted to.
    control_range, size_ratio_range, symmetry_range : (float, float)
        Least and greatest Ca Ã z̃, D0/R and S_c of those points.
    residuals : ndarray, shape (count,)
        ln of the points' S_c over that of the line.
    coefficients : ndarray, shape (n,)
        ln α, the exponent of Ca, and where it is free that of Ã.
    covariance : ndarray, shape (n, n)
        Of the coefficients: from the scatter about the line and from the brackets' widths.
    """

    alpha: Estimate
    beta: Estimate
    area_power: Estimate
    area_exponent: Estimate
    speed: str
    confidence: float
    count: int
    control_range: tuple[float, float]
    size_ratio_range: tuple[float, float]
    symmetry_range: tuple[float, float]
    residuals: NDArray[np.float64]
    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]

    @property
    def line(self) -> Line:
        """The line as `pinchoff.collisions.law.breakup_number` takes it; of use where p = 1."""
        return Line(self.alpha.value, self.beta.value)

    @property
    def scatter(self) -> float:
        """Root mean square of the residuals: the typical relative distance from the line."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def symmetry(
        self, capillary_number: ArrayLike, normalized_area: ArrayLike = 1.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return S_c on the line and the ends of its confidence interval.

        Parameters
        ----------
        capillary_number : array_like, shape (...)
            Ca z̃, or Ca Ã z̃ where p = 1 and no area is given; with the speed that was fitted.
        normalized_area : array_like, shape (...), optional
            Ã.

        Returns
        -------
        value, low, high : ndarray, shape (...)
            Dimensionless. The interval is that of the line, not of single points.
        """
        log_ca, log_area = np.broadcast_arrays(np.log(capillary_number), np.log(normalized_area))
        if self.coefficients.size == 2:
            rows = np.stack([np.ones_like(log_ca), log_ca + log_area], axis=-1)
        else:
            rows = np.stack([np.ones_like(log_ca), log_ca, log_area], axis=-1)
        value = rows @ self.coefficients
        variance = np.einsum("...i,ij,...j->...", rows, self.covariance, rows)
        reach = _quantile(self.confidence, self.count - self.coefficients.size) * np.sqrt(variance)
        return np.exp(value), np.exp(value - reach), np.exp(value + reach)

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold: numbers, intervals and ranges."""
        estimates = ("alpha", "beta", "area_power", "area_exponent")
        return {
            "form": "S_c = alpha (Ca A^p z)^beta",
            **{name: getattr(self, name)._asdict() for name in estimates},
            "area_exponent_free": self.coefficients.size == 3,
            "speed": self.speed,
            "confidence": self.confidence,
            "count": self.count,
            "control_range": list(self.control_range),
            "size_ratio_range": list(self.size_ratio_range),
            "symmetry_range": list(self.symmetry_range),
            "scatter": self.scatter,
            "largest_residual": float(np.abs(self.residuals).max()),
        }

    def __str__(self) -> str:
        tied = self.coefficients.size == 2
        area = "Ã" if tied else f"Ã^{self.area_exponent.value:.3g}"
        return (
            f"S_c = {self.alpha.value:.4g} (Ca {area} z̃)^{self.beta.value:.3g}, "
            f"{self.confidence:.0%} intervals: α {self.alpha.low:.4g} to {self.alpha.high:.4g}, "
            f"β {self.beta.low:.3g} to {self.beta.high:.3g}"
            + ("" if tied else f", p {self.area_exponent.low:.3g} to {self.area_exponent.high:.3g}")
            + f"; {self.count} points, Ca Ã z̃ from {self.control_range[0]:.3g} to "
            f"{self.control_range[1]:.3g}"
        )


def fit_line(
    capillary_number: ArrayLike,
    normalized_area: ArrayLike,
    symmetry: ArrayLike,
    width: ArrayLike = 0.0,
    *,
    free_area: bool = False,
    speed: str = "flow",
    confidence: float = 0.95,
) -> LineFit:
    r"""Fit S_c = α (Ca Ã z̃)^β, or S_c = α (Ca Ã^p z̃)^β, by least squares in logarithms.

    The covariance of the coefficients is

    .. math:: s^2 (X^T X)^{-1} + H V H^T, \qquad H = (X^T X)^{-1} X^T

    with the scatter s² of the points about the line and V = diag(w²/(12 S²)), the variance of a
    critical symmetry that may lie anywhere in its bracket of width w. Intervals take Student's t
    for the degrees of freedom that are left. The brackets count twice, since they are part of the
    scatter too: the intervals are rather too wide than too narrow.

    Parameters
    ----------
    capillary_number, normalized_area, symmetry : array_like, shape (n,)
        Ca z̃, Ã and S_c of each point, dimensionless.
    width : array_like, shape (n,) or (), optional
        Widths of the brackets in S.
    free_area : bool, optional
        Whether p is fitted too; its interval follows from those of βp and β to first order.
    speed : str, optional
        Kept as `LineFit.speed`.
    confidence : float, optional
        Of the intervals.

    Raises
    ------
    InputError
        There are too few points, or they do not differ in Ca Ã z̃ (with `free_area`: in Ca and Ã
        independently).

    Examples
    --------
    >>> control = np.array([0.05, 0.1, 0.2])
    >>> fit = fit_line(control, np.ones(3), 0.089 * control**-0.72)
    >>> round(fit.alpha.value, 3), round(fit.beta.value, 2)
    (0.089, -0.72)
    """
    confidence = checked_confidence(confidence)
    ca, area, s = (
        np.asarray(values, dtype=np.float64)
        for values in (capillary_number, normalized_area, symmetry)
    )
    log_ca, log_area = np.log(ca), np.log(area)
    columns = [log_ca, log_area] if free_area else [log_ca + log_area]
    design = np.stack([np.ones_like(log_ca), *columns], axis=1)
    _require_rank(design)
    coefficients, covariance, residuals = _least_squares(design, s, np.asarray(width))
    quantile = _quantile(confidence, s.size - design.shape[1])
    reach = quantile * np.sqrt(np.diag(covariance))
    low, high = coefficients - reach, coefficients + reach
    estimates = [
        Estimate(float(value), float(least), float(most), _METHOD)
        for value, least, most in zip(coefficients, low, high, strict=True)
    ]
    return LineFit(
        alpha=_exponential(estimates[0]),
        beta=estimates[1],
        area_power=estimates[-1],
        area_exponent=_ratio(coefficients, covariance, quantile)
        if free_area
        else Estimate(1.0, 1.0, 1.0, "fixed"),
        speed=speed,
        confidence=confidence,
        count=s.size,
        control_range=_range(ca * area),
        size_ratio_range=_range(np.sqrt(area * 4 / math.pi)),
        symmetry_range=_range(s),
        residuals=residuals,
        coefficients=coefficients,
        covariance=covariance,
    )


def _least_squares(
    design: NDArray[np.float64], symmetry: NDArray[np.float64], width: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the coefficients of ln S, their covariance as of `fit_line`, and the residuals."""
    inverse = np.linalg.inv(design.T @ design)
    solver = inverse @ design.T
    coefficients = solver @ np.log(symmetry)
    residuals = np.log(symmetry) - design @ coefficients
    freedom = symmetry.size - design.shape[1]
    bracket = np.broadcast_to(np.square(width / symmetry) / 12, symmetry.shape)
    covariance = inverse * (residuals @ residuals) / freedom + (solver * bracket) @ solver.T
    return coefficients, covariance, residuals


def _require_rank(design: NDArray[np.float64]) -> None:
    points, unknowns = design.shape
    # Taken from the mean, so that values that differ by rounding alone are not a range.
    spread = design[:, 1:] - design[:, 1:].mean(axis=0) if points else design[:, 1:]
    if points > unknowns and np.linalg.matrix_rank(spread, tol=1e-6) == unknowns - 1:
        return
    differ = "Ca and Ã independently" if unknowns == 3 else "Ca Ã z̃"
    raise InputError.of(
        "boundary",
        f"{unknowns + 1} or more points with a critical symmetry that differ in {differ}",
        counted(points, "point"),
        "vary simulation_capillary_number" + (" and size_ratio" if unknowns == 3 else ""),
    )


def _ratio(
    coefficients: NDArray[np.float64], covariance: NDArray[np.float64], quantile: float
) -> Estimate:
    """Return the exponent p of Ã: the ratio of its power and β, to first order in their errors."""
    _, beta, power = coefficients
    slope = np.array([0.0, -power / beta**2, 1.0 / beta])
    reach = quantile * math.sqrt(slope @ covariance @ slope)
    value = float(power / beta)
    return Estimate(value, value - reach, value + reach, _METHOD)


def _exponential(logarithm: Estimate) -> Estimate:
    value, low, high = (math.exp(end) for end in logarithm[:3])
    return Estimate(value, low, high, _METHOD)


def _quantile(confidence: float, freedom: int) -> float:
    from scipy.stats import t  # slow to import

    return float(t.ppf(0.5 + confidence / 2, freedom))


def _range(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values.min()), float(values.max())
