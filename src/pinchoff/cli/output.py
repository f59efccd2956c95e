"""What commands report: JSON, warnings, and the results of one collision as a table."""

from __future__ import annotations

import json
import math
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pinchoff.model.outcomes import Collision

_TABLE = (
    "outcome",
    "symmetry",
    "impact_parameter",
    "breakup_number",
    "contact_time",
    "contact_time_s",
    "contact_speed",
    "speed_mm_s",
    "maximum_shape_parameter",
    "minimum_neck",
    "neck_um",
    "breakup_time",
    "daughter_area_ratio",
    "droplet_count",
    "end_time",
)
_PHYSICAL_RESULTS = ("contact_time_s", "area_um2", "speed_mm_s", "neck_um")


def report_of(collision: Collision, preset: str) -> dict[str, Any]:
    """Return what goes into collision.json."""
    from pinchoff import __version__
    from pinchoff.collisions.schema import units

    parameters, row = collision.parameters, collision.to_row()
    results = collision.to_dict()
    given = results.pop("parameters")
    if parameters.scale is not None:
        results.update({name: _finite(row[name]) for name in _PHYSICAL_RESULTS})
    return {
        "pinchoff_version": __version__,
        "preset": preset,
        "parameters": given,
        "derived": {
            "capillary_number": parameters.capillary_number,
            "normalized_area": parameters.normalized_area,
            "normalized_thickness": parameters.normalized_thickness,
            "breakup_number": _finite(row["breakup_number"]),
            "effective_time_step": parameters.effective_time_step,
        },
        "results": results,
        "units": {
            **{name: unit for name, unit in units().items() if unit and name in results},
            "daughter_areas": "D0²",
            "contacts": "D0, t0, v_f∞",
            "breakups": "D0, t0, v_f∞",
        },
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def json_text(report: Mapping[str, Any]) -> str:
    """Return a report as JSON in the strict sense: no NaN."""
    return json.dumps(report, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def jsonable(value: Any) -> Any:
    """Return the value as JSON can hold it, with None where it is not a finite number."""
    if isinstance(value, Mapping):
        return {str(name): jsonable(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [jsonable(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def printed_warnings() -> Iterator[None]:
    """Print each warning once, as one line on stderr."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        warnings.simplefilter("always", RuntimeWarning)
        yield
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        print(f"warning: {message}", file=sys.stderr)


def print_table(row: Mapping[str, Any]) -> None:
    """Print the results that there are, with their units."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    from pinchoff.collisions.schema import units

    table = Table(box=SIMPLE_HEAD)
    table.add_column("result")
    table.add_column("value", justify="right")
    table.add_column("unit")
    for name in _TABLE:
        value, unit = row[name], units()[name]
        if not isinstance(value, float):
            table.add_row(name, str(value), "")
        elif math.isfinite(value):
            table.add_row(name, f"{value:.4g}", "" if unit == "1" else unit)
    Console().print(table)
