"""Pages in a real browser: no errors, every picture shows, links lead somewhere, clicks enlarge."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from pinchoff.figures.html_page import Page


@pytest.fixture
def path(tmp_path):
    page = Page("A page", "summary", "notice")
    for name in ("First", "Second"):
        page.section(name)
        page.figure(Figure(figsize=(6, 2)).subplots(), "a wide picture")
        page.table([f"column {k}" for k in range(9)], [["some words in a cell"] * 9] * 3)
    page.write(tmp_path / "page.html")
    return tmp_path / "page.html"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1100, 420])
def test_a_page_opens_without_errors(browser, path, width, scheme):
    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    failures = []
    for kind in ("pageerror", "requestfailed"):
        page.on(kind, lambda failure: failures.append(str(failure)))
    page.goto(path.as_uri())
    images, dialog = page.locator("figure img"), page.locator("dialog")
    assert images.evaluate_all("all => all.map(image => image.naturalWidth > 0)") == [True] * 2
    targets = page.locator("nav a").evaluate_all("all => all.map(a => a.getAttribute('href'))")
    assert [page.locator(target).count() for target in targets] == [1, 1]
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")  # tables scroll
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (ground == "rgb(255, 255, 255)") == (scheme == "light")
    images.first.click()
    assert dialog.locator("img").get_attribute("src") == images.first.get_attribute("src")
    dialog.click()
    assert not dialog.is_visible()
    assert failures == []
    page.close()
