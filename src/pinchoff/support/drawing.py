"""How a result shows itself without knowing who draws: figures stand above the rooms of results.

A result is `Drawable`. The package's root, which is above all rooms, says with `draw_with` which
module draws; it is imported when the first picture is asked for.
"""

from __future__ import annotations

import importlib
from typing import Any

_artists: list[str] = []


def draw_with(module: str) -> None:
    """Name the module that draws, with ``plot(result, axes, **options)`` and ``html(result)``."""
    _artists[:] = [module]


def artist() -> Any:
    """Return the module that draws."""
    return importlib.import_module(_artists[0])


class Drawable:
    """A result that draws itself, and shows itself in a notebook."""

    def plot(self, axes: Any = None) -> Any:
        """Draw the result.

        Parameters
        ----------
        axes : Axes or sequence of Axes, optional
            Where to draw; by default a new figure, which a notebook shows.

        Returns
        -------
        Axes or list of Axes
        """
        return self._drawn(axes)

    def _drawn(self, axes: Any, **options: Any) -> Any:
        return artist().plot(self, axes, **options)

    def _repr_html_(self) -> str:
        page: str = artist().html(self)
        return page
