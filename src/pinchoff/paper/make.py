"""Make the figures and numbers one after the other; a later call goes on where one stopped."""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import NonNegativeFloat

from pinchoff.figures import style
from pinchoff.paper.catalogue import FIGURES, PaperFigure
from pinchoff.paper.numbers import data_name, numbers
from pinchoff.paper.study import Study
from pinchoff.paper.verdicts import Number
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.files import write_csv
from pinchoff.support.locks import held_folder
from pinchoff.support.records import Shape, read_record, write_json

if TYPE_CHECKING:
    from pinchoff.collisions.importing import ImportedCollisions

SETTINGS = "settings.json"
NUMBERS = "numbers"
"""Name of the table of numbers among the figures."""

ITEMS = (*(figure.name for figure in FIGURES), NUMBERS)
"""Names of all that can be made."""


# modules that show whether an extra is installed
_MODULES = {"chamber": ("shapely", "gdstk"), "video": ("av", "cv2")}


@dataclass(frozen=True)
class MadeFigure:
    """A figure that is there.

    Attributes
    ----------
    figure : PaperFigure
    png, pdf : Path
    how : str
        Where it comes from.
    seconds : float
    """

    figure: PaperFigure
    png: Path
    pdf: Path
    how: str
    seconds: float


@dataclass(frozen=True, eq=False)
class Reproduction:
    """What was made.

    Attributes
    ----------
    path : Path
        The folder.
    figures : list of MadeFigure
    numbers : list of Number
        Empty where they were not asked for.
    left_out : dict of str to str
        Figures that could not be made, and why.
    settings : dict
        Version, seed, quick or not, and the experiment's digest.
    seconds : float
        Time to make all of it, in this call and earlier ones.
    """

    path: Path
    figures: list[MadeFigure]
    numbers: list[Number]
    left_out: dict[str, str]
    settings: dict[str, Any]
    seconds: float

    def to_dict(self) -> dict[str, Any]:
        """Return settings, numbers and the figures that exist, ready for JSON."""
        return {
            **self.settings,
            "figures": [made.figure.name for made in self.figures],
            "left_out": self.left_out,
            "numbers": [number.to_dict() for number in self.numbers],
            "seconds": self.seconds,
        }


def reproduce(
    out: str | os.PathLike[str],
    *,
    only: Sequence[str] | None = None,
    quick: bool = False,
    seed: int = 1,
    experiment: ImportedCollisions | None = None,
    progress: Callable[[str, int, int], object] | None = None,
) -> Reproduction:
    """Remake the figures and numbers of the paper.

    What is in the folder already, with the same settings, is not made again: a reproduction that
    was stopped goes on where it was.

    Parameters
    ----------
    out : path
        Folder: figure_NAME.png and .pdf, numbers.json and numbers.csv.
    only : sequence of str, optional
        Some of `ITEMS`; by default all.
    quick : bool, optional
        Fewer and coarser simulations.
    seed : int, optional
        The same seed gives the same numbers.
    experiment : ImportedCollisions, optional
        Real collisions in place of the synthetic ones.
    progress : callable, optional
        Called with the name of what is made next, how much is done, and how much there is.

    Raises
    ------
    InputError
        There is no such item, or the folder holds a reproduction with other settings.

    Examples
    --------
    >>> import tempfile
    >>> made = reproduce(tempfile.mkdtemp(), only=["2", "3"], quick=True)
    >>> [figure.png.name for figure in made.figures]
    ['figure_2.png', 'figure_3.png']
    """
    wanted = _wanted(only)
    folder = Path(out)
    settings = _settings(seed, quick, experiment)
    with held_folder(folder):
        _require_same(folder, settings)
        write_json(folder / SETTINGS, settings)
        study = Study(seed, quick, experiment, folder)
        left_out: dict[str, str] = {}
        figures: list[MadeFigure] = []
        found: list[Number] = []
        seconds = 0.0
        for done, name in enumerate(wanted):
            if progress is not None:
                progress(name, done, len(wanted))
            if name == NUMBERS:
                found, took = _numbers(study, folder)
            else:
                figure = next(figure for figure in FIGURES if figure.name == name)
                absent = _absent(figure.extra)
                if absent:
                    left_out[name] = (
                        f"{absent} is not installed: pip install 'pinchoff[{figure.extra}]'"
                    )
                    continue
                figures.append(_figure(figure, study, folder))
                took = figures[-1].seconds
            seconds += took
        return Reproduction(folder, figures, found, left_out, settings, seconds)


def remove_reproduction(folder: Path) -> None:
    """Remove what `reproduce` wrote to a folder, films included, and nothing else."""
    for pattern in ("figure_*.*", f"{NUMBERS}.*", SETTINGS, "film_*"):
        for path in folder.glob(pattern):
            shutil.rmtree(path) if path.is_dir() else path.unlink()


def _absent(extra: str) -> str:
    """Return the first module of an extra that is not installed; empty if all are."""
    return next((name for name in _MODULES.get(extra, ()) if find_spec(name) is None), "")


def _wanted(only: Iterable[str] | None) -> list[str]:
    if only is None:
        return list(ITEMS)
    chosen = [name.strip() for name in only]
    for name in chosen:
        if name not in ITEMS:
            raise unknown_name("only", "the name of a figure of the paper, or numbers", name, ITEMS)
    return [name for name in ITEMS if name in chosen]


def _settings(seed: int, quick: bool, experiment: ImportedCollisions | None) -> dict[str, Any]:
    from pinchoff import __version__

    digest = None
    if experiment is not None:
        rows = experiment.table.to_csv(index=False).encode()
        digest = hashlib.sha256(rows).hexdigest()
    return {"pinchoff_version": __version__, "seed": seed, "quick": quick, "experiment": digest}


class _Settings(Shape):
    pinchoff_version: str
    seed: int
    quick: bool
    experiment: str | None


class _Figure(Shape):
    how: str
    seconds: NonNegativeFloat


class _Numbers(Shape):
    numbers: list[Number]
    seconds: NonNegativeFloat


def _require_same(folder: Path, settings: dict[str, Any]) -> None:
    path = folder / SETTINGS
    if not path.exists():
        return
    advice = "choose another folder, or remove this one"
    recorded = read_record(path, _Settings, "the settings of a reproduction", advice)
    differ = [key for key, value in settings.items() if recorded[key] != value]
    if differ:
        got = f"{folder} ({', '.join(differ)} differ)"
        rule = "a folder without a reproduction of other settings"
        raise InputError.of("out", rule, got, advice)


def _made_before(path: Path, shape: type[Shape]) -> dict[str, Any] | None:
    """Return the record of what is there; None where there is none, or it is damaged."""
    try:
        return read_record(path, shape, "a record", "it is made again")
    except InputError:
        return None


def _figure(figure: PaperFigure, study: Study, folder: Path) -> MadeFigure:
    """Draw a figure unless it is there; its record is written last."""
    stem = folder / f"figure_{figure.name}"
    png, pdf, record = (stem.with_suffix(suffix) for suffix in (".png", ".pdf", ".json"))
    made = _made_before(record, _Figure) if png.exists() and pdf.exists() else None
    if made is None:
        started = time.perf_counter()
        with style.off_screen():
            axes = figure.draw(study)
        style.save(png, axes)
        style.save(pdf, axes)
        how = f"{figure.how}; {data_name(study)}" if figure.experiment else figure.how
        made = {
            "figure": figure.name,
            "title": figure.title,
            "caption": figure.caption,
            "how": how,
            "seconds": round(time.perf_counter() - started, 2),
        }
        write_json(record, made)
    return MadeFigure(figure, png, pdf, made["how"], made["seconds"])


def _numbers(study: Study, folder: Path) -> tuple[list[Number], float]:
    import pandas as pd

    record = folder / f"{NUMBERS}.json"
    made = _made_before(record, _Numbers)
    if made is None:
        started = time.perf_counter()
        found = [number.to_dict() for number in numbers(study)]
        write_csv(folder / f"{NUMBERS}.csv", pd.DataFrame(found))
        made = {"numbers": found, "seconds": round(time.perf_counter() - started, 2)}
        write_json(record, made)
    return [Number(**_known(number)) for number in made["numbers"]], made["seconds"]


def _known(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}
