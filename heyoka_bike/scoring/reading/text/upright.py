"""Texts on their side: columns in lines."""

from dataclasses import replace
from itertools import pairwise

from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.text.dialects import best_dialect, plain_text, without_comment
from heyoka_bike.scoring.reading.text.table import read_text
from heyoka_bike.scoring.reading.vectors import Vectors, turned


def read_upright(text: bytes, request: Request) -> list[Vectors] | None:
    """The table of a text that is on its side; None if it is not.

    It is if it has as many lines as there may be columns, all of them numbers, as many in each, and
    those of the first one ascend.
    """
    lines = [c for line in text.split(b"\n") if (c := without_comment(plain_text(line)))]
    found = best_dialect(lines, ()) if len(lines) in request.widths else None
    if found is None or len(found[2]) != len(lines):
        return None
    dialect, width, _ = found
    columns = [[dialect.number(field) or "" for field in dialect.split(line)] for line in lines]
    if not all(float(a) < float(b) for a, b in pairwise(columns[0])):
        return None
    rows = "\n".join("\t".join(row) for row in zip(*columns, strict=True)).encode()
    table, finding = read_text([rows], "utf-8", request), turned("text", len(lines), width)
    return [replace(table, lines=None, findings=(finding, *table.findings))]
