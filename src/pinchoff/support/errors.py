"""What can go wrong, as two kinds of error.

`InputError` says that something given to the package is wrong; `SimulationError` says that a run
became untrustworthy and was stopped. Every message has one form::

    <argument> must be <rule>; got <value>; <what to do>
"""

from __future__ import annotations

from typing import ClassVar


class PinchoffError(Exception):
    """Base of every error that this package raises on purpose.

    Attributes
    ----------
    exit_code : int
        What the command line returns when the error ends it.
    """

    exit_code: ClassVar[int] = 1


class InputError(PinchoffError, ValueError):
    """A parameter, a file or an argument is wrong: change it and try again.

    Build it with `InputError.of`, which keeps the message in its one form.

    Attributes
    ----------
    argument, rule, got, advice : str
        The four pieces of the message.
    """

    exit_code: ClassVar[int] = 2

    argument: str = ""
    rule: str = ""
    got: str = ""
    advice: str = ""

    @classmethod
    def of(cls, argument: str, rule: str, got: object, advice: str) -> InputError:
        """Make the error ``<argument> must be <rule>; got <got>; <advice>``.

        Parameters
        ----------
        argument : str
            Name of the thing that is wrong, as the user wrote it.
        rule : str
            What it must be; completes "must be".
        got : object
            What was given. A string is shown as it is, anything else by its `repr`, shortened.
        advice : str
            What to do about it.

        Examples
        --------
        >>> print(InputError.of("width", "positive", -1, "use 0.005"))
        width must be positive; got -1; use 0.005
        """
        shown = _shortened(got if isinstance(got, str) else repr(got)) or "an empty text"
        error = cls(f"{argument or 'an empty name'} must be {rule}; got {shown}; {advice}")
        error.argument, error.rule, error.got, error.advice = argument, rule, shown, advice
        return error

    def within(self, place: str) -> InputError:
        """Return the same error with the argument's name placed inside `place`.

        ``diameter`` within ``physical`` is ``physical.diameter``.

        Examples
        --------
        >>> print(InputError.of("diameter", "a length", "3", "add a unit").within("physical"))
        physical.diameter must be a length; got 3; add a unit
        """
        return self.renamed(f"{place}.{self.argument}")

    def renamed(self, argument: str) -> InputError:
        """Return the same error about an argument by another name, as the user wrote it.

        Examples
        --------
        >>> print(InputError.of("n", "positive", 0, "give 1").renamed("rows"))
        rows must be positive; got 0; give 1
        """
        return type(self).of(argument, self.rule, self.got, self.advice)


class SimulationError(PinchoffError, RuntimeError):
    """A guard stopped a run because its result could not be trusted.

    Attributes
    ----------
    guard : str
        Which guard: ``penetration``, ``overlap``, ``self_intersection``, ``area``, ``blow_up`` or
        ``flow_domain``.
    value : float
        What the guard measured, in the units that the message states.
    time : float
        When, in t0 = D0 / v_f∞.
    """

    def __init__(
        self,
        message: str,
        *,
        guard: str = "",
        value: float = float("nan"),
        time: float = float("nan"),
    ) -> None:
        super().__init__(message)
        self.guard = guard
        self.value = value
        self.time = time


def _shortened(text: str, limit: int = 120) -> str:
    return text if len(text) <= limit else f"{text[: limit - 1]}…"
