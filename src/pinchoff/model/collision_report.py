"""A collision as data: its parameters, what follows from them, and its results, with units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pinchoff.collisions.schema import units
from pinchoff.support.records import jsonable

if TYPE_CHECKING:
    from pinchoff.model.results import Collision

_PHYSICAL_RESULTS = ("contact_time_s", "area_um2", "speed_mm_s", "neck_um")


def collision_report(collision: Collision, preset: str) -> dict[str, Any]:
    """Return the content of collision.json; the parameters come from a preset of that name.

    Examples
    --------
    >>> import pinchoff as po
    >>> report = collision_report(po.simulate(po.Parameters()), "default")
    >>> report["results"]["outcome"], report["derived"]["normalized_thickness"]
    ('broke', 1.0)
    """
    from pinchoff import __version__

    parameters, row = collision.parameters, jsonable(collision.to_row())
    results = collision.to_dict()
    given = results.pop("parameters")
    if parameters.scale is not None:
        results.update({name: row[name] for name in _PHYSICAL_RESULTS})
    return {
        "pinchoff_version": __version__,
        "preset": preset,
        "parameters": given,
        "derived": {
            "capillary_number": parameters.capillary_number,
            "normalized_area": parameters.normalized_area,
            "normalized_thickness": parameters.normalized_thickness,
            "breakup_number": row["breakup_number"],
            "effective_time_step": parameters.effective_time_step,
        },
        "results": results,
        "row": row,
        "units": {
            **{name: unit for name, unit in units().items() if unit and name in results},
            "daughter_areas": "D0²",
            "contacts": "D0, t0, v_f∞",
            "breakups": "D0, t0, v_f∞",
        },
    }
