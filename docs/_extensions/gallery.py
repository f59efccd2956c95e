"""How the gallery is made: which pictures an example has, and in which order they stand."""

from collections.abc import Iterator, Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

_DOTS_PER_INCH = 200
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


def order(filename: str) -> int:
    """Return the place of an example, by the name of its file."""
    return _ORDER.index(filename.removeprefix("plot_").removesuffix(".py"))


def pictures(_: Any, variables: Mapping[str, Any], settings: Mapping[str, Any]) -> str:
    """Write the figures that a block of an example has drawn, and return what shows them.

    They are those of the axes that its variables hold. One that is written is marked, so that the
    next block does not show it again.
    """
    paths = []
    for figure in _figures(variables["example_globals"]):
        if not getattr(figure, "in_gallery", False):
            figure.in_gallery = True  # type: ignore[attr-defined]
            path = next(variables["image_path_iterator"])
            figure.savefig(path, dpi=_DOTS_PER_INCH)
            paths.append(path)
    return figure_rst(paths, settings["src_dir"])


def _figures(names: Mapping[str, Any]) -> Iterator[Figure]:
    for value in list(names.values()):
        for axes in value[:1] if isinstance(value, list) else [value]:
            if isinstance(axes, Axes) and isinstance(axes.figure, Figure):
                yield axes.figure
