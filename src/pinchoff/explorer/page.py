"""The page: what `make explorer` built, filled with the facts of this package and a user's data."""

from __future__ import annotations

import json
import os
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.support.errors import InputError
from pinchoff.support.files import write_text

if TYPE_CHECKING:
    from collections.abc import Mapping

BUILT = "page.html"
"""The page without facts and data: made by `make explorer`, part of every release."""


FOLDER_PAGE = "explore.html"
"""The page beside the results of a command."""

LINK = "Explore these collisions: filter, see them move, simulate each beside its film"
"""What leads from other pages to it."""

NO_PAGE = (
    "The page to explore these collisions is left out: this installation came without it. "
    "`make explorer` in a clone builds it, and every release has it."
)
"""What stands in the place of the link where there is no page."""


def is_built() -> bool:
    """Return whether the package came with the page."""
    return resources.files(__package__).joinpath(BUILT).is_file()


def explorer_page(own: Mapping[str, Any] | None = None) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    own : mapping, optional
        A user's collisions, as `pinchoff.explorer.own_data.own_data` returns them.

    Raises
    ------
    InputError
        The package came without the page.
    """
    if not is_built():
        raise InputError.of(
            "the explorer's page",
            "built",
            "a package without it",
            "run `make explorer` in the clone and install it again, or install a released wheel",
        )
    html = resources.files(__package__).joinpath(BUILT).read_text(encoding="utf-8")
    before, rest = html.split("{{facts}}")
    middle, after = rest.split("{{own}}")
    from pinchoff.explorer.facts import facts

    return "".join((before, _embedded(facts()), middle, _embedded(own), after))


def write_explorer(path: str | os.PathLike[str], own: Mapping[str, Any] | None = None) -> None:
    """Write the page, complete or not at all; as `explorer_page`."""
    write_text(Path(path), explorer_page(own))


def write_folder_page(folder: Path) -> bool:
    """Write the page of a folder of results beside them.

    Returns
    -------
    bool
        Whether the package came with the page; without, nothing is written.

    Raises
    ------
    InputError
        As `pinchoff.explorer.own_data.own_data`.
    """
    from pinchoff.explorer.own_data import own_data

    if is_built():
        write_explorer(folder / FOLDER_PAGE, own_data(folder))
    return is_built()


def _embedded(value: object) -> str:
    """Return JSON that no parser of HTML takes for markup: every < is written by its number."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")
