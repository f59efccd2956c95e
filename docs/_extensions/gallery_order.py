"""The order of the pictures in the gallery: from one collision to films and devices."""

_ORDER = (
    "snapshots",
    "film_of_a_run",
    "construction",
    "sequences",
    "phase_diagram",
    "separating_line",
    "size_ratios",
    "capillary_number",
    "constant_height",
    "law",
    "daughters",
    "necks",
    "calibration",
    "measured_film",
    "chamber",
)


def key(filename: str) -> int:
    """Return the place of an example, by the name of its file."""
    return _ORDER.index(filename.removeprefix("plot_").removesuffix(".py"))
