"""What several parameters must agree on."""

from __future__ import annotations

import math
from typing import Any

from pinchoff.model.entry import Entry
from pinchoff.support.errors import InputError


def require_consistent(parameters: Any) -> None:
    """Refuse parameters that are valid one by one but make no sense together.

    They come without their type in the code: its module imports this one.

    Raises
    ------
    InputError
        A parameter has no meaning in the model, the droplet starts on the obstacle, an undeformed
        droplet has a neck, or the numbers are not those of their physical scale.
    """
    _require_meaning(parameters)
    _require_start(parameters)
    _require_separation(parameters)
    _require_thickness(parameters)
    _require_scale(parameters)


def _require_meaning(p: Any) -> None:
    for name in sorted(p.model_fields_set):
        entry = type(p).model_fields[name].json_schema_extra
        model = entry.model if isinstance(entry, Entry) else ""
        if model not in ("", p.model):
            raise InputError.of(
                name,
                f"left out with model = '{p.model}', where it has no meaning",
                getattr(p, name),
                f"drop it, or use model = '{model}'",
            )


def _require_start(p: Any) -> None:
    nearest = p.obstacle_radius + 0.75
    if p.start_distance <= nearest:
        raise InputError.of(
            "start_distance",
            f"larger than 1/size_ratio + 0.75 = {nearest:g}",
            p.start_distance,
            "start farther away: the droplet must not touch the obstacle at first",
        )


def _require_separation(p: Any) -> None:
    if p.neck_separation_unit != "perimeter":
        return
    if p.neck_separation >= 0.5:
        raise InputError.of(
            "neck_separation",
            "less than 0.5 when it is a fraction of the perimeter",
            p.neck_separation,
            "lower it: no shorter arc exceeds half the perimeter",
        )
    least = 3.0 / p.vertex_count
    if p.neck_separation < least:
        raise InputError.of(
            "neck_separation",
            f"at least 3/vertex_count = {least:.3g} when it is a fraction of the perimeter",
            p.neck_separation,
            "raise it or vertex_count: neighbouring vertices are no two sides of a neck",
        )


def _require_thickness(p: Any) -> None:
    """Refuse a threshold at which an undeformed droplet would break."""
    half_angle = p.neck_separation * (math.pi if p.neck_separation_unit == "perimeter" else 1.0)
    chord = math.sin(half_angle)
    if p.neck_threshold >= chord:
        in_unit = chord * p.neck_thickness / p.neck_threshold
        raise InputError.of(
            "neck_thickness",
            f"below {in_unit:.4g}, the undeformed droplet's own chord over neck_separation",
            p.neck_thickness,
            "lower it, or raise neck_separation: a droplet would break without being deformed",
        )


def _require_scale(p: Any) -> None:
    if p.scale is None:
        return
    for name, expected in (
        ("size_ratio", p.scale.size_ratio),
        ("simulation_capillary_number", p.scale.capillary_number / p.ca_per_ca_sim),
    ):
        if not math.isclose(getattr(p, name), expected, rel_tol=1e-9):
            raise InputError.of(
                name,
                f"{expected:.10g}, as its physical scale says",
                getattr(p, name),
                "change the physical quantity in from_physical, or drop the scale",
            )
