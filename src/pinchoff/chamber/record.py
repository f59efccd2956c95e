"""The design as data: everything that was asked for and what follows from it, as JSON."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.chamber.layout import REGIONS
from pinchoff.chamber.masks import LAYERS
from pinchoff.support.records import Shape, read_record

if TYPE_CHECKING:
    from pinchoff.chamber.design import Chamber
    from pinchoff.chamber.rules import Violation


def design_record(chamber: Chamber, violations: Sequence[Violation] = ()) -> dict[str, Any]:
    """Return the content of design.json; units are in the names."""
    from pinchoff import __version__

    layout = chamber.layout
    left, low, right, high = layout.outline.bounds
    return {
        "pinchoff_version": __version__,
        "parameters": chamber.model_dump(mode="json"),
        "derived": {
            "length_um": round(chamber.length_um, 3),
            "width_um": round(chamber.width_um, 3),
            "chip_um": [round(right - left, 3), round(high - low, 3)],
            "fluid_area_mm2": round(layout.fluid.area * 1e-6, 6),
            "fluid_volume_uL": round(layout.fluid.area * chamber.thickness_um * 1e-9, 6),
            "least_gap_um": chamber.least_gap_um,
            "least_wall_um": chamber.least_wall_um,
            "database_unit_um": 0.001,
        },
        "regions": [
            {
                "number": number,
                "name": name,
                "area_mm2": round(layout.regions[name].area * 1e-6, 6),
                "pillars": sum(pillar.region == name for pillar in layout.pillars),
            }
            for number, name in enumerate(REGIONS, start=1)
        ],
        "layers": LAYERS,
        "stations_um": layout.stations._asdict(),
        "ports": {name: port._asdict() for name, port in layout.ports.items()},
        "pillars": [pillar._asdict() for pillar in layout.pillars],
        "violations": [
            {name: getattr(violation, name) for name in ("rule", "x_um", "y_um", "says")}
            for violation in violations
        ],
    }


class _Design(Shape):
    parameters: dict[str, Any]


def read_design(path: str | os.PathLike[str]) -> Chamber:
    """Return the device that a design.json describes.

    Raises
    ------
    InputError
        The file cannot be read or is no design; or as `Chamber`.

    Examples
    --------
    >>> import json
    >>> from pathlib import Path
    >>> from pinchoff.chamber import Chamber
    >>> from pinchoff.chamber.record import design_record
    >>> wide = Chamber(imaging={"rows": 6})
    >>> size = Path("design.json").write_text(json.dumps(design_record(wide)))
    >>> read_design("design.json") == wide
    True
    """
    from pinchoff.chamber.design import Chamber

    advice = "name a design.json that pinchoff chamber wrote"
    record = read_record(Path(path), _Design, "a design as JSON", advice)
    return Chamber(**record["parameters"])
