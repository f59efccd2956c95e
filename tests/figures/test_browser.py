"""Pages in a real browser: no errors, every picture shows, links lead somewhere, clicks enlarge."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape

import pytest
from matplotlib.figure import Figure

from pinchoff.figures.html_page import Page

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))),
    None,
)
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--virtual-time-budget=5000",
]

_BEFORE = """<script>
window.failures = [];
window.addEventListener("error", (event) => window.failures.push(String(event.message)), true);
</script>"""
_AFTER = """<script>
window.addEventListener("load", () => {
  const images = [...document.querySelectorAll("figure img")];
  const links = [...document.querySelectorAll("nav a")].map((a) => a.getAttribute("href"));
  images[0].closest("a").click();
  const dialog = document.querySelector("dialog");
  const found = {
    failures: window.failures,
    images: images.length,
    shown: images.filter((image) => image.complete && image.naturalWidth > 0).length,
    lost: links.filter((href) => !document.querySelector(href)),
    enlarged: dialog.open && dialog.querySelector("img").src === images[0].src,
    wide: document.documentElement.scrollWidth > window.innerWidth,
  };
  dialog.click();
  found.closed = !dialog.open;
  document.title = JSON.stringify(found);
});
</script>"""

pytestmark = pytest.mark.skipif(BROWSER is None, reason="there is no Chromium to open pages with")


def opened(page, folder, width=1100):
    """Open the page and return what a script in it finds."""
    html = page.html().replace("<head>", f"<head>{_BEFORE}").replace("</body>", f"{_AFTER}</body>")
    path = folder / "page.html"
    path.write_text(html, encoding="utf-8")
    command = [
        BROWSER,
        *FLAGS,
        f"--window-size={width},900",
        f"--user-data-dir={folder / 'profile'}",
    ]
    done = subprocess.run(
        [*command, "--dump-dom", path.as_uri()],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    title = re.search(r"<title>(.*?)</title>", done.stdout, flags=re.S)
    assert title is not None
    return json.loads(unescape(title[1]))


@pytest.fixture
def page():
    page = Page("A page", "summary", "notice")
    for name in ("First", "Second"):
        page.section(name)
        page.figure(Figure(figsize=(6, 2)).subplots(), "a wide picture")
        page.table([f"column {k}" for k in range(9)], [["some words in a cell"] * 9] * 3)
    return page


@pytest.mark.parametrize("width", [1100, 420])
def test_a_page_opens_without_errors(page, tmp_path, width):
    found = opened(page, tmp_path, width)
    assert found["failures"] == []
    assert found["images"] == found["shown"] == 2
    assert found["lost"] == []
    assert found["enlarged"]
    assert found["closed"]
    assert not found["wide"]  # wide tables scroll by themselves
