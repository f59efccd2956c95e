"""Pages: one file, nothing loaded from elsewhere, everything escaped."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure

import pinchoff as po
from pinchoff.figures.html_page import Mark, Page
from pinchoff.figures.mathml import formula

VOID = {"meta", "link", "img", "br"}


class Outline(HTMLParser):
    """Checks that tags nest, and keeps what the page refers to and the text it shows."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.names: list[str] = []
        self.text = ""

    def handle_starttag(self, tag, attrs):
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            if name in ("src", "href"):
                self.references.append(value)
            if name == "id":
                self.names.append(value)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def read(page):
    outline = Outline()
    outline.feed(page.html())
    assert outline.open == []
    return outline


@pytest.fixture
def axes():
    return Figure(figsize=(2, 1)).subplots()


def test_everything_is_inside(axes):
    page = Page("Title", "summary", "notice")
    page.section("First")
    page.paragraph("text")
    page.section("Second")
    page.figure(axes, "a picture")
    page.gallery([(axes, "one"), (axes, "two")])
    outline = read(page)
    inside = [each for each in outline.references if not each.startswith(("data:", "#"))]
    assert inside == []
    assert sum(each.startswith("data:image/png;base64,") for each in outline.references) == 3
    assert [each for each in outline.references if each.startswith("#section")] == [
        f"#{name}" for name in outline.names
    ]
    assert "url(" not in page.html()


def test_what_is_written_is_shown_as_it_stands(axes):
    hostile = "<script>alert('x')</script> & \"quoted\" Ã"
    page = Page(hostile, hostile, hostile)
    page.section(hostile)
    page.paragraph(hostile)
    page.table([hostile], [[hostile]], hostile)
    page.facts({hostile: hostile})
    page.figure(axes, hostile)
    html = page.html()
    assert "<script>alert" not in html
    assert 'alt="&lt;script' in html
    assert read(page).text.count(hostile) == 12


def test_columns_of_numbers_are_aligned_as_such():
    page = Page("t")
    page.table(["name", "value"], [["1 a", "1.5e-3"], ["2", "−0.74"], ["3", "12 %"]])
    assert re.findall(r'<td class="(.*?)"', page.html())[:2] == ["short", "number"]


def test_a_picture_can_be_a_file_or_bytes(tmp_path, axes):
    axes.figure.savefig(tmp_path / "a.png")
    axes.figure.savefig(tmp_path / "a.svg")
    page = Page("t")
    page.figure(tmp_path / "a.png", "png")
    page.figure((tmp_path / "a.svg").read_bytes(), "svg")
    kinds = [each.partition(";")[0] for each in read(page).references if each.startswith("data:i")]
    assert kinds == ["data:image/png", "data:image/svg+xml"]


def test_other_data_are_refused(refused):
    error = refused("picture", Page("t").figure, b"nonsense", "caption")
    assert isinstance(error, po.InputError)


def test_written_whole(tmp_path):
    page = Page("t")
    page.write(tmp_path / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.html()


def test_formulas_are_mathml_and_nest():
    page = Page("Title", "on the line $S = α (Ca Ã z̃)^β$")
    page.formula("Bk = Ca Ã z̃ (S/α)^(-1/β)")
    page.paragraph("costs $3, or a$b$c^")
    page.paragraph("an <index> $ε_μ^2$")
    text = page.html()
    read(page)
    assert text.count("<math") == 3
    assert "<msup><mi>β" not in text
    assert "<mfrac><mi>S</mi><mi>α</mi></mfrac>" in text
    assert "costs $3, or a$b$c^" in text  # what is no formula stays as it is


def test_fractions_powers_and_indices_bind_as_they_are_read():
    assert (
        formula("a/b^2")
        == "<math><mfrac><mi>a</mi><msup><mi>b</mi><mn>2</mn></msup></mfrac></math>"
    )
    assert "<msup><mi>μ</mi><msub><mi>ε</mi><mi>v</mi></msub></msup>" in formula("μ^ε_v")
    for wrong in ("(a", "a)", "a^", "/a", "a?"):
        with pytest.raises(ValueError, match=r"formula|partner"):
            formula(wrong)


def test_marks_have_a_colour_and_a_sign():
    page = Page("Title")
    page.table(("", "verdict"), [("α^(1/β) <", Mark("agrees", "good")), ("b", Mark("no", "bad"))])
    text = page.html()
    read(page)
    assert '<span class="good">✓ agrees</span>' in text
    assert '<span class="bad">✗ no</span>' in text
    assert "α<sup>1/β</sup> &lt;" in text


def test_indices_are_lowered_and_facts_have_no_heading():
    page = Page("Title")
    page.facts({"2ε1 + ε2 = 0": "v_f∞", "S_c": "xS_c"})
    text = page.html()
    for part in ("2ε<sub>1</sub> + ε<sub>2</sub>", "v<sub>f∞</sub>", "S<sub>c</sub>", "xS_c"):
        assert part in text
    assert "<thead>" not in text
