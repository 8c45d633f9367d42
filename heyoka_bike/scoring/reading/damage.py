"""What libraries raise for damaged files, as errors of one line."""

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from warnings import catch_warnings, simplefilter

from heyoka_bike.errors import InputError, MissingPackageError, printable


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
        raise _damaged(expected, path, e) from None


@contextmanager
def any_damage(expected: str, path: str) -> Iterator[None]:
    """The same around a library's reader alone, which may raise anything for damaged bytes."""
    try:
        with catch_warnings():
            simplefilter("ignore")
            yield
    except InputError:
        raise
    except Exception as e:
        raise _damaged(expected, path, e) from None


def missing(path: str, package: str, reads: str) -> MissingPackageError:
    """What to say where the library that reads a file is not installed."""
    return MissingPackageError(
        f"{path}: {package}, which reads {reads}, is not installed: pip install {package}"
    )


def _damaged(expected: str, path: str, error: BaseException) -> InputError:
    """What to say of a file for which a library raised an error."""
    reason = printable(" ".join(str(error).split()))[:100] or type(error).__name__
    return InputError(f"found a damaged file ({reason}), expected {expected}", file=path)
