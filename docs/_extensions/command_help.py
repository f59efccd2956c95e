"""The directive ``command-help``: a section for every command with what its --help says."""

import os
import subprocess
import sys
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from pinchoff.cli import app as command_line

_COLUMNS = 96
_PROGRAM = "from pinchoff.cli import main; raise SystemExit(main())"


def help_text(*command: str) -> str:
    """Return what a command prints with --help, without colours."""
    plain = {"NO_COLOR": "1", "TERM": "dumb", "COLUMNS": str(_COLUMNS)}
    done = subprocess.run(
        [sys.executable, "-c", _PROGRAM, *command, "--help"],
        capture_output=True,
        text=True,
        check=True,
        encoding="utf-8",
        env={**os.environ, **plain, "PYTHONUTF8": "1", "TERMINAL_WIDTH": str(_COLUMNS)},
    )
    return "\n".join(line.rstrip() for line in done.stdout.strip("\n").splitlines())


class CommandHelp(SphinxDirective):
    """Sections in the order in which the program lists its commands."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        sections: list[nodes.Node] = []
        for command in command_line.registered_commands:
            name = command.name or command.callback.__name__.replace("_", "-")
            section = nodes.section(ids=[f"pinchoff-{name}"], names=[f"pinchoff {name}"])
            section += nodes.title("", f"pinchoff {name}")
            text = help_text(name)
            section += nodes.literal_block(text, text, language="text", classes=["command-help"])
            sections.append(section)
        return sections


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
