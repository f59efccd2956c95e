"""One set of options: their names, defaults and help, over all commands."""

from __future__ import annotations

import inspect
import re
from typing import get_args

import pytest
import typer

import pinchoff as po
from pinchoff.cli import app, main
from pinchoff.cli.assignments import read_list, read_pairs, read_value
from pinchoff.model.presets import preset_names

GROUP = typer.main.get_command(app)
COMMANDS = {name: GROUP.get_command(None, name) for name in GROUP.commands}
WRITERS = [*COMMANDS]
NO_FOLDER = ("summary", "examples")
"""A picture is not a result that could be lost; the examples' folder is an argument."""


def options_of(command):
    return {flag: each for each in COMMANDS[command].params for flag in each.opts}


def test_help_names_every_parameter_and_preset():
    options = options_of("run")
    own = {"model", "size_ratio", "simulation_capillary_number", "offset", "scale"}
    _, _, names = options["--set"].help.partition("NAME is ")
    assert {*names.rstrip(".").split(", ")} == {*po.Parameters.model_fields} - own
    for name in get_args(po.Parameters.model_fields["model"].annotation):
        assert name in options["--model"].help
    for name in preset_names():
        assert name in options["--preset"].help


@pytest.mark.parametrize(
    ("flag", "name"),
    [
        ("--size-ratio", "size_ratio"),
        ("--capillary", "simulation_capillary_number"),
        ("--offset", "offset"),
    ],
)
def test_help_of_run_has_the_defaults_of_the_model(flag, name):
    said = options_of("run")[flag].help
    (default,) = re.findall(r"default: ([\d.]+)\]", said)
    assert float(default) == getattr(po.Parameters(), name)


@pytest.mark.parametrize("command", WRITERS)
def test_all_that_write_have_the_same_options_for_it(command):
    options = options_of(command)
    assert "--json" in options
    if command not in NO_FOLDER:
        assert "--out" in options
    if command not in ("summary", "video"):  # what is measured already is taken up, not replaced
        assert "--overwrite" in options


@pytest.mark.parametrize("command", COMMANDS)
def test_help_fits_a_terminal_and_can_be_pasted(command):
    """No line is wrapped, and one that goes on says so."""
    text = inspect.cleandoc(COMMANDS[command].callback.__doc__)
    assert max(map(len, text.splitlines())) <= 77
    examples = text.partition("[bold]Example")[2].partition("[/bold]")[2].split("\n\n")
    assert examples[0] or examples[1:]
    for example in filter(None, map(str.strip, examples)):
        *lines, last = example.splitlines()
        assert example.startswith("pinchoff ")
        assert not last.endswith("\\")
        assert all(line.endswith(" \\") for line in lines), example


def test_one_name_is_one_meaning():
    """Options of one name take the same and say the same, but for the examples."""
    found = {}
    for command in WRITERS:
        for flag, each in options_of(command).items():
            found.setdefault(flag, set()).add(each.metavar)
    mixed = {flag: takes for flag, takes in found.items() if len(takes) > 1}
    assert {*mixed} <= {"--size-ratio", "--capillary", "--set", "--free", "--out"}


def test_earlier_and_longer_names_are_understood(tmp_path, capsys):
    long = ["run", "--simulation-capillary-number=-3", "--out", str(tmp_path / "a")]
    assert main(long) == 2
    assert capsys.readouterr().err.startswith("error: --capillary must be")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("run --offset 0.1 --offset=0.2", "--offset must be given once; got 0.2; drop one of them"),
        ("run --capillary 3 --simulation-capillary-number 4", "--capillary must be given once"),
        (
            "boundary --capillary 20 --capillary 30",
            "--capillary must be given once; got 30; write one list, with commas",
        ),
        ("sweep a.toml --workers 1 --threads 2", "--workers must be given once; got 2"),
    ],
)
def test_option_that_is_given_twice_is_refused(line, message, capsys):
    """The last one would hold, and of a list of values one only."""
    assert main(line.split()) == 2
    assert capsys.readouterr().err.startswith(f"error: {message}")


def test_pairs_lists_and_values():
    assert read_pairs("--set", ["a=1", " b = x=y "], "a=1") == {"a": "1", "b": "x=y"}
    assert read_list("--size-ratio", "[4, 5.5,true]") == [4, 5.5, True]
    assert read_value("--set a", "2e3") == 2000.0
    for texts in (["a"], ["=1"], ["a="], ["a=1", "a=2"]):
        with pytest.raises(po.InputError, match="--set"):
            read_pairs("--set", texts, "a=1")


def test_only_an_option_that_is_much_like_it_is_offered_for_an_unknown_one(refusal):
    assert refusal("run", "--offest", 0.1)["advice"] == "did you mean --offset?"
    assert refusal("run", "--vertices", 64)["advice"] == "see pinchoff run --help"
