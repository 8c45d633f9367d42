"""Blocks as a piece of HTML for a notebook, which has no script and touches nothing around it.

The style sheet of the pages is nested in the class of the piece, where it sets no page.
"""

from collections.abc import Sequence
from functools import cache

from heyoka_bike.errors import printable
from heyoka_bike.showing.document import NOTEBOOK, Block, Paragraph
from heyoka_bike.showing.document.html import PAGE_STYLE, markup

_CLASS = "heyoka-bike"
_OWN = """background: var(--page); color: var(--ink); padding: 8px 12px; font: 14px/1.5 system-ui, sans-serif;
.verdict { font-size: 1.25em; }
details { margin: .4em 0; } summary { cursor: pointer; font-weight: 600; }
"""  # noqa: E501


@cache
def _style() -> str:
    sheet = PAGE_STYLE.read_text(encoding="utf-8").replace(":root", "&")
    return f"<style>.{_CLASS} {{\n{sheet}{_OWN}}}</style>"


def render(blocks: Sequence[Block]) -> str:
    """Blocks as one piece, in which chapters fold."""
    return f'<div class="{_CLASS}">{_style()}{markup(blocks, medium=NOTEBOOK)}</div>'


def head(title: str, facts: str = "") -> tuple[Paragraph, Paragraph]:
    """Return a title, and some words on it, as paragraphs."""
    return Paragraph(printable(title), "head"), Paragraph(printable(facts), "facts")
