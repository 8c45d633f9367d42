"""Lines of text of a certain width, and tables in them, plain or with the colours of a terminal."""

import re
import shutil
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

PROSE = 100
"""The longest line of text, and what a table of scores fits into."""

_KEPT = "\N{NO-BREAK SPACE}"
# Select Graphic Rendition, ECMA-48 8.3.117.
_CODES = {"bold": "1", "dim": "2", "red": "31", "green": "32", "yellow": "33", "": ""}


@dataclass(frozen=True, slots=True)
class Styled:
    """Text in a style: words of `bold`, `dim`, `red`, `green`, `yellow`.

    Attributes
    ----------
    text
    style
    """

    text: str
    style: str


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table as lines, each of pieces of text with their style.

    Attributes
    ----------
    lines : tuple of tuple of Styled
    width
        Of the longest line.
    """

    lines: tuple[tuple[Styled, ...], ...]
    width: int


class TextPage:
    """Lines of text of at most so many letters, by default those of the terminal."""

    def __init__(self, width: int | None, color: bool) -> None:
        columns = shutil.get_terminal_size((PROSE, 24)).columns if width is None else width
        self._lines: list[str] = []
        self._color = color
        self.width = max(columns, 40)

    def say(self, text: str, style: str = "", indent: str = "") -> None:
        """Text, wrapped; all lines but the first are indented."""
        for i, line in enumerate(wrap(text, min(self.width, PROSE) - len(indent))):
            self._add(Styled((indent if i else "") + line, style))

    def brief(self, name: str, text: str, most: int, style: str = "") -> None:
        """Text behind a name, in at most so many lines: what is more is cut, and shows that."""
        lines = wrap(text, min(self.width, PROSE) - len(name))
        if len(lines) > most:
            last = " ".join(lines[most - 1 :])[: min(self.width, PROSE) - len(name) - 4]
            lines = [*lines[: most - 1], f"{last.rstrip()} ..."]
        for i, line in enumerate(lines):
            self._add(Styled(name if not i else " " * len(name), ""), Styled(line, style))

    def head(self, text: str, indent: str = "") -> None:
        """A heading, after an empty line."""
        self.say("")
        self.say(text, "bold", indent)

    def listed(self, mark: str, style: str, text: str) -> None:
        """An entry of a list, with its mark in front."""
        for i, line in enumerate(wrap(text, min(self.width, PROSE) - 10)):
            self._add(Styled(f"  {mark if not i else '':<8}", style), Styled(line, ""))

    def fits(self, table: TextTable) -> bool:
        """Whether a table is no wider than the page."""
        return table.width <= self.width

    def show(self, table: TextTable) -> None:
        """A table as it is; what does not fit is not cut."""
        for line in table.lines:
            self._add(*line)

    def text(self) -> str:
        """All of it."""
        return "".join(f"{line}\n" for line in self._lines)

    def _add(self, *pieces: Styled) -> None:
        if not self._color:
            self._lines.append("".join(p.text for p in pieces).rstrip())
            return
        line = ""
        for p in pieces:
            codes = ";".join(_CODES[word] for word in p.style.split())
            line += f"\x1b[{codes}m{p.text}\x1b[0m" if codes and p.text.strip() else p.text
        self._lines.append(line.rstrip())


def wrap(text: str, width: int) -> list[str]:
    """Lines of at most so many letters; a unit stays with its number."""
    kept = re.sub(r"(?<=[0-9]) (?=(?:%|s|J|rad(?:/s)?|m/s)(?![a-z]))", _KEPT, text)
    lines = textwrap.wrap(kept, width, break_on_hyphens=False) or [""]
    return [line.replace(_KEPT, " ") for line in lines]


def text_table(
    names: Sequence[str], rows: Sequence[Sequence[str | Styled]], left: int, words: bool = False
) -> TextTable:
    """A table with a rule below its headings.

    Parameters
    ----------
    names
        Headings, which may have several lines.
    rows
        Cells, which may have several lines.
    left
        How many columns are flush left; numbers stand in the others.
    words
        Whether the last column is words, and flush left too.
    """
    height = max(name.count("\n") for name in names)
    # Headings stand on the rule.
    head = [Styled("\n" * (height - name.count("\n")) + name, "bold") for name in names]
    cells = [[c if isinstance(c, Styled) else Styled(c, "") for c in row] for row in rows]
    # Two spaces in front of each number but the first, which follows words of many lengths.
    gaps = [" " * ((i > 0) + (i > left)) for i in range(len(names))]
    widths = [
        max(len(line) for row in (head, *cells) for line in row[i].text.split("\n"))
        for i in range(len(names))
    ]

    is_left = [i < left or (words and i == len(names) - 1) for i in range(len(names))]

    def lines(row: Sequence[Styled]) -> list[tuple[Styled, ...]]:
        split = zip_longest(*(cell.text.split("\n") for cell in row), fillvalue="")
        return [
            tuple(
                Styled(gap + (text.ljust(width) if is_left[i] else text.rjust(width)), cell.style)
                for i, (text, gap, width, cell) in enumerate(
                    zip(texts, gaps, widths, row, strict=True)
                )
            )
            for texts in split
        ]

    width = sum(widths) + sum(map(len, gaps))
    rule = (Styled("-" * width, ""),)
    return TextTable((*lines(head), rule, *(x for row in cells for x in lines(row))), width)
