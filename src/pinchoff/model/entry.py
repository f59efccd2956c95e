"""One entry per parameter: all that the package knows of it, said once, in a class body.

From the entries follow the checks and their messages, the row of numbers that the compiled core
takes, the columns of tables in which a parameter varies, the axes of sweeps, the docstring of
`pinchoff.Parameters` and the table in the documentation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel, Field

from pinchoff.collisions.schema import Column
from pinchoff.support.arguments import number_rule
from pinchoff.support.checked import Explanation, with_parameters

CoreNumber = Callable[[Any], float]
"""What the compiled core takes for a parameter, from all the parameters of a run."""


@dataclass(frozen=True, kw_only=True)
class Entry(Explanation):
    """What is known of one parameter, beside its type.

    Attributes
    ----------
    rule : str
        What a value must be; completes "<name> must be".
    meaning : str
        What it is, in a phrase that completes "give".
    default : str
        As messages and documentation show it.
    follows : bool
        Whether the default follows from other parameters.
    low, high : float or None
        The smallest and the largest number that is allowed.
    model : str
        The model outside of which it has no meaning and is None; empty: it always has one.
    symbol : str
        As in the paper; empty: it has none.
    unit : str
        "1" for a pure number, "" for what is not a number.
    note : str
        What else the documentation says.
    column : str
        Name of its column in a table in which it varies; empty: its own.
    core_name : str
        Name of its number in the core's row; empty: its own.
    core : callable or None
        That number, from all the parameters; None: their attribute of that name.
    in_core : bool
        Whether it has one: what only says how results are read has none.
    name : str
    kind : str
        "float", "int", "bool" or "str".
    """

    default: str
    follows: bool
    low: float | None
    high: float | None
    model: str
    symbol: str = ""
    unit: str = ""
    note: str = ""
    column: str = ""
    core_name: str = ""
    core: CoreNumber | None = None
    in_core: bool = True
    name: str = ""
    kind: str = ""

    @property
    def place(self) -> str:
        """Name of its number in the core's row."""
        return self.core_name or self.name

    def core_value(self, parameters: object) -> float:
        """Return that number."""
        value = self.core(parameters) if self.core else getattr(parameters, self.place)
        return 0.0 if value is None else float(value)

    @property
    def phrase(self) -> str:
        """Meaning, symbol and unit."""
        unit = f"in {self.unit}" if self.unit not in ("", "1") else ""
        return ", ".join(filter(None, (self.meaning, self.symbol, unit)))

    @property
    def advice(self) -> str:
        """What to give in place of a refused value."""
        return f"give {self.phrase}, or leave it out for {self.default}"

    def __call__(self, schema: dict[str, Any]) -> None:
        """Add symbol and unit to the JSON schema, and the limits of a number that may be None."""
        schema.update(symbol=self.symbol, unit=self.unit)
        for kind in schema.get("anyOf", ()) if self.model else ():
            if kind.get("type") == "number":
                kind.update(minimum=self.low, maximum=self.high)

    def as_column(self) -> Column:
        """Return the column of a table in which the parameter varies."""
        dtype = {"float": "float64", "int": "int64"}.get(self.kind, self.kind)
        return Column(self.column or self.name, self.unit, dtype, self.meaning)


def parameter(
    default: Any,
    meaning: str,
    *,
    low: float | None = None,
    high: float | None = None,
    rule: str = "",
    follows: str = "",
    model: str = "",
    **known: Any,
) -> Any:
    """Return the field of a parameter, for a class body.

    Parameters
    ----------
    default : object
        Its default; or, with `follows`, a function of the values before it.
    meaning, low, high
        As of `Entry`.
    rule : str, optional
        As of `Entry`; by default that of a finite number within the limits.
    follows : str, optional
        What the default is where it follows from other parameters, such as "5000 γ̃".
    model : str, optional
        As of `Entry`; the field's type then allows None.
    **known
        What else an `Entry` says.
    """
    default_text = str(default).lower() if isinstance(default, bool) else str(default)
    limits = (-math.inf if low is None else low, math.inf if high is None else high)
    entry = Entry(
        rule=rule or number_rule(*limits),
        meaning=meaning,
        default=follows or default_text,
        follows=bool(follows),
        low=low,
        high=high,
        model=model,
        **known,
    )
    start: dict[str, Any] = {"default_factory": default} if follows else {"default": default}
    if model:
        start = {"default_factory": _default_in(model, default)}
    return Field(description=meaning, json_schema_extra=entry, ge=low, le=high, **start)


def _default_in(model: str, default: Any) -> Callable[[dict[str, Any]], Any]:
    """Return what gives a parameter its default in one model, and None in others."""

    def start(given: dict[str, Any]) -> Any:
        if given.get("model", model) != model:
            return None
        return default(given) if callable(default) else default

    return start


def entries_of(model: type[BaseModel]) -> dict[str, Entry]:
    """Return the entries of a model's parameters, with their names and kinds."""
    entries = {}
    for name, field in model.model_fields.items():
        entry = field.json_schema_extra
        if isinstance(entry, Entry):
            entries[name] = replace(entry, name=name, kind=_kind(field.annotation, entry))
    return entries


def _kind(annotation: object, entry: Entry) -> str:
    if annotation in (int, bool):
        return "int" if annotation is int else "bool"
    return "float" if entry.unit else "str"


def documented(docstring: str | None, entries: Mapping[str, Entry]) -> str | None:
    """Return a docstring with the entries written out in place of ``**values``."""
    return with_parameters(
        docstring, {f"{name} : {entry.kind}": _described(entry) for name, entry in entries.items()}
    )


def _described(entry: Entry) -> str:
    scope = f" Only with model = '{entry.model}'." if entry.model else ""
    text = f"{entry.phrase}: {entry.rule}, by default {entry.default}. {entry.note}".rstrip()
    return text + scope
