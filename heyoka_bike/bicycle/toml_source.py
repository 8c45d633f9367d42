"""Reading TOML: errors name the file and the key, and syntax errors the line and the column."""

from __future__ import annotations

import difflib
import re
import stat
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError, printable, quoted
from heyoka_bike.numbers.exact import Exact

Where = tuple[str | int, ...]
"""Path of an entry: keys, and indices in arrays."""

_MAX_BYTES = 200_000
# Maximum length of a line [characters]. It limits the number of parts of a dotted key, because the
# time that tomllib takes grows with the square of that number.
_MAX_LINE = 2000
_WIDE = (b"\xff\xfe", b"\xfe\xff")
# Pattern of the place of an error, at the end of tomllib's messages.
_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


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

    def __init__(self, path: str | None = None) -> None:
        self.path = path
        self.text = ""
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

    def table(self, key: str) -> dict[str, Any]:
        """Return the table ``[key]`` at the top level."""
        if key not in self.tree:
            found = f"no table [{key}]" if self.text.strip() else "an empty file"
            raise self.error(f"found {found}, expected a table [{key}]")
        table = self.tree[key]
        if not isinstance(table, dict):
            raise self.error(f"found {kind(table)}, expected a table [{key}]", (key,))
        return table

    def tables(self, key: str) -> list[dict[str, Any]]:
        """Return the tables ``[[key]]`` at the top level, of which there must be at least one.

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
            raise self.error(f"found {kind(found)}, expected tables [[{key}]]", (key,))
        for i, table in enumerate(found):
            if not isinstance(table, dict):
                raise self.error(f"found {kind(table)}, expected a table [[{key}]]", (key, i))
        if not found:
            what = f"no table [[{key}]]" if self.text.strip() else "an empty file"
            raise self.error(f"found {what}, expected one or more [[{key}]]")
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
            f"found {found}, expected one line of text, at most {limit} characters", (*where, key)
        )

    def number(self, entry: object, where: Where) -> Exact:
        """Return the number of an entry, which is text or an integer."""
        if isinstance(entry, bool) or not isinstance(entry, int | str):
            found = f"found {kind(entry)}, expected a number as a decimal string"
            raise self.error(found, where)
        try:
            return Exact.parse(str(entry))
        except ValueError as e:
            raise self.error(str(e), where) from None

    def positive(self, tree: dict[str, Any], key: str, where: Where) -> float:
        """Return the positive number under `key`."""
        value = float(self.number(tree[key], (*where, key)))
        if value <= 0:
            found = f"found {quoted(str(tree[key]))}, expected more than zero"
            raise self.error(found, (*where, key))
        return value

    def refuse_unknown(
        self, tree: dict[str, Any], known: Collection[str], where: Where,
        needed: Mapping[str, str] | Collection[str] = (),
    ) -> None:  # fmt: skip
        """Raise an error that names the first unknown entry, or the first missing one.

        `needed` may map each entry to its description.
        """
        for key in tree:
            if key in known:
                continue
            lower = {name.lower(): name for name in known}
            close = difflib.get_close_matches(key[:40].lower(), lower, n=1)
            guess = f"'{lower[close[0]]}' or another of" if close else "one of"
            raise self.error(
                f"found unknown entry {quoted(key)}, expected {guess}: {', '.join(sorted(known))}",
                where,
            )
        for key in needed:
            if key not in tree:
                what = f" ({needed[key]})" if isinstance(needed, Mapping) else ""
                raise self.error(f"found no entry '{key}', expected one{what}", where)

    def error(self, message: str, where: Where = (), about: str = "") -> InputError:
        """Return an error that names the file and the key.

        Parameters
        ----------
        message
            What was found and what was expected.
        where
            The entry; none for the file as a whole.
        about
            Description of the entry.
        """
        # Without a file, the values come from Python, where tables have no names. So name only the
        # entry.
        place = _key(where if self.path else where[-1:])
        place += f" ({about})" if about else ""
        return InputError(f"{place}: {message}" if place else message, file=self.path)

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
            # e.object is the content of the file after a byte order mark, if there is one.
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
            raise self.error("found values nested too deeply, expected numbers and text") from None
        except ValueError as e:
            raise self._syntax_error(str(e)) from None

    def _syntax_error(self, said: str) -> InputError:
        """Return tomllib's error with its line and column, and the text of that line."""
        lines = self.text.split("\n")
        line, column = len(lines), len(lines[-1]) + 1
        if place := _PLACE.search(said):
            said = said[: place.start()]
            if place[1]:
                line, column = int(place[1]), int(place[2])
        text = lines[line - 1].strip()
        found = quoted(text, 80) if text else "the end of the text"
        message = f"found {found}, expected valid TOML ({printable(said[:100])})"
        return InputError(message, file=self.path, line=line, column=column)

    def _error_at(self, message: str, at: int) -> InputError:
        line = self.text.count("\n", 0, at) + 1
        column = at - self.text.rfind("\n", 0, at)
        return InputError(message, file=self.path, line=line, column=column)


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


def _key(where: Where) -> str:
    """Return an entry's key as people write it: ``parameters.mB``, ``maneuver 2, speed``."""
    key = ""
    for part in where:
        if isinstance(part, int):
            key += f" {part + 1}, "
        else:
            key += f".{part}" if key and not key.endswith(" ") else part
    return key.removesuffix(", ")
