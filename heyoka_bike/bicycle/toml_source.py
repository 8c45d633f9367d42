"""A TOML file that knows where its entries stand, so that an error can name line and column.

`tomllib` decides what is valid; it does not say where things were. When an error is to be reported,
and only then, a lenient scanner walks over the text and notes the position of each entry.
"""

from __future__ import annotations

import contextlib
import difflib
import re
import stat
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError, printable, quoted
from heyoka_bike.numbers.exact import Exact

Where = tuple[str | int, ...]
"""Path of an entry: keys, and indices in arrays."""

_MAX_BYTES = 200_000
# tomllib's time grows with the square of the parts of a dotted key; a short line bounds them.
_MAX_LINE = 2000
_MAX_DEPTH = 50
_WIDE = (b"\xff\xfe", b"\xfe\xff")


class UnquotedDecimal(str):
    """Text of a TOML float; nothing becomes a binary float on the way."""

    __slots__ = ()


class TomlSource:
    """A parsed TOML file.

    Attributes
    ----------
    path
        Name of the file for messages: printable and on one line; None without a file.
    text
        Its text, lines ending in a line feed.
    tree
        What it says; floats are `UnquotedDecimal`.
    """

    def __init__(self, path: str | None = None, text: str = "") -> None:
        self.path = path
        self.text = text
        self.tree: dict[str, Any] = {}

    @classmethod
    def load(cls, path: str | Path) -> TomlSource:
        """Read and parse a file.

        Raises
        ------
        InputError
            Not a file that can be read, not UTF-8 text, not valid TOML, or too large.
        """
        source = cls(_printable_path(path))
        source.text = source._decode(source._read(Path(path)))
        source._check_lines()
        source._parse()
        return source

    def table(self, tree: dict[str, Any], key: str, where: Where) -> dict[str, Any]:
        """The table under `key`."""
        if key not in tree:
            empty = not self.text.strip()
            found = "an empty file" if empty else f"no table [{key}]"
            raise self.error(f"found {found}, expected a table [{key}]", where)
        table = tree[key]
        if not isinstance(table, dict):
            raise self.error(f"{key}: found {kind(table)}, expected a table [{key}]", (*where, key))
        return table

    def tables(self, key: str) -> list[dict[str, Any]]:
        """The tables ``[[key]]`` at the top, one or more.

        Raises
        ------
        InputError
            It is missing, or something else.
        """
        found = self.tree.get(key, [])
        if isinstance(found, dict):
            raise self.error(
                f"found a table [{key}], expected [[{key}]], with double brackets", (key,)
            )
        if not isinstance(found, list):
            raise self.error(f"{key}: found {kind(found)}, expected tables [[{key}]]", (key,))
        for i, table in enumerate(found):
            if not isinstance(table, dict):
                raise self.error(f"{key}: found {kind(table)}, expected tables [[{key}]]", (key, i))
        if not found:
            what = f"no table [[{key}]]" if self.text.strip() else "an empty file"
            raise self.error(f"found {what}, expected one or more [[{key}]]", (key,))
        return found

    def line_of_text(self, tree: dict[str, Any], key: str, where: Where, limit: int = 200) -> str:
        """The text under `key`, which must fit on a line."""
        text = tree[key]
        if type(text) is not str:
            found = kind(text)
        elif text.strip() and text.isprintable() and len(text) <= limit:
            return text.strip()
        else:
            found = quoted(text)
        raise self.error(
            f"{key}: found {found}, expected one line of text, at most {limit} characters",
            (*where, key),
        )

    def positive(self, tree: dict[str, Any], key: str, where: Where) -> float:
        """The positive decimal under `key`: text, or a whole number."""
        entry = tree[key]
        if isinstance(entry, int) and not isinstance(entry, bool):
            entry = str(entry)
        if not isinstance(entry, str):
            message = f"{key}: found {kind(entry)}, expected a decimal number"
            raise self.error(message, (*where, key))
        try:
            value = float(Exact.parse(entry))
        except ValueError as e:
            raise self.error(f"{key}: {e}", (*where, key)) from None
        if value <= 0:
            raise self.error(
                f"{key}: found {quoted(entry)}, expected more than zero", (*where, key)
            )
        return value

    def refuse_unknown(self, tree: dict[str, Any], known: Collection[str], where: Where) -> None:
        """Raise an error that names the first entry not among those known."""
        for key in tree:
            if key in known:
                continue
            lower = {name.lower(): name for name in known}
            close = difflib.get_close_matches(key[:40].lower(), lower, n=1)
            guess = f"'{lower[close[0]]}' or another of" if close else "one of"
            raise self.error(
                f"found unknown entry {quoted(key)}, expected {guess}: {', '.join(sorted(known))}",
                (*where, key),
            )

    def error(self, message: str, where: Where) -> InputError:
        """An `InputError` at an entry, or at the nearest thing around it that the file has."""
        line, column = self.locate(where)
        return InputError(message, file=self.path, line=line, column=column)

    def locate(self, where: Where) -> tuple[int | None, int | None]:
        """Line and column of an entry's value, of its first part, or of the table around it."""
        if self.path is None:
            return None, None
        places = _Scanner(self.text).places()
        for length in range(len(where), 0, -1):
            wanted = where[:length]
            exact = (at for path, at in places if path == wanted)
            inside = (at for path, at in places if path[:length] == wanted)
            at = next(exact, next(inside, None))
            if at is not None:
                return self._line_and_column(at)
        return 1, 1

    def _line_and_column(self, at: int) -> tuple[int, int]:
        return self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)

    def _read(self, path: Path) -> bytes:
        try:
            mode = path.stat().st_mode
            if stat.S_ISREG(mode):
                with path.open("rb") as file:
                    raw = file.read(_MAX_BYTES + 1)
        except (OSError, ValueError) as e:
            reason = e.strerror if isinstance(e, OSError) and e.strerror else str(e)
            raise InputError(
                f"cannot be read ({reason}), expected a TOML file", file=self.path
            ) from None
        # A pipe could keep us waiting, a device never end.
        if not stat.S_ISREG(mode):
            found = "a directory" if stat.S_ISDIR(mode) else "a pipe or device"
            raise InputError(f"found {found}, expected a TOML file", file=self.path)
        if len(raw) > _MAX_BYTES:
            raise InputError(
                f"found more than {_MAX_BYTES} bytes, expected a short TOML file", file=self.path
            )
        return raw

    def _decode(self, raw: bytes) -> str:
        if raw.startswith(_WIDE):
            raise InputError("found UTF-16 text, expected UTF-8", file=self.path, line=1, column=1)
        try:
            return raw.decode("utf-8-sig").replace("\r\n", "\n")
        except UnicodeDecodeError as e:
            # e.object is the input after the byte order mark, should there be one.
            before = e.object[: e.start].decode("utf-8").replace("\r\n", "\n")
            raise InputError(
                f"found byte 0x{e.object[e.start]:02x}, expected UTF-8 text",
                file=self.path,
                line=before.count("\n") + 1,
                column=len(before) - before.rfind("\n"),
            ) from None

    def _check_lines(self) -> None:
        for number, line in enumerate(self.text.split("\n"), start=1):
            if len(line) > _MAX_LINE:
                raise InputError(
                    f"found a line of {len(line)} characters, expected at most {_MAX_LINE}",
                    file=self.path,
                    line=number,
                    column=_MAX_LINE + 1,
                )

    def _parse(self) -> None:
        try:
            self.tree = tomllib.loads(self.text, parse_float=UnquotedDecimal)
        except RecursionError:
            scanner = _Scanner(self.text)
            scanner.places()
            line, column = self._line_and_column(scanner.start)
            raise InputError(
                "found values nested too deeply, expected numbers and text",
                file=self.path,
                line=line,
                column=column,
            ) from None
        except ValueError as e:
            raise self._syntax_error(str(e)) from None

    def _syntax_error(self, what: str) -> InputError:
        """What tomllib said, and the text at which it stopped; duplicates in plain words."""
        at = len(self.text)
        if place := re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z", what):
            what = what[: place.start()]
            if place[1]:
                lines = self.text.split("\n")
                at = sum(len(line) + 1 for line in lines[: int(place[1]) - 1]) + int(place[2]) - 1
        first: dict[Where, int] = {}
        for path, start in _Scanner(self.text).places():
            if start > at:
                break
            if path in first:
                line, column = self._line_and_column(start)
                return InputError(
                    f"found {quoted(str(path[-1]))} a second time, expected it once "
                    f"(first in line {self._line_and_column(first[path])[0]})",
                    file=self.path,
                    line=line,
                    column=column,
                )
            first[path] = start
        line, column = self._line_and_column(at)
        rest = self.text[at:].partition("\n")[0]
        found = quoted(rest) if rest else "the end of the line"
        return InputError(
            f"found {found}, expected valid TOML ({printable(what[:100])})",
            file=self.path,
            line=line,
            column=column,
        )


def kind(value: object) -> str:
    """What a TOML value is, in words."""
    names = {
        bool: "a boolean",
        int: "an integer",
        UnquotedDecimal: "a number",
        str: "text",
        list: "a list",
        dict: "a table",
    }
    return names.get(type(value), "a date or time")


def _printable_path(path: str | Path) -> str:
    shown = printable(str(path))
    return shown if len(shown) <= 1000 else f"{shown[:500]}...{shown[-400:]}"


_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_DOT = re.compile(r"[ \t]*\.[ \t]*")
_PART = re.compile(r"[A-Za-z0-9_-]+|\"(?:\\.|[^\"\\\n])*\"|'[^'\n]*'")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""+'
    r"|'''.*?'''+"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'",
    re.DOTALL,
)
_WORD = re.compile(r"[^\s,\]}#=][^,\]}#\n]*")


class _UnreadableError(Exception):
    """The text stops being TOML here."""


class _Scanner:
    """Paths of the entries of a TOML text and where their values start, in the text's order.

    Made for text that tomllib has read or refused: it judges nothing, and stops where the text
    stops making sense or is nested deeper than any file should be.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.start = 0
        self.depth = 0
        self.found: list[tuple[Where, int]] = []

    def places(self) -> list[tuple[Where, int]]:
        with contextlib.suppress(_UnreadableError):
            self._document()
        return self.found

    def _document(self) -> None:
        table: Where = ()
        elements: dict[Where, int] = {}
        while not self._ends():
            self.start = self.at
            if not self._take("["):
                self._pair(table)
                continue
            is_element = self._take("[")
            table = ()
            for part in self._key():
                # A key through an array of tables means its latest table.
                if table in elements:
                    table = (*table, elements[table])
                table = (*table, part)
            if is_element:
                elements[table] = elements.get(table, -1) + 1
                table = (*table, elements[table])
            self.found.append((table, self.start))
            self._skip(_SPACE)
            if not self._take("]]" if is_element else "]"):
                raise _UnreadableError

    def _pair(self, table: Where) -> None:
        key = self._key()
        self._skip(_SPACE)
        if not self._take("="):
            raise _UnreadableError
        self._skip(_SPACE)
        path = (*table, *key)
        self.found.append((path, self.at))
        self._value(path)

    def _value(self, path: Where) -> None:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise _UnreadableError
        if self._take("["):
            index = 0
            while not (self._ends() or self._take("]")):
                self.found.append(((*path, index), self.at))
                self._value((*path, index))
                self._skip(_BLANK)
                index += 1
                self._take(",")
        elif self._take("{"):
            while not (self._ends() or self._take("}")):
                self._pair(path)
                self._skip(_BLANK)
                self._take(",")
        else:
            match = _STRING.match(self.text, self.at) or _WORD.match(self.text, self.at)
            if match is None:
                raise _UnreadableError
            self.at = match.end()
        self.depth -= 1

    def _key(self) -> tuple[str, ...]:
        parts = []
        while True:
            self._skip(_SPACE)
            part = _PART.match(self.text, self.at)
            if part is None:
                raise _UnreadableError
            self.at = part.end()
            parts.append(_plain(part[0]))
            dot = _DOT.match(self.text, self.at)
            if dot is None:
                return tuple(parts)
            self.at = dot.end()

    def _ends(self) -> bool:
        self._skip(_BLANK)
        return self.at == len(self.text)

    def _skip(self, what: re.Pattern[str]) -> None:
        match = what.match(self.text, self.at)
        self.at = match.end() if match else self.at

    def _take(self, sign: str) -> bool:
        if not self.text.startswith(sign, self.at):
            return False
        self.at += len(sign)
        return True


def _plain(part: str) -> str:
    """A part of a key without its quotes and escapes."""
    if part[0] not in "\"'":
        return part
    try:
        return next(iter(tomllib.loads(f"{part} = 0")))
    except tomllib.TOMLDecodeError:
        return part
