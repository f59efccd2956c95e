"""One HTML file with text, tables and pictures inside: it opens anywhere, without a network."""

from __future__ import annotations

import base64
import io
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple
from urllib.parse import quote

from pinchoff.figures.mathml import formula
from pinchoff.support.errors import InputError
from pinchoff.support.files import write_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Picture = Axes | bytes | str | os.PathLike[str]

_NUMBER = re.compile(
    r"^[+\-−±<>≤≥~]?\s?\d[\d.,  ]*(?:e[+-]?\d+|(?:×10)?[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?(?:\s?%)?$|^$|^–$|^—$", re.I
)
_SUBSCRIPT = re.compile(
    r"(?<![^\W\d])(S|Ca|A|d|ε|k̃|N|v)"
    r"(?:_(c|sim|eff|small|large|min-neck|μ|γ|l|v|f∞|droplet|flow)|(?<=ε)([123]))(?!\w)"
)
_POWER = re.compile(r"(?<=[\w)])\^(?:\(([^()]*)\)|([-−]?[\w.]+))")
_SIGNS = {"good": "✓", "bad": "✗", "odd": "!"}
_MEDIA = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg", b"<?xml": "image/svg+xml"}
_SHORT = 26  # letters: a cell this short is kept on one line
_SCREEN_DOTS_PER_INCH = 96
_ENLARGED = 'class="picture" href="#"'


class Mark(NamedTuple):
    """A word of a table that says whether something is well.

    Attributes
    ----------
    text : str
    tone : {"good", "bad", "odd"}
        Green with ✓, red with ✗, or orange with !.
    """

    text: str
    tone: Literal["good", "bad", "odd"]

    def __str__(self) -> str:
        return f"{_SIGNS[self.tone]} {self.text}"


class Detailed(NamedTuple):
    """A cell of a table with a second line in small print, such as an interval.

    Attributes
    ----------
    text, detail : str
    """

    text: str
    detail: str

    def __str__(self) -> str:
        return self.text


class Page:
    """A report as one HTML file, light or dark as the reader's system is, fit for print.

    Everything that is written into it is escaped. A picture is enlarged by a click.

    Parameters
    ----------
    title : str
    summary : str, optional
        A sentence below the title.
    notice : str, optional
        What nobody may overlook, such as that the data are synthetic.
    """

    def __init__(self, title: str, summary: str = "", notice: str = "") -> None:
        self._title, self._summary, self._notice = title, summary, notice
        self._headings: list[str] = []
        self._body: list[str] = []

    def section(self, heading: str) -> None:
        """Begin a section; the page's head links to it."""
        self._headings.append(heading)
        self._body.append(f'<h2 id="section-{len(self._headings)}">{escape(heading)}</h2>')

    def paragraph(self, text: str) -> None:
        """Add a paragraph of plain text; a formula in it stands between two signs ``$``."""
        self._body.append(f"<p>{_typeset(text)}</p>")

    def formula(self, text: str) -> None:
        """Add a formula on a line of its own, written as in `mathml.formula`."""
        self._body.append(f"<p>{formula(text, display=True)}</p>")

    def link(self, text: str, target: str) -> None:
        """Add a link to a file in the folder of the page, by the file's name."""
        self._body.append(f'<p><a href="{escape(quote(target))}">{escape(text)}</a></p>')

    def table(
        self, columns: Sequence[str], rows: Iterable[Sequence[object]], caption: str = ""
    ) -> None:
        """Add a table; a column whose cells are all numbers is aligned as such.

        Parameters
        ----------
        columns : sequence of n str
            Headings, with units.
        rows : iterable of sequence of n
            Cells, as they are to be read. A `Mark` is coloured and has a sign; a `Detailed` has
            a second line.
        caption : str, optional
        """
        rows = [list(row) for row in rows]
        cells = [[_longest(cell) for cell in row] for row in rows]
        kinds = [_kind([row[k] for row in cells]) for k in range(len(columns))]
        heading = f"<caption>{_raised(caption)}</caption>" if caption else ""
        names = "".join(f"<th{k}>{_raised(c)}</th>" for c, k in zip(columns, kinds, strict=True))
        head = f"<thead><tr>{names}</tr></thead>\n" if any(columns) else ""
        body = "".join(
            "<tr>"
            + "".join(f"<td{k}>{_cell(c)}</td>" for c, k in zip(row, kinds, strict=True))
            + "</tr>\n"
            for row in rows
        )
        self._body.append(
            f'<div class="table"><table>{heading}{head}<tbody>{body}</tbody></table></div>'
        )

    def facts(self, facts: Mapping[str, object]) -> None:
        """Add a table of names and values."""
        self.table(("", ""), facts.items())

    def figure(self, picture: Picture, caption: str) -> None:
        """Add a picture with a caption.

        Parameters
        ----------
        picture : Axes, bytes or path
            Axes, whose figure is drawn; a PNG, JPEG or SVG picture, or the file that holds it.
        caption : str
            Also what a reader without the picture gets to know of it.

        Raises
        ------
        InputError
            It is none of these.
        """
        self._body.append(_figure(picture, caption))

    def gallery(self, pictures: Iterable[tuple[Picture, str] | tuple[Picture, str, str]]) -> None:
        """Add small pictures side by side, each with a caption; as in `figure`.

        Where a third value is given and not empty, it is the address of what the picture opens.
        """
        figures = "\n".join(_figure(*picture) for picture in pictures)
        self._body.append(f'<div class="gallery">\n{figures}\n</div>')

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the page, complete or not at all."""
        write_text(Path(path), self.html())

    def html(self) -> str:
        """Return the page."""
        from pinchoff import __version__

        links = "\n".join(
            f'<a href="#section-{k}">{escape(heading)}</a>'
            for k, heading in enumerate(self._headings, start=1)
        )
        head = [
            f"<h1>{escape(self._title)}</h1>",
            f'<p class="summary">{_typeset(self._summary)}</p>' if self._summary else "",
            f'<p class="notice">{escape(self._notice)}</p>' if self._notice else "",
            f"<nav>{links}</nav>" if len(self._headings) > 1 else "",
        ]
        body = "\n".join([*filter(None, head), *self._body])
        return (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            '<link rel="icon" href="data:,">\n'
            f"<title>{escape(self._title)}</title>\n<style>\n{_resource('page.css')}</style>\n"
            f"</head>\n<body>\n{body}\n"
            f"<footer>pinchoff {escape(__version__)}</footer>\n"
            f'<dialog aria-label="Enlarged picture"><img alt=""></dialog>\n'
            f"<script>\n{_resource('page.js')}</script>\n</body>\n</html>\n"
        )


def _typeset(text: str) -> str:
    """Return a text for a page, with the formulas between its signs $ typeset."""
    plain, *rest = text.split("$")
    if len(rest) % 2:  # a sign of its own, as in a name
        return escape(text)
    shown = [escape(plain)]
    for inside, after in zip(rest[::2], rest[1::2], strict=True):
        try:
            shown += [formula(inside), escape(after)]
        except ValueError:
            return escape(text)
    return "".join(shown)


def _cell(value: object) -> str:
    """Return a cell for a page: a mark in its colour, a detail in small print."""
    if isinstance(value, Mark):
        return f'<span class="{value.tone}">{escape(str(value))}</span>'
    if isinstance(value, Detailed) and value.detail:
        return f"{_raised(value.text)}<br><small>{_raised(value.detail)}</small>"
    return _raised(str(value))


def _raised(text: str) -> str:
    """Return a text for a page with its powers raised and the indices of symbols lowered."""
    lowered = _SUBSCRIPT.sub(lambda m: f"{m[1]}<sub>{m[2] or m[3]}</sub>", escape(text))
    return _POWER.sub(lambda found: f"<sup>{found[1] or found[2]}</sup>", lowered)


def _longest(cell: object) -> str:
    return max(cell, key=len) if isinstance(cell, Detailed) else str(cell)


def _kind(cells: Sequence[str]) -> str:
    """Return the class of a column: numbers, short words that stay on one line, or neither."""
    if cells and all(_NUMBER.match(cell) for cell in cells):
        return ' class="number"'
    return ' class="short"' if max(map(len, cells), default=0) <= _SHORT else ""


def _resource(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _figure(picture: Picture, caption: str, opens: str = "") -> str:
    data = _bytes(picture)
    media = next((kind for mark, kind in _MEDIA.items() if data.startswith(mark)), None)
    if media is None:
        raise InputError.of(
            "picture", "Axes or a PNG, JPEG or SVG picture", "other data", "draw it"
        )
    source = f"data:{media};base64,{base64.b64encode(data).decode()}"
    kind = f'class="film" href="{escape(opens)}" target="_blank"' if opens else _ENLARGED
    return (
        f'<figure><a {kind}><img src="{source}" alt="{escape(caption)}"'
        f"{_size_on_screen(data)}></a><figcaption>{_raised(caption)}</figcaption></figure>"
    )


def _bytes(picture: Picture) -> bytes:
    if isinstance(picture, bytes):
        return picture
    if isinstance(picture, (str, os.PathLike)):
        return Path(picture).read_bytes()
    from pinchoff.figures import style

    return style.png(picture)


def _size_on_screen(data: bytes) -> str:
    """Return a width that shows a PNG 1.4 times as large as print, if it states its resolution."""
    from PIL import Image

    if not data.startswith(b"\x89PNG"):
        return ""
    image = Image.open(io.BytesIO(data))
    if "dpi" not in image.info:
        return ""
    return f' width="{round(1.4 * image.width / image.info["dpi"][0] * _SCREEN_DOTS_PER_INCH)}"'
