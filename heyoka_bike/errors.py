"""Errors of the package, and the exit code each of them ends with.

An error message is one line: where (file, line, column), what was found, what was expected.
"""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from importlib import import_module
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
        What was found and what was expected.
    file, line, column
        Where, as far as known; lines and columns count from 1.
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
    """The motion meets a singularity of the model before its end.

    Parameters
    ----------
    message : str
        What became singular.
    time : float
        When [s].
    """

    def __init__(self, message: str, time: float) -> None:
        self.time = time
        super().__init__(message, time)

    def __str__(self) -> str:
        return str(self.args[0])


class UndecidedError(BicycleError, ArithmeticError):
    """A value whose correctly rounded form the available digits do not decide."""

    exit_code = Exit.CHECK_FAILED


class NotCertifiedError(BicycleError, ArithmeticError):
    """A candidate that cannot be certified: the step, the time, and the inequality that failed."""

    exit_code = Exit.CHECK_FAILED


class DatasetError(BicycleError, ValueError):
    """A reference folder that is missing, incomplete, damaged, or of another version."""


class MissingPackageError(BicycleError, ImportError):
    """An optional package that the command needs is not installed."""


def required(module: str, said: str) -> ModuleType:
    """A module of an optional package, imported.

    Raises
    ------
    MissingPackageError
        The package is not installed; `said` says so, and how to install it. (A package that it
        needs itself, and does not find, is the error of the import.)
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as e:
        if str(e.name).partition(".")[0] != module.partition(".")[0]:
            raise
        raise MissingPackageError(said) from None


GENERATE = "pip install 'heyoka_bike[generate]'"
"""Command that installs the packages that integrate."""


class WorkerLostError(BicycleError, RuntimeError):
    """A process that did a part of the work ended, again and again, or its cluster did."""

    exit_code = Exit.INTERNAL


class SchedulerLostError(WorkerLostError):
    """The scheduler of a cluster ended, or cannot be reached any more."""

    exit_code = Exit.INPUT


class VersionsDifferError(BicycleError, RuntimeError):
    """A worker of a cluster has other versions, so that its results might differ."""


class NothingScoredError(BicycleError, ValueError):
    """A result file that can be read, but of which nothing can be compared with the reference."""

    exit_code = Exit.NOTHING_SCORED


def printable(text: str) -> str:
    """The text on one line: what cannot be printed is escaped."""
    return "".join(ch if ch.isprintable() else ch.encode("unicode_escape").decode() for ch in text)


def quoted(text: str, limit: int = 40) -> str:
    """The text in single quotes for a message, printable and shortened to `limit`."""
    if len(text) <= limit:
        return f"'{printable(text)}'"
    return f"'{printable(text[:limit])}...' ({len(text)} characters)"


def quoted_names(names: Sequence[str], limit: int = 8) -> str:
    """The first names in quotes for a message, and how many more there are."""
    more = len(names) - limit
    return ", ".join(map(quoted, names[:limit])) + (f" and {more} more" if more > 0 else "")


def shortened(text: str, limit: int = 40) -> str:
    """The text for a list of names, printable and shortened to `limit`."""
    return printable(text if len(text) <= limit else f"{text[:limit]}...")


def unknown_word(word: object, known: Sequence[str], what: str = "") -> str:
    """Return the message about a word that is not known, or is none: it, and all that are known."""
    some = " or ".join(known) if len(known) == 2 else f"one of {', '.join(known)}"
    if not isinstance(word, str):
        return f"found {printable(repr(word))[:60]} ({type(word).__name__}), expected {what}{some}"
    return f"found {what}{quoted(word)}, expected {some}{did_you_mean(word, known)}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a message about a word that is not known: the one that it is most like, if any."""
    from difflib import get_close_matches

    close = get_close_matches(word[:40].lower(), list(known), 1)
    return f"; did you mean {close[0]}?" if close else ""
