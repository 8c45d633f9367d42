"""Documents as text for a terminal or a pipe, with or without colours."""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Sequence
from itertools import zip_longest

from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing import document as doc
from heyoka_bike.showing.document import brief
from heyoka_bike.showing.wording.grade_text import ASCII_SIGNS, MEANINGS

PROSE = 100
"""Maximum length of a line of text, and width of a table of scores [characters]."""

_KEPT_BLANK = "\N{NO-BREAK SPACE}"
_MARK = 8  # width of an item's mark [characters]
_LEAST_WORDS = 16  # minimum width of a column of prose [characters]
# Escape codes for colours and bold text (ECMA-48 8.3.117, Select Graphic Rendition), by the class
# of a paragraph, an item or a cell.
_CODES = {
    "verdict": "1", "head": "1", "facts": "2", "info": "2", "warning": "1;33", "unmade": "33",
    "passed": "32", "failed": "1;31", "right": "32", "untold": "33", "close": "33", "wrong": "31",
}  # fmt: skip

_Piece = tuple[str, str]
"""A text and its classes."""

_Columns = Sequence[tuple[int, doc.TableColumn]]
"""Columns of a table with their indices in its rows."""


def render(
    shown: doc.Document | Sequence[doc.Block],
    width: int | None = None,
    has_colors: bool = False,
    *,
    has_details: bool = True,
) -> str:
    """Render a document, or some blocks, as text.

    Parameters
    ----------
    width
        Width of the lines [characters]; None for that of the terminal. Tables leave out columns
        that do not fit, but never cut a number.
    has_colors
        True to use the colours of a terminal.
    has_details
        True to show folded chapters, and the origin of the document.
    """
    page = TextPage(width, has_colors, has_details)
    if isinstance(shown, doc.Document):
        page.show(shown.blocks)
        if has_details:
            page.say("")
            for name, text in shown.origin:
                page.say(f"{name + ':':<11}{text}", "facts", " " * 11)
    else:
        page.show(shown)
    return page.text()


class TextPage:
    """Lines of text of limited width; the default is the width of the terminal."""

    def __init__(self, width: int | None, has_colors: bool, has_details: bool = True) -> None:
        columns = shutil.get_terminal_size((PROSE, 24)).columns if width is None else width
        self._lines: list[str] = []
        self._has_colors, self._has_details = has_colors, has_details
        self._explained: set[Grade] = set()
        self.width = max(columns, 40)
        self.prose = min(self.width, PROSE)

    def show(self, blocks: Sequence[doc.Block]) -> None:
        """Add blocks below each other, with an empty line before and after each table."""
        last: doc.Block | None = None
        for block in doc.of_medium(blocks, doc.TEXT):
            if isinstance(block, doc.Chapter) and block.is_detail and not self._has_details:
                continue
            is_apart = isinstance(block, doc.TableBlock) or isinstance(
                last, doc.TableBlock | doc.Chapter
            )
            if last is not None and is_apart and not isinstance(block, doc.Chapter):
                self.say("")
            last = block
            match block:
                case doc.Paragraph():
                    lead = f"{block.lead}: " if block.lead else ""
                    indent = "" if block.style == "facts" else "  "
                    self.say(lead + brief(block.text), block.style, indent)
                case doc.Listing():
                    for item in block.items:
                        self._item(item)
                case doc.Facts():
                    for name, text, _ in block.facts:
                        self.say(f"  {brief(name)}: {text}", indent="    ")
                case doc.TableBlock():
                    self._table(block)
                case doc.Chapter():
                    self.head(brief(block.title))
                    self.show(block.blocks)

    def say(self, text: str, style: str = "", indent: str = "") -> None:
        """Add a text, wrapped; all lines except the first are indented."""
        for i, line in enumerate(wrap(text, self.prose - len(indent))):
            self._add((indent * (i > 0) + line, style))

    def brief(self, name: str, text: str, most: int, style: str = "") -> None:
        """Add a name and a text, in at most `most` lines; a longer text is cut and ends in dots."""
        lines = wrap(text, self.prose - len(name))
        if len(lines) > most:
            last = " ".join(lines[most - 1 :])[: self.prose - len(name) - 4]
            lines = [*lines[: most - 1], f"{last.rstrip()} ..."]
        for i, line in enumerate(lines):
            self._add((name if not i else " " * len(name), ""), (line, style))

    def head(self, text: str) -> None:
        """Add a heading after an empty line."""
        if self._lines and self._lines[-1]:
            self.say("")
        self.say(text, "head", "  ")

    def text(self) -> str:
        """Return all lines as one text."""
        return "".join(f"{line}\n" for line in self._lines)

    def _item(self, item: doc.Item) -> None:
        typed = f"{item.typed}: " if item.typed else ""
        for i, line in enumerate(wrap(typed + brief(item.text), self.prose - _MARK - 2)):
            mark = brief(item.mark) if not i else ""
            self._add((f"  {mark:<{_MARK}}", item.style), (line, ""))

    def _table(self, table: doc.TableBlock) -> None:
        """Add a table; columns that do not fit are left out or shown below, but never cut."""
        columns = table.columns_of(doc.TEXT)
        for order in sorted({c.leave_out for _, c in columns} - {0}):
            if self._fits(table, columns):
                break
            columns = [x for x in columns if x[1].leave_out != order]
        left, others = columns[: table.left], columns[table.left :]
        while others:
            count = len(others)
            while table.in_parts and count > 1 and not self._fits(table, left + others[:count]):
                count -= 1
            for line in _lines(table, left + others[:count], self.width):
                self._add(*line)
            others = others[count:]
            if others:
                self.say("")
        if note := brief(table.note):
            self.say(note, "facts")
        if meanings := [g for g in table.grades if g not in self._explained]:
            self._explained |= set(meanings)
            self.say("; ".join(f"{ASCII_SIGNS[g]} {MEANINGS[g]}" for g in meanings), "facts")

    def _fits(self, table: doc.TableBlock, columns: _Columns) -> bool:
        (first, *_) = _lines(table, columns, self.width)
        return sum(len(text) for text, _ in first) <= self.width

    def _add(self, *pieces: _Piece) -> None:
        line = ""
        for text, style in pieces:
            codes = ";".join(_CODES[x] for x in style.split() if x in _CODES)
            line += (
                f"\x1b[{codes}m{text}\x1b[0m"
                if self._has_colors and codes and text.strip()
                else text
            )
        self._lines.append(line.rstrip())


def _lines(table: doc.TableBlock, columns: _Columns, width: int) -> list[list[_Piece]]:
    """Return columns of a table as lines of equal length, with a rule below the headings."""
    rows = [_headings(columns)]
    rows += [[_written(row[i]) for i, _ in columns] for row in table.rows]
    prose = [i for i, (_, c) in enumerate(columns) if c.is_prose]
    # One space precedes the columns that are aligned left, and the first column of numbers. Two
    # spaces precede all further columns of numbers.
    gaps = [" " * ((i > 0) + (i > table.left)) for i in range(len(columns))]
    widths = _widths(rows, prose, width - sum(map(len, gaps)))
    rule = [("-" * (sum(widths) + sum(map(len, gaps))), "")]
    found = []
    for n, row in enumerate(rows):
        cells = [
            wrap(text, widths[i]) if n and i in prose else text.split("\n")
            for i, (text, _) in enumerate(row)
        ]
        for texts in zip_longest(*cells, fillvalue=""):
            line = []
            for i, text in enumerate(texts):
                is_left = i < table.left or i in prose
                padded = text.ljust(widths[i]) if is_left else text.rjust(widths[i])
                line.append((gaps[i] + padded, row[i][1]))
            found.append(line)
        is_end = table.group and n % table.group == 0 and n < len(table.rows)
        if n == 0 or is_end:
            found.append(rule)
    return found


def _headings(columns: _Columns) -> list[_Piece]:
    """Return the headings of columns, padded at the top so that their last lines are aligned."""
    head = [_written(c.heading)[0] for _, c in columns]
    height = max(text.count("\n") for text in head)
    return [("\n" * (height - text.count("\n")) + text, "head") for text in head]


def _widths(rows: Sequence[Sequence[_Piece]], prose: Sequence[int], room: int) -> list[int]:
    """Return the column widths; columns of prose are narrowed, widest first, until lines fit."""
    widths = [
        max(len(line) for text, _ in cells for line in text.split("\n"))
        for cells in zip(*rows, strict=True)
    ]
    while sum(widths) > room and prose:
        longest = max(prose, key=widths.__getitem__)
        if widths[longest] <= _LEAST_WORDS:
            break
        widths[longest] -= 1
    return widths


def wrap(text: str, width: int) -> list[str]:
    """Wrap a text; numbers stay with their units, and words are not broken.

    A word longer than `width`, such as the value of ``--columns``, has its own line, so that it can
    be copied.
    """
    kept = re.sub(r"(?<=[0-9]) (?=(?:%|s|J|rad(?:/s)?|m/s)(?![a-z]))", _KEPT_BLANK, text)
    lines = textwrap.wrap(kept, width, break_on_hyphens=False, break_long_words=False) or [""]
    return [line.replace(_KEPT_BLANK, " ") for line in lines]


def _written(cell: str | doc.Cell) -> _Piece:
    if not isinstance(cell, doc.Cell):
        return brief(cell), ""
    text = brief(cell.text)
    if cell.unit:
        text += f"{'' if text.endswith(chr(10)) else ' '}[{cell.unit}]"
    if cell.grade is None:
        return text, cell.style
    return f"{text} {ASCII_SIGNS.get(cell.grade, ' ')}", cell.grade.style
