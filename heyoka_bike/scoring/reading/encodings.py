"""Decode texts to whole lines, with ordinary blanks and minus signs.

A byte order mark shows UTF-8, UTF-16 or UTF-32 (Unicode Standard, section 23.8). Without a mark, a
text with many zero bytes is UTF-16. Any other text is UTF-8; bytes that are not valid UTF-8 are
read as Latin-1.
"""

from __future__ import annotations

import codecs
from collections.abc import Iterable, Iterator
from io import IncrementalNewlineDecoder

from heyoka_bike.scoring.reading.request import Request

_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    # UTF-32 must precede UTF-16, because the byte order mark of UTF-32-LE begins with that of
    # UTF-16-LE.
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
# Maximum length of a line [characters], because a file without line feeds must not be read into
# memory.
_LONGEST_LINE = 4_000_000
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r\x1a\x1b"))
# Translation of typographic minus signs and blanks to ordinary ones.
_PLAIN_SIGNS = str.maketrans({"\u2212": "-", "\xa0": " ", "\u202f": " ", "\v": " ", "\f": " "})
# Largest fraction of control characters in a text. A damaged text may contain a few of them; in
# random bytes, one in ten is a control character.
_MOST_CONTROLS = 0.02


def encoding_of(head: bytes) -> tuple[str, int] | None:
    """Return the encoding of a text and the length of its byte order mark; None if not a text.

    Bytes with hardly any control characters are text. Bytes that are not valid UTF-8 can only be in
    headings and comments, where they do no harm.
    """
    for mark, name in _BOMS:
        if head.startswith(mark):
            return name, len(mark)
    even, odd = head[::2], head[1::2]
    # In a row of numbers in UTF-16, every second byte is zero.
    for name, zeros, others in (("utf-16-le", odd, even), ("utf-16-be", even, odd)):
        if len(zeros) > 1 and zeros.count(0) > 0.9 * len(zeros) and not others.count(0):
            return name, 0
    if len(head) - len(head.translate(None, _CONTROLS)) > _MOST_CONTROLS * len(head):
        return None
    return "utf-8", 0


def whole_lines(chunks: Iterable[bytes], encoding: str, request: Request) -> Iterator[str]:
    """Yield blocks of whole lines, each with its line feed; the last one may lack it.

    Typographic blanks and minus signs are replaced with plain ones.

    Parameters
    ----------
    chunks
        The parts of the text after its byte order mark.
    encoding
        See `encoding_of`. Bytes that are not valid UTF-8 are read as Latin-1.
    request
        The request to read it.

    Raises
    ------
    InputError
        A line is too long, or the text is not in this encoding.
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
                yield block.translate(_PLAIN_SIGNS)
        # If the file ends in the middle of a character, ignore only that character.
        plain.errors = "ignore"
        rest += decoder.decode(b"", final=True)
    except UnicodeError:
        name = encoding.upper().replace("-LE", "").replace("-BE", "")
        raise request.error(f"found damaged text, expected {name}", line) from None
    if rest:
        yield rest.translate(_PLAIN_SIGNS)


def _as_latin_1(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("latin-1"), error.end


codecs.register_error("latin-1", _as_latin_1)
