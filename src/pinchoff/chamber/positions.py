"""Where the pillars of a design stand in a microscope's frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pinchoff.support.arguments import finite_or_nan
from pinchoff.support.errors import InputError
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
    if not finite_or_nan(pixel_size_um) > 0:
        advice = "give the size of a pixel in µm"
        raise InputError.of("pixel_size_um", "positive and finite", pixel_size_um, advice)
    width, height = (_pixels(side) for side in frame_px)
    at = chamber.layout.stations
    x, y = ((at.imaging + at.exit) / 2, 0.0) if centre_um is None else map(_place, centre_um)
    table = chamber.obstacles
    table["obstacle_x_um"] += (width - 1) / 2 * pixel_size_um - x
    table["obstacle_y_um"] = (height - 1) / 2 * pixel_size_um - (table["obstacle_y_um"] - y)
    radius = table["obstacle_radius_um"]
    shown = (table["obstacle_x_um"] + radius > -0.5 * pixel_size_um) & (
        table["obstacle_x_um"] - radius < (width - 0.5) * pixel_size_um
    )
    shown &= (table["obstacle_y_um"] + radius > -0.5 * pixel_size_um) & (
        table["obstacle_y_um"] - radius < (height - 0.5) * pixel_size_um
    )
    visible: pd.DataFrame = table[shown].reset_index(drop=True)
    for name in ("obstacle_x", "obstacle_y", "obstacle_radius"):
        visible[f"{name}_px"] = visible[f"{name}_um"] / pixel_size_um
        visible.attrs["units"][f"{name}_px"] = "px"
    return visible


def _pixels(value: int) -> int:
    if isinstance(value, bool) or int(value) != value or value < 1:
        advice = "give width and height as in (640, 512)"
        raise InputError.of("frame_px", "two whole numbers from 1 on", value, advice)
    return int(value)


def _place(value: float) -> float:
    number = finite_or_nan(value)
    if number != number:
        advice = "give x and y in the design's coordinates"
        raise InputError.of("centre_um", "two finite numbers", value, advice)
    return number
