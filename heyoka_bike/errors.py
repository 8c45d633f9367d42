"""Errors of the package, each with the exit code of the command line.

An error message is one line: the place (file, line, column), what was found, what was expected.
"""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from types import ModuleType


class Exit(IntEnum):
    """Exit codes of the command line; they are part of the interface."""

    OK = 0
    INPUT = 1
    NOTHING_SCORED = 2
    CHECK_FAILED = 3
    STOPPED_EARLY = 4
    INTERNAL = 70
    INTERRUPTED = 130


class BicycleError(Exception):
    """Base of every error this package raises on purpose; its text is one line for the user."""

    exit_code = Exit.INPUT


class InputError(BicycleError, ValueError):
    """Input that cannot be used: unreadable, malformed, or outside the model.

    Parameters
    ----------
    message : str
        The text: what was found, and what was expected instead.
    file, line, column
        The place, as far as it is known; lines and columns count from 1.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        self.message = message
        self.file = None if file is None else str(file)
        self.line = line
        self.column = column
        place = self.file or ""
        if line is not None:
            place += f":{line}" if place else f"line {line}"
            if column is not None:
                place += f":{column}"
        super().__init__(f"{place}: {message}" if place else message)


class SingularMotionError(BicycleError, ArithmeticError):
    """The motion reaches a singularity of the model before its end.

    Parameters
    ----------
    message : str
        What became singular.
    time : float
        Time of the singularity [s].
    """

    def __init__(self, message: str, time: float) -> None:
        self.time = time
        super().__init__(message, time)

    def __str__(self) -> str:
        return str(self.args[0])


class UndecidedError(BicycleError, ArithmeticError):
    """A value that cannot be rounded correctly, because it is not known to enough digits."""

    exit_code = Exit.CHECK_FAILED


class NotCertifiedError(BicycleError, ArithmeticError):
    """A candidate that cannot be certified: the step, the time, and the inequality that failed."""

    exit_code = Exit.CHECK_FAILED


class DatasetError(BicycleError, ValueError):
    """A reference folder that is missing, incomplete, damaged, or of another version."""


class MissingPackageError(BicycleError, ImportError):
    """An optional package that the command needs is not installed."""


def required(module: str, said: str) -> ModuleType:
    """Import a module of an optional package.

    Parameters
    ----------
    module
        Its full name.
    said
        Message of the error: the package is not installed, and how to install it.

    Raises
    ------
    MissingPackageError
        The package is not installed. (If one of its own dependencies is missing, the original
        `ModuleNotFoundError` is raised.)
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as e:
        if str(e.name).partition(".")[0] != module.partition(".")[0]:
            raise
        raise MissingPackageError(said) from None


GENERATE = "pip install 'heyoka_bike[generate]'"
"""Command that installs the packages needed for integration."""


class WorkerLostError(BicycleError, RuntimeError):
    """A worker process, or its whole cluster, ended repeatedly before its work was done."""

    exit_code = Exit.INTERNAL


class SchedulerLostError(WorkerLostError):
    """The scheduler of a cluster ended or can no longer be reached."""

    exit_code = Exit.INPUT


class VersionsDifferError(BicycleError, RuntimeError):
    """A worker of a cluster has different package versions, so its results might differ."""


class NothingScoredError(BicycleError, ValueError):
    """A result file that is readable, but contains nothing to compare with the reference."""

    exit_code = Exit.NOTHING_SCORED


def printable(text: str) -> str:
    """Return the text on one line, with unprintable characters escaped."""
    return "".join(ch if ch.isprintable() else ch.encode("unicode_escape").decode() for ch in text)


def quoted(text: str, limit: int = 40) -> str:
    """Return the text in single quotes for a message, printable and at most `limit` long."""
    if len(text) <= limit:
        return f"'{printable(text)}'"
    return f"'{printable(text[:limit])}...' ({len(text)} characters)"


def quoted_names(names: Sequence[str], beside: Sequence[str] = (), limit: int = 8) -> str:
    """List the first names in quotes, each followed by its text in `beside`; count the others."""
    shown = [
        quoted(name) + text
        for name, text in zip_longest(names[:limit], beside[:limit], fillvalue="")
    ]
    more = len(names) - limit
    return ", ".join(shown) + (f" and {more} more" if more > 0 else "")


def shortened(text: str, limit: int = 40) -> str:
    """Return a text for a list of names: printable, and cut after `limit` characters."""
    return printable(text if len(text) <= limit else f"{text[:limit]}...")


def unknown_word(word: object, known: Sequence[str], what: str = "") -> str:
    """Return the message about an unknown word (or another object), which lists the known words."""
    some = " or ".join(known) if len(known) == 2 else f"one of {', '.join(known)}"
    if not isinstance(word, str):
        return f"found {printable(repr(word))[:60]} ({type(word).__name__}), expected {what}{some}"
    return f"found {what}{quoted(word)}, expected {some}{did_you_mean(word, known)}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown word: the most similar known one, or nothing."""
    from difflib import get_close_matches

    close = get_close_matches(word[:40].lower(), list(known), 1)
    return f"; did you mean {close[0]}?" if close else ""
