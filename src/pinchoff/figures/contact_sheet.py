"""A contact sheet: every filmed collision before and after, side by side [paper, fig. intro]."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from pinchoff.support.files import written_aside

Pixels = NDArray[np.uint8]

MOST_PICTURES = 600
"""Collisions on one sheet; of more, the first ones."""

_COLUMNS = 4
_LINE_HEIGHT = 16  # of a label, pixels
_FONT, _FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.38
_GAP = 8


class Picture(NamedTuple):
    """A collision on the sheet.

    Attributes
    ----------
    path : Path
        Before and after, as one picture.
    label : str
        ASCII.
    opens : str
        Address of the moment in the annotated film; empty where there is none.
    """

    path: Path
    label: str
    opens: str


def write_contact_sheet(path: str | os.PathLike[str], pictures: Sequence[Picture]) -> int:
    """Write a sheet of pictures as PNG, four collisions a row; return how many are on it.

    Those whose file is missing are left out. The sheet appears when it is complete.
    """
    existing = (one for one in pictures[:MOST_PICTURES] if one.path.exists())
    read = ((cv2.imread(str(picture.path)), picture.label) for picture in existing)
    tiles = [_labelled(tile, label) for tile, label in read if tile is not None]
    nothing = _labelled(np.full((80, 320, 3), 255, np.uint8), "no collisions")
    sheet = _joined(tiles or [nothing])
    with written_aside(Path(path)) as unfinished:
        unfinished.write_bytes(cv2.imencode(".png", sheet)[1].tobytes())
    return len(tiles)


def _labelled(tile: Pixels, label: str) -> Pixels:
    """Return a picture with its label below it, on as many lines as the label needs."""
    lines = _wrapped(label, tile.shape[1] - 4)
    strip = np.full((_LINE_HEIGHT * len(lines) + 4, tile.shape[1], 3), 255, dtype=np.uint8)
    for k, line in enumerate(lines):
        place = (2, (k + 1) * _LINE_HEIGHT - 4)
        cv2.putText(strip, line, place, _FONT, _FONT_SCALE, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([tile, strip])


def _wrapped(label: str, width: int) -> list[str]:
    lines = [""]
    for word in label.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and cv2.getTextSize(longer, _FONT, _FONT_SCALE, 1)[0][0] > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def _joined(tiles: Sequence[Pixels]) -> Pixels:
    """Lay tiles on white paper, row by row."""
    width = max(tile.shape[1] for tile in tiles) + _GAP
    columns = min(_COLUMNS, len(tiles))
    rows = [tiles[first : first + columns] for first in range(0, len(tiles), columns)]
    heights = [max(tile.shape[0] for tile in row) + _GAP for row in rows]
    sheet = np.full((sum(heights), columns * width + _GAP, 3), 255, dtype=np.uint8)
    for row, height, low in zip(rows, heights, np.cumsum(heights), strict=True):
        for k, tile in enumerate(row):
            top, left = low - height + _GAP, k * width + _GAP
            sheet[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return sheet
