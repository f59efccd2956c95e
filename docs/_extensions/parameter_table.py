"""The directive ``parameter-table``: the entries of `pinchoff.Parameters` as a table."""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from pinchoff.model.parameters import PARAMETERS

_HEADINGS = ("symbol", "name", "meaning", "unit", "must be", "default")


class ParameterTable(SphinxDirective):
    """One row for each parameter, in their order."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        table = nodes.table()
        group = nodes.tgroup(cols=len(_HEADINGS))
        table += group
        group.extend(nodes.colspec(colwidth=1) for _ in _HEADINGS)
        group += nodes.thead("", _row(*(nodes.Text(heading) for heading in _HEADINGS)))
        body = nodes.tbody()
        group += body
        for name, entry in PARAMETERS.items():
            sentence = f"{entry.meaning}. {entry.note}" if entry.note else entry.meaning
            plain = (sentence, entry.unit, entry.rule, entry.default)
            body += _row(
                nodes.Text(entry.symbol), nodes.literal("", name), *(nodes.Text(t) for t in plain)
            )
        return [table]


def _row(*cells: nodes.Node) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def setup(app: Sphinx) -> dict[str, Any]:
    """Name the directive."""
    app.add_directive("parameter-table", ParameterTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
