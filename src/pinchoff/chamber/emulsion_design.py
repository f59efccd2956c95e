"""What `pinchoff emulsion` runs: an array, the flow through it, and droplets, read from a table.

Lengths are numbers of D0, or quantities with a unit beside a table of physical quantities; every
refusal names the key.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pinchoff.chamber.emulsion_tables import (
    diameter_of_physical,
    in_diameters,
    read_array,
    read_coalescence,
    read_droplets,
    read_flow,
    read_inlet,
    read_parameters,
    require_known,
    table_of,
)
from pinchoff.chamber.emulsion_trust import Trust, measure_trust
from pinchoff.model.arrays import Floats, PillarArray
from pinchoff.model.emulsion import simulate_emulsion
from pinchoff.model.emulsion_scene import WINDOW, Coalescence, Inlet, checked_on_guard
from pinchoff.model.parameters import Parameters
from pinchoff.studies.emulsion_sizes import SizeStudy, study_sizes
from pinchoff.studies.isolated_pillar import isolated_pillar
from pinchoff.support.arguments import checked_positive, checked_whole
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml

if TYPE_CHECKING:
    import pandas as pd

    from pinchoff.chamber.periodic_flow import ArrayFlow
    from pinchoff.model.emulsion_result import Emulsion
    from pinchoff.model.flow import Flow
    from pinchoff.support.progress import Show

_RUN: dict[str, Any] = {
    "interval": 0.5,
    "smallest_breaking": 0.2,
    "checkpoint": 10.0,
    "seed": 0,
    "outlines": True,
    "on_guard": "retire",
}
_STOP = "stop_when_steady"
_TABLES = ("parameters", "physical", "array", "flow", "inlet", "droplets", "coalescence")
STRETCHES = 20
"""After each of these parts of a run it is looked whether sizes are steady, if that may end it."""

_REFERENCES = 7  # diameters for which the line of a pillar alone is sought
_PAD = 2.0  # of the flow's samples beyond the cell, D0


@dataclass(frozen=True, eq=False)
class EmulsionDesign:
    """A run of many droplets through an array, ready to begin.

    Build it with `from_toml` or `from_config`.

    Attributes
    ----------
    parameters : Parameters
    array : PillarArray
        With its margins.
    thickness : float
        z of the chamber, D0.
    drive : dict
        ``mean_speed`` or ``pressure_gradient`` of `pinchoff.chamber.array_flow`, or neither.
    time : float
        t0.
    inlet : Inlet or None
    droplets : ndarray, shape (K, 3)
        Those that are there at the start.
    coalescence : Coalescence or None
        None: droplets do not merge.
    settings : dict
        Of `pinchoff.simulate_emulsion`: interval, smallest_breaking, checkpoint, seed,
        outlines, on_guard.
    stop_when_steady : bool
        Whether a run may end before its time: at the first of `STRETCHES` equal stretches after
        which its sizes are steady.
    """

    parameters: Parameters
    array: PillarArray
    thickness: float
    drive: dict[str, float]
    time: float
    inlet: Inlet | None
    droplets: Floats
    coalescence: Coalescence | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    stop_when_steady: bool = False

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> EmulsionDesign:
        """Read a design from a TOML file with the keys of `from_config`.

        A table of pillars that it names is looked for beside it.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as `from_config`.
        """
        return cls.from_config(read_toml(Path(path)), beside=Path(path).parent)

    @classmethod
    def from_config(cls, config: Mapping[str, Any], beside: Path | None = None) -> EmulsionDesign:
        """Read a design.

        Parameters
        ----------
        config : mapping
            ``time`` and, if wanted, ``interval``, ``smallest_breaking``, ``checkpoint``, ``seed``,
            ``outlines`` and ``on_guard`` of `pinchoff.simulate_emulsion`, and
            ``stop_when_steady``; tables
            ``array`` (``kind`` and the arguments of `pinchoff.arrays`, or ``kind = "chamber"`` and,
            if wanted, the ``path`` of a device's file; ``before`` and ``behind``), ``flow``
            (``thickness``,
            ``mean_speed`` or ``pressure_gradient``), ``parameters``, and ``inlet`` or
            ``droplets`` (``places``, or ``diameters`` and ``area_fraction``), and ``coalescence``
            (the arguments of `pinchoff.Coalescence`) where droplets merge. With ``physical``
            (diameter, speed, viscosity, surface_tension) lengths of the other tables may have
            units.
        beside : Path, optional
            The folder of the files that it names.

        Raises
        ------
        InputError
            A key is unknown or missing, or its value wrong; the message names the key.

        Examples
        --------
        >>> design = EmulsionDesign.from_config({
        ...     "time": 10,
        ...     "array": {"kind": "square", "rows": 2, "columns": 2, "radius": 0.3, "gap": 0.9,
        ...               "before": 3, "behind": 2},
        ...     "flow": {"thickness": 0.5},
        ...     "inlet": {"area_fraction": 0.2},
        ... })
        >>> design.periodic, design.inlet.top
        ('y', 3.0)
        """
        require_known("", config, ("time", _STOP, *_RUN, *_TABLES))
        for name in ("outlines", _STOP):
            if not isinstance(config.get(name, False), bool):
                raise InputError.of(name, "true or false", config[name], "write it without quotes")
        settings = {name: config.get(name, default) for name, default in _RUN.items()}
        checked_on_guard(settings["on_guard"])
        seed = checked_whole("seed", settings["seed"], "use 0", low=0)
        tables = {name: table_of(config, name) for name in _TABLES if name in config}
        for name in ("array", "flow"):
            if name not in tables:
                raise InputError.of(name, "a table", "nothing", f"write [{name}]")
        if ("inlet" in tables) == ("droplets" in tables):
            got = "both" if "inlet" in tables else "neither"
            advice = "write one of the two: with an inlet, or in a cell that repeats itself"
            raise InputError.of("inlet", "given, or droplets", got, advice)
        diameter_um = diameter_of_physical(tables)
        for name in ("array", "flow", "inlet", "droplets"):
            if name in tables:
                tables[name] = in_diameters(name, tables[name], diameter_um)
        array = read_array(tables["array"], beside or Path(), diameter_um)
        thickness, drive = read_flow(tables["flow"])
        parameters = read_parameters(tables, array, thickness, diameter_um)
        return cls(
            parameters,
            array,
            thickness,
            drive,
            checked_positive("time", config.get("time"), "give it in t0"),
            read_inlet(tables["inlet"], tables["array"], array) if "inlet" in tables else None,
            read_droplets(tables.get("droplets"), array, parameters, seed),
            read_coalescence(tables["coalescence"]) if "coalescence" in tables else None,
            settings,
            config.get(_STOP, False),
        )

    @property
    def periodic(self) -> str:
        """Along which axes space repeats itself: across always, along without an inlet."""
        return "xy" if self.inlet is None else "y"

    def flow(self, show: Show | None = None) -> ArrayFlow:
        """Return the flow through the array, computed."""
        from pinchoff.chamber import array_flow

        return array_flow(self.array, thickness=self.thickness, show=show, **self.drive)

    def run(self, flow: ArrayFlow, out: Path, **options: Any) -> Emulsion:
        """Run it in the flow into a folder, or go on with the run that is there.

        Options are those of `pinchoff.simulate_emulsion`: threads and progress.
        """
        sampled = flow.sampled(pad=_PAD, periodic=self.periodic)
        if not self.stop_when_steady:
            return self._run_until(self.time, sampled, out, options)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # said once, at the end
            run = self._run_until_steady(flow, sampled, out, options)
        run.warn_of_guards()
        return run

    def _run_until_steady(
        self, flow: ArrayFlow, sampled: Flow, out: Path, options: Mapping[str, Any]
    ) -> Emulsion:
        run = self._run_until(self.time / STRETCHES, sampled, out, options)
        for k in range(1, STRETCHES + 1):
            end = self.time * k / STRETCHES
            # A run that goes on after a stop has passed these ends without being steady.
            if end <= run.time - WINDOW + 1e-9:
                continue
            run = self._run_until(end, sampled, out, options)
            if run.stopped or self._is_steady(run, flow):
                break
        return run

    def _is_steady(self, run: Emulsion, flow: ArrayFlow) -> bool:
        return self.study(run, flow).steady is True

    def _run_until(
        self, time: float, flow: Flow, out: Path, options: Mapping[str, Any]
    ) -> Emulsion:
        return simulate_emulsion(
            self.parameters,
            time=time,
            droplets=self.droplets if self.inlet is None else None,
            obstacles=self.array,
            flow=flow,
            periodic=self.periodic,
            inlet=self.inlet,
            outlet=None if self.inlet is None else self.array.length,
            coalescence=self.coalescence,
            out=out,
            resume=True,
            **self.settings,
            **options,
        )

    def isolated(
        self, contacts: pd.DataFrame, flow: ArrayFlow, threads: int | None = None
    ) -> pd.DataFrame | None:
        """Return the line of a pillar alone in this flow, for the diameters of contacts.

        None where there is none: in plane Stokes flow, with pillars of several radii, with necks
        that break at a thickness of their own, or without contacts.
        """
        radii = self.array.circles[:, 2]
        fixed = self.parameters.neck_thickness_unit != "diameter"
        if self.thickness == math.inf or np.ptp(radii) > 1e-6 or fixed or not len(contacts):
            return None
        found = contacts["diameter"].to_numpy(np.float64)
        low, high = max(found.min(), radii[0]), found.max()
        diameters = np.geomspace(low, high, _REFERENCES) if high > 1.02 * low else np.array([high])
        speed = flow.mean_velocity[0]
        return isolated_pillar(
            self.parameters, float(radii[0]), self.thickness, diameters, speed, threads
        )

    def trust(self, run: Emulsion, flow: ArrayFlow, begin: float) -> Trust | None:
        """Return how far a run can be trusted from a time on; None where outlines are not kept."""
        if not self.settings["outlines"]:
            return None
        spacing = math.pi / run.parameters.vertex_count
        sampled = flow.sampled(pad=_PAD)
        return measure_trust(run.outline_pieces(), self.array, sampled, begin, spacing)

    def study(self, run: Emulsion, flow: ArrayFlow) -> SizeStudy:
        """Return the sizes and rates of a run.

        In a cell that repeats itself a residence time is what the fluid takes through the cell.
        """
        residence = None if self.inlet else self.array.length / flow.mean_velocity[0]
        return study_sizes(run.sizes, run.events, residence_time=residence)
