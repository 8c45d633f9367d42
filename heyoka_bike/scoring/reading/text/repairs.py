"""Texts that are read after a change: on their side, or with names of maneuvers in their rows."""

import re
from collections.abc import Iterator
from itertools import pairwise

from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.dialects import best_dialect, plain_text, without_comment
from heyoka_bike.scoring.reading.vectors import turned

# Of a text on its side all is read at once; with more lines it is none.
_MOST_LINES = 1000
_MANEUVER = re.compile(
    rb"(?i)(?<![^\s,;])([\"']?)(?:maneuver|manoeuvre|man|m)[ _-]?([0-9]{1,3})\1(?![^\s,;])"
)


def numbered(text: bytes) -> bytes:
    """The text with the numbers of maneuvers in place of names such as ``maneuver_2``."""
    return _MANEUVER.sub(rb"\2", text)


def upright(
    first: bytes, others: Iterator[bytes], request: Request
) -> tuple[bytes, Finding] | None:
    """A text of columns below each other as rows, and what is to be said; None if it is none.

    It is one if it has as many lines as there may be columns, all of them numbers, as many in each,
    and those of the first one ascend.
    """
    text = first
    while text.count(b"\n") <= _MOST_LINES and (block := next(others, b"")):
        text += block
    if text.count(b"\n") > _MOST_LINES:
        return None
    lines = [c for line in text.split(b"\n") if (c := without_comment(plain_text(line)))]
    found = best_dialect(lines, ()) if len(lines) in request.widths else None
    if found is None or len(found[2]) != len(lines):
        return None
    dialect, width, _ = found
    columns = [[dialect.number(field) or "" for field in dialect.split(line)] for line in lines]
    if not all(float(a) < float(b) for a, b in pairwise(columns[0])):
        return None
    return "\n".join("\t".join(row) for row in zip(*columns, strict=True)).encode(), turned(
        "text", len(lines), width
    )
