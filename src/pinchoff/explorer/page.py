"""The page: what `make explorer` built, filled with the facts of this package and a user's data."""

from __future__ import annotations

import json
import os
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pinchoff.explorer.facts import facts
from pinchoff.support.errors import InputError
from pinchoff.support.files import written_aside

if TYPE_CHECKING:
    from collections.abc import Mapping

BUILT = "page.html"
"""The page without facts and data: made by `make explorer`, part of every release."""


def is_built() -> bool:
    """Return whether the package came with the page."""
    return resources.files(__package__).joinpath(BUILT).is_file()


def explorer_page(own: Mapping[str, Any] | None = None) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    own : mapping, optional
        A user's collisions, as `pinchoff.explorer.collisions.own_collisions` returns them.

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
    before, facts_mark, rest = html.partition("{{facts}}")
    middle, own_mark, after = rest.partition("{{own}}")
    assert facts_mark
    assert own_mark
    return "".join((before, _embedded(facts()), middle, _embedded(own), after))


def write_explorer(path: str | os.PathLike[str], own: Mapping[str, Any] | None = None) -> None:
    """Write the page, complete or not at all; as `explorer_page`."""
    text = explorer_page(own)
    with written_aside(Path(path)) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def _embedded(value: object) -> str:
    """Return JSON that no parser of HTML takes for markup: every < is written by its number."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")
