"""The form of options, and those that most commands share.

An option is called as the parameter that it gives, with hyphens: ``--obstacle-radius`` gives
``obstacle_radius``. One is shorter: ``--capillary`` gives ``simulation_capillary_number``. The help
says what an option takes, what it is, in which unit, and what holds without it.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Annotated, Any, get_type_hints

import typer

from pinchoff.support.errors import InputError

OUTPUT = "Output"
MODEL = "Dimensionless parameters"
"""Headings: what is written where, and the parameters of the model."""

RENAMED = {
    "--simulation-capillary-number": "--capillary",
    "--threads": "--workers",
    "--processes": "--workers",
}
"""Options by other names under which they are understood: a parameter's own, and earlier ones."""


def option(
    takes: str, meaning: str, *flags: str, default: str | None = None, panel: str | None = None
) -> Any:
    """Return an option with its help in our form.

    Parameters
    ----------
    takes : str
        ``NUMBER``, ``INTEGER``, ``QUANTITY`` (a number with its unit, as '85 um'), ``LIST``,
        ``NAME``, ``FILE``, ``DIR`` or another word in capitals.
    meaning : str
        What it is, with its unit; a sentence without the stop.
    *flags : str
        Its names; by default the argument's, with hyphens.
    default : str, optional
        What holds without it, where the value in the code does not say so.
    panel : str, optional
        Heading under which the help shows it.
    """
    text = f"{meaning}."
    if default is not None:
        text += f" [dim]\\[default: {default}][/dim]"
    shown = default is None
    return typer.Option(*flags, metavar=takes, help=text, show_default=shown, rich_help_panel=panel)


def switch(flag: str, meaning: str, *, panel: str | None = None) -> Any:
    """Return an option without a value."""
    return typer.Option(flag, metavar="", help=f"{meaning}.", rich_help_panel=panel)


def argument(name: str, meaning: str, *, show_default: bool = True) -> Any:
    """Return an argument without a flag: its name in capitals, and what it is."""
    return typer.Argument(metavar=name, help=f"{meaning}.", show_default=show_default)


def grouped(**defaults: Any) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the options of its groups as its own.

    A group is a parameter whose type is a dataclass; every field of it is an option, which stands
    in the help where the group stands in the signature. Fields that have no default of their own
    get one here.
    """
    return functools.partial(_ungrouped, defaults)


def _ungrouped(defaults: Mapping[str, Any], command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that takes the options of its groups one by one."""
    parameters: list[inspect.Parameter] = []
    groups: dict[str, Any] = {}
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        if not is_dataclass(parameter.annotation):
            parameters.append(parameter)
            continue
        groups[parameter.name] = group = parameter.annotation
        types = get_type_hints(group, include_extras=True)
        parameters += [
            parameter.replace(
                name=field.name,
                annotation=types[field.name],
                default=defaults.get(field.name, field.default),
            )
            for field in fields(group)
        ]

    @functools.wraps(command)
    def run(**given: Any) -> None:
        for name, group in groups.items():
            given[name] = group(**{field.name: given.pop(field.name) for field in fields(group)})
        command(**given)

    by_name = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters]
    run.__signature__ = inspect.Signature(by_name)  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in parameters}
    return run


def flag_of(name: str) -> str:
    """Return the option that gives a parameter.

    Examples
    --------
    >>> flag_of("obstacle_radius")
    '--obstacle-radius'
    """
    flag = "--" + name.replace("_", "-")
    return RENAMED.get(flag, flag)


@contextmanager
def named_as_options(*names: str, **others: str) -> Iterator[None]:
    """Give arguments of the library the names that they have on the command line.

    Parameters
    ----------
    *names : str
        Arguments that are called as their options.
    **others : str
        Arguments that are not, with what they are called.

    Examples
    --------
    >>> with named_as_options("symmetry_noise", n="--rows"):
    ...     raise InputError.of("n", "positive", 0, "give 1 or more")
    Traceback (most recent call last):
    ...
    pinchoff.support.errors.InputError: --rows must be positive; got 0; give 1 or more
    """
    flags = {**{name: flag_of(name) for name in names}, **others}
    try:
        yield
    except InputError as error:
        name, _, place = error.argument.partition("[")
        if name not in flags:
            raise
        inner = f" {place[1:-2]}" if place else ""  # of free['line_tension']
        raise error.renamed(flags[name] + inner) from None


Overwrite = Annotated[bool, switch("--overwrite", "Replace earlier results", panel=OUTPUT)]
AsJson = Annotated[
    bool,
    switch("--json", "Print the results as JSON, and the names of files on stderr", panel=OUTPUT),
]
Seed = Annotated[int, option("INTEGER", "The same seed gives the same numbers")]
Workers = Annotated[
    int | None,
    option("INTEGER", "How many work at the same time", "--workers", default="one a core"),
]
