"""The explorer on the site: its page beside the others, and the role that links to it."""

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

from pinchoff.explorer.page import write_explorer

PAGE = "live-model.html"


def _link(
    name: str, rawtext: str, text: str, lineno: int, inliner: Any, *_: Any
) -> tuple[list[nodes.Node], list[nodes.system_message]]:
    docname = inliner.document.settings.env.docname
    target = "../" * docname.count("/") + PAGE
    return [nodes.reference(rawtext, text, refuri=target, classes=["live-model"])], []


def _write(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        write_explorer(Path(app.outdir) / PAGE)


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the role, and write the page once the others are there."""
    app.add_role("live-model", _link)
    app.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
