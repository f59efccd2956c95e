"""Why a collision is not used, each reason in one place.

Those of a guard that stopped a run are in `pinchoff.model.results`, those of a film in
`pinchoff.video.encounters`.
"""

from __future__ import annotations

NO_CONTACT = "no contact: the droplet never touched the obstacle"
"""Of a row that is no collision."""

BROKE_BEFORE_CONTACT = "broke before first contact: it is not the mother that met the obstacle"
"""Of a droplet whose neck was below its limit before it touched."""

REJECTED = "rejected when it was measured"

OUTCOME_UNKNOWN = "outcome not known"

NO_SYMMETRY = "S = 0: no place on a logarithmic axis, and the law says that it does not break"
"""Of a collision beside the obstacle's centreline, where logarithms are taken."""


def not_measured(name: str) -> str:
    """Return the reason of a row that lacks a number."""
    return f"{name} not measured"


def general_reason(reason: str) -> str:
    """Leave the measured value out of a reason: '<rule>; got <value>; <advice>'.

    Examples
    --------
    >>> general_reason("the area must be within 1 %; got +3 % at t = 2 t0; raise it")
    'the area must be within 1 %; raise it'
    """
    rule, got, rest = reason.partition("; got ")
    return f"{rule}; {rest.rpartition('; ')[2]}" if got else rule
