"""A TOML file that knows the position of its entries, so that errors can name line and column.

`tomllib` decides what is valid, but it does not report positions. Only when there is an error to
report is the text split into its statements: ``[table]``, ``[[table]]`` and ``key = value``.
Anything inside a value gets the position where the value begins.
"""

from __future__ import annotations

import difflib
import re
import stat
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from heyoka_bike.errors import InputError, printable, quoted
from heyoka_bike.numbers.exact import Exact

Where = tuple[str | int, ...]
"""Path of an entry: keys, and indices in arrays."""

_MAX_BYTES = 200_000
# The time of tomllib grows with the square of the parts of a dotted key; a limit on the line length
# bounds it.
_MAX_LINE = 2000
_WIDE = (b"\xff\xfe", b"\xfe\xff")


class UnquotedDecimal(str):
    """Text of a TOML float, which is never converted to a binary float."""

    __slots__ = ()


class TomlSource:
    """A parsed TOML file.

    Attributes
    ----------
    path
        Name of the file for messages: printable and on one line; None without a file.
    text
        Text of the file, with line feeds as line ends.
    tree
        Parsed content; floats are `UnquotedDecimal`.
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
            The file cannot be read, is not UTF-8 text, is not valid TOML, or is too large.
        """
        source = cls(_printable_path(path))
        source.text = source._decode(source._read(Path(path)))
        source._check_lines()
        source._parse()
        return source

    def table(self, tree: dict[str, Any], key: str, where: Where) -> dict[str, Any]:
        """Return the table under `key`."""
        if key not in tree:
            empty = not self.text.strip()
            found = "an empty file" if empty else f"no table [{key}]"
            raise self.error(f"found {found}, expected a table [{key}]", where)
        table = tree[key]
        if not isinstance(table, dict):
            raise self.error(f"{key}: found {kind(table)}, expected a table [{key}]", (*where, key))
        return table

    def tables(self, key: str) -> list[dict[str, Any]]:
        """Return the tables ``[[key]]`` at the top level, one or more.

        Raises
        ------
        InputError
            The entry is missing, or of another type.
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
        """Return the text under `key`, which must fit on a line."""
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

    def number(self, entry: object, what: str, where: Where) -> Exact:
        """Return the number in an entry, which is text or an integer."""
        if isinstance(entry, bool) or not isinstance(entry, int | str):
            found = f"found {kind(entry)}, expected a number as a decimal string"
            raise self.error(f"{what}: {found}", where)
        try:
            return Exact.parse(str(entry))
        except ValueError as e:
            raise self.error(f"{what}: {e}", where) from None

    def positive(self, tree: dict[str, Any], key: str, where: Where) -> float:
        """Return the positive number under `key`."""
        value = float(self.number(tree[key], key, (*where, key)))
        if value <= 0:
            found = f"found {quoted(str(tree[key]))}, expected more than zero"
            raise self.error(f"{key}: {found}", (*where, key))
        return value

    def refuse_unknown(
        self, tree: dict[str, Any], known: Collection[str], where: Where,
        needed: Mapping[str, str] | Collection[str] = (),
    ) -> None:  # fmt: skip
        """Raise an error that names the first unknown entry, or a missing one.

        If an entry of ``[[key]]`` is missing, the error gives the number of the table. `needed` may
        contain a description of each entry.
        """
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
        for key in needed:
            if key not in tree:
                of = f" in {where[0]} {int(where[1]) + 1}" if where else ""
                what = f" ({needed[key]})" if isinstance(needed, Mapping) else ""
                raise self.error(f"found no entry '{key}'{of}, expected one{what}", where)

    def error(self, message: str, where: Where) -> InputError:
        """Return an `InputError` at an entry, or at the nearest enclosing one that the file has."""
        line, column = self.locate(where)
        return InputError(message, file=self.path, line=line, column=column)

    def locate(self, where: Where) -> tuple[int | None, int | None]:
        """Return line and column of an entry's value, of its first part, or of its table."""
        if self.path is None:
            return None, None
        statements = list(_statements(self.text))
        for length in range(len(where), 0, -1):
            wanted = where[:length]
            exact = (x.value for x in statements if x.path == wanted)
            inside = (x.value for x in statements if x.path[:length] == wanted)
            at = next(exact, next(inside, None))
            if at is not None:
                return self._line_and_column(at)
        return 1, 1

    def _line_and_column(self, at: int) -> tuple[int, int]:
        return self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)

    def _error_at(self, message: str, at: int) -> InputError:
        line, column = self._line_and_column(at)
        return InputError(message, file=self.path, line=line, column=column)

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
        # Reading a pipe could block, and reading a device might never end.
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
            # e.object is the input after the byte order mark, if there is one.
            self.text = e.object[: e.start].decode("utf-8").replace("\r\n", "\n")
            message = f"found byte 0x{e.object[e.start]:02x}, expected UTF-8 text"
            raise self._error_at(message, len(self.text)) from None

    def _check_lines(self) -> None:
        if line := re.search(rf"[^\n]{{{_MAX_LINE + 1},}}", self.text):
            message = f"found a line of {len(line[0])} characters, expected at most {_MAX_LINE}"
            raise self._error_at(message, line.start() + _MAX_LINE)

    def _parse(self) -> None:
        try:
            self.tree = tomllib.loads(self.text, parse_float=UnquotedDecimal)
        except RecursionError:
            nothing = _Statement((), 0, 0, 0)
            deepest = max(_statements(self.text), key=lambda x: x.brackets, default=nothing)
            message = "found values nested too deeply, expected numbers and text"
            raise self._error_at(message, deepest.start) from None
        except ValueError as e:
            raise self._syntax_error(str(e)) from None

    def _syntax_error(self, what: str) -> InputError:
        """Return tomllib's error with the text where parsing stopped; duplicates in plain words."""
        at = len(self.text)
        if place := re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z", what):
            what = what[: place.start()]
            if place[1]:
                lines = self.text.split("\n")
                at = sum(len(line) + 1 for line in lines[: int(place[1]) - 1]) + int(place[2]) - 1
        first: dict[Where, int] = {}
        for x in _statements(self.text):
            if x.value > at:
                break
            if x.path in first:
                return self._error_at(
                    f"found {quoted(str(x.path[-1]))} a second time, expected it once "
                    f"(first in line {self._line_and_column(first[x.path])[0]})",
                    x.value,
                )
            first[x.path] = x.value
        if twice := re.match(r"Duplicate inline table key ('.*')", what):
            message = f"found {printable(twice[1])} a second time, expected it once"
            return self._error_at(message, at)
        rest = self.text[at:].partition("\n")[0]
        found = quoted(rest) if rest else "the end of the line"
        return self._error_at(f"found {found}, expected valid TOML ({printable(what[:100])})", at)


def kind(value: object) -> str:
    """Return the type of a TOML value in words."""
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


_PATTERN_OF_KEY = r"""(?:[A-Za-z0-9_-]+|"(?:\\.|[^"\\\n])*"|'[^'\n]*')"""
_KEY = rf"{_PATTERN_OF_KEY}(?:[ \t]*\.[ \t]*{_PATTERN_OF_KEY})*"
_PATTERN_OF_HEADER = re.compile(rf"(\[\[?)[ \t]*({_KEY})")
_PAIR = re.compile(rf"({_KEY})[ \t]*=[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
# Strings and comments, whose content has no meaning here; brackets; line ends; anything else.
_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"""+'
    r"|'''.*?'''+"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*|[\[\]{}\n]|[^\[\]{}\n\"'#]+|.",
    re.DOTALL,
)


class _Statement(NamedTuple):
    """A table's header, or a key with its value."""

    path: Where
    start: int
    value: int
    brackets: int


def _statements(text: str) -> Iterator[_Statement]:
    """Yield the statements of a TOML text in order, as far as they can be recognised.

    tomllib has already accepted or rejected the text, so this function does not validate it.
    """
    table: Where = ()
    elements: dict[Where, int] = {}
    at = _end(_BLANK, text, 0)
    while at < len(text):
        if header := _PATTERN_OF_HEADER.match(text, at):
            table = ()
            for part in _parts(header[2]):
                # A key through an array of tables refers to its latest table.
                if table in elements:
                    table = (*table, elements[table])
                table = (*table, part)
            if header[1] == "[[":
                elements[table] = elements.get(table, -1) + 1
                table = (*table, elements[table])
            path, value, end = table, at, header.end()
        elif pair := _PAIR.match(text, at):
            path, value = (*table, *_parts(pair[1])), pair.end()
            end = value
        else:
            return
        depth = brackets = 0
        tables: list[int] = []
        for token in _TOKEN.finditer(text, value):
            end = token.end()
            depth += (token[0] in "[{") - (token[0] in "]}")
            brackets += token[0] in "[{"
            if token[0] == "{" and depth == 2:
                tables.append(token.start())
            if token[0] == "\n" and depth <= 0:
                break
        yield _Statement(path, at, value, brackets)
        # Tables in an array may begin on separate lines.
        yield from (_Statement((*path, i), x, x, 0) for i, x in enumerate(tables))
        at = _end(_BLANK, text, end)


def _end(pattern: re.Pattern[str], text: str, at: int) -> int:
    match = pattern.match(text, at)
    return at if match is None else match.end()


def _parts(key: str) -> Iterator[str]:
    """Yield the parts of a key, without quotes and escapes."""
    for part in re.findall(_PATTERN_OF_KEY, key):
        try:
            yield next(iter(tomllib.loads(f"{part} = 0")))
        except tomllib.TOMLDecodeError:
            yield part
