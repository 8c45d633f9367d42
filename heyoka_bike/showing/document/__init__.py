"""The document model: blocks, which `text` and `html` render.

A report, a leaderboard, a table of checks or the view of an object is declared once, as blocks.
A block for some media only says so (`only`); words that are shorter on a terminal are `Words`.
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
    """Words of a page, and the brief ones of a terminal; lines of a cell end with a line feed."""

    __slots__ = ("brief",)
    brief: str

    def __new__(cls, full: str, brief: str) -> Self:
        found = super().__new__(cls, full)
        found.brief = brief
        return found


def brief(text: str) -> str:
    """The words for a terminal."""
    return getattr(text, "brief", text)


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A paragraph.

    Attributes
    ----------
    text
    style
        Classes, as page.css has them; text has colours for some.
    lead
        Stands in front of the text, for who reads fast.
    sign
        Stands in front of all, for who sees it.
    link : (text, anchor), optional
        A place of the page, named behind the text.
    note
        In small letters below.
    only
        `TEXT`, `HTML`, or one of HTML's two; empty for all media.
    """

    text: str
    style: str = ""
    lead: str = ""
    sign: str = ""
    link: tuple[str, str] | None = None
    note: str = ""
    only: str = ""


def head(title: str, facts: str = "") -> tuple[Paragraph, Paragraph]:
    """Return a title, and some words on it, as paragraphs."""
    return Paragraph(printable(title), "head"), Paragraph(printable(facts), "facts")


@dataclass(frozen=True, slots=True)
class Item:
    """An entry of a list.

    Attributes
    ----------
    text
    style
        Its class.
    mark
        Stands in front.
    typed
        Its subject, as it was typed.
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
    """Names, what is said of them, and a remark on that."""

    facts: tuple[tuple[str, str, str], ...]
    only: str = ""


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell that is more than its words.

    Attributes
    ----------
    text
    unit
        Of what the text names.
    style
        Class of the cell.
    grade : Grade, optional
        Of the digits in it: a sign and a colour.
    facts : Facts, optional
        They unfold.
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
        Said below the table, if that is explained.
    is_prose
        Flush left, and folded.
    leave_out
        Order in which text leaves it out where there is no room, from 1 on; 0 never.
    style
        Class of its cells.
    only
        The medium that it is for; empty for all.
    """

    heading: str | Cell
    meaning: str = ""
    is_prose: bool = False
    leave_out: int = 0
    style: str = ""
    only: str = ""


@dataclass(frozen=True, slots=True)
class TableBlock:
    """A table; the first cell of a row names it.

    Attributes
    ----------
    columns : sequence of str or TableColumn
    rows
        Cells of all columns.
    about
        Its name.
    style
        Its class.
    left
        Number of columns that are flush left; numbers stand in the others.
    group
        A line is drawn below each so many rows of text; 0 for none.
    in_parts
        True if text shows columns below the others if there is no room beside them; those that are
        flush left stand in each part.
    is_explained
        True if a page says what the columns mean.
    note
        Said below.
    only
        The medium that it is for; empty for all.
    """

    columns: Sequence[str | Cell | TableColumn]
    rows: Sequence[TableRow]
    about: str = ""
    style: str = "scores"
    left: int = 1
    group: int = 0
    in_parts: bool = False
    is_explained: bool = False
    note: str = ""
    only: str = ""

    def columns_of(self, medium: str) -> list[tuple[int, TableColumn]]:
        """The columns that a medium shows, with their places in the rows."""
        every = (TableColumn(c) if isinstance(c, str | Cell) else c for c in self.columns)
        return [(i, c) for i, c in enumerate(every) if c.only in _SHOWN[medium]]

    @property
    def grades(self) -> list[Grade]:
        """Those that occur, the best first."""
        cells = (c for row in self.rows for c in row if isinstance(c, Cell))
        return sorted({c.grade for c in cells if c.grade})


@dataclass(frozen=True, eq=False)
class Chart:
    """A chart or what else a page draws, once somebody looks at it; text has none."""

    draw: Callable[[], str]
    only: str = HTML

    @cached_property
    def markup(self) -> str:
        """As HTML; empty if there is nothing to draw."""
        return self.draw()


@dataclass(frozen=True, slots=True)
class Chapter:
    """Blocks below a heading; nothing without blocks.

    Attributes
    ----------
    title
    blocks
    anchor, link
        Its place on a page, and how the contents of the page name it.
    is_folded, is_open
        True if it can be opened and closed in a notebook, and is open. What is folded and not open
        is a detail, which text may leave out.
    only
        The medium that it is for; empty for all.
    folds
        True if a page has it closed at first, too.
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
        """True if it is shown to who asks for it."""
        return self.is_folded and not self.is_open


TableRow = Sequence[str | Cell]
"""Cells of a table."""

Block = Paragraph | Listing | Facts | TableBlock | Chart | Chapter


@dataclass(frozen=True, slots=True)
class Document:
    """All that is shown of something.

    Attributes
    ----------
    title
        Of the window.
    heading
        Of the page; text has none.
    kind
        Its kind, above the heading.
    blocks
    origin : sequence of (name, text)
        Where it comes from.
    """

    title: str
    heading: str
    kind: str
    blocks: Sequence[Block]
    origin: Sequence[tuple[str, str]] = ()


def of_medium(blocks: Sequence[Block], medium: str) -> list[Block]:
    """The blocks that a medium shows: none that is empty, or for another."""
    return [b for b in blocks if b.only in _SHOWN[medium] and _has_content(b, medium)]


def _has_content(block: Block, medium: str) -> bool:
    match block:
        case Chapter(blocks=blocks):
            return bool(of_medium(blocks, medium))
        case Paragraph(text=content) | Chart(markup=content):
            return bool(content)
        case Listing(items=parts) | Facts(facts=parts) | TableBlock(rows=parts):
            return bool(parts)
