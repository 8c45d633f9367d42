"""What screen readers and keyboards need, and the theme's pages lack.

Captions of the navigation get the level of their heading, both columns at the sides a name, the
page of the search a heading; a cell of a table's head that is empty is no heading. What is wider
than its place is reached by the keyboard: `static/scrollable.js`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sphinx.application import Sphinx

_MAIN = '<article role="main" id="furo-main-content">'
_ALL = {
    '<p class="caption" role="heading">': '<p class="caption" role="heading" aria-level="2">',
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="Site navigation">',
    '<aside class="toc-drawer">': '<aside class="toc-drawer" aria-label="On this page">',
    '<th class="head"><p></p></th>': "<td></td>",
}
_SEARCH = {f"{_MAIN}\n": f"{_MAIN}<h1>Search</h1>\n"}


def mended(name: str, text: str) -> str:
    """The text of a page; what is mended already stays as it is."""
    for old, new in {**_ALL, **(_SEARCH if name == "search.html" else {})}.items():
        text = text.replace(old, new)
    return text


def lacking(name: str, text: str) -> Iterator[str]:
    """Yield what a page still lacks, for a version of the theme that writes it otherwise."""
    for part in text.split("<")[1:]:
        tag = part.partition(">")[0]
        if 'role="heading"' in tag and "aria-level" not in tag:
            yield f"{name}: a heading without its level: <{tag}>"
        if tag.partition(" ")[0] == "aside" and "aria-label" not in tag and "no-toc" not in tag:
            yield f"{name}: a column without a name: <{tag}>"
    if "</aside>" in text and "<h1" not in text:
        yield f"{name}: no heading of the page"


def _mend(app: Sphinx, error: Exception | None) -> None:
    from sphinx.util.logging import getLogger  # the rest is tested where Sphinx is not

    if error is not None or app.builder.name != "html":
        return
    for path in sorted(Path(app.outdir).rglob("*.html")):
        before = path.read_text(encoding="utf-8")
        name = path.relative_to(app.outdir).as_posix()
        after = mended(name, before)
        if after != before:
            path.write_text(after, encoding="utf-8")
        for line in lacking(name, after):
            getLogger(__name__).warning(line)


def setup(app: Sphinx) -> dict[str, Any]:
    """Mend the pages once they are written."""
    app.add_js_file("scrollable.js", loading_method="defer")
    app.connect("build-finished", _mend)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
