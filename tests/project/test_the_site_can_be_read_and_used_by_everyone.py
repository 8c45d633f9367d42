"""Screen readers get the headings and columns of a page, and scrolling areas can be reached by
keyboard."""

import subprocess
import sys

import pytest

from accessible import lacking, mended
from heyoka_bike.system.resources import data_folder
from support.browser import browser, wait_until

SITE = data_folder().parent / "docs" / "_site"
LONG = "x" * 400
SCROLLED = "[...document.querySelectorAll('[tabindex=\"0\"]')].map((place) => place.id)"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return a function that builds a page with the site's theme: its messages, and the HTML by
    file name."""
    for name in ("sphinx", "furo", "myst_parser"):
        pytest.importorskip(name)

    def build(page):
        docs = tmp_path_factory.mktemp("docs")
        (docs / "conf.py").write_text(
            f"import sys; sys.path.insert(0, {str(SITE)!r})\n"
            "extensions = ['myst_parser', 'accessible']\n"
            f"html_theme = 'furo'; html_static_path = [{str(SITE / 'static')!r}]\n"
        )
        (docs / "index.md").write_text(page)
        (docs / "other.md").write_text(f"# Other\n\n## Long\n\n```text\n{LONG}\n```\n")
        done = subprocess.run(
            [sys.executable, "-m", "sphinx", "-q", "-E", "-W", "--keep-going", ".", "html"],
            cwd=docs, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
        html = {p.name: p.read_text(encoding="utf-8") for p in (docs / "html").glob("*.html")}
        return done.stderr, html

    return build


PAGE = """# A page

| | of it |
|---|---|
| one | two |

```{toctree}
:caption: Start here

other
```
"""


@pytest.mark.proof
def test_headings_and_columns_are_told(built):
    said, html = built(PAGE)
    assert said == ""
    assert {"index.html", "other.html", "search.html", "genindex.html"} <= {*html}
    for name, text in html.items():
        # One caption is in the side bar, and one is on the page itself.
        captions = 2 if name == "index.html" else 1
        assert text.count('role="heading" aria-level="2"') == captions, name
        assert text.count('<aside class="sidebar-drawer" aria-label="Site navigation">') == 1
        assert text.count("<h1") == 1, name
        assert mended(name, text) == text
        assert [*lacking(name, text)] == []
    assert '<aside class="toc-drawer" aria-label="On this page">' in html["other.html"]
    assert html["index.html"].count("<th ") == 1
    assert "scrollable.js" in html["other.html"]


@pytest.mark.proof
def test_a_column_that_the_theme_adds_is_asked_for_its_name(built):
    said, _ = built(f"{PAGE}\n<aside class='new'>More</aside>\n")
    assert "index.html: a column without a name: <aside class='new'>" in said


def test_what_a_page_lacks_is_said():
    page = '<aside class="{}"></aside><h1>{}</h1>'
    assert [*lacking("a.html", page.format("toc-drawer no-toc", ""))] == []
    assert [*lacking("a.html", page.format("toc-drawer", ""))] == [
        'a.html: a column without a name: <aside class="toc-drawer">'
    ]
    assert [*lacking("a.html", page.format("toc-drawer no-toc", "").replace("h1", "h2"))] == [
        "a.html: no heading of the page"
    ]
    assert [*lacking("a.html", '<p class="new" role="heading">')] == [
        'a.html: a heading without its level: <p class="new" role="heading">'
    ]


@browser
def test_what_scrolls_is_a_stop_of_the_keyboard_while_it_does(opened):
    script = (SITE / "static" / "scrollable.js").read_text(encoding="utf-8")
    page = opened(
        "<style>pre, .table-wrapper { overflow-x: auto }</style>"
        f'<pre id="long">{LONG}</pre><pre id="short">x</pre>'
        f'<div id="table" class="table-wrapper"><div style="width: 600px">x</div></div>'
        f"<script>{script}</script>"
    )
    assert page.evaluate(SCROLLED) == ["long"]
    page.set_viewport_size({"width": 500, "height": 900})
    wait_until(page, f"{SCROLLED}.length === 2")
    assert page.evaluate(SCROLLED) == ["long", "table"]
    page.set_viewport_size({"width": 1280, "height": 900})
    wait_until(page, f"{SCROLLED}.length === 1")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "long"
