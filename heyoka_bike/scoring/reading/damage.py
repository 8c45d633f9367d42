"""What libraries raise for damaged files, as errors of one line."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager

from heyoka_bike.errors import InputError, printable


@contextmanager
def damage(expected: str, path: str) -> Iterator[None]:
    """Turn what libraries raise for damaged files into an `InputError`."""
    from struct import error as StructError  # noqa: N812
    from tokenize import TokenError
    from zipfile import BadZipFile

    try:
        yield
    except InputError:
        raise
    except (
        OSError, ValueError, KeyError, EOFError, TypeError, SyntaxError, OverflowError, MemoryError,
        RuntimeError, zlib.error, StructError, TokenError, BadZipFile,
    ) as e:  # fmt: skip
        raise damaged(expected, path, e) from None


def damaged(expected: str, path: str, error: BaseException) -> InputError:
    """What to say of a file for which a library raised an error."""
    reason = printable(" ".join(str(error).split()))[:100] or type(error).__name__
    return InputError(f"found a damaged file ({reason}), expected {expected}", file=path)
