"""A piece of HTML for a notebook, in the looks of the reports and without touching what is around.

The style sheet of the reports is nested in the class of the card, where it sets no page.
"""

from collections.abc import Iterable, Sequence
from functools import cache
from html import escape

from heyoka_bike.errors import printable
from heyoka_bike.showing.formats.markup import PAGE_STYLE
from heyoka_bike.showing.formats.tables import table

_CLASS = "heyoka-bike"
_OWN = """background: var(--page); color: var(--ink); padding: 8px 12px; font: 14px/1.5 system-ui, sans-serif;
.verdict { font-size: 1.25em; }
details { margin: .4em 0; } summary { cursor: pointer; font-weight: 600; }
"""  # noqa: E501


@cache
def _style() -> str:
    sheet = PAGE_STYLE.read_text(encoding="utf-8").replace(":root", "&")
    return f"<style>.{_CLASS} {{\n{sheet}{_OWN}}}</style>"


def card(*parts: str) -> str:
    """Parts that are HTML, as one piece."""
    return f'<div class="{_CLASS}">{_style()}{"".join(parts)}</div>'


def folded(title: str, content: str, *, is_open: bool = False) -> str:
    """HTML below a title that opens and closes it; nothing without content."""
    if not content:
        return ""
    state = " open" if is_open else ""
    return f"<details{state}><summary>{escape(title)}</summary>{content}</details>"


def head(title: str, facts: str = "") -> str:
    """What it is, and some words on it."""
    return f"<p><b>{escape(printable(title))}</b></p>{remark(facts)}"


def remark(words: str) -> str:
    """Some words, if there are any."""
    return f'<p class="facts">{escape(printable(words))}</p>' if words else ""


def plain_table(
    names: Sequence[str], rows: Iterable[Sequence[str]], about: str, style: str = "scores"
) -> str:
    """A table of text, in the style of `tables.table`."""
    cells = ([escape(printable(cell)) for cell in row] for row in rows)
    return table([escape(printable(name)) for name in names], cells, about, style)
