"""Variables in a text that Octave writes with ``save -text``, as decimals."""

from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from math import prod
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError

_FIRST = b"# Created by Octave"
_NAME = "# name:"
_TYPE = "# type:"
_RANGES = ("range", "double_range")
# Groups in groups; a program's text nests a few.
_DEEPEST = 20
_MOST_TIMES = 10**7
# The first variable begins in these bytes.
_SHORT = 400


def holds_variables(head: bytes) -> bool:
    """Whether a text that starts like this has variables; one matrix alone is rows of numbers."""
    several = head.count(f"\n{_NAME}".encode()) > 1
    is_column = any(mark in head[:_SHORT] for mark in (b"_range\n", b"# columns: 1\n"))
    return head.startswith(_FIRST) and (several or is_column)


def variables(text: bytes, path: str) -> dict[str, Any]:
    """Arrays of decimals by name, and structures as mappings of these.

    What is no real number, such as texts and cells, is left out.

    Raises
    ------
    InputError
        A variable that is not complete, with its line.
    """
    reader = _Reader(text.decode("utf-8", "replace").split("\n"))
    try:
        return reader.members(None, 0)
    except (IndexError, ValueError, InvalidOperation):
        raise InputError(
            f"found {'the end' if reader.at >= len(reader.lines) else 'a damaged variable'}, "
            "expected the variables of Octave's save -text",
            file=path,
            line=reader.at,
        ) from None


class _Reader:
    """Variables one after the other."""

    def __init__(self, lines: Sequence[str]) -> None:
        self.lines = lines
        self.at = 0

    def members(self, count: int | None, depth: int) -> dict[str, Any]:
        """So many variables, or all that follow; those that are no numbers are left out."""
        if depth > _DEEPEST:
            raise ValueError
        found: dict[str, Any] = {}
        read = 0
        while read != count and self._seek():
            name = self._after(_NAME)
            value = self._value(self._after(_TYPE), depth)
            read += 1
            if value is not None:
                found[name] = value
        if count is not None and read < count:
            raise IndexError
        return found

    def _value(self, kind: str, depth: int) -> Any:
        kind = kind.removeprefix("global ")
        if kind == "scalar struct":
            while not self.lines[self.at].startswith("# length:"):
                self.at += 1
            return self.members(int(self._after("# length:")), depth + 1)
        if kind == "cell":
            size = int(self._after("# rows:")) * int(self._after("# columns:"))
            self.members(size, depth + 1)
            return None
        if kind in _RANGES:
            return self._range()
        if kind.endswith("scalar") and "complex" not in kind:
            return np.array([self._line()], dtype=object)
        if kind.endswith("matrix") and not {"complex", "diagonal", "sparse"} & set(kind.split()):
            return self._matrix()
        return None

    def _matrix(self) -> Any:
        if self.lines[self.at].startswith("# ndims:"):
            self.at += 1
            shape = tuple(map(int, self._line().split()))
            values = [self._line().strip() for _ in range(prod(shape))]
            return np.array(values, dtype=object).reshape(shape, order="F")
        rows, columns = int(self._after("# rows:")), int(self._after("# columns:"))
        table = [self._line().split() for _ in range(rows)]
        if any(len(row) != columns for row in table):
            raise ValueError
        return np.array(table, dtype=object).reshape(rows, columns) if rows * columns else None

    def _range(self) -> Any:
        self.at += 1
        base, limit, step = map(Decimal, self._line().split())
        count = int((limit - base) / step + Decimal("1e-9")) + 1 if step else 1
        if not 0 < count <= _MOST_TIMES:
            raise ValueError
        return np.array([str(base + i * step) for i in range(count)], dtype=object)

    def _seek(self) -> bool:
        """Go to the next name, if there is one."""
        while self.at < len(self.lines) and not self.lines[self.at].startswith(_NAME):
            self.at += 1
        return self.at < len(self.lines)

    def _after(self, start: str) -> str:
        line = self._line()
        if not line.startswith(start):
            raise ValueError
        return line.removeprefix(start).strip()

    def _line(self) -> str:
        line = self.lines[self.at]
        self.at += 1
        return line.rstrip("\r")
