"""Old addresses of pages lead to the new ones: the table "Pages that moved" of docs/new.md.

Each old page of the site is a page that sends the browser on, without a script.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

LIST = Path(__file__).parent.parent / "new.md"
_ROW = re.compile(r"^\| ([\w/-]+)\.md \| \[[^\]]*\]\(([\w/-]+)\.md(#[\w-]+)?\) \|$", re.MULTILINE)
_PAGE = """\
<!DOCTYPE html>
<meta charset="utf-8">
<meta http-equiv="refresh" content="0; url={to}">
<link rel="canonical" href="{to}">
<title>Moved</title>
<p>This page is now <a href="{to}">{to}</a>.</p>
"""


def moved(text: str) -> dict[str, str]:
    """New page with its heading, as a link of the site's root, by the old page."""
    _, _, table = text.partition("\n## Pages that moved\n")
    return {old: f"{new}.html{heading}" for old, new, heading in _ROW.findall(table)}


def _write(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        for old, new in moved(LIST.read_text(encoding="utf-8")).items():
            page = Path(app.outdir, f"{old}.html")
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(_PAGE.format(to="../" * old.count("/") + new), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Write them beside the pages of the site."""
    app.connect("build-finished", _write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
