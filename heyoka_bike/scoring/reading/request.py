"""A request to read a file: what its columns may be, its bytes, and the lines of a text."""

import codecs
import re
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from io import BytesIO, IncrementalNewlineDecoder
from os import PathLike
from os.path import isdir
from pathlib import Path
from typing import BinaryIO, cast
from warnings import catch_warnings, simplefilter

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import BicycleError, InputError, printable

LEFT_OUT = ("-", "skip")
"""Words of `--columns` for a column that is not used."""

OPTION, ARGUMENT = "--columns", "columns="
"""Ways to tell the columns: on the command line, and in Python."""

NAMES = ", ".join(("time", *BENCHMARK_COLUMNS))
"""The names of the benchmark's columns, for messages."""


@dataclass(frozen=True, slots=True)
class Request:
    """A file or arrays to read, for a reference of so many maneuvers.

    Attributes
    ----------
    path
        Name of the file, for errors.
    count
        Number of maneuvers of the reference.
    maneuver
        Number of the maneuver of columns that do not tell; None if that is not known.
    names : tuple of str or None
        What the columns are, whatever the file says; None if it is to be seen from the file.
    option
        How the user tells these, `OPTION` or `ARGUMENT`.
    part
        What messages begin with: of which part of the file they speak.
    known : callable or None
        True for the names of columns in a table without times; None of results.
    group
        Number of the maneuver that this part of the file is of; None if it tells of none.
    is_ordered
        True if the order of arrays by name means anything.
    """

    path: str
    count: int
    maneuver: int | None = None
    names: tuple[str, ...] | None = None
    option: str = OPTION
    part: str = ""
    known: Callable[[str], bool] | None = None
    group: int | None = None
    is_ordered: bool = True

    def within(self, part: str) -> "Request":
        """The request for a part of the file; for all of it if that has no name."""
        return replace(self, part=f"{self.part}{part}: ") if part else self

    def of_maneuver(self, number: int) -> "Request":
        """The request for the part of the file that is of one maneuver."""
        return replace(self.within(f"maneuver {number}"), count=1, group=number)

    def error(self, message: str, line: int | None = None, column: int | None = None) -> InputError:
        """The error that says where, what was found and what was expected."""
        return InputError(f"{self.part}{message}", file=self.path, line=line, column=column)

    @contextmanager
    def damage(self, expected: str) -> Iterator[None]:
        """Turn what libraries raise for damaged files, which may be anything, into an error."""
        try:
            with catch_warnings():
                simplefilter("ignore")
                yield
        except (BicycleError, ImportError):
            raise
        except Exception as e:
            said = re.sub(r" at 0x[0-9a-f]+", "", " ".join(str(e).split()))
            reason = printable(said)[:100] or type(e).__name__
            raise self.error(f"found a damaged file ({reason}), expected {expected}") from None

    @property
    def widths(self) -> tuple[int, ...]:
        """Numbers of columns that mean something without names."""
        if self.known is not None:
            return ()
        if self.names is not None:
            return (len(self.names),)
        return tuple(sorted({9, 1 + 8 * self.count}))

    @property
    def how_to_tell(self) -> str:
        """The words on what to do where names are not understood."""
        said = '"time,roll_angle,..."' if self.option == ARGUMENT else " time,roll_angle,..."
        return f"{self.option}{said} tells what they are"

    def not_columns(self, found: str, line: int | None = None) -> InputError:
        """The error that says what there is in the place of columns, and which were expected."""
        widths = " or ".join(map(str, self.widths))
        said = f"{widths} columns, or columns named {NAMES}; {self.how_to_tell}"
        if self.known is not None:
            said = "columns by name"
        elif self.names is not None:
            said = f'{len(self.names)} as {self.option} tells; there "-" stands for one left out'
        return self.error(f"found {found}, expected {said}", line)

    def wrong_width(self, width: int, rows: int, line: int | None = None) -> InputError:
        """The error for columns without names of which there are too many or too few."""
        likely, widths = "", self.widths if self.names is None else ()
        if width + 1 in widths:
            likely = " (is the time missing?)"
        elif rows + 1 in widths:
            likely = f" (are the {rows} rows columns, and is the time missing?)"
        elif rows in widths:
            likely = f" (are the {rows} rows columns? the first does not ascend as times do)"
        return self.not_columns(f"{width} columns{likely}", line)


_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    # Before UTF-16, whose mark is the start of this one.
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
# What has no line feeds at all is not read into memory.
_LONGEST_LINE = 4_000_000
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a\x1b"))
# What typesetting makes of a minus sign and of blanks.
_PLAIN = str.maketrans({"\u2212": "-", "\xa0": " ", "\u202f": " ", "\v": " ", "\f": " "})
# Of random bytes one in ten; a damaged text may have a few.
_MOST_CONTROLS = 0.02


def encoding_of(head: bytes) -> tuple[str, int] | None:
    """Encoding of a text that starts like this and the length of its mark; None if it is no text.

    Any bytes with hardly any control characters are text. Those that are not UTF-8 can only stand
    in headings and comments, and are left alone.
    """
    for mark, name in _BOMS:
        if head.startswith(mark):
            return name, len(mark)
    even, odd = head[::2], head[1::2]
    # Of UTF-16 every other byte is zero, of rows of numbers all of these.
    for name, zeros, others in (("utf-16-le", odd, even), ("utf-16-be", even, odd)):
        if len(zeros) > 1 and zeros.count(0) > 0.9 * len(zeros) and not others.count(0):
            return name, 0
    if len(head) - len(head.translate(None, _CONTROLS)) > _MOST_CONTROLS * len(head):
        return None
    return "utf-8", 0


def whole_lines(chunks: Iterable[bytes], encoding: str, request: Request) -> Iterator[str]:
    """Blocks of whole lines that end in a line feed; the last one may lack it.

    Blanks are plain ones, and so are minus signs.

    Parameters
    ----------
    chunks
        The text after its mark, cut anywhere.
    encoding
        See `encoding_of`. A byte that is no UTF-8 is Latin-1.
    request
        The request to read it.

    Raises
    ------
    InputError
        A line that is too long, or text that is not in that encoding.
    """
    errors = "latin-1" if encoding == "utf-8" else "strict"
    plain = codecs.getincrementaldecoder(encoding)(errors)
    decoder = IncrementalNewlineDecoder(plain, translate=True)
    rest, line = "", 1
    try:
        for chunk in chunks:
            text = rest + decoder.decode(chunk)
            end = text.rfind("\n") + 1
            block, rest = text[:end], text[end:]
            line += block.count("\n")
            if len(rest) > _LONGEST_LINE:
                said = f"found a line of more than {_LONGEST_LINE} characters"
                raise request.error(f"{said}, expected rows of numbers", line)
            if block:
                yield block.translate(_PLAIN)
        # A file cut in the middle of a character lacks no more than that.
        plain.errors = "ignore"
        rest += decoder.decode(b"", final=True)
    except UnicodeError:
        name = encoding.upper().replace("-LE", "").replace("-BE", "")
        raise request.error(f"found damaged text, expected {name}", line) from None
    if rest:
        yield rest.translate(_PLAIN)


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error("latin-1", _as_latin_1)


# Whole lines of so much text are read at once; the processor's cache holds what they become.
_CHUNK = 1 << 21
# The first of them shows how rows are written: it must hold any heading, and some rows.
_HEAD = 1 << 21
# Of that so much tells text from other files.
_SIGNATURE = 4096
_GZIP = b"\x1f\x8b"


class ResultFile:
    """A file, or standard input; what gzip packed is unpacked.

    Parameters
    ----------
    source
        Its path, ``-`` for standard input.
    request
        The request to read it.
    stack
        Closes it.

    Attributes
    ----------
    request : Request
    stack : ExitStack
    head : bytes
        What it begins with.
    encoding : str
        Of a text; see `request.encoding_of`.

    Raises
    ------
    InputError
        It cannot be read.
    """

    def __init__(self, source: str | PathLike[str], request: Request, stack: ExitStack) -> None:
        self.request = request
        self.stack = stack
        self._file = self._open(source)
        self._plain = None if source == "-" else Path(source)
        self.head = self._read(_HEAD)
        if self.head.startswith(_GZIP):
            from gzip import GzipFile

            packed = GzipFile(fileobj=self.stream())
            self._file = cast(BinaryIO, stack.enter_context(packed))
            self._plain = None
            self.head = self._read(_HEAD)
        self.encoding, self._mark = encoding_of(self.signature) or ("utf-8", 0)

    @property
    def signature(self) -> bytes:
        """The first bytes, which tell the format."""
        return self.head[:_SIGNATURE]

    def text(self) -> Iterator[bytes]:
        """All bytes after the mark of the encoding, in pieces."""
        yield self.head[self._mark :]
        while chunk := self._read(_CHUNK):
            yield chunk

    def content(self) -> bytes:
        """All bytes, which then are the head."""
        self.head += self._read(-1)
        return self.head

    def stream(self) -> BinaryIO:
        """The file at its beginning, which is in memory if it cannot seek."""
        if self._plain is None or not self._file.seekable():
            return BytesIO(self.content())
        self._file.seek(0)
        return self._file

    def path_or_stream(self) -> Path | BinaryIO:
        """The file by its path, if it is one."""
        return self._plain if self._plain and self._plain.is_file() else self.stream()

    def _open(self, source: str | PathLike[str]) -> BinaryIO:
        if source != "-" and isdir(source):
            raise self.request.error("found a directory, expected a result file")
        try:
            if source != "-":
                return self.stack.enter_context(Path(source).open("rb"))
            if sys.stdin is None:
                raise ValueError("closed")
            return cast(BinaryIO, sys.stdin.buffer)
        except (OSError, ValueError) as e:
            raise self._unreadable(e) from None

    def _read(self, size: int) -> bytes:
        """So many bytes more; all that are left if the size is -1."""
        try:
            return self._file.read(size)
        except (OSError, EOFError, zlib.error) as e:
            raise self._unreadable(e) from None

    def _unreadable(self, e: Exception) -> InputError:
        reason = printable(" ".join(str(getattr(e, "strerror", None) or e).split()))[:100]
        return self.request.error(f"cannot be read ({reason}), expected a result file")
