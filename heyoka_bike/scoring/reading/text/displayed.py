"""Matrices that MATLAB and Octave display in several blocks of lines, because they are wide.

Each block begins with a line such as ``Columns 1 through 8``. Its rows are appended to those of the
first block.
"""

from __future__ import annotations

import re

from heyoka_bike.errors import quoted
from heyoka_bike.scoring.reading.request import Request

_BLOCK = re.compile(
    r"[ \t]*columns?[ \t]+([0-9]{1,6})(?:[ \t]+(?:through|to|and)[ \t]+([0-9]{1,6}))?:?[ \t\r]*",
    re.IGNORECASE,
)
_ROW = re.compile(r"\s*[-+.0-9]")


def has_blocks(text: str) -> bool:
    """True if any line of a text may begin a block of columns."""
    is_likely = "olumn" in text or "OLUMN" in text
    return is_likely and any(map(_BLOCK.fullmatch, text.split("\n")))


def side_by_side(text: str, request: Request) -> str:
    """Return the text with the rows of all blocks joined, in the lines of the first block.

    Return any other text unchanged.

    Raises
    ------
    InputError
        A block has another number of rows than the first one, or does not continue the one before.
    """
    lines = text.split("\n")
    starts = {i: match for i, line in enumerate(lines) if (match := _BLOCK.fullmatch(line))}
    ends = [*[*starts][1:], len(lines)]
    rows = {
        i: [j for j in range(i + 1, end) if _ROW.match(lines[j])]
        for i, end in zip(starts, ends, strict=True)
    }
    if not all(rows.values()):
        return text
    first, *others = starts
    expected = 1
    for i, match in starts.items():
        if int(match[1]) != expected:
            said = f"found {quoted(lines[i].strip())}, expected a block of columns from {expected}"
            raise request.error(said, i + 1)
        expected = int(match[2] or match[1]) + 1
        if len(rows[i]) != len(rows[first]):
            raise request.error(
                f"found {len(rows[i])} rows below {quoted(lines[i].strip())}, expected "
                f"{len(rows[first])} as below {quoted(lines[first].strip())}",
                i + 1,
            )
    for i in others:
        for to, j in zip(rows[first], rows[i], strict=True):
            lines[to] += f" {lines[j].strip()}"
            lines[j] = ""
    for i in starts:
        lines[i] = ""
    return "\n".join(lines)
