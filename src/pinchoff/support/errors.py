"""What can go wrong, as two kinds of error.

`InputError` says that something given to the package is wrong; `SimulationError` says that a run
became untrustworthy and was stopped. Every message has one form::

    <argument> must be <rule>; got <value>; <what to do>
"""

from __future__ import annotations

import errno
from pathlib import PurePath
from typing import ClassVar

_LONGEST = 120  # letters of a value in a message


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
            What was given. A string or path is shown as it is, anything else by its `repr`,
            shortened.
        advice : str
            What to do about it.

        Examples
        --------
        >>> print(InputError.of("width", "positive", -1, "use 0.005"))
        width must be positive; got -1; use 0.005
        >>> print(InputError.of("path", "a name ending in .mp4", PurePath("a.avi"), "rename it"))
        path must be a name ending in .mp4; got a.avi; rename it
        """
        plain = str(got) if isinstance(got, (str, PurePath)) else repr(got)
        shown = _shortened(plain) or "an empty text"
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


_FULL = "on a disk with room for it", "make room and give the same command again"
_CLOSED = "one that you may write to", "choose another, or have it opened to you"
_ABSENT = "in a folder that exists", "make that folder, or choose another"
_RULES: dict[int | None, tuple[str, str]] = {
    errno.ENOSPC: _FULL,
    errno.EFBIG: _FULL,
    getattr(errno, "EDQUOT", errno.ENOSPC): _FULL,  # Windows has no quotas
    errno.EACCES: _CLOSED,
    errno.EPERM: _CLOSED,
    errno.EROFS: _CLOSED,
    errno.ENOENT: _ABSENT,
    errno.ENOTDIR: _ABSENT,
    errno.EISDIR: ("a file", "it is a folder: choose another name"),
    errno.ENAMETOOLONG: ("a name that the system takes", "choose a shorter one"),
    errno.EMFILE: ("among few open files", "allow more open files (ulimit -n)"),
    errno.EAGAIN: (
        "done with as many threads and processes as the system allows",
        "allow more (ulimit -u), or run fewer threads",
    ),
}
_OTHER = "what the system can read and write", "see whether its disk is in order"
_CHOSEN = (_CLOSED, _ABSENT, _RULES[errno.EISDIR], _RULES[errno.ENAMETOOLONG])


def is_full(error: BaseException) -> bool:
    """Tell whether the system had no room left for a file.

    Examples
    --------
    >>> is_full(OSError(errno.ENOSPC, "No space left on device"))
    True
    """
    return isinstance(error, OSError) and _RULES.get(error.errno) == _FULL


def refused_by_system(error: OSError, argument: str = "") -> PinchoffError:
    """Make the error for what the system refused, in the one form, with what to do.

    It is an `InputError` where another name or place would do, and a `PinchoffError` where the
    machine must be helped, as where a disk is full. What is wrong is called by the argument's name,
    or else by that of the file.

    Examples
    --------
    >>> print(refused_by_system(OSError(errno.ENAMETOOLONG, "Too long", "law.json")))
    law.json must be a name that the system takes; got 'Too long'; choose a shorter one
    """
    rule, advice = _RULES.get(error.errno, _OTHER)
    reason = error.strerror or str(error)
    if argument and error.filename:
        refusal = InputError.of(argument, rule, f"'{reason}' of {error.filename}", advice)
    else:
        name = argument or str(error.filename or "the work")
        refusal = InputError.of(name, rule, f"'{reason}'", advice)
    return refusal if (rule, advice) in _CHOSEN else PinchoffError(str(refusal))


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
