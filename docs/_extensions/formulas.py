r"""Formulas as SVG, drawn when the site is built: a page needs neither a script nor the network.

``\tag{…}`` in a displayed formula puts a number beside it, as LaTeX does.
"""

import re
from typing import Any
from xml.etree import ElementTree

import ziamath
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_SIZE = 20.0  # of the letters, in the drawing's own unit; the page scales it to its own
_TAG = re.compile(r"\\tag\{([^}]*)\}")
_EMPTY_LINES = re.compile(r"\n\s*\n")

ElementTree.register_namespace("", "http://www.w3.org/2000/svg")
ziamath.config.svg2 = False  # shapes, not references: two formulas on a page share no names
ziamath.config.precision = 2


def draw(latex: str, inline: bool) -> str:
    """Return a formula as an SVG element whose height and baseline follow the text around it."""
    picture = ziamath.Latex(latex, size=_SIZE, color="currentColor", inline=inline).svgxml()
    _, top, width, height = (float(number) for number in picture.attrib["viewBox"].split())
    picture.attrib |= {
        "role": "img",
        "aria-label": latex,
        "width": f"{width / _SIZE:.3f}em",
        "height": f"{height / _SIZE:.3f}em",
        "style": f"vertical-align: {-(top + height) / _SIZE:.3f}em",
    }
    return ElementTree.tostring(picture, encoding="unicode")


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(f'<span class="formula">{draw(node.astext(), inline=True)}</span>')
    raise nodes.SkipNode


def _displayed(writer: HTML5Translator, node: nodes.math_block) -> None:
    latex = _EMPTY_LINES.sub("\n", node.astext())
    tag = _TAG.search(latex)
    anchors = "".join(f'<span id="{anchor}"></span>' for anchor in node["ids"])
    number = f'<span class="formula-number">({tag[1]})</span>' if tag else ""
    drawing = draw(_TAG.sub("", latex).strip(), inline=False)
    writer.body.append(f'<div class="formula">{anchors}<div>{drawing}</div>{number}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Make ``formulas`` a value of html_math_renderer."""
    app.add_html_math_renderer("formulas", (_inline, None), (_displayed, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
