"""Necks that thin, and what a camera sees of them.

The thinnest neck that a film shows of a droplet that breaks is the one in its last frame before
the break-up: the slower the camera, the earlier that frame and the thicker the neck.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pinchoff.support import paper_constants as paper
from pinchoff.support.arguments import checked_positive
from pinchoff.support.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from pinchoff.model.results import Collision

Floats = NDArray[np.float64]

PINCH_SPEED_MM_S = 4.2
"""70 µm in 1/60 s: the slowest end of a break-up that fits the paper's frames."""


@dataclass(frozen=True, eq=False)
class ThinningHistory:
    """The thinnest neck of a droplet until it breaks.

    Attributes
    ----------
    times_s : ndarray, shape (n,)
        Ascending, s.
    necks_um : ndarray, shape (n,)
        µm.
    breakup_time_s : float
        At or after the last time, s.
    """

    times_s: Floats
    necks_um: Floats
    breakup_time_s: float

    def __post_init__(self) -> None:
        times, necks = np.asarray(self.times_s, float), np.asarray(self.necks_um, float)
        object.__setattr__(self, "times_s", times)
        object.__setattr__(self, "necks_um", necks)
        if times.ndim != 1 or times.shape != necks.shape or len(times) < 2:
            rule = "as many times as necks, two or more"
            got = f"{times.shape} and {necks.shape}"
            raise InputError.of("times_s", rule, got, "give one neck for each time")
        if not (np.diff(times) > 0).all() or not self.breakup_time_s >= times[-1]:
            raise InputError.of(
                "times_s", "ascending and not after the break-up", times, "sort them"
            )

    def pinched_off(self, speed_mm_s: float) -> ThinningHistory:
        """Return the history with an end in which the neck thins to nothing at a constant speed.

        The engine cuts a neck at its threshold; a real one goes on thinning for a moment.

        Parameters
        ----------
        speed_mm_s : float
            At which the neck's thickness falls, mm/s.
        """
        speed = checked_positive("speed_mm_s", speed_mm_s, "use 4.2")
        end = self.breakup_time_s + float(self.necks_um[-1]) * 1e-3 / speed
        times = np.append(self.times_s, end)
        return ThinningHistory(times, np.append(self.necks_um, 0.0), end)


def last_frame_necks(
    history: ThinningHistory, frame_rate: float, phases: ArrayLike | None = None
) -> Floats:
    """Return the neck in the last frame before the break-up of a camera that nothing triggers.

    That frame is up to one frame interval before the break-up, every time in it equally likely.

    Parameters
    ----------
    history : ThinningHistory
    frame_rate : float
        Frames per second.
    phases : array_like, shape (m,), optional
        That share, above 0 and at most 1; by default 200 even ones.

    Returns
    -------
    ndarray, shape (m,)
        µm; NaN where the history begins later.

    Examples
    --------
    >>> history = ThinningHistory([0.0, 1.0, 2.0], [80.0, 40.0, 0.0], breakup_time_s=2.0)
    >>> last_frame_necks(history, frame_rate=2.0, phases=[0.5, 1.0]).tolist()
    [10.0, 20.0]
    """
    rate = checked_positive("frame_rate", frame_rate, "use 60")
    shares = (np.arange(200) + 0.5) / 200 if phases is None else np.asarray(phases, float)
    moments = history.breakup_time_s - shares / rate
    return np.asarray(np.interp(moments, history.times_s, history.necks_um, left=math.nan))


def thinning_history(collision: Collision) -> ThinningHistory:
    """Return the thinnest neck of a simulated droplet until its first break-up.

    Raises
    ------
    InputError
        It does not break, or has no outlines, which are best recorded often, or no physical scale.
    """
    outlines, scale = collision.outlines, collision.parameters.scale
    if not collision.broke or outlines is None or scale is None:
        rule = "one that broke, with outlines, from physical quantities"
        advice = "use simulate(Parameters.from_physical(...), outlines=0.01)"
        raise InputError.of("collision", rule, collision, advice)
    before = np.flatnonzero(outlines.times < collision.breakup_time)
    necks = np.array(
        [min(outlines.neck(outline)[0] for outline in outlines[k]) for k in before.tolist()]
    )
    measured = np.isfinite(necks)
    times = np.append(outlines.times[before][measured], collision.breakup_time)
    end = float(times[-1]) * scale.time_unit_s
    return ThinningHistory(
        times * scale.time_unit_s,
        np.append(necks[measured], collision.breakup_neck) * scale.diameter_um,
        end,
    )


def median_history() -> ThinningHistory:
    """Return the neck of the paper's median breaking droplet, simulated, and then pinched off.

    From the threshold on it thins at 4.2 mm/s, that is 70 µm, the thickest neck that the paper saw
    before a break-up, in one of its frames.
    """
    from pinchoff.model.parameters import Parameters
    from pinchoff.model.simulation import simulate

    droplet = Parameters.from_physical(
        diameter=f"{paper.MEDIAN_DIAMETER_UM} um",
        obstacle_radius=f"{paper.OBSTACLE_RADIUS_UM} um",
        speed="1 mm/s",
        viscosity=f"{paper.VISCOSITY_MPA_S} mPa s",
        surface_tension=f"{paper.SURFACE_TENSION_MN_M} mN/m",
        thickness=f"{paper.THICKNESS_UM} um",
        offset="20 um",
    )
    return thinning_history(simulate(droplet, outlines=0.01)).pinched_off(PINCH_SPEED_MM_S)
