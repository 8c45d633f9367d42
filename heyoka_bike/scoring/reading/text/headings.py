"""The heading of a text: the line with the names of its columns, and a line of their units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from heyoka_bike.scoring.reading.names.heading import are_names, parse_heading, with_degrees
from heyoka_bike.scoring.reading.names.heading_units import quantities
from heyoka_bike.scoring.reading.names.paths import without_paths
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.dialects import DIALECTS

# Characters that may surround a unit.
_AROUND_UNITS = "[](){}<>\"' "
# Words that may begin a line of units, in place of the unit of the time.
_CALLED_UNITS = ("unit", "units", "unit:", "units:")
# Maximum number of lines of names above the rows: such as the names of maneuvers, programs, parts
# and quantities.
_MOST_LEVELS = 5
COMMENT_SIGNS = re.compile(r"\A[#%!/;*\s]+")
_BRACKETS_AND_WORDS = re.compile(r"\[[^][]*\]|\S+")
_TWO_BLANKS = re.compile(r"\s{2,}")
# A line above the names in OpenSim's storage and motion files, which states that angles are in
# degrees.
_IN_DEGREES = re.compile(r"\s*inDegrees\s*=\s*yes\s*", re.IGNORECASE)
# A unit in brackets, with the blanks before it. Where blanks separate names, the unit remains part
# of its name.
_BRACKETED = re.compile(r"(?<![ \t])[ \t]*(?:\[[^\[\]]*\]|\([^()]*\))")
Headings = Mapping[int, Sequence[list[str]]]
"""All names that lines may have, by the index of the line."""

# Beginning of a line of units whose first column has no unit.
_NO_UNIT = re.compile(r"-[\s,;]")


def headings_in(line: str) -> Iterator[list[str]]:
    """The names in a heading, for all ways to separate them."""
    if line.startswith("\t"):
        # The first name is empty, because pandas leaves the name of its index blank.
        yield DIALECTS[0].split(line)
    text = COMMENT_SIGNS.sub("", line, count=1) if COMMENT_SIGNS.match(line) else line
    text = text.strip()
    # If the line is blank, text[:1] is empty and therefore contained in every text. So check this
    # case separately.
    begins = text[:1].isalpha() or text[:1] in "\"',;[({<\u00b0" or _NO_UNIT.match(text)
    if not (text and begins):
        return
    for dialect in DIALECTS[::2]:
        if dialect.separator in text:
            yield dialect.split(text)
    yield [part for part in _TWO_BLANKS.split(text) if part]
    kept = _BRACKETED.sub(lambda match: re.sub(r"\s", "\0", match[0]), text)
    yield [part.replace("\0", " ").strip() for part in kept.split()]
    if text.startswith("["):
        # The line may contain only units, which may contain blanks, as in [m s^-1].
        yield _BRACKETS_AND_WORDS.findall(text)


def headings_of_cells(row: Sequence[Any]) -> list[list[str]]:
    """The names in a row of a sheet, which are its cells; nothing if it has none."""
    words = ["" if x is None else " ".join(str(x).split()) for x in row]
    return [[COMMENT_SIGNS.sub("", words[0], count=1), *words[1:]]] if words else []


def is_heading(written: Sequence[str], request: Request) -> bool:
    """True if names, the last steps of those that are paths, are those of columns."""
    return are_names(without_paths(written), request)


def heading_among(
    above: Headings, width: int, request: Request
) -> tuple[list[str] | None, int | None]:
    """The last heading of so many names above the rows, and its index.

    A line of units below it or above it is put into the names, and degrees where a line says that
    angles are in these.

    Parameters
    ----------
    above
        Names that the lines above the rows may have.
    width
        Numbers in a row.
    request
        The request to read them.
    """
    below: list[str] = []
    for i, written in of_width(above, width):
        names = without_paths(written)
        if are_names(names, request) or are_names(with_units(names, below), request):
            if _are_repeated(names) and (levels := _levels(above, width, request))[0]:
                return levels
            line_above = {i - 1: above.get(i - 1, ())}
            units = (x for _, x in of_width(line_above, width) if are_units(x))
            names = with_units(names, below or next(units, []))
            return (with_degrees(names) if _are_in_degrees(above) else names), i
        if not below and are_units(names):
            below = names
    return _levels(above, width, request)


def _levels(above: Headings, width: int, request: Request) -> tuple[list[str] | None, int | None]:
    """The names in several lines, as pandas writes those of levels, and the index of the last."""
    lines = dict(reversed([*of_width(above, width)]))
    for last in sorted(lines, reverse=True):
        for first in range(last - 1, last - _MOST_LEVELS, -1):
            if first not in lines:
                break
            levels = zip(*(lines[i] for i in range(first, last + 1)), strict=True)
            steps = [[x for part in column if (x := part.strip("\"'"))] for column in levels]
            names = without_paths(list(map(".".join, steps)))
            if are_names(names, request) and not _are_repeated(names):
                return names, last
    return None, None


def _are_repeated(names: Sequence[str]) -> bool:
    """True if two names mean the same."""
    found = [x for name in names if (x := parse_heading(name).meaning)]
    return len(set(found)) < len(found)


def of_width(above: Headings, width: int) -> Iterator[tuple[int, list[str]]]:
    """Index of each line, from the last to the first, and so many names that it may have.

    Of units the last may be empty: a separator at the end of a line adds none.
    """
    for i in sorted(above, reverse=True):
        yield from ((i, names) for names in above[i] if len(names) == width)
        short = (names for names in above[i] if len(names) == width - 1 and "" in names)
        yield from ((i, [*names, ""]) for names in short if are_units(names))


def are_units(names: Sequence[str]) -> bool:
    """True if the words of a line are units, or blank."""
    units = [name.strip(_AROUND_UNITS) for name in names]
    if units[0].lower() in _CALLED_UNITS:
        units[0] = ""
    return any(map(quantities, units)) and all(u in ("", "-", "1") or quantities(u) for u in units)


def with_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    """Return names with the units of the line below them in brackets."""
    plain = [name.strip("\"'") for name in names]
    if not units:
        return plain
    return [
        f"{name} [{u}]" if quantities(u := unit.strip(_AROUND_UNITS)) else name
        for name, unit in zip(plain, units, strict=True)
    ]


def _are_in_degrees(above: Headings) -> bool:
    """True if one of the lines says that all angles and their rates are in degrees."""
    alone = (names[0] for line in above.values() for names in line if len(names) == 1)
    return any(map(_IN_DEGREES.fullmatch, alone))
