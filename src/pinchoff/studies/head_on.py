"""One droplet runs head-on into another, and K of their coalescence from what was observed.

The pair goes through a channel that widens and narrows again, as in the experiment of Bremond,
Thiam and Bibette (Phys. Rev. Lett. 100, 024501, 2008): where it widens the first droplet slows
down and the second runs into it; where it narrows they are drawn apart. With the width w(x) the
flow is u = 1/w, v = y w'/w², in units of v_f∞ and D0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pinchoff.model import flow as flows
from pinchoff.model.emulsion import emulsion_parameters, simulate_emulsion
from pinchoff.model.emulsion_result import Emulsion
from pinchoff.model.emulsion_scene import Coalescence
from pinchoff.model.parameters import Parameters
from pinchoff.support.arguments import checked_number, checked_positive
from pinchoff.support.errors import InputError, SimulationError

WIDENING = 2.0
"""Of the channel."""

SPACING = 1.5
"""Between the centres of the droplets where the channel is narrow, D0."""

_WIDE = 2.0  # length of the wide part, D0
_SLOPE = 0.5  # length over which the width changes, D0
_BEFORE, _BEHIND = 3.0, 3.0  # way before the wide part and behind it, D0
_NEVER = 1e9  # K at which no film drains


@dataclass(frozen=True)
class Drainage:
    """K of a coalescence from an observation.

    Attributes
    ----------
    drainage : float
        K.
    critical_capillary_number : float
        What was observed.
    contact_time : float
        How long the pair touches at that number, t0.
    facing_length : float
        L at most, D0.
    separation : float
        s, as given.
    """

    drainage: float
    critical_capillary_number: float
    contact_time: float
    facing_length: float
    separation: float

    @property
    def coalescence(self) -> Coalescence:
        """As `pinchoff.simulate_emulsion` takes it."""
        return Coalescence(self.drainage, self.separation)


def head_on_pair(
    parameters: Parameters,
    coalescence: Coalescence | None,
    *,
    widening: float = WIDENING,
    spacing: float = SPACING,
    **options: Any,
) -> Emulsion:
    """Run one droplet into another in a channel that widens and narrows again.

    Parameters
    ----------
    parameters : Parameters
    coalescence : Coalescence or None
    widening : float, optional
        How many times as wide the channel becomes.
    spacing : float, optional
        Between the droplets' centres where it is narrow, D0.
    **options
        Of `pinchoff.simulate_emulsion`.

    Examples
    --------
    >>> parameters = Parameters(simulation_capillary_number=20, vertex_count=32)
    >>> head_on_pair(parameters, Coalescence(drainage=0)).balance["merges"]
    1
    """
    left, right = -_BEFORE - spacing - 2.0, _WIDE + _BEHIND + 3.0
    x = np.arange(left, right, 0.1)
    y = np.arange(-3.0, 3.05, 0.1)
    rise, fall = np.tanh(x / _SLOPE), np.tanh((x - _WIDE) / _SLOPE)
    width = 1.0 + 0.5 * (widening - 1.0) * (rise - fall)
    slope = 0.5 * (widening - 1.0) * (fall**2 - rise**2) / _SLOPE
    u = np.broadcast_to(1.0 / width, (y.size, x.size))
    v = y[:, None] * slope / width**2
    arguments = {
        "time": _BEFORE + spacing + widening * (_WIDE + 2.0 * _SLOPE) + _BEHIND,
        "outlet": _WIDE + _BEHIND,
        "threads": 1,
        **options,
    }
    return simulate_emulsion(
        parameters,
        droplets=[[-_BEFORE, 0.0, 1.0], [-_BEFORE - spacing, 0.0, 1.0]],
        flow=flows.sampled(x, y, u, v),
        coalescence=coalescence,
        **arguments,
    )


def calibrate_drainage(
    critical_capillary_number: float,
    parameters: Parameters | None = None,
    *,
    separation: float = 0.0,
    widening: float = WIDENING,
    spacing: float = SPACING,
) -> Drainage:
    """Return the K with which a head-on pair merges below a capillary number and not above it.

    One run at that number is enough: until they merge, K changes the clock but not the motion, and
    the clock of a pair that never merges is C = 1 when K is 1/K times smaller.

    Parameters
    ----------
    critical_capillary_number : float
        Ca below which head-on pairs are seen to merge, such as 0.005.
    parameters : Parameters, optional
        The model; its own capillary number plays no part. K belongs to its vertex_count, for
        contact is counted from one vertex spacing on.
    separation : float, optional
        s, where pairs that part shall merge at C >= 1 - s.
    widening, spacing : float, optional
        Of `head_on_pair`.

    Raises
    ------
    InputError
        A number is out of range, or the pair does not touch and part.
    SimulationError
        A guard took out one of the droplets.

    Examples
    --------
    >>> found = calibrate_drainage(0.005, Parameters(vertex_count=32))
    >>> 0.05 < found.drainage < 1.0
    True
    """
    ca = checked_positive("critical_capillary_number", critical_capillary_number, "use 0.005")
    separation = checked_number("separation", separation, "use 0", low=0.0, high=0.99)
    widening = checked_number("widening", widening, "use 2", low=1.0, high=4.0, above=True)
    spacing = checked_number("spacing", spacing, "use 1.5", low=1.1, high=4.0)
    parameters = emulsion_parameters(Parameters() if parameters is None else parameters)
    number = ca / parameters.ca_per_ca_sim
    run = head_on_pair(
        parameters.replace(simulation_capillary_number=number),
        Coalescence(_NEVER),
        widening=widening,
        spacing=spacing,
    )
    if run.balance["retired"]:
        raise SimulationError(run.guard_report, time=run.time)
    parted = run.events[run.events["kind"] == "parted"]
    if len(parted) != 1 or run.balance["breakups"]:
        got = f"{widening:g}, with {len(parted)} partings and {run.balance['breakups']} break-ups"
        advice = "raise it, or lower spacing, where nothing touches; lower it where one breaks"
        raise InputError.of("widening", "such that the pair touches and parts once", got, advice)
    contact = parted.iloc[0]
    return Drainage(
        float(_NEVER * contact["clock"] / (1.0 - separation)),
        ca,
        float(contact["time"] - contact["since"]),
        float(contact["facing_length"]),
        separation,
    )
