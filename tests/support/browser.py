"""Pages in a real browser (chromium, driven by Playwright): content and complaints.

Pages run in real time: a test waits until the expected content is there, however long that takes on
a loaded machine. A test that needs to control a page's clock stops it and advances it
(`is_stopped`).
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
WIDTHS = (320, 400, 800, 1280)

# Script that waits for two frames: a change requested in the first frame is drawn in the second.
DRAWN = "() => new Promise((d) => requestAnimationFrame(() => requestAnimationFrame(d)))"

# Script that drops a file, given by name and text, with the events that a browser generates.
DROP = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([text], name));
  for (const kind of ["dragenter", "dragover", "drop"]) {
    const how = { dataTransfer: data, bubbles: true, cancelable: true };
    document.body.dispatchEvent(new DragEvent(kind, how));
  }
}"""


def browser(test: Any) -> Any:
    """Mark a test that starts a browser, which exceeds the second of a fast test."""
    needed = pytest.mark.skipif(CHROMIUM is None, reason="no chromium to look at the page with")
    return pytest.mark.proof(needed(test))


def wait_until(page: Any, expression: str, seconds: float = 60.0) -> None:
    """Wait until a JavaScript expression is true in a page.

    Playwright's own `wait_for_function` evaluates repeatedly inside the page, which the policy of
    most pages forbids, so it fails unless the expression is true at once.
    """
    end = time.monotonic() + seconds
    while not page.evaluate(expression):
        assert time.monotonic() < end, expression
        page.wait_for_timeout(20)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Start one browser for the tests of a module; the windows of tests share nothing."""
    if CHROMIUM is None:
        pytest.skip("no chromium to look at the pages with")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield started
        started.close()


@pytest.fixture
def visited(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Open an address in a new window: `visited(address, until=..., width=1280)`.

    The result is a page of Playwright. Its `complaints` contain console messages, script errors,
    and every request to another address. `until` is a JavaScript expression to wait for. With
    `is_stopped` the page's clock stands at zero and only advances by
    `page.clock.run_for(milliseconds)`.
    """
    windows = []

    def visit(
        address: str, *, until: str = "", width: int = 1280, is_stopped: bool = False, **how: Any
    ) -> Any:
        windows.append(chromium.new_context(viewport={"width": width, "height": 900}, **how))
        page = windows[-1].new_page()
        complaints: list[str] = []
        page.on("console", lambda m: complaints.append(m.text))
        page.on("pageerror", lambda e: complaints.append(str(e)))
        here = tuple({address.partition("#")[0].rpartition("/")[0], "data:", "blob:"})
        page.on(
            "request", lambda r: complaints.append(r.url) if not r.url.startswith(here) else None
        )
        page.complaints = complaints
        if is_stopped:
            page.clock.install(time=0)
            page.clock.pause_at(1)
        page.goto(address)
        if until:
            wait_until(page, until)
        if not is_stopped:
            page.evaluate(DRAWN)
        return page

    yield visit
    for window in windows:
        window.close()


@pytest.fixture
def opened(visited: Callable[..., Any], tmp_path: Path) -> Callable[..., Any]:
    """Open a page from its text, at an address within it: `opened(text, "#t=3")`."""

    def open_text(text: str, within: str = "", **how: Any) -> Any:
        path = tmp_path / "page.html"
        path.write_text(text, encoding="utf-8")
        return visited(f"{path.as_uri()}{within}", **how)

    return open_text


def widths(opened: Callable[..., Any], text: str, within: str = "", **how: Any) -> list[Any]:
    """Return the width of a page in windows of four widths, and those widths."""
    root = "document.documentElement"
    size = f"[{root}.scrollWidth, {root}.clientWidth]"
    return [opened(text, within, width=w, **how).evaluate(size) for w in WIDTHS]
