"""The command line: one file per command, which parses, calls the library and prints.

Exit codes: 0 done, 2 the input is wrong, 1 anything else.
"""

from __future__ import annotations

import difflib
import errno
import functools
import io
import re
import signal
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from pinchoff.cli.boundary import boundary
from pinchoff.cli.calibrate import calibrate
from pinchoff.cli.chamber import chamber
from pinchoff.cli.compare import compare
from pinchoff.cli.emulsion import emulsion
from pinchoff.cli.examples import examples
from pinchoff.cli.explore import explore
from pinchoff.cli.export import export
from pinchoff.cli.film import film
from pinchoff.cli.fit import fit
from pinchoff.cli.options import RENAMED
from pinchoff.cli.output import printed_warnings
from pinchoff.cli.reproduce import reproduce
from pinchoff.cli.run import run
from pinchoff.cli.summary import summary
from pinchoff.cli.sweep import sweep
from pinchoff.cli.video import video
from pinchoff.cli.virtual import virtual
from pinchoff.support.errors import InputError, PinchoffError, refused_by_system
from pinchoff.support.interruption import interrupted_by_signals

# Of typer's errors about what was typed only this subclass is public; all of them are caught.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]

_INTERRUPTED = 130  # what typer returns after Ctrl-C; its older releases raise Abort

_TYPES = {"integer": "a whole number", "number": "a number"}  # our words for the parser's


class _PlainWords:
    """Help without ``<path>`` and ``<bool>``: names of arguments and switches say enough."""

    def get_params(self, ctx: Any) -> list[Any]:
        found: list[Any] = super().get_params(ctx)  # type: ignore[misc]
        for parameter in found:
            if parameter.param_type_name == "argument":
                parameter.display_type_rich = lambda ctx: None
            elif parameter.is_flag:
                parameter.metavar = ""
        return found


class _PlainCommand(_PlainWords, TyperCommand):
    """A command; of an option that is given twice the parser would take the last, in silence."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        values, _, order = self.make_parser(ctx).parse_args(args=list(args))
        parameter: Any
        for parameter, times in Counter(order).items():
            if times > 1 and not (parameter.multiple or parameter.is_flag):
                many = parameter.metavar == "LIST"
                advice = "write one list, with commas" if many else "drop one of them"
                last = values[parameter.name]
                raise InputError.of(parameter.opts[0], "given once", last, advice)
        return super().parse_args(ctx, args)


class _PlainGroup(_PlainWords, TyperGroup):
    """The program."""


app = typer.Typer(
    name="pinchoff",
    help="Droplets that collide with an obstacle and pinch off.",
    rich_markup_mode="rich",
    cls=_PlainGroup,
)
_COMMANDS = {
    "Begin": (examples,),
    "Simulate": (run, explore, sweep, summary, boundary, calibrate, emulsion),
    "Measure": (video, compare, export, film),
    "The break-up law": (fit, virtual),
    "The device": (chamber,),
    "The paper": (reproduce,),
}
for _heading, _commands in _COMMANDS.items():
    for _command in _commands:
        app.command(cls=_PlainCommand, rich_help_panel=_heading)(_command)


def _print_version(wanted: bool) -> None:
    if wanted:
        from pinchoff import __version__

        typer.echo(f"pinchoff {__version__}")
        raise typer.Exit


@app.callback()
def _pinchoff(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Droplets that collide with an obstacle and pinch off."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What stands behind ``pinchoff``; by default the process's own arguments. ``--debug``
        anywhere lets an error that nobody foresaw through, with its traceback.
    """
    typed = sys.argv[1:] if arguments is None else list(arguments)
    debug = "--debug" in typed
    given = [_by_its_name(text) for text in typed if text != "--debug"] or ["--help"]
    _never_fail_on_letters()
    with interrupted_by_signals() as came:
        code = _ended(given, debug)
    if code != _INTERRUPTED:
        return code
    if came:
        name = signal.Signals(came[0]).name
        return _failed(f"stopped by {name}", 128 + came[0])  # as shells and batch systems count
    return _failed("interrupted", 1)


@functools.cache
def _parser() -> Callable[..., object]:
    """Build what reads the line, once: it asks every command for its options."""
    return typer.main.get_command(app)


def _ended(given: Sequence[str], debug: bool) -> int:
    """Run a command to its end and say what went wrong; return the exit code."""
    try:
        with printed_warnings():
            code = _parser()(given, prog_name="pinchoff", standalone_mode=False)
    except PinchoffError as error:
        return _failed(str(error), error.exit_code)
    except _UsageError as error:
        return _failed(_usage_message(error, given), 2)
    except (typer.Abort, KeyboardInterrupt):
        return _INTERRUPTED
    except OSError as error:
        refusal = refused_by_system(error)
        return _failed(str(refusal), refusal.exit_code)
    except MemoryError:
        return _failed("no memory is left; close other programs, or give less at a time", 1)
    except ImportError as error:
        return _failed(str(error), 1)
    except Exception as error:
        if debug:
            raise
        return _failed(_unforeseen(error), 1)
    return code if isinstance(code, int) else 0


def _by_its_name(text: str) -> str:
    """Return an option under the name by which the commands know it."""
    flag, equals, value = text.partition("=")
    return RENAMED.get(flag, flag) + equals + value


def _never_fail_on_letters() -> None:
    # A console without some letter, as in v_f∞, shows a question mark instead of an error.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _unforeseen(error: Exception) -> str:
    what = f"{type(error).__name__}: {str(error).partition(chr(10))[0]}".rstrip(": ")
    if "thread" in what or "Resource temporarily unavailable" in what:
        return str(refused_by_system(OSError(errno.EAGAIN, what)))
    advice = "the same command with --debug shows where; please report it to the developers"
    return f"this failed in a way that nobody foresaw ({what}); {advice}"


def _failed(message: str, code: int) -> int:
    print(f"error: {message}", file=sys.stderr)
    return code


def _usage_message(error: Exception, given: Sequence[str]) -> str:
    """Say what the parser did not understand, in the form of our own errors where it fits."""
    commands = {getattr(command.callback, "__name__", "") for command in app.registered_commands}
    see = f"see pinchoff {given[0]} --help" if given[0] in commands else "see pinchoff --help"
    option = str(getattr(error, "option_name", ""))
    if hasattr(error, "possibilities"):
        near = difflib.get_close_matches(option, error.possibilities or (), n=1, cutoff=0.75)
        advice = f"did you mean {near[0]}?" if near else see
        command = f"pinchoff {given[0]}" if given[0] in commands else "pinchoff"
        return f"{option} must be an option of {command}; got {option}; {advice}"
    message = str(getattr(error, "message", ""))
    if option:
        rule = "given without a value" if "does not take" in message else "followed by a value"
        return f"{option} must be {rule}; got {_given_to(option, given)}; {see}"
    (name, *_) = getattr(getattr(error, "param", None), "opts", None) or ("",)
    if name:
        place = name if name.startswith("-") else name.upper()
        rule = next((rule for word, rule in _TYPES.items() if word in message), "given")
        return f"{place} must be {rule}; got {_given_to(name, given)}; {see}"
    message = getattr(error, "format_message", error.__str__)()
    if message.startswith("No such command"):
        near = difflib.get_close_matches(given[0], commands, n=1)
        advice = f"did you mean {near[0]}?" if near else see
        return f"COMMAND must be a command of pinchoff; got {given[0]}; {advice}"
    extra = re.search(r"unexpected extra argument\S* \((.*)\)", message, re.S)
    if extra:
        return f"arguments must be those of pinchoff {given[0]}; got {extra[1]} besides; {see}"
    return f"{message.rstrip('.')}; {see}"


def _given_to(option: str, given: Sequence[str]) -> str:
    """Return the value that follows an option."""
    for k, text in enumerate(given):
        if text.startswith(f"{option}="):
            return text.partition("=")[2]
        if text == option and k + 1 < len(given):
            return given[k + 1]
    return "nothing"
