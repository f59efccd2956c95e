"""Which collisions a sweep runs: fixed parameters, varied ones, and the points between them."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pinchoff.model.parameters import DEFAULTS, PARAMETERS, Parameters
from pinchoff.model.presets import preset_constants
from pinchoff.studies.sweep.axes import Axis, Levels, read_axis
from pinchoff.studies.sweep.sampling import KINDS, unit_points
from pinchoff.support.arguments import checked_whole
from pinchoff.support.checked import unknown_name
from pinchoff.support.errors import InputError
from pinchoff.support.files import read_toml
from pinchoff.support.quantities import (
    PHYSICAL_NAMES,
    groups_of_magnitudes,
    physical_magnitude,
    physical_magnitudes,
    refuse_physical_groups,
)

MOST_POINTS = 100_000_000

_SWEEP_KEYS = ("design", "samples", "seed", "vary", "preset", "parameters", "physical")
_BLOCK = 1024  # points that are drawn at once


@dataclass(frozen=True)
class SweepDesign:
    """The points of a sweep, made when they are asked for.

    Build it with `from_toml` or `from_config`.

    Attributes
    ----------
    kind : str
        "grid", "sobol", "latin-hypercube" or "random".
    constants : dict
        Parameters that are the same in all points.
    physical : dict or None
        Physical quantities that are, in µm, mm/s, mPa s and mN/m.
    axes : tuple of Axis
        The varied parameters; in a grid the last one changes fastest.
    samples, seed : int
        Of a sample; in a grid the number of points, and 0.

    Examples
    --------
    >>> design = SweepDesign.from_config({"vary": {"offset": [0, 0.1], "line_tension": [60, 80]}})
    >>> len(design), design.point(2).offset
    (4, 0.1)
    """

    kind: str
    constants: dict[str, Any]
    physical: dict[str, float] | None
    axes: tuple[Axis, ...]
    samples: int
    seed: int

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> SweepDesign:
        """Read a design from a TOML file with the keys of `from_config`.

        Raises
        ------
        InputError
            The file cannot be read or is not TOML; or as `from_config`.
        """
        return cls.from_config(read_toml(Path(path)))

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> SweepDesign:
        """Read a design.

        Parameters
        ----------
        config : mapping
            ``vary`` maps each varied parameter to a list of values or a range ``{"min": ...,
            "max": ..., "count": ..., "scale": "linear" or "log"}``. ``design`` is "grid" (all
            combinations; the default), "sobol", "latin-hypercube" or "random"; the latter three
            need ``samples``, may have a ``seed`` (0) and their ranges no count. Fixed parameters
            stand beside these keys or in ``parameters``; ``preset`` and ``physical`` are those
            of `Parameters.from_toml`. With ``physical``, its quantities can be varied too.

        Raises
        ------
        InputError
            A key is unknown or missing, or its value wrong; the message names the key.

        Examples
        --------
        >>> vary = {"offset": {"min": 0, "max": 0.4}}
        >>> len(SweepDesign.from_config({"design": "sobol", "samples": 8, "vary": vary}))
        8
        """
        constants = _fixed_constants(config)
        vary = config.get("vary")
        if not isinstance(vary, Mapping) or not vary:
            got = "nothing" if vary is None else vary
            raise InputError.of("vary", "a table of the varied parameters", got, "write [vary]")
        kind = config.get("design", "grid")
        if kind not in ("grid", *KINDS):
            known = ("grid", *KINDS)
            raise unknown_name("design", "'grid' or a sample", kind, known)
        physical = _physical_magnitudes(config, constants, vary)
        axes = tuple(_axis(name, vary[name], kind, constants, physical) for name in vary)
        samples, seed = _size(config, kind, axes)
        design = cls(kind, constants, physical, axes, samples, seed)
        design._check_axes()
        return design

    def __len__(self) -> int:
        return self.samples

    def point(self, number: int) -> Parameters:
        """Return one point, from 0.

        Examples
        --------
        >>> design = SweepDesign.from_config({"vary": {"offset": [0, 0.1]}})
        >>> design.point(1).offset
        0.1
        """
        return next(self.points(number, number + 1))

    def points(self, start: int = 0, stop: int | None = None) -> Iterator[Parameters]:
        """Yield the points from `start` to before `stop`, without holding the others.

        Examples
        --------
        >>> design = SweepDesign.from_config({"vary": {"offset": [0, 0.1, 0.2]}})
        >>> [point.offset for point in design.points(start=1)]
        [0.1, 0.2]
        """
        for values in self._values(start, len(self) if stop is None else stop):
            yield self._parameters(values)

    def check(self, show: Callable[[int], object] | None = None) -> None:
        """Make every point once, so that none is refused in the middle of a sweep.

        Parameters
        ----------
        show : callable, optional
            Called with the number of points done now and then.

        Raises
        ------
        InputError
            A point is refused; the message says which and why.
        """
        for number, values in enumerate(self._values(0, len(self))):
            if show is not None and number % _BLOCK == 0:
                show(number)
            try:
                self._parameters(values).model_row()
            except InputError as error:
                where = ", ".join(f"{name} = {_short(value)}" for name, value in values.items())
                got = f"{error.got} in point {number} ({where})"
                raise InputError.of(error.argument, error.rule, got, error.advice) from None

    @functools.cached_property
    def configuration(self) -> dict[str, Any]:
        """All that decides the points, fit for JSON; equal for designs with equal points."""
        first_point = self.point(0).model_dump(mode="json")
        fixed = {name: first_point[name] for name in sorted(self.constants)}
        kept = {name: value for name, value in fixed.items() if value != DEFAULTS.get(name)}
        sample = {} if self.kind == "grid" else {"samples": self.samples, "seed": self.seed}
        return {
            "design": self.kind,
            **sample,
            "parameters": kept,
            **({} if self.physical is None else {"physical": self.physical}),
            # The order of a grid's axes numbers its points.
            "vary": {axis.name: axis.configuration for axis in self.axes},
        }

    @functools.cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the configuration, in hexadecimal digits."""
        return hashlib.sha256(json.dumps(self.configuration).encode()).hexdigest()

    def _values(self, start: int, stop: int) -> Iterator[dict[str, Any]]:
        for first in range(start, stop, _BLOCK):
            last = min(first + _BLOCK, stop)
            yield from self._grid(first, last) if self.kind == "grid" else self._sample(first, last)

    def _grid(self, start: int, stop: int) -> Iterator[dict[str, Any]]:
        levels = [axis.values for axis in self.axes if isinstance(axis, Levels)]
        places = np.unravel_index(np.arange(start, stop), [len(values) for values in levels])
        for indices in np.transpose(places).tolist():
            chosen = (values[k] for values, k in zip(levels, indices, strict=True))
            yield dict(zip((axis.name for axis in self.axes), chosen, strict=True))

    def _sample(self, start: int, stop: int) -> Iterator[dict[str, Any]]:
        points = unit_points(self.kind, len(self.axes), self.samples, self.seed, start, stop)
        for coordinates in points.tolist():
            pairs = zip(self.axes, coordinates, strict=True)
            yield {axis.name: axis.at(u) for axis, u in pairs}

    def _parameters(self, values: Mapping[str, Any]) -> Parameters:
        if self.physical is None:
            return Parameters(**{**self.constants, **values})
        varied = {name: value for name, value in values.items() if name in PHYSICAL_NAMES}
        constants = {name: value for name, value in values.items() if name not in PHYSICAL_NAMES}
        groups = groups_of_magnitudes({**self.physical, **varied})
        return Parameters(**{**self.constants, **constants, **groups})

    def _check_axes(self) -> None:
        """Refuse a value that its own parameter does not take, under the name the user wrote."""
        first = {axis.name: next(axis.ends())[1] for axis in self.axes}
        for axis in self.axes:
            for argument, value in axis.ends():
                try:
                    self._parameters({**first, axis.name: value})
                except InputError as error:
                    # Rules over several parameters are checked in `check`, which has all of them.
                    if error.argument == axis.name:
                        raise error.renamed(argument) from None


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _fixed_constants(config: Mapping[str, Any]) -> dict[str, Any]:
    """Join the preset, the keys beside [vary] and those in [parameters]."""
    table = config.get("parameters", {})
    if not isinstance(table, Mapping):
        raise InputError.of("parameters", "a table", table, "write it as [parameters]")
    names = PARAMETERS.keys()
    beside = {name: value for name, value in config.items() if name not in _SWEEP_KEYS}
    for name in beside:
        if name not in names:
            raise unknown_name(name, "the name of a parameter", name, {*names, *_SWEEP_KEYS})
        if name in table:
            raise InputError.of(name, "given once", beside[name], f"drop it or parameters.{name}")
    for name in table:
        if name not in names:
            raise unknown_name(f"parameters.{name}", "the name of a parameter", name, names)
    given = {**preset_constants(config.get("preset", "default")), **beside, **table}
    return {name: value for name, value in given.items() if value is not None}


def _physical_magnitudes(
    config: Mapping[str, Any], constants: Mapping[str, Any], vary: Mapping[str, Any]
) -> dict[str, float] | None:
    """Read [physical], but for the quantities that are varied."""
    given = config.get("physical")
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise InputError.of("physical", "a table", given, "write it as [physical]")
    refuse_physical_groups(constants)
    for name in given:
        if name in vary:
            raise InputError.of(f"physical.{name}", "left out when varied", given[name], "drop it")
    try:
        return physical_magnitudes(given, vary)
    except InputError as error:
        raise error.within("physical") from None


def _axis(
    name: str,
    given: object,
    kind: str,
    constants: Mapping[str, Any],
    physical: Mapping[str, float] | None,
) -> Axis:
    sampled = kind != "grid"
    if physical is not None and name in PHYSICAL_NAMES:
        return read_axis(name, given, sampled=sampled, whole=False, read=_read_quantity)
    names = {*PARAMETERS}
    if physical is not None:
        if name in ("size_ratio", "simulation_capillary_number"):
            rule, advice = "left out beside [physical]", "vary a quantity of [physical]"
            raise InputError.of(f"vary.{name}", rule, given, advice)
        names |= set(PHYSICAL_NAMES)
    if name not in names:
        raise unknown_name(f"vary.{name}", "the name of a parameter", name, names)
    if name in constants:
        advice = f"drop it, or vary.{name}"
        raise InputError.of(name, "left out when varied", constants[name], advice)
    whole = Parameters.model_fields[name].annotation is int
    return read_axis(name, given, sampled=sampled, whole=whole)


def _read_quantity(argument: str, value: Any) -> float:
    name = argument.split(".")[1].partition("[")[0]
    try:
        return physical_magnitude(name, "" if value is None else value)
    except InputError as error:
        raise error.renamed(argument) from None


def _size(config: Mapping[str, Any], kind: str, axes: tuple[Axis, ...]) -> tuple[int, int]:
    """Return the number of points and the seed."""
    if kind == "grid":
        for key in ("samples", "seed"):
            if config.get(key) is not None:
                advice = "drop it, or say which sample: design = 'sobol'"
                raise InputError.of(key, "left out of a grid", config[key], advice)
        count = math.prod(len(axis.values) for axis in axes if isinstance(axis, Levels))
        if count > MOST_POINTS:
            advice = "lower a count, or draw a sample: design = 'sobol'"
            raise InputError.of("vary", f"at most {MOST_POINTS} points", count, advice)
        return count, 0
    advice = "say how many points to draw"
    samples = checked_whole("samples", config.get("samples"), advice, low=1, high=MOST_POINTS)
    seed = config.get("seed", 0)
    return samples, checked_whole("seed", seed, "give any, such as 1", low=0, high=2**63 - 1)
