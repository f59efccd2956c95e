"""Droplet sizes of an emulsion: means and distributions, rates, and steadiness.

Every error comes from blocks of time, as `block_errors` says.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pinchoff.studies.block_errors import (
    BLOCK,
    FEWEST_BLOCKS,
    MOST_BLOCKS,
    Floats,
    Measured,
    correlation_time,
    jackknife,
)
from pinchoff.support.arguments import checked_number
from pinchoff.support.numerals import counted

if TYPE_CHECKING:
    import pandas as pd

FEWEST_FRAMES = 8
"""Fewer tell no correlation time."""

STEADY_TIMES = 5.0
"""Residence times without a trend, for sizes to be called steady."""

_CREATES, _REMOVES = ("entered", "breakup"), ("left", "merge", "retired")
_RATED = ("entered", "left", "breakup", "merge", "retired")


@dataclass(frozen=True, eq=False)
class SizeStudy:
    """What the sizes of a run tell.

    Attributes
    ----------
    series : DataFrame
        A row a frame: time, count, area (in all, D0²), mean_diameter and weighted_diameter (by
        area), D0, and mean_area, D0².
    start, end : float
        Of what means and rates are taken over, t0.
    correlation_time : float
        Of the mean area, t0.
    blocks : int
    mean_diameter, weighted_diameter, mean_area : Measured
        Over all droplets of all frames; the second weighted by area.
    dispersity : Measured
        <A²>/<A>²: 1 for droplets of one size, 2 for an exponential distribution of areas.
    edges : ndarray, shape (b + 1,)
        Of the bins in diameter, D0.
    by_number, by_area : ndarray, shape (b, 2)
        Density of the distribution of diameters, 1/D0, and its standard error.
    rates : dict of str to Measured
        Events of each kind per t0.
    growth : Measured
        Droplets gained per t0: entered and break-ups less left, merged and retired.
    exchange : Measured
        Merges per break-up: 1 where the two balance, NaN without break-ups.
    residence_time : float
        t0, by Little's law: droplets present per droplet that leaves; else as given.
    trend : Measured
        Change of the mean area over the last `STEADY_TIMES` residence times, as a share of it.
    steady : bool or None
        None: the record is too short to tell.
    remarks : list of str
        What a reader has to know beside the numbers.
    """

    series: pd.DataFrame
    start: float
    end: float
    correlation_time: float
    blocks: int
    mean_diameter: Measured
    weighted_diameter: Measured
    mean_area: Measured
    dispersity: Measured
    edges: Floats
    by_number: Floats
    by_area: Floats
    rates: dict[str, Measured]
    growth: Measured
    exchange: Measured
    residence_time: float
    trend: Measured
    steady: bool | None
    remarks: list[str] = field(default_factory=list)


def study_sizes(
    sizes: pd.DataFrame,
    events: pd.DataFrame,
    *,
    start: float | None = None,
    residence_time: float | None = None,
    bins: int = 24,
) -> SizeStudy:
    """Study the sizes and events of a run.

    Parameters
    ----------
    sizes, events : DataFrame
        Of an `Emulsion`.
    start : float, optional
        What came before is left out, t0; by default the first half of the run.
    residence_time : float, optional
        t0; where droplets leave it follows from the run.
    bins : int, optional
        Of the distribution.

    Returns
    -------
    SizeStudy
        What is not known from so many frames is not a number, and a remark says why.

    Examples
    --------
    >>> import pandas as pd
    >>> sizes = pd.DataFrame({"time": np.repeat(np.arange(20.0), 2), "diameter": [1.0, 2.0] * 20})
    >>> study = study_sizes(sizes, pd.DataFrame({"time": [], "kind": []}), residence_time=1.0)
    >>> study.mean_diameter.value, round(study.weighted_diameter.value, 3)
    (1.5, 1.8)
    """
    series = _series(sizes)
    end = float(series["time"].max()) if len(series) else 0.0
    begin = 0.5 * end if start is None else checked_number("start", start, "give it in t0")
    kept = series[series["time"] >= begin]
    correlation, ends, remarks = _blocks(
        kept["time"].to_numpy(np.float64), kept["mean_area"].to_numpy(np.float64), begin
    )
    # Blocks begin with the first frame that is kept, which may be later than `begin`.
    happened = events[(events["time"] > ends[0]) & (events["time"] <= end)]
    rates, growth, exchange = _event_rates(happened, ends)
    if rates["left"].value > 0:
        residence_time = float(kept["count"].mean()) / rates["left"].value
    residence = math.nan if residence_time is None else residence_time
    trend = _trend(series, residence)
    steady = _steady(growth, trend)
    if steady is None:
        known = f"each {residence:.3g} t0 long."
        remarks.append(
            "Whether sizes are steady was not measured, because that takes an error of the rates "
            f"and {STEADY_TIMES:g} residence times, "
            + ("which are not known before a droplet has left." if math.isnan(residence) else known)
        )
    return SizeStudy(
        series=series,
        start=begin,
        end=end,
        correlation_time=correlation,
        blocks=len(ends) - 1,
        **_distribution(sizes[sizes["time"] >= begin], ends, bins),
        rates=rates,
        growth=growth,
        exchange=exchange,
        residence_time=residence,
        trend=trend,
        steady=steady,
        remarks=remarks,
    )


def _blocks(times: Floats, areas: Floats, begin: float) -> tuple[float, Floats, list[str]]:
    """Return the correlation time, the ends of the blocks, and what has to be said of them."""
    if not len(times):
        remark = (
            f"Sizes were not measured, because no frame from t = {begin:.4g} t0 on has a droplet. "
            "Run for longer."
        )
        return math.nan, np.array([begin, begin]), [remark]
    last = times[-1] if len(times) == 1 else float(np.nextafter(times[-1], np.inf))
    if len(times) < FEWEST_FRAMES:
        remark = (
            f"Errors were not measured, because only {counted(len(times), 'frame')} from "
            f"t = {begin:.4g} t0 on {'has' if len(times) == 1 else 'have'} droplets. "
            "Run for longer, or lower interval."
        )
        return math.nan, np.array([times[0], last]), [remark]
    correlation = correlation_time(times, areas)
    spans = (times[-1] - times[0]) / correlation
    count = int(min(MOST_BLOCKS, spans // BLOCK))
    remarks = []
    if count < FEWEST_BLOCKS:
        remarks.append(
            f"Errors were not measured, because the record from t = {begin:.4g} t0 on is "
            f"{spans:.2g} correlation times long, and they take {BLOCK * FEWEST_BLOCKS:g}. "
            "Run for longer."
        )
    return correlation, np.linspace(times[0], last, max(count, 1) + 1), remarks


def _ratio(part: float, whole: float) -> float:
    return float(part / whole) if whole > 0 else math.nan


def _series(sizes: pd.DataFrame) -> pd.DataFrame:
    import pandas as pd

    d = sizes["diameter"].to_numpy(np.float64)
    frames = pd.DataFrame({"d": d, "d2": d**2, "d3": d**3}).groupby(sizes["time"].to_numpy())
    count, sums = frames.size().to_numpy(), frames.sum()
    area = math.pi / 4 * sums["d2"].to_numpy()
    return pd.DataFrame(
        {
            "time": sums.index.to_numpy(np.float64),
            "count": count,
            "area": area,
            "mean_diameter": sums["d"].to_numpy() / count,
            "weighted_diameter": (sums["d3"] / sums["d2"]).to_numpy(),
            "mean_area": area / count,
        }
    )


def _block_sums(ends: Floats, times: Floats, *weights: Floats) -> Floats:
    """Return the sum of each weight over each block, shape (blocks, weights)."""
    which = np.clip(np.searchsorted(ends, times, side="right") - 1, 0, len(ends) - 2)
    sums = [np.bincount(which, weight, minlength=len(ends) - 1) for weight in weights]
    return np.column_stack(sums).astype(np.float64)


def _distribution(sizes: pd.DataFrame, ends: Floats, bins: int) -> dict[str, Any]:
    """Return the means and the distributions of a `SizeStudy`."""
    times = sizes["time"].to_numpy(np.float64)
    d = sizes["diameter"].to_numpy(np.float64)
    edges = np.linspace(0.0, 1.0001 * d.max(initial=0.0) or 1.0, bins + 1)
    moments = _block_sums(ends, times, *(d**k for k in range(5)))

    def mean(of: Callable[[Floats], float]) -> Measured:
        return jackknife(moments, of)

    def density(weights: Floats) -> Floats:
        """Return density and error of each bin, shape (bins, 2)."""
        blocks, _, _ = np.histogram2d(times, d, (ends, edges), weights=weights)
        widths = np.diff(edges)

        def of_bin(sums: Floats, k: int) -> float:
            return _ratio(sums[k], sums.sum() * widths[k])

        return np.array([jackknife(blocks, partial(of_bin, k=k)) for k in range(bins)])

    return {
        "mean_diameter": mean(lambda m: _ratio(m[1], m[0])),
        "weighted_diameter": mean(lambda m: _ratio(m[3], m[2])),
        "mean_area": mean(lambda m: _ratio(math.pi / 4 * m[2], m[0])),
        "dispersity": mean(lambda m: _ratio(m[4] * m[0], m[2] ** 2)),
        "edges": edges,
        "by_number": density(np.ones_like(d)),
        "by_area": density(d**2),
    }


def _event_rates(
    events: pd.DataFrame, ends: Floats
) -> tuple[dict[str, Measured], Measured, Measured]:
    """Return events of each kind per t0, droplets gained per t0, and merges per break-up."""
    times = events["time"].to_numpy(np.float64)
    kinds = events["kind"].astype(str).to_numpy()

    def per_time(weights: NDArray[Any]) -> Measured:
        counts = _block_sums(ends, times, weights.astype(np.float64))
        return jackknife(np.column_stack([counts, np.diff(ends)]), lambda s: _ratio(s[0], s[1]))

    rates = {kind: per_time(kinds == kind) for kind in _RATED}
    gained = np.isin(kinds, _CREATES) * 1.0 - np.isin(kinds, _REMOVES)
    exchanged = _block_sums(ends, times, kinds == "merge", kinds == "breakup")
    exchange = jackknife(exchanged, lambda s: _ratio(s[0], s[1]))
    return rates, per_time(gained), exchange


def _trend(series: pd.DataFrame, residence: float) -> Measured:
    """Return the change of the mean area over the last residence times, as a share of it."""
    end = float(series["time"].max())
    first = end - STEADY_TIMES * residence
    if not first >= 0:
        return Measured(math.nan, math.nan)
    kept = series[series["time"] >= first]
    t, area = kept["time"].to_numpy(np.float64), kept["mean_area"].to_numpy(np.float64)
    if len(t) < 4:
        return Measured(math.nan, math.nan)
    slope, offset = np.polyfit(t - t.mean(), area, 1)
    left = area - offset - slope * (t - t.mean())
    # Neighbouring frames are correlated: as many independent ones as the residuals say.
    independent = max(3.0, (t[-1] - t[0]) / (2.0 * correlation_time(t, left)))
    error = float(left.std() / (t.std() * math.sqrt(independent - 2.0)))
    span = float(t[-1] - t[0]) / float(offset)
    return Measured(float(slope) * span, error * span)


def _steady(growth: Measured, trend: Measured) -> bool | None:
    """Tell whether sizes are steady; None where nothing speaks against it but too little for it."""
    if any(abs(found.value) > 2.0 * found.error for found in (growth, trend)):
        return False
    return None if math.isnan(trend.value) or math.isnan(growth.error) else True
