"""A number of the paper beside ours, and what may be said of the two.

How ours was obtained decides it. Only what was simulated, or measured on collisions that a user
brings, is evidence and can agree with the paper or differ from it. What was recovered from data
that were drawn from the paper's own law shows that the analysis works; arithmetic follows from
numbers that the paper prints, or does not.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pinchoff.support.numerals import numeral

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from pinchoff.support.interval import Estimate

Kind = Literal["simulated", "measured", "recovered", "arithmetic", "needs the authors' data"]
Verdict = Literal[
    "agrees", "differs", "recovered", "not recovered", "follows", "does not follow", "misprint", ""
]

SIMULATED: Kind = "simulated"
MEASURED: Kind = "measured"
RECOVERED: Kind = "recovered"
ARITHMETIC: Kind = "arithmetic"
NEEDS_DATA: Kind = "needs the authors' data"

KINDS: dict[Kind, str] = {
    SIMULATED: "computed by the engine: these alone can agree with the paper or differ from it",
    MEASURED: "fitted to the collisions that you gave: these can agree with the paper or differ",
    RECOVERED: "fitted to collisions that were drawn from the paper's own law: shows that the "
    "analysis works, and is no evidence",
    ARITHMETIC: "computed from numbers that the paper prints, or from the defaults taken from them",
    NEEDS_DATA: "what only the authors' own collisions can give",
}
"""How a number is obtained, and what that means, in the order of reports."""

_VERDICTS: dict[Kind, tuple[Verdict, Verdict]] = {
    SIMULATED: ("agrees", "differs"),
    MEASURED: ("agrees", "differs"),
    RECOVERED: ("recovered", "not recovered"),
    ARITHMETIC: ("follows", "does not follow"),
    NEEDS_DATA: ("", ""),
}


_PLURALS: dict[str, str] = {
    "agrees": "agree",
    "differs": "differ",
    "follows": "follow",
    "does not follow": "do not follow",
    "misprint": "misprints",
    NEEDS_DATA: "need the authors' data",
}


def how_many(count: int, what: Verdict | Kind) -> str:
    """Return how many numbers have a verdict or are of a kind.

    Examples
    --------
    >>> how_many(1, "agrees"), how_many(5, "agrees")
    ('1 agrees', '5 agree')
    """
    return f"{count} {what if count == 1 else _PLURALS.get(what, what)}"


TONES: dict[Verdict, Literal["good", "bad", "odd"]] = {
    "agrees": "good",
    "recovered": "good",
    "follows": "good",
    "differs": "bad",
    "not recovered": "bad",
    "does not follow": "bad",
    "misprint": "odd",
}
"""How a page marks each verdict."""


def verdict_of(kind: Kind, same: bool) -> Verdict:
    """Return the verdict on a number that agrees, or does not agree, with the paper.

    Examples
    --------
    >>> verdict_of("simulated", True), verdict_of("recovered", True)
    ('agrees', 'recovered')
    """
    return _VERDICTS[kind][0 if same else 1]


@dataclass(frozen=True)
class Number:
    """A number of the paper and ours.

    Attributes
    ----------
    name, place : str
        What it is, and where the paper has it.
    paper, ours, interval : str
        The texts that a reader sees; empty where there is none.
    how : str
        How ours was obtained, in words.
    kind : str
        The same as one of `KINDS`.
    verdict : str
        Empty where there is nothing to compare.
    value, low, high : float
        Ours as numbers; NaN: none.
    note : str
    front, front_interval, front_verdict : str
        The same with front tracking, the model without springs, where both simulate it.
    """

    name: str
    place: str
    paper: str
    ours: str
    interval: str
    how: str
    kind: Kind
    verdict: Verdict
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    note: str = ""
    front: str = ""
    front_interval: str = ""
    front_verdict: Verdict = ""

    def to_dict(self) -> dict[str, Any]:
        """Return what JSON can hold: what is not a finite number is None."""
        values = asdict(self)
        return {
            k: None if isinstance(v, float) and not math.isfinite(v) else v
            for k, v in values.items()
        }


def beside(number: Number, front: Number | None) -> Number:
    """Put what front tracking gives beside a number, where it gives one."""
    if front is None:
        return number
    same = front.how == number.how
    return replace(
        number,
        how=f"both models: {number.how}" if same else f"{number.how}; front tracking: {front.how}",
        front=front.ours,
        front_interval=front.interval,
        front_verdict=front.verdict,
    )


def estimated(
    name: str,
    place: str,
    paper: str,
    known: tuple[float, float],
    ours: Estimate,
    how: str,
    kind: Kind,
    note: str = "",
) -> Number:
    """Compare an interval with a number and its error: they are the same where they overlap."""
    value, error = known
    same = ours.low <= value + 2 * error and value - 2 * error <= ours.high
    return Number(
        name,
        place,
        paper,
        four_digits(ours.value),
        f"{four_digits(ours.low)} to {four_digits(ours.high)}",
        how,
        kind,
        verdict_of(kind, same),
        *ours[:3],
        note=note,
    )


def plain(
    name: str,
    place: str,
    paper: str,
    known: float,
    ours: float,
    how: str,
    kind: Kind = ARITHMETIC,
    *,
    unit: str = "",
    factor: float = 1.0,
) -> Number:
    """Compare two numbers within a factor, which allows for the paper's rounding."""
    ratio = ours / known
    same = ratio > 0 and max(ratio, 1 / ratio) <= factor + 1e-9
    return judged(name, place, paper, f"{four_digits(ours)}{unit}", ours, same, how, kind)


def ordered(
    name: str, place: str, paper: str, known: float, ours: ArrayLike, factor: float
) -> Number:
    """Compare a range that arithmetic gives with an order of magnitude."""
    values = np.asarray(ours, dtype=np.float64)
    low, high = float(values.min()), float(values.max())
    same = known / factor <= low and high <= known * factor
    shown = f"{numeral(low, '.1e')} to {numeral(high, '.1e')}"
    found = judged(name, place, paper, shown, math.sqrt(low * high), same, ARITHMETIC)
    return replace(found, low=low, high=high)


def judged(
    name: str,
    place: str,
    paper: str,
    shown: str,
    ours: float,
    same: bool,
    how: str,
    kind: Kind = ARITHMETIC,
    note: str = "",
) -> Number:
    """Return a number without an interval, of which the caller says whether it is the paper's."""
    verdict = verdict_of(kind, same)
    return Number(name, place, paper, shown, "", how, kind, verdict, ours, note=note)


def misprint(
    name: str, place: str, paper: str, shown: str, ours: float, how: str, note: str = ""
) -> Number:
    """Return a number for which the paper prints another one than follows from it."""
    return Number(name, place, paper, shown, "", how, ARITHMETIC, "misprint", ours, note=note)


def four_digits(value: float) -> str:
    """Return a number as a reader sees it."""
    return numeral(value, ".3e" if 0 < abs(value) < 1e-3 else ".4g")
