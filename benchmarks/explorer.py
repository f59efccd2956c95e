"""Speed of the engine in a browser beside the native one, on one core each, in one run.

The two take turns, collision by collision after a round to warm up, and what is counted is time of
the processor, which other work on the machine does not lengthen: that of this process, and that of
the page's process as Chromium itself states it.

    python benchmarks/explorer.py [--quick]

Needs Chromium, Playwright and the page that `make explorer` builds.
"""

from __future__ import annotations

import argparse
import math
import shutil
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

import pinchoff as po
from pinchoff import _core
from pinchoff.explorer.page import write_explorer

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
IN_PAGE = """row => {
    const { result } = explorer.engine().run(Float64Array.from(row));
    return [result.outcome, result.symmetry];
}"""


class PageClock:
    """Time that the page's process has had of the processor, in seconds."""

    def __init__(self, chromium: Browser) -> None:
        self._session = chromium.new_browser_cdp_session()

    def __call__(self) -> float:
        processes = self._session.send("SystemInfo.getProcessInfo")["processInfo"]
        return sum(float(each["cpuTime"]) for each in processes if each["type"] == "renderer")


def collisions(count: int) -> list[po.Parameters]:
    """Return collisions as a map of the page has them: offset against the flow's strength."""
    random = np.random.default_rng(1)
    return [
        po.Parameters(
            offset=random.uniform(0.0, 0.5),
            simulation_capillary_number=10 ** random.uniform(0.9, 2.0),
            follow_daughters=False,
        )
        for _ in range(count)
    ]


def measure(page: Page, clock: PageClock, count: int, rounds: int) -> None:
    """Print the figures of single collisions."""
    rows = [parameters.model_row() for parameters in collisions(count)]
    native, browser, same, apart = [], [], 0, 0.0
    for number in range(rounds + 1):
        begun = time.process_time()
        results = [_core.run_many(row[None], None, 1, None)[0].tolist() for row in rows]
        middle = clock()
        native.append((time.process_time() - begun) / count)
        found = [page.evaluate(IN_PAGE, row.tolist()) for row in rows]
        browser.append((clock() - middle) / count)
        if number:
            continue
        for result, (outcome, symmetry) in zip(results, found, strict=True):
            known = dict(zip(_core.RESULT_FIELDS, result, strict=True))
            same += known["outcome"] == outcome
            if not math.isnan(known["symmetry"]):
                apart = max(apart, abs(known["symmetry"] - symmetry))
    native, browser = native[1:], browser[1:]
    ratios = [b / n for n, b in zip(native, browser, strict=True)]
    print(f"{count} collisions, {rounds} rounds; medians")
    print(f"native ({_core.instruction_set()}): {1e3 * statistics.median(native):.1f} ms each")
    print(f"browser: {1e3 * statistics.median(browser):.1f} ms each")
    print(f"ratio: {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")
    print(f"same outcome: {same} of {count}; S differs by at most {apart:.1e}")


def measure_map(page: Page, clock: PageClock) -> None:
    """Print what a map of 20 by 20 takes on the browser's cores."""
    begun = clock()
    page.select_option("#map-size", "20")
    page.click("#map")
    while "collisions in" not in page.inner_text("#map-word"):
        time.sleep(0.2)
    cores = page.evaluate("navigator.hardwareConcurrency")
    print(f"map {page.inner_text('#map-word')} on {cores} cores as they were,", end=" ")
    print(f"{(clock() - begun) / cores:.1f} s of each core")


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        raise SystemExit("Chromium must be installed; got none; install Debian's `chromium`")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "page.html"
        write_explorer(path)
        chromium = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        clock = PageClock(chromium)
        page = chromium.new_context(reduced_motion="reduce").new_page()
        page.goto(path.as_uri())
        while not page.evaluate("'explorer' in window && explorer.current().run !== null"):
            time.sleep(0.05)
        measure(page, clock, 10 if quick else 60, 2 if quick else 5)
        measure_map(page, clock)
        chromium.close()


if __name__ == "__main__":
    main()
