"""Where a report comes from: when, by which version, against which numbers, by which command."""

import os
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from heyoka_bike.errors import printable
from heyoka_bike.version import __version__


@dataclass(frozen=True, slots=True)
class Origin:
    """When and how a report was made; empty where that is unknown.

    Attributes
    ----------
    date
        Coordinated universal time (``2026-11-22 09:30 UTC``).
    command
        The command line.
    """

    date: str = ""
    command: str = ""


def origin(words: Sequence[str] | None = None) -> Origin:
    """The origin of a report that is made now.

    ``SOURCE_DATE_EPOCH`` gives another time [s since 1970], so that reports can be made again
    byte for byte (https://reproducible-builds.org/specs/source-date-epoch/).

    Parameters
    ----------
    words
        Of the command line, without the program; None where there was no command.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    is_date = given.isascii() and given.isdigit() and len(given) <= 10
    now = datetime.fromtimestamp(int(given), UTC) if is_date else datetime.now(UTC)
    command = "" if words is None else shlex.join(("heyoka-bike", *words))
    return Origin(f"{now:%Y-%m-%d %H:%M} UTC", command)


def origin_words(made: Origin, *numbers: str) -> list[tuple[str, str]]:
    """When and how it was made, and `reference_words` of the numbers."""
    said = [("made", printable(made.date)), ("command", printable(made.command))]
    return [*((name, text) for name, text in said if text), *reference_words(*numbers)]


def reference_words(bicycle: str, dataset_version: str, sha256: str = "") -> list[tuple[str, str]]:
    """By which version, and against which numbers."""
    said = f"{printable(bicycle)}, data {printable(dataset_version)}"
    content = f", content sha256 {sha256}" if sha256 else ""
    return [("by", f"heyoka_bike {__version__}"), ("reference", said + content)]
