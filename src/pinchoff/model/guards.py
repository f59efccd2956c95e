"""Why a run was stopped: what each of the core's guards holds, and what to do."""

from __future__ import annotations

import warnings
from typing import NamedTuple

from pinchoff import _core


class _Guard(NamedTuple):
    """Message of a guard; `got` formats the measured value."""

    rule: str
    got: str
    advice: str
    without_springs: str = ""  # the advice with front tracking, where it is another


_GUARDS = {
    "penetration": _Guard(
        "the obstacle's depth in the droplet must be at most {:g} of its radius",
        "{:.3g} radii",
        "raise edge_stiffness or vertex_count: the obstacle passes between two vertices",
        "raise vertex_count: the obstacle passes between two vertices",
    ),
    "overlap": _Guard(
        "one droplet's depth in another must be at most {:g} vertex spacing",
        "{:.3g} D0",
        "raise line_tension or vertex_count: droplets are pressed through each other",
        "raise vertex_count: droplets are pressed through each other",
    ),
    "self_intersection": _Guard(
        "the outline must be free of crossings",
        "crossing edges in droplet {:.0f}",
        "raise vertex_count or edge_stiffness",
        "raise vertex_count: a part of the droplet is thinner than the vertices resolve",
    ),
    "area": _Guard(
        "the droplet's area must be within {percent:g} % of its equilibrium",
        "{:+.2%}",
        "raise area_stiffness, or lower time_step",
        "raise vertex_count, or lower time_step",
    ),
    "blow_up": _Guard(
        "every coordinate must be finite and within {:g} D0",
        "{:.3g} D0",
        "lower time_step",
    ),
    "flow_domain": _Guard(
        "the droplet must be inside the sampled flow",
        "{:.3g} D0 outside",
        "sample the flow over the droplet's whole way, from its start to behind the obstacle",
    ),
    "generations": _Guard(
        "a droplet must break at most {:.0f} times in one line of descent",
        "{:.0f}",
        "lower neck_thickness or raise neck_separation: everything breaks, again and again",
    ),
    "daughter_size": _Guard(
        "a daughter's diameter must be at least {:g} D0",
        "{:.3g} D0",
        "lower neck_thickness, raise neck_separation, or set follow_daughters=False",
    ),
    "time_step": _Guard(
        "small daughters must divide the time step into at most {:.0f} parts",
        "{:.0f}",
        "lower area_stiffness or edge_stiffness, or set follow_daughters=False",
        "lower vertex_count, or set follow_daughters=False",
    ),
}


def guard_message(guard: str, value: float, time: float, *, springs: bool = True) -> str:
    """Say which guard stopped a run, what it measured and when, and what to do."""
    rule, got, with_springs, without = _GUARDS[guard]
    advice = with_springs if springs else without or with_springs
    limit = _core.GUARD_LIMITS[guard]
    rule = rule.format(limit, percent=100 * limit)
    return f"{rule}; got {got.format(value)} at t = {time:.4g} t0; {advice}"


def warn_of_failures(failed: int, total: int, stacklevel: int = 3) -> None:
    """Warn that guards stopped some runs of the caller's, if they did."""
    if failed:
        warnings.warn(
            f"guards stopped {failed} of {total} runs: their rows have accepted False and a "
            "reject_reason",
            RuntimeWarning,
            stacklevel=stacklevel,
        )
