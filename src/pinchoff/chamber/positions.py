"""Where the pillars of a design stand in a microscope's frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pinchoff.support.arguments import checked_number, checked_positive, checked_whole
from pinchoff.support.paper_constants import PIXEL_SIZE_UM

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.design import Chamber

PAPER_FRAME_PX = (640, 512)
"""Width and height of the paper's frames [section 2]."""


def in_frame(
    chamber: Chamber,
    *,
    centre_um: tuple[float, float] | None = None,
    pixel_size_um: float = PIXEL_SIZE_UM,
    frame_px: tuple[int, int] = PAPER_FRAME_PX,
) -> pd.DataFrame:
    """Return the pillars that are visible in a frame, and their places in it.

    Parameters
    ----------
    chamber : Chamber
    centre_um : (float, float), optional
        The point of the design in the middle of the frame; by default the middle of the imaging
        area.
    pixel_size_um : float, optional
        Size of a pixel in the chamber.
    frame_px : (int, int), optional
        Width and height of the frame.

    Returns
    -------
    DataFrame
        As `Chamber.obstacles`, but in the coordinates of the collisions table: µm from the centre
        of the top left pixel, x to the right and y down; the same in pixels, as film and analysis
        take obstacles, in ``obstacle_x_px``, ``obstacle_y_px`` and ``obstacle_radius_px``. A pillar
        that the edge cuts is included.

    Raises
    ------
    InputError
        A size is not positive, or a number not finite.

    Examples
    --------
    >>> from pinchoff.chamber import Chamber
    >>> pillars = in_frame(Chamber(), pixel_size_um=5.28, frame_px=(640, 512))
    >>> len(pillars), set(pillars["obstacle_radius_um"])
    (10, {85.0})
    """
    pixel = checked_positive("pixel_size_um", pixel_size_um, "give the size of a pixel in µm")
    advice = "give width and height as in (640, 512)"
    width, height = (checked_whole("frame_px", side, advice, low=1) for side in frame_px)
    at = chamber.layout.stations
    advice = "give x and y in the design's coordinates"
    middle = ((at.imaging + at.exit) / 2, 0.0) if centre_um is None else centre_um
    x, y = (checked_number("centre_um", place, advice) for place in middle)
    table = chamber.obstacles
    table["obstacle_x_um"] += (width - 1) / 2 * pixel - x
    table["obstacle_y_um"] = (height - 1) / 2 * pixel - (table["obstacle_y_um"] - y)
    shown = np.ones(len(table), dtype=bool)
    for name, count in (("obstacle_x_um", width), ("obstacle_y_um", height)):
        shown &= table[name] + table["obstacle_radius_um"] > -0.5 * pixel
        shown &= table[name] - table["obstacle_radius_um"] < (count - 0.5) * pixel
    visible: pd.DataFrame = table[shown].reset_index(drop=True)
    for name in ("obstacle_x", "obstacle_y", "obstacle_radius"):
        visible[f"{name}_px"] = visible[f"{name}_um"] / pixel
        visible.attrs["units"][f"{name}_px"] = "px"
    return visible
