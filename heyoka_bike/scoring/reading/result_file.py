"""The bytes of a result file from a path or standard input; gzipped files are unpacked."""

from __future__ import annotations

import sys
import zlib
from collections.abc import Iterator
from contextlib import ExitStack
from io import BytesIO
from os import SEEK_END, PathLike
from os.path import isdir
from pathlib import Path
from struct import unpack
from typing import BinaryIO, cast

from heyoka_bike.errors import InputError, printable
from heyoka_bike.scoring.reading.encodings import encoding_of
from heyoka_bike.scoring.reading.not_read import folder
from heyoka_bike.scoring.reading.request import Request

# Size of the blocks in which a text is read [bytes]. The numbers in a block of this size fit into
# the processor's cache.
_BYTES_AT_ONCE = 1 << 21
# Size of the first block of a text [bytes]. It shows how rows are written, so it must contain any
# heading and some rows.
_BYTES_OF_HEAD = 1 << 21
# Number of bytes at the beginning of a file that show whether it is text or has another format.
_BYTES_OF_SIGNATURE = 4096
_BYTES_OF_LENGTH = 4
# Largest compression ratio of gzip: deflate needs at least two bits for 258 bytes (RFC 1951).
_MOST_PACKED = 1032
_GZIP_SIGNATURE = b"\x1f\x8b"


class ResultFile:
    """A result file, or standard input; gzipped contents are unpacked.

    Parameters
    ----------
    source
        Path of the file, or ``-`` for standard input.
    request
        The request to read it.
    stack
        Closes the file on exit.

    Attributes
    ----------
    request : Request
    stack : ExitStack
    head : bytes
        The beginning of the file.
    encoding : str
        Encoding of a text; see `encodings.encoding_of`.

    Raises
    ------
    InputError
        The file cannot be read.
    """

    def __init__(self, source: str | PathLike[str], request: Request, stack: ExitStack) -> None:
        self.request = request
        self.stack = stack
        self._file = self._open(source)
        # Number of bytes that may still be unpacked; None if the file is not packed.
        self._left: int | None = None
        self._plain = None if source == "-" else Path(source)
        self.head = self._read(_BYTES_OF_HEAD)
        if self.head.startswith(_GZIP_SIGNATURE):
            from gzip import GzipFile

            self._refuse_long()
            packed = GzipFile(fileobj=self.stream())
            self._file = cast(BinaryIO, stack.enter_context(packed))
            self._plain, self._left = None, request.most_bytes
            self.head = self._read(_BYTES_OF_HEAD)
        self.encoding, self._mark = encoding_of(self.signature) or ("utf-8", 0)

    @property
    def signature(self) -> bytes:
        """The first bytes of the file, which show the format."""
        return self.head[:_BYTES_OF_SIGNATURE]

    def text(self) -> Iterator[bytes]:
        """Yield all bytes after the byte order mark, in blocks."""
        yield self.head[self._mark :]
        while chunk := self._read(_BYTES_AT_ONCE):
            yield chunk

    def content(self) -> bytes:
        """Read all remaining bytes and return the whole content."""
        self.head += self._read(-1)
        return self.head

    def stream(self) -> BinaryIO:
        """Return the file at its beginning; a file that cannot seek is read into memory."""
        if self._plain is None or not self._file.seekable():
            return BytesIO(self.content())
        self._file.seek(0)
        return self._file

    def path_or_stream(self) -> Path | BinaryIO:
        """Return the path if the source is a plain file, otherwise a stream."""
        return self._plain if self._plain and self._plain.is_file() else self.stream()

    def _refuse_long(self) -> None:
        """Raise an error if the unpacked length that a gzipped file states exceeds the limit.

        The last four bytes are the unpacked length, modulo 2^32 (RFC 1952, section 2.3.1). In a
        damaged file they are arbitrary, and mostly larger than the compression ratio allows. Such a
        length is ignored.
        """
        if self._plain is None or not self._plain.is_file():
            return
        size = self._plain.stat().st_size
        if size < _BYTES_OF_LENGTH:
            return
        with self._plain.open("rb") as file:
            file.seek(-_BYTES_OF_LENGTH, SEEK_END)
            (length,) = unpack("<I", file.read(_BYTES_OF_LENGTH))
        if self.request.most_bytes < length <= _MOST_PACKED * size:
            raise self.request.too_long(length)

    def _open(self, source: str | PathLike[str]) -> BinaryIO:
        if source != "-" and isdir(source):
            found = folder(Path(source))
            said = f"found {found.found}, expected a result file"
            raise self.request.error(f"{said}; {found.instead}" if found.instead else said)
        try:
            if source != "-":
                return self.stack.enter_context(Path(source).open("rb"))
            if sys.stdin is None:
                raise ValueError("closed")
            return cast(BinaryIO, sys.stdin.buffer)
        except (OSError, ValueError) as e:
            raise self._unreadable(e) from None

    def _read(self, size: int) -> bytes:
        """Read at most `size` more bytes, or all remaining bytes if `size` is -1."""
        try:
            if self._left is None:
                return self._file.read(size)
            found = self._file.read(min(size, self._left + 1) if size >= 0 else self._left + 1)
            self._left -= len(found)
            if self._left < 0:
                raise self.request.too_long()
            return found
        except (OSError, EOFError, zlib.error) as e:
            raise self._unreadable(e) from None

    def _unreadable(self, e: Exception) -> InputError:
        reason = printable(" ".join(str(getattr(e, "strerror", None) or e).split()))[:100]
        return self.request.error(f"cannot be read ({reason}), expected a result file")
