"""``pinchoff fit``: the break-up law of a table of collisions, with intervals and figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pinchoff.cli.folders import Results, remove_results
from pinchoff.cli.options import argument, grouped, named_as_options, option
from pinchoff.cli.output import bar, print_table, versioned, warn
from pinchoff.cli.table_options import TableOptions
from pinchoff.explorer.page import FOLDER_PAGE
from pinchoff.support.files import write_csv
from pinchoff.support.numerals import counted
from pinchoff.support.records import write_json

if TYPE_CHECKING:
    from pinchoff.figures.html_page import Picture
    from pinchoff.fits.law_study import LawStudy

LAW = "law.json"
LAWS = "laws.csv"
SET_ASIDE = "set_aside.csv"
COLLISIONS = "collisions.parquet"
PAGE = "report.html"
_FIGURES = (
    "separated_outcomes.png",
    "breakup_probability.png",
    "daughter_areas.png",
    "neck_histograms.png",
    "constant_height.png",
)
_FILES = (LAW, LAWS, SET_ASIDE, COLLISIONS, PAGE, FOLDER_PAGE, *_FIGURES)

_FIT = "Fit"


def _number(meaning: str, takes: str = "NUMBER") -> Any:
    return option(takes, meaning, panel=_FIT)


@grouped(out="law")
def fit(
    table: Annotated[
        Path,
        argument(
            "TABLE", "Parquet file or folder of a sweep, CSV, TSV or spreadsheet of collisions"
        ),
    ],
    reading: TableOptions,
    *,
    free: Annotated[
        list[str] | None,
        option(
            "NAME",
            "Fit its exponent: area, thickness, viscosity, surface_tension or speed; may "
            "be repeated. The radius's follows from those of area and thickness; radius "
            "frees all three",
            default="none",
            panel=_FIT,
        ),
    ] = None,
    symmetry_noise: Annotated[float, _number("Standard error of S to account for, as 0.088")] = 0.0,
    confidence: Annotated[float, _number("Confidence of the intervals")] = 0.95,
    samples: Annotated[int, _number("Parts of the bootstrap", "INTEGER")] = 100,
    fraction: Annotated[float, _number("Share of the collisions in a part")] = 0.5,
    seed: Annotated[int, _number("Same seed, same parts", "INTEGER")] = 0,
    results: Results,
) -> None:
    r"""Fit the break-up law to a table of collisions.

    The columns symmetry and broke must be there. Ca, Ã and z̃ are
    capillary_number, normalized_area and normalized_thickness, or follow from
    area or diameter, obstacle_radius, thickness, viscosity, speed and
    surface_tension, with units in their names (area_mm2) or behind --unit.
    Impossible rows are set aside and listed. DIR gets

    - law.json: α, β, w and free exponents with intervals
    - laws.csv: which quantities the data need
    - set_aside.csv: rows that were not used, and why
    - collisions.parquet: those that were, in the package's columns
    - report.html: all of it and the figures on one page
    - explore.html: the collisions to play with, beside the live model
    - the figures as PNG

    [bold]Examples[/bold]

    pinchoff fit phase-diagram --out law

    pinchoff fit mine.csv --map symmetry=S_meas --unit area=mm^2 \
    --constant 'viscosity=48 mPa s' --free area --free thickness
    """
    from pinchoff.fits.law_study import study_law

    collisions = reading.read(table)
    for message in collisions.messages():
        warn(message)
    with results.held_for(_FILES) as folder:
        with (
            named_as_options(
                *("free", "symmetry_noise", "confidence", "samples", "fraction", "seed"),
                table="TABLE",
            ),
            bar("bootstrap", samples) as show,
        ):
            study = study_law(
                collisions,
                free=tuple(free or ()),
                symmetry_noise=symmetry_noise,
                confidence=confidence,
                samples=samples,
                fraction=fraction,
                seed=seed,
                progress=show,
            )
        remove_results(folder, _FILES)
        report = versioned(study.to_dict())
        write_json(folder / LAW, report)
        _write(study, table.name, folder)
        files = (folder / name for name in _FILES)
        results.announce(report, lambda: _print(study), files)


def _write(study: LawStudy, source: str, folder: Path) -> None:
    from pinchoff.collisions.parquet import write_collisions
    from pinchoff.explorer.page import write_folder_page
    from pinchoff.figures import style
    from pinchoff.figures.pages.law_page import law_figures, law_page

    for name, frame in ((LAWS, study.comparison), (SET_ASIDE, study.collisions.set_aside)):
        if frame is not None and len(frame):
            write_csv(folder / name, frame)
    write_collisions(study.collisions.table, folder / COLLISIONS)
    pictures: list[tuple[Picture, str]] = []
    for name, (axes, caption) in law_figures(study).items():
        style.save(folder / f"{name}.png", axes)
        pictures.append((folder / f"{name}.png", caption))
    explorer = FOLDER_PAGE if write_folder_page(folder) else ""
    law_page(study, source, pictures, explorer).write(folder / PAGE)


def _print(study: LawStudy) -> None:
    from pinchoff.figures.pages.law_page import interval, signed_number
    from pinchoff.fits.form import SYMBOLS

    rows = []
    for name, estimate in study.estimates.items():
        several = (interval(numbers[name]) for numbers in study.intervals.values())
        rows.append((SYMBOLS[name], signed_number(estimate.value), *several))
    title = f"{study.fit.confidence:.0%} intervals"
    print_table(("", "value", *study.intervals), rows, title=title)
    print(f"{counted(study.fit.count, 'collision')}, {study.fit.broke_count} of which broke")
    if study.fit.step:
        print(f"w = 0: {study.fit.step}")
    for reason, count in study.fit.left_out.items():
        print(f"{counted(count, 'row')} not used: {reason}")
