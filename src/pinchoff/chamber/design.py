"""The device as a whole: what it is asked to be, and the geometry that follows from it."""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pinchoff.chamber.device import Device
from pinchoff.chamber.extra import chamber_extra
from pinchoff.chamber.pillars import pillar_table
from pinchoff.support.files import read_toml

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.layout import Layout


class Chamber(Device):
    """The microfluidic device, parametric; the defaults are the paper's device [appendix A].

    Parameters
    ----------
    thickness_um : float
        z, the height of the moulded channels [paper: 85; 45 as a variant].
    inlets, junction, oil_inputs, expansion, supports, imaging, exit
        Regions 1 to 7, each a model of `pinchoff.chamber` or a mapping of its parameters.
    mask, rules, operation
        The photomask, the design rules, and how the device is run.

    Raises
    ------
    InputError
        A value is out of its range, or parts do not fit each other; names the parameter, as in
        ``imaging.pitch_um``.

    Examples
    --------
    >>> import pinchoff as po
    >>> chamber = po.chamber.Chamber(imaging={"obstacle_radius_um": 60})
    >>> round(chamber.length_um), round(chamber.width_um)
    (22000, 6500)
    >>> len(chamber.obstacles.query("region == 'imaging'"))
    32
    """

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Read the device from a TOML file with a table for each part, as ``[imaging]``.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as the constructor, naming the key.
        """
        return cls(**read_toml(Path(path)))

    @cached_property
    def layout(self) -> Layout:
        """The geometry that all files, checks and flows follow from."""
        with chamber_extra():
            from pinchoff.chamber.layout import build_layout
        return build_layout(self)

    @property
    def length_um(self) -> float:
        """Length of the device, from the oil port's edge to the outlet's, µm."""
        return self.layout.stations.end

    @property
    def obstacles(self) -> pd.DataFrame:
        """Every pillar: ``obstacle_x_um``, ``obstacle_y_um``, ``obstacle_radius_um``, ``region``.

        In the design's coordinates; `pinchoff.chamber.in_frame` has those of a picture. Regions
        are named as the parts: the obstacles of the imaging area are those of ``"imaging"``.
        """
        return pillar_table(self.layout.pillars)
