"""The directive ``command-help``: a section for every command, an entry for each of its options."""

import re
from itertools import groupby
from typing import Any

import typer.main
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from pinchoff.cli import app as command_line

_MARKUP = re.compile(r"\\\[|\[/?(?:bold|dim)\]")
_OPTION = re.compile(r"(?<![\w-])(--[a-z][a-z-]*)")
_LIST = re.compile(r"^- ", flags=re.M)


def _plain(text: str) -> str:
    """Return a help text without the markup of terminals."""
    return _MARKUP.sub(lambda found: "[" if found[0] == "\\[" else "", text).strip()


class CommandHelp(SphinxDirective):
    """Sections in the order in which the program lists its commands."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        group: Any = typer.main.get_command(command_line)
        return [_section(name, command) for name, command in group.commands.items()]


def _section(name: str, command: Any) -> nodes.section:
    section = nodes.section(ids=[f"pinchoff-{name}"], names=[f"pinchoff {name}"])
    section += nodes.title("", f"pinchoff {name}")
    given = [p for p in command.params if p.param_type_name == "argument"]
    usage = " ".join(["pinchoff", name, *map(_metavar, given)])
    section += nodes.literal_block("", f"{usage} [OPTIONS]", language="text")
    section.extend(_prose(_plain(command.help or "")))
    if given:
        section += nodes.definition_list("", *(_entry(name, p) for p in given))
    options = [p for p in command.params if p.param_type_name == "option" and not p.hidden]
    panels = sorted(options, key=_panel)
    panels.sort(key=lambda p: _panel(p) != "Options")
    for panel, members in groupby(panels, key=_panel):
        section += nodes.rubric("", panel)
        section += nodes.definition_list("", *(_entry(name, p) for p in members))
    return section


def _metavar(argument: Any) -> str:
    named = f"{argument.metavar or argument.name.upper()}{'...' if argument.nargs != 1 else ''}"
    return named if argument.required else f"[{named}]"


def _panel(parameter: Any) -> str:
    return getattr(parameter, "rich_help_panel", None) or "Options"


def _prose(text: str) -> list[nodes.Node]:
    """Return the paragraphs, lists and examples of a help text."""
    found: list[nodes.Node] = []
    examples = False
    for block in re.split(r"\n\s*\n", text):
        if block.strip() in ("Example", "Examples"):
            found.append(nodes.rubric("", block.strip()))
            examples = True
        elif examples and block.lstrip().startswith(("pinchoff", "#")):
            lines = "\n".join(line.strip() for line in block.splitlines())
            lines = lines.replace("\\\n", "\\\n    ")
            found.append(nodes.literal_block("", lines, language="sh"))
        elif _LIST.match(block.lstrip()):
            items = [" ".join(item.split()) for item in _LIST.split(block) if item.strip()]
            found.append(
                nodes.bullet_list("", *(nodes.list_item("", _paragraph(item)) for item in items))
            )
        else:
            found.append(_paragraph(" ".join(block.split())))
    return found


def _paragraph(text: str) -> nodes.paragraph:
    """Return a paragraph in which the names of options are literal."""
    parts = _OPTION.split(text)
    shown = [nodes.literal("", p) if k % 2 else nodes.Text(p) for k, p in enumerate(parts)]
    return nodes.paragraph("", "", *shown)


def _entry(command: str, parameter: Any) -> nodes.definition_list_item:
    """Return an option or argument with what it takes and what it is, and an anchor."""
    flags = [*parameter.opts, *parameter.secondary_opts]
    takes = parameter.metavar or ""
    option = parameter.param_type_name == "option"
    term = nodes.term("", "", ids=[f"pinchoff-{command}-{parameter.name.replace('_', '-')}"])
    shown = ", ".join(flags) if option else takes
    term += nodes.literal("", shown)
    if option and takes:
        term += nodes.Text(f" {takes}")
    said = _plain(parameter.help or "")
    if parameter.show_default and parameter.default not in (None, False, ...):
        said += f" [default: {parameter.default}]"
    return nodes.definition_list_item("", term, nodes.definition("", _paragraph(said)))


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the directive."""
    app.add_directive("command-help", CommandHelp)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
