"""The document model: documents consist of blocks, which `text` and `html` render.

A report, a leaderboard, a table of checks or the view of an object is declared once, as blocks.
The attribute `only` limits a block to some media. `Words` are texts with a shorter version for a
terminal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

from heyoka_bike.errors import printable
from heyoka_bike.scoring.grades import Grade

TEXT, HTML, PAGE, NOTEBOOK = "text", "html", "page", "notebook"
"""Media; a page and a notebook are both HTML."""

_SHOWN = {TEXT: ("", TEXT), PAGE: ("", HTML, PAGE), NOTEBOOK: ("", HTML, NOTEBOOK)}


class Words(str):
    """A text for a page, with a brief version for a terminal.

    Line feeds separate the lines of a table cell.
    """

    __slots__ = ("brief",)
    brief: str

    def __new__(cls, full: str, brief: str) -> Self:
        found = super().__new__(cls, full)
        found.brief = brief
        return found


def brief(text: str) -> str:
    """Return the brief version of a text, or the text if it has none."""
    return getattr(text, "brief", text)


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A paragraph.

    Attributes
    ----------
    text
    style
        Classes of page.css; the terminal has colours for some of them.
    lead
        Bold words before the text.
    sign
        Symbol before everything else; screen readers skip it.
    link : (text, anchor), optional
        A place of the page, linked after the text.
    note
        Small print after the text.
    only
        The medium that shows it: `TEXT`, `HTML`, `PAGE` or `NOTEBOOK`; empty for all media.
    """

    text: str
    style: str = ""
    lead: str = ""
    sign: str = ""
    link: tuple[str, str] | None = None
    note: str = ""
    only: str = ""


def head(title: str, facts: str = "") -> tuple[Paragraph, Paragraph]:
    """Return a title and a line of facts as paragraphs."""
    return Paragraph(printable(title), "head"), Paragraph(printable(facts), "facts")


@dataclass(frozen=True, slots=True)
class Item:
    """An entry of a list.

    Attributes
    ----------
    text
    style
        Class of the item.
    mark
        Bold word before the text.
    typed
        The subject as the user typed it, before the text.
    """

    text: str
    style: str = ""
    mark: str = ""
    typed: str = ""


@dataclass(frozen=True, slots=True)
class Listing:
    """A list."""

    items: tuple[Item, ...]
    only: str = ""


@dataclass(frozen=True, slots=True)
class Facts:
    """A list of facts: name, value, and a remark on the value."""

    facts: tuple[tuple[str, str, str], ...]
    only: str = ""


@dataclass(frozen=True, slots=True)
class Cell:
    """A table cell: a text, and perhaps a unit, a style, a grade and facts.

    Attributes
    ----------
    text
    unit
        Unit of the quantity that the text names.
    style
        Class of the cell.
    grade : Grade, optional
        Grade of the digits in the cell, shown as a sign and a colour.
    facts : Facts, optional
        Folded facts below the text.
    """

    text: str
    unit: str = ""
    style: str = ""
    grade: Grade | None = None
    facts: Facts | None = None


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of a table.

    Attributes
    ----------
    heading : str or Cell
    meaning
        Explanation below the table, if the table is explained.
    is_prose
        True to align the column left and wrap its text.
    leave_out
        Order in which columns are left out of a text that is too narrow, from 1 on; 0 for never.
    style
        Class of its cells.
    only
        The medium that shows it; empty for all.
    """

    heading: str | Cell
    meaning: str = ""
    is_prose: bool = False
    leave_out: int = 0
    style: str = ""
    only: str = ""


@dataclass(frozen=True, slots=True)
class TableBlock:
    """A table; the first cell of a row is its heading.

    Attributes
    ----------
    columns : sequence of str or TableColumn
    rows
        Cells of all columns.
    about
        Name of the table for screen readers.
    style
        Class of the table.
    left
        Number of columns that are aligned left; the others contain numbers.
    group
        In text, a line is drawn after every `group` rows; 0 for no lines.
    in_parts
        True to split a table that is too wide for the text into several parts below each other.
        Each part repeats the columns that are aligned left.
    is_explained
        True if a page explains the columns.
    beside : Chapter, optional
        Shown next to the table on a page with enough room, and below it elsewhere.
    note
        Text below the table.
    only
        The medium that shows it; empty for all.
    """

    columns: Sequence[str | Cell | TableColumn]
    rows: Sequence[TableRow]
    about: str = ""
    style: str = "scores"
    left: int = 1
    group: int = 0
    in_parts: bool = False
    is_explained: bool = False
    beside: Chapter | None = None
    note: str = ""
    only: str = ""

    def columns_of(self, medium: str) -> list[tuple[int, TableColumn]]:
        """Return the columns that a medium shows, with their indices in the rows."""
        every = (TableColumn(c) if isinstance(c, str | Cell) else c for c in self.columns)
        return [(i, c) for i, c in enumerate(every) if c.only in _SHOWN[medium]]

    @property
    def grades(self) -> list[Grade]:
        """Grades that occur in the table, best first."""
        cells = (c for row in self.rows for c in row if isinstance(c, Cell))
        return sorted({c.grade for c in cells if c.grade})


@dataclass(frozen=True, eq=False)
class Chart:
    """A chart or other drawing for HTML, drawn when it is first needed."""

    draw: Callable[[], str]
    only: str = HTML

    @cached_property
    def markup(self) -> str:
        """The drawing as HTML; empty if there is nothing to draw."""
        return self.draw()


@dataclass(frozen=True, slots=True)
class Chapter:
    """A heading and the blocks below it; not shown if there are no blocks.

    Attributes
    ----------
    title
    blocks
    anchor, link
        Its anchor on a page, and its name in the contents of the page.
    is_folded, is_open
        True if it can be folded in a notebook, and if it is open there. A chapter that is folded
        and not open is a detail, which text may leave out.
    only
        The medium that shows it; empty for all.
    folds
        True if it is also closed at first on a page.
    """

    title: str
    blocks: Sequence[Block]
    anchor: str = ""
    link: str = ""
    is_folded: bool = False
    is_open: bool = False
    only: str = ""
    folds: bool = False

    @property
    def is_detail(self) -> bool:
        """True if the chapter is shown only on request, because it is folded and not open."""
        return self.is_folded and not self.is_open


TableRow = Sequence[str | Cell]
"""Cells of a table."""

Block = Paragraph | Listing | Facts | TableBlock | Chart | Chapter


@dataclass(frozen=True, slots=True)
class Document:
    """A whole document.

    Attributes
    ----------
    title
        Title of the window.
    heading
        Heading of the page; text does not show it.
    kind
        Kind of the document, above the heading.
    blocks
    origin : sequence of (name, text)
        When and how it was made.
    """

    title: str
    heading: str
    kind: str
    blocks: Sequence[Block]
    origin: Sequence[tuple[str, str]] = ()


def of_medium(blocks: Sequence[Block], medium: str) -> list[Block]:
    """Return the blocks that a medium shows, without empty ones."""
    return [b for b in blocks if b.only in _SHOWN[medium] and _has_content(b, medium)]


def _has_content(block: Block, medium: str) -> bool:
    match block:
        case Chapter(blocks=blocks):
            return bool(of_medium(blocks, medium))
        case Paragraph(text=content) | Chart(markup=content):
            return bool(content)
        case Listing(items=parts) | Facts(facts=parts) | TableBlock(rows=parts):
            return bool(parts)
