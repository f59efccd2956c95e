"""A boundary as data: what was varied, what was found, and the lines fitted to it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pinchoff.studies.boundary.collapse import collapse_spread, slopes
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from pinchoff.studies.boundary.line_fit import LineFit
    from pinchoff.studies.boundary.search import Boundary


def boundary_report(line: Boundary, seconds: float) -> tuple[dict[str, Any], LineFit | None]:
    """Return the content of fit.json, and the line if there is one; it took so many seconds."""
    from pinchoff import __version__

    report: dict[str, Any] = {
        "pinchoff_version": __version__,
        "base": line.base.model_dump(mode="json"),
        "varied": {name: line.table[name].unique().tolist() for name in line.varied},
        "status": line.table["status"].value_counts().to_dict(),
        "runs": len(line.runs),
        "captured_runs": int(line.table["captured_runs"].sum()),
        "failed_runs": int(line.table["failed_runs"].sum()),
        "seconds": round(seconds, 3),
    }
    try:
        fit = line.fit()
    except InputError as error:
        return {**report, "fit": None, "why_no_fit": str(error)}, None
    report["fit"] = fit.to_dict()
    if line.found["size_ratio"].nunique() > 1:
        try:
            report["fits_free_area_exponent"] = {
                speed: line.fit(free_area=True, speed=speed).to_dict()
                for speed in ("flow", "contact")
            }
        except InputError as error:
            report["why_no_free_area_exponent"] = str(error)
    if line.found["line_tension"].nunique() > 1:
        report["appendix_c"] = _appendix_c(line)
    return report, fit


def _appendix_c(line: Boundary) -> dict[str, Any] | None:
    try:
        spread = collapse_spread(line.found)._asdict()
    except InputError:
        return None
    return {"slopes": {f"{g:g}": s for g, s in slopes(line.found).items()}, "spread": spread}
