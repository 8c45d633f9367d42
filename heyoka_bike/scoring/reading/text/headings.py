"""Find the heading of a text: the line with the names of its columns, and a line of their units."""

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
# Maximum number of lines of names above the rows, such as the names of maneuvers, programs, parts
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
"""For the index of each line, a list of names for each way to split the line."""

# Beginning of a line of units whose first column has no unit.
_NO_UNIT = re.compile(r"-[\s,;]")


def headings_in(line: str) -> Iterator[list[str]]:
    """Yield the names in a heading, for each way to split the line into names."""
    if line.startswith("\t"):
        # The first name is empty, because pandas leaves the name of its index blank.
        yield DIALECTS[0].split(line)
    text = COMMENT_SIGNS.sub("", line, count=1) if COMMENT_SIGNS.match(line) else line
    text = text.strip()
    # Exclude blank lines separately: for these, text[:1] is empty, and the empty string is in every
    # string.
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
    """Return the cells of a row of a sheet as its names; an empty list if the row is empty."""
    words = ["" if x is None else " ".join(str(x).split()) for x in row]
    return [[COMMENT_SIGNS.sub("", words[0], count=1), *words[1:]]] if words else []


def is_heading(written: Sequence[str], request: Request) -> bool:
    """True if names, or the last components of paths among them, are those of columns."""
    return are_names(without_paths(written), request)


def heading_among(
    above: Headings, width: int, request: Request
) -> tuple[list[str] | None, int | None]:
    """Return the names and the index of the last heading with one name for each column.

    Units from the line below or above are added to the names, and degrees if a line states that
    angles are in degrees. None if there is no such heading.

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
    """Return names that pandas wrote on several lines, and the index of the last of these lines."""
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
    """True if two names have the same meaning."""
    found = [x for name in names if (x := parse_heading(name).meaning)]
    return len(set(found)) < len(found)


def of_width(above: Headings, width: int) -> Iterator[tuple[int, list[str]]]:
    """Yield the index and the possible names of each line that has `width` names, last line first.

    In a line of units the last one may be empty, because a separator at the end of a line adds no
    field.
    """
    for i in sorted(above, reverse=True):
        yield from ((i, names) for names in above[i] if len(names) == width)
        short = (names for names in above[i] if len(names) == width - 1 and "" in names)
        yield from ((i, [*names, ""]) for names in short if are_units(names))


def are_units(names: Sequence[str]) -> bool:
    """True if each word is a unit, a hyphen, 1 or blank, and at least one is a unit."""
    units = [name.strip(_AROUND_UNITS) for name in names]
    if units[0].lower() in _CALLED_UNITS:
        units[0] = ""
    return any(map(quantities, units)) and all(u in ("", "-", "1") or quantities(u) for u in units)


def with_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    """Return names with the units of a line of units in brackets."""
    plain = [name.strip("\"'") for name in names]
    if not units:
        return plain
    return [
        f"{name} [{u}]" if quantities(u := unit.strip(_AROUND_UNITS)) else name
        for name, unit in zip(plain, units, strict=True)
    ]


def _are_in_degrees(above: Headings) -> bool:
    """True if one of the lines states that all angles and their rates are in degrees."""
    alone = (names[0] for line in above.values() for names in line if len(names) == 1)
    return any(map(_IN_DEGREES.fullmatch, alone))
