"""The built page and the engine in it, skipped with a reason where absent, and the page opened."""

from __future__ import annotations

import base64
import gzip
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pinchoff.explorer.page import explorer_page, is_built, write_explorer


@pytest.fixture(scope="session")
def html() -> str:
    if not is_built():
        pytest.skip("the explorer's page is not built; `make explorer` builds it")
    return explorer_page()


@pytest.fixture(scope="session")
def code(html: str) -> bytes:
    """The engine as the page holds it."""
    packed = re.search(r'<script type="text/plain" id="engine">([\w+/=]*)</script>', html)
    assert packed
    return gzip.decompress(base64.b64decode(packed[1]))


class Opened:
    """A page in the browser, with all that it complained of and asked the network for."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.complaints: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self._note(message.type, message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def _note(self, kind: str, text: str) -> None:
        if kind in ("error", "warning"):
            self.complaints.append(text)

    def value(self, script: str) -> Any:
        return self.page.evaluate(script)

    def until(self, script: str, seconds: float = 60.0) -> None:
        """Wait for something to be true; the page's policy lets nobody evaluate text in it."""
        end = time.monotonic() + seconds
        while not self.value(script):
            assert time.monotonic() < end, f"{script} did not come true in {seconds} s"
            time.sleep(0.02)

    def settled(self) -> None:
        """Wait for the collision that was asked for last."""
        self.until(
            "explorer.current().refused !== '' || (explorer.current().here !== null && "
            "explorer.points.key(explorer.current().here.values) === "
            "explorer.points.key(explorer.state.values))"
        )


@pytest.fixture
def opened(html: str, browser: Any, tmp_path: Path) -> Iterator[Callable[..., Opened]]:
    """Open the page, with a user's data or a fragment, and hold it to silence at the end."""
    pages: list[Opened] = []

    def open_page(own: dict[str, Any] | None = None, fragment: str = "", **options: Any) -> Opened:
        path = tmp_path / f"page{len(pages)}.html"
        write_explorer(path, own)
        context = browser.new_context(reduced_motion="reduce", **options)
        result = Opened(context.new_page())
        result.page.goto(path.as_uri() + fragment)
        result.until("'explorer' in window && explorer.current().run !== null")
        pages.append(result)
        return result

    yield open_page
    for each in pages:
        assert each.complaints == []
        outside = [url for url in each.requests if not url.startswith(("file:", "blob:", "data:"))]
        assert outside == []
        each.page.context.close()
