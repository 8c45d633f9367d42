"""Documents as HTML: self-contained pages, and pieces of pages for notebooks.

Pages are readable without the script and on paper; the script only reads values off the charts. A
piece has no script. It does not affect the notebook around it, because the style sheet of the pages
is nested in its class.
"""

import re
from base64 import b64encode
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from html import escape
from pathlib import Path
from string import Template

from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing import document as doc
from heyoka_bike.showing.wording.grade_text import MEANINGS, SIGNS, WORDS

PAGE_STYLE = Path(__file__).with_name("page.css")
SCRIPT = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
"""Script of every report."""
_PAGE = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))

_CLASS = "heyoka-bike"
_STYLE_OF_NOTEBOOK = """background: var(--page); color: var(--ink); padding: 8px 12px; font: 14px/1.5 system-ui, sans-serif;
.verdict { font-size: 1.25em; }
details { margin: .4em 0; } summary { cursor: pointer; font-weight: 600; }
"""  # noqa: E501

# Lines must not break within a number such as 1e-05, or between a number and its unit.
_UNIT = r" (?:%|s\b|J\b|rad\b(?:/s)?|m/s)"
_PATTERN_OF_NUMBER = re.compile(rf"(-?[0-9.]+(?:e[-+]?[0-9]+(?:{_UNIT})?|{_UNIT}))")


def render(document: doc.Document) -> str:
    """Render a self-contained page, with a table of contents before the first chapter."""
    blocks = doc.of_medium(document.blocks, doc.PAGE)
    start = next((i for i, b in enumerate(blocks) if isinstance(b, doc.Chapter)), len(blocks))
    places = [(b.anchor, b.link) for b in blocks if isinstance(b, doc.Chapter) and b.link]
    items = "".join(f'<li><a href="#{where}">{escape(said)}</a></li>' for where, said in places)
    contents = (
        f'<nav class="contents" aria-label="Contents"><ul>{items}</ul></nav>\n' if items else ""
    )
    body = (
        f'<header><p class="kicker">{escape(document.kind)}</p>'
        f"<h1>{escape(document.heading)}</h1>"
        f"{markup(blocks[:start])}</header>\n{contents}{markup(blocks[start:])}"
    )
    return page(document.title, body, document.origin, styles=(PAGE_STYLE,), script=SCRIPT)


@cache
def _style() -> str:
    sheet = PAGE_STYLE.read_text(encoding="utf-8").replace(":root", "&")
    return f"<style>.{_CLASS} {{\n{sheet}{_STYLE_OF_NOTEBOOK}}}</style>"


def piece(blocks: Sequence[doc.Block]) -> str:
    """Render blocks as HTML for a notebook, with chapters that fold."""
    return f'<div class="{_CLASS}">{_style()}{markup(blocks, medium=doc.NOTEBOOK)}</div>'


def markup(blocks: Sequence[doc.Block], level: int = 2, medium: str = doc.PAGE) -> str:
    """Render blocks as HTML for a page or a notebook; `level` is that of the highest headings."""
    return "\n".join(_block(b, level, medium) for b in doc.of_medium(blocks, medium))


def _block(block: doc.Block, level: int, medium: str) -> str:
    match block:
        case doc.Paragraph():
            return _paragraph(block, medium)
        case doc.Listing():
            return f'<ul class="said">{"".join(map(_item, block.items))}</ul>'
        case doc.Facts():
            return _facts(block)
        case doc.TableBlock():
            return _beside(block, level, medium)
        case doc.Chart():
            return block.markup
        case doc.Chapter():
            return _chapter(block, level, medium)


def _paragraph(block: doc.Paragraph, medium: str) -> str:
    sign = f'<span aria-hidden="true">{block.sign}</span> ' if block.sign else ""
    lead = f"<b>{escape(capital(block.lead))}.</b> " if block.lead else ""
    text = prose(capital(block.text) if lead else block.text)
    if block.link:
        said, where = block.link
        # The target of the link exists only on a page. Elsewhere, such as in a notebook, write
        # plain text.
        is_page = medium == doc.PAGE
        text += "; " + (f'<a href="#{where}">{escape(said)}</a>' if is_page else escape(said))
    note = f" <span>{escape(block.note)}</span>" if block.note else ""
    return f"<p{_class(block.style)}>{sign}{lead}{text}{note}</p>"


def _item(item: doc.Item) -> str:
    mark = f"<b>{escape(item.mark)}</b> " if item.mark else ""
    text = prose(item.text)
    if item.typed:
        text = f"<code>{escape(item.typed)}</code> <span>{text}</span>"
    return f"<li{_class(item.style)}>{mark}{text}</li>"


def _facts(block: doc.Facts) -> str:
    items = "".join(
        f"<dt>{escape(name)}</dt><dd>"
        + (f"<b>{prose(said)}</b> <span>{escape(more)}</span>" if more else prose(said))
        + "</dd>"
        for name, said, more in block.facts
    )
    return f'<dl class="facts">{items}</dl>'


def _chapter(block: doc.Chapter, level: int, medium: str) -> str:
    title = escape(block.title)
    if medium == doc.NOTEBOOK and block.is_folded:
        content = markup(block.blocks, level, medium)
        state = " open" if block.is_open else ""
        return f"<details{state}><summary>{title}</summary>{content}</details>"
    heading, inner = f"<h{level}>{title}</h{level}>", markup(block.blocks, level + 1, medium)
    if medium == doc.PAGE and block.folds:
        return f"<details><summary>{heading}</summary>{inner}</details>"
    content = heading + inner
    # Sections in a notebook have no id, because a notebook may contain two reports with the same
    # ids.
    is_place = block.anchor and medium == doc.PAGE
    return f'<section id="{block.anchor}">{content}</section>' if is_place else content


def _beside(table: doc.TableBlock, level: int, medium: str) -> str:
    """Render a table, and next to it its chapter `beside` if the medium shows one."""
    found = _table(table, medium)
    detail = markup([table.beside], level, medium) if table.beside else ""
    if not detail:
        return found
    return (
        f'<div class="found"><div class="digits">{found}</div>'
        f'<div class="detail">{detail}</div></div>'
    )


def _table(table: doc.TableBlock, medium: str) -> str:
    """Render a table in a scrolling box, and below it the meanings of its signs and its notes."""
    columns = table.columns_of(medium)
    top = "".join(f'<th scope="col"{_class(c.style)}>{_inline(c.heading)}</th>' for _, c in columns)
    body = []
    for row in table.rows:
        (first, _), *others = columns
        cells = "".join(_cell(row[i], column) for i, column in others)
        body.append(f'<tr><th scope="row">{_inline(row[first])}</th>{cells}</tr>')
    found = (
        f'<div class="scroll" tabindex="0" role="group" aria-label="{escape(table.about)}">'
        f'<table class="{table.style}"><thead><tr>{top}</tr></thead><tbody>{"".join(body)}</tbody>'
        "</table></div>"
    )
    if table.grades:
        items = "".join(
            f'<li><b class="{g.style}">{SIGNS[g]}</b> {escape(MEANINGS[g])}</li>'
            for g in table.grades
        )
        found += f'<ul class="signs">{items}</ul>'
    if table.note:
        found += f'<p class="facts">{prose(table.note)}</p>'
    if table.is_explained:
        said = ((escape(str(c.heading)), escape(c.meaning)) for _, c in columns[1:])
        meanings = "".join(f"<dt>{name}</dt><dd>{meaning}</dd>" for name, meaning in said)
        found += f'<dl class="meanings">{meanings}</dl>'
    return found


def _class(style: str) -> str:
    return f' class="{style}"' if style else ""


def _cell(cell: str | doc.Cell, column: doc.TableColumn) -> str:
    if not isinstance(cell, doc.Cell) or cell.grade is None:
        inner = prose(cell) if column.is_prose and isinstance(cell, str) else _inline(cell)
        return f"<td{_class(column.style)}>{inner}</td>"
    if cell.grade == Grade.UNKNOWN:
        return f'<td class="unknown">{escape(cell.text)}</td>'
    return (
        f'<td class="{cell.grade.style}"><b aria-hidden="true">{SIGNS[cell.grade]}</b> '
        f'{escape(cell.text)}<span class="spoken"> {WORDS[cell.grade]}</span></td>'
    )


def _inline(cell: str | doc.Cell) -> str:
    if not isinstance(cell, doc.Cell):
        return escape(cell)
    text = escape(cell.text) + (f" <i>[{escape(cell.unit)}]</i>" if cell.unit else "")
    if cell.style:
        text = f"<i>{text}</i>" if text else ""
    if cell.facts:
        return f"<details><summary>{text}</summary>{_facts(cell.facts)}</details>"
    return text


def capital(text: str) -> str:
    """Capitalise a text, unless its first word is the name of a column or a file."""
    first = text.partition(" ")[0].rstrip(".:")
    is_name = "_" in first or "." in first
    return text if is_name else text[:1].upper() + text[1:]


def prose(text: str) -> str:
    """Return text as HTML, in which numbers and their units stay on one line."""
    parts = map(escape, _PATTERN_OF_NUMBER.split(text))
    return "".join(f"<bdi>{part}</bdi>" if i % 2 else part for i, part in enumerate(parts))


def policy(*scripts: str, has_wasm: bool = False) -> str:
    """Return the content security policy of a page that loads nothing and runs only these scripts.

    With `has_wasm` the scripts may compile WebAssembly that is part of the page.

    References
    ----------
    Content Security Policy Level 3, https://www.w3.org/TR/CSP3/.
    """
    hashes = (b64encode(sha256(f"\n{script}".encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{x}'" for x in hashes)
    allowed += " 'wasm-unsafe-eval'" if has_wasm else ""
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {allowed}"


def page(
    title: str, body: str, origin: Sequence[tuple[str, str]], *, styles: Sequence[Path],
    script: str, data: str | None = None, has_wasm: bool = False,
) -> str:  # fmt: skip
    """Return a self-contained page.

    It declares what it loads and runs, and the browser enforces this: see `policy`.

    Parameters
    ----------
    title
        Title as text.
    body
        Body as HTML.
    origin
        When and how the page was made: names and values as text.
    styles
        Files with style sheets.
    script
        Script in JavaScript.
    data
        JSON for the script, if it needs any.
    has_wasm
        True if the script compiles WebAssembly.
    """
    given = f'<script type="application/json" id="data">\n{data}\n</script>\n' if data else ""
    return _PAGE.substitute(
        title=escape(title),
        body=body,
        origin="".join(f"<dt>{escape(a)}</dt><dd>{escape(b)}</dd>" for a, b in origin),
        styles="".join(file.read_text(encoding="utf-8") for file in styles),
        policy=policy(script, has_wasm=has_wasm),
        script=script,
        data=given,
    )
